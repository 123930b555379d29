#pragma once

#include <optional>
#include <string>

#include "libfit/core/error.hpp"

namespace palpate::testing_support {

/// The Error that an act is refused with; none where it throws none.
template <class Act>
std::optional<Error> refusal_of(const Act& act) {
  try {
    act();
  } catch (const Error& error) {
    return error;
  }
  return std::nullopt;
}

/// What an act is refused with, or the fact of it alone; "accepted" where it throws no Error.
template <class Act>
std::string error_of(const Act& act) {
  const std::optional<Error> refusal = refusal_of(act);
  return refusal ? refusal->what() : "accepted";
}
template <class Act>
std::string fact_of(const Act& act) {
  const std::optional<Error> refusal = refusal_of(act);
  return refusal ? refusal->fact() : "accepted";
}

}  // namespace palpate::testing_support
