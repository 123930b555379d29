#pragma once

#include <functional>
#include <string>
#include <vector>

#include "libfit/io/hdf5/handle.hpp"

namespace palpate::h5 {

/// Appends `count` texts of fixed or variable length, without their padding, to `out`.
/// type, space: of the data set or attribute. read: fetches all values as a memory type into a
/// buffer, negative on failure. False when it fails.
using ReadValues = std::function<int(std::int64_t memory_type, void* buffer)>;
bool read_strings(const Handle& type, const Handle& space, std::size_t count,
                  const ReadValues& read, std::vector<std::string>& out);

}  // namespace palpate::h5
