#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

namespace palpate::fem {

// Eight elements side by side: the arithmetic of one law, written once over a scalar S that is a
// double or a Pack. Lanes never mix and no multiply-add is fused (-ffp-contract=off), so a result
// has the same bits whichever instruction set the kernels were dispatched to.

inline constexpr int kLanes = 8;
/// The alignment is spelled out: left to itself it depends on the instruction set of the function.
typedef double Pack
    __attribute__((vector_size(kLanes * sizeof(double)), aligned(kLanes * sizeof(double))));

#define PALPATE_INLINE inline __attribute__((always_inline))

/// Packs on the heap. (std::vector<Pack> would drop the alignment.)
class PackArray {
 public:
  explicit PackArray(std::size_t size = 0) : lanes_(size) {}
  Pack* data() { return reinterpret_cast<Pack*>(lanes_.data()); }
  const Pack* data() const { return reinterpret_cast<const Pack*>(lanes_.data()); }
  std::size_t size() const { return lanes_.size(); }
  double& at(std::size_t i, int lane) { return lanes_[i].lane[lane]; }

 private:
  struct alignas(kLanes * sizeof(double)) Lanes {
    double lane[kLanes] = {};
  };
  std::vector<Lanes> lanes_;
};

// Elementary functions over a scalar S that is a double or a Pack. Written out in plain arithmetic
// on the bits, so that a lane of a Pack and a double give the same bits on every instruction set
// and with every C library, and eight lanes cost as much as one.

typedef std::uint64_t PackBits
    __attribute__((vector_size(kLanes * sizeof(double)), aligned(kLanes * sizeof(double))));

PALPATE_INLINE void bits_of(const double& x, std::uint64_t& out) {
  out = std::bit_cast<std::uint64_t>(x);
}
PALPATE_INLINE void bits_of(const Pack& x, PackBits& out) { out = (PackBits)x; }
PALPATE_INLINE void from_bits(const std::uint64_t& bits, double& out) {
  out = std::bit_cast<double>(bits);
}
PALPATE_INLINE void from_bits(const PackBits& bits, Pack& out) { out = (Pack)bits; }

/// The bit pattern of a number and back: typename Bits<S>::type.
template <class S>
struct Bits {
  typedef PackBits type;
};
template <>
struct Bits<double> {
  typedef std::uint64_t type;
};

PALPATE_INLINE void sqrt_of(const double& x, double& out) { out = std::sqrt(x); }
PALPATE_INLINE void sqrt_of(const Pack& x, Pack& out) {
  for (int lane = 0; lane < kLanes; ++lane) out[lane] = std::sqrt(x[lane]);
}

/// True if any lane is not zero.
PALPATE_INLINE bool is_any_nonzero(const double& x) { return x != 0; }
PALPATE_INLINE bool is_any_nonzero(const Pack& x) {
  bool is_any = false;
  for (int lane = 0; lane < kLanes; ++lane) is_any |= x[lane] != 0;
  return is_any;
}

namespace math {

inline constexpr double kLog2High = 6.93147180369123816490e-01;  // 32 bits: multiples are exact
inline constexpr double kLog2Low = 1.90821492927058770002e-10;

}  // namespace math

/// log(value) and log(value) - less_one, to 3 and 24 units in the last place. less_one is value - 1
/// to full relative accuracy where value is near 1. value from 1e-300 to 1e300.
/// Source: reduction to [sqrt(1/2), sqrt(2)) and 2 atanh(f / (2 + f)), as in fdlibm's e_log.c.
template <class S>
PALPATE_INLINE void log_of(const S& less_one, const S& value, S& log, S& log_less) {
  constexpr std::uint64_t kRootHalf = 0x3fe6a09e667f3bcdULL, kOne = 0x3ff0000000000000ULL;
  typename Bits<S>::type bits;
  bits_of(value, bits);
  bits += kOne - kRootHalf;
  S exponent, mantissa;
  from_bits((bits >> 52) + 0x4330000000000000ULL, exponent);  // 2^52 + the biased exponent
  exponent -= 4503599627370496.0 + 1023.0;
  from_bits((bits & 0x000fffffffffffffULL) + kRootHalf, mantissa);
  const S f = exponent == 0.0 ? less_one : mantissa - 1.0;
  const S s = f / (f + 2.0);
  const S z = s * s;
  S tail = z * (2.0 / 21) + 2.0 / 19;
  tail = tail * z + 2.0 / 17;
  tail = tail * z + 2.0 / 15;
  tail = tail * z + 2.0 / 13;
  tail = tail * z + 2.0 / 11;
  tail = tail * z + 2.0 / 9;
  tail = tail * z + 2.0 / 7;
  tail = tail * z + 2.0 / 5;
  tail = tail * z + 2.0 / 3;
  tail = tail * z;
  const S bent = s * (f - tail);  // f - log(1 + f)
  log = exponent * math::kLog2High + (f - (bent - exponent * math::kLog2Low));
  log_less = exponent == 0.0 ? -bent : log - less_one;
}

/// log(1 + x) and log(1 + x) - x to full relative accuracy; x from -1 + 1e-16 to 1e300.
template <class S>
PALPATE_INLINE void log1p_of(const S& x, S& log, S& log_less) {
  log_of(x, S(x + 1.0), log, log_less);
}
template <class S>
PALPATE_INLINE void log1p_of(const S& x, S& log) {
  S log_less;
  log1p_of(x, log, log_less);
}

/// exp(x) - 1 and exp(x) - 1 - x to full relative accuracy; |x| beyond 700 counts as 700.
/// Source: reduction by multiples of ln 2 and the Taylor series to r^13, |r| < 0.35.
template <class S>
PALPATE_INLINE void expm1_of(const S& argument, S& expm1, S& expm1_less) {
  constexpr double kRound = 6755399441055744.0;  // 1.5 * 2^52: adding it rounds to a whole number
  const S low = argument * 0.0 - 700.0, high = argument * 0.0 + 700.0;
  S x = argument > low ? argument : low;
  x = x < high ? x : high;
  const S shifted = x * 1.44269504088896338700 + kRound;
  const S n = shifted - kRound;
  const S r = (x - n * math::kLog2High) - n * math::kLog2Low;
  S series = r * (1.0 / 6227020800) + 1.0 / 479001600;
  series = series * r + 1.0 / 39916800;
  series = series * r + 1.0 / 3628800;
  series = series * r + 1.0 / 362880;
  series = series * r + 1.0 / 40320;
  series = series * r + 1.0 / 5040;
  series = series * r + 1.0 / 720;
  series = series * r + 1.0 / 120;
  series = series * r + 1.0 / 24;
  series = series * r + 1.0 / 6;
  series = series * r + 0.5;
  const S less = r * r * series;
  typename Bits<S>::type bits;
  bits_of(shifted, bits);
  S scale;
  from_bits((bits + 1023) << 52, scale);
  expm1 = scale * (r + less) + (scale - 1.0);
  expm1_less = n == 0.0 ? less : expm1 - x;
}
template <class S>
PALPATE_INLINE void expm1_of(const S& x, S& expm1) {
  S expm1_less;
  expm1_of(x, expm1, expm1_less);
}

/// Beyond this exponent an exponential law's energy is +inf (e^200 = 7e86 times its modulus: no
/// tissue is there), and its derivatives stay those of the bound, so that they never overflow.
inline constexpr double kLargestExponent = 200;

/// exp(Q) - 1, its value for energies (+inf beyond the bound) and for derivatives.
template <class S>
PALPATE_INLINE void bounded_expm1_of(const S& exponent, S& for_energy, S& for_derivatives) {
  const S bound = exponent * 0.0 + kLargestExponent;
  const S infinite = exponent * 0.0 + std::numeric_limits<double>::infinity();
  expm1_of(S(exponent < bound ? exponent : bound), for_derivatives);
  for_energy = exponent > bound ? infinite : for_derivatives;
}

}  // namespace palpate::fem
