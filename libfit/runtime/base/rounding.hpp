// Copyright (c) Palpate contributors. SPDX-License-Identifier: MIT
#pragma once

// The engine needs IEEE doubles, rounded after each operation. A compiler that
// fuses a * b + c, reorders sums or believes that NaN does not exist computes other forces.

#include <cstdint>
#include <cstring>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || \
    defined(__RECIPROCAL_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(_M_FP_FAST)
#error "palpate runtime: build without /fp:fast, -ffast-math and what of it changes bits"
#endif
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(_MSC_VER)
#pragma fp_contract(off)
#endif  // g++ knows no such pragma: -ffp-contract=off

namespace palpate::runtime {

/// By its bits, whatever the compiler believes of NaN.
inline bool is_finite(double x) noexcept {
  std::uint64_t bits;
  std::memcpy(&bits, &x, sizeof bits);
  return (bits >> 52 & 0x7ff) != 0x7ff;
}

}  // namespace palpate::runtime
