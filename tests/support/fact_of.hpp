#pragma once

#include <string>

#include "libfit/core/error.hpp"

namespace palpate::testing_support {

/// The fact of the Error that an act is refused with; "accepted" where it throws none.
template <class Act>
std::string fact_of(const Act& act) {
  try {
    act();
  } catch (const Error& error) {
    return error.fact();
  }
  return "accepted";
}

}  // namespace palpate::testing_support
