#pragma once

namespace palpate {

// Results have the same bytes on every x86-64 processor with AVX2. Two things below our own code
// would take them from the processor: the order in which Eigen sums a product, which follows the
// sizes of the caches, and the C library's elementary functions, which have a variant with FMA.
// same_bytes.cpp replaces the latter by SLEEF's for the program and all that it loads.

/// Sizes of the caches that Eigen's block sizes are computed for [bytes]: the least that an x86-64
/// processor with AVX2 has. Half and twice were not measured.
inline constexpr int kFirstCache_bytes = 32 << 10, kSecondCache_bytes = 256 << 10,
                     kThirdCache_bytes = 2 << 20;

/// Makes Eigen sum in the order for these caches. To be called before the first product.
void fix_order_of_sums();

}  // namespace palpate
