// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// Included before every source of a program that vary.py has instrumented: a constant is read from
// the environment once, as PALPATE_TUNE="file:kName=factor,...".

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <type_traits>

namespace palpate_tune {

/// The value times the factor that the environment has for the name, else the value. Integers are
/// rounded and stay at least 1.
template <class T>
T tune(const char* name, T value) {
  const char* text = std::getenv("PALPATE_TUNE");
  if (text == nullptr) return value;
  const std::size_t length = std::strlen(name);
  for (const char* p = std::strstr(text, name); p != nullptr; p = std::strstr(p + 1, name)) {
    if ((p != text && p[-1] != ',') || p[length] != '=') continue;
    const double scaled = static_cast<double>(value) * std::strtod(p + length + 1, nullptr);
    if (!std::is_integral<T>::value) return static_cast<T>(scaled);
    return static_cast<T>(scaled < 1 && value > 0 ? 1 : std::round(scaled));
  }
  return value;
}

}  // namespace palpate_tune
