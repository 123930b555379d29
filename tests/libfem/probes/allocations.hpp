#pragma once

#include <cstddef>

namespace palpate::fem {

/// How often this program called operator new.
extern std::size_t allocations;

}  // namespace palpate::fem
