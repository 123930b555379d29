#pragma once

#include "libfem/materials/pack_math.hpp"

namespace palpate::fem {

// Eigenvalues and eigenvectors of symmetric 3 x 3 matrices, lane by lane with one sequence of
// steps.

namespace spectral {

/// Turns M (symmetric, full) by the Jacobi rotation that empties entry (p, q), and the columns of V
/// with it. A lane whose entry is negligible is left as it is, to the bit. Returns whether any lane
/// was turned.
template <int p, int q, class S>
PALPATE_INLINE bool rotate(const S& negligible_squared, S* M, S* V) {
  constexpr int r = 3 - p - q;
  const S zero = M[0] * 0.0, one = zero + 1.0;
  const S off = M[3 * p + q];
  const S turned = off * off > negligible_squared ? one : zero;
  if (!is_any_nonzero(turned)) return false;
  const S gap = M[4 * q] - M[4 * p];
  const S size = gap < 0.0 ? -gap : gap;
  S root, inverse_c;
  sqrt_of(S(gap * gap + 4.0 * (off * off)), root);
  const S below = size + root;
  S t = 2.0 * off / (below > 0.0 ? below : one);
  t = gap < 0.0 ? -t : t;
  t = turned > 0.0 ? t : zero;
  sqrt_of(S(t * t + 1.0), inverse_c);
  const S c = one / inverse_c, s = t * c;
  M[4 * p] -= t * off;
  M[4 * q] += t * off;
  M[3 * p + q] = M[3 * q + p] = turned > 0.0 ? zero : off;
  const S rp = M[3 * r + p], rq = M[3 * r + q];
  M[3 * r + p] = M[3 * p + r] = c * rp - s * rq;
  M[3 * r + q] = M[3 * q + r] = s * rp + c * rq;
  for (int i = 0; i < 3; ++i) {
    const S vp = V[3 * i + p], vq = V[3 * i + q];
    V[3 * i + p] = c * vp - s * vq;
    V[3 * i + q] = s * vp + c * vq;
  }
  return true;
}

}  // namespace spectral

/// Eigenvalues (in no order) and orthonormal eigenvectors (columns of `vectors`, 9 scalars row
/// major) of a symmetric matrix, to rounding of its norm; repeated eigenvalues are no special case.
/// Cyclic Jacobi: it has converged after five sweeps at most, six are allowed.
/// Source: Golub and Van Loan, Matrix Computations (2013), 8.5.
template <class S>
PALPATE_INLINE void eigen_of(const S* symmetric, S* values, S* vectors) {
  const S zero = symmetric[0] * 0.0;
  S M[9];
  S squares = zero;
  for (int i = 0; i < 9; ++i) {
    M[i] = symmetric[i];
    squares += M[i] * M[i];
    vectors[i] = zero;
  }
  for (int i = 0; i < 9; i += 4) vectors[i] += 1.0;
  const S negligible = squares * 1e-36;
  for (int sweep = 0; sweep < 6; ++sweep) {
    bool is_turned = spectral::rotate<0, 1>(negligible, M, vectors);
    is_turned |= spectral::rotate<0, 2>(negligible, M, vectors);
    is_turned |= spectral::rotate<1, 2>(negligible, M, vectors);
    if (!is_turned) break;
  }
  for (int a = 0; a < 3; ++a) values[a] = M[4 * a];
}

}  // namespace palpate::fem
