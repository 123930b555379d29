#pragma once

#include <string>

#include "libfit/core/error.hpp"

namespace palpate::testing_support {

/// What an act is refused with; "accepted" where it throws no Error.
template <class Act>
std::string error_of(const Act& act) {
  try {
    act();
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

}  // namespace palpate::testing_support
