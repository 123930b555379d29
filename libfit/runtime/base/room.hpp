// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

#include <new>
#include <type_traits>

#include "rounding.hpp"

namespace palpate::runtime {

/// Room on the stack for up to kCount objects that are made one by one where they are needed: what
/// a tick does not use it does not clear.
template <class T, int kCount>
class Room {
  static_assert(std::is_trivially_destructible<T>::value, "nothing is destroyed");

 public:
  template <class... Arguments>
  T& make(int i, const Arguments&... arguments) noexcept {
    return *new (static_cast<void*>(bytes_ + sizeof(T) * static_cast<std::size_t>(i)))
        T(arguments...);
  }
  T& operator[](int i) noexcept { return begin()[i]; }
  const T& operator[](int i) const noexcept { return begin()[i]; }
  T* begin() noexcept { return std::launder(reinterpret_cast<T*>(bytes_)); }
  const T* begin() const noexcept { return std::launder(reinterpret_cast<const T*>(bytes_)); }

 private:
  alignas(T) unsigned char bytes_[sizeof(T) * kCount];
};

}  // namespace palpate::runtime
