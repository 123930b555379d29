#pragma once

#include "libfem/materials/pack_math.hpp"

namespace palpate::fem {

// From the displacement gradient H = F - 1 to what laws are written in. Everything that vanishes at
// rest is summed from terms that vanish at rest, so small strains lose no digits. Matrices are 9
// scalars, row major; S is a double or a Pack.

/// Principal invariants of H: trace, sum of principal minors, determinant; det F - 1 is their sum.
template <class S>
struct GradientInvariants {
  S trace, minors, determinant;

  PALPATE_INLINE explicit GradientInvariants(const S* H)
      : trace(H[0] + H[4] + H[8]),
        minors(H[4] * H[8] - H[5] * H[7] + H[0] * H[8] - H[2] * H[6] + H[0] * H[4] - H[1] * H[3]),
        determinant(H[0] * (H[4] * H[8] - H[5] * H[7]) + H[1] * (H[5] * H[6] - H[3] * H[8]) +
                    H[2] * (H[3] * H[7] - H[4] * H[6])) {}
};

/// Cofactors of a 3 x 3 matrix.
template <class S>
PALPATE_INLINE void cofactors_of(const S* M, S* out) {
  out[0] = M[4] * M[8] - M[5] * M[7];
  out[1] = M[5] * M[6] - M[3] * M[8];
  out[2] = M[3] * M[7] - M[4] * M[6];
  out[3] = M[2] * M[7] - M[1] * M[8];
  out[4] = M[0] * M[8] - M[2] * M[6];
  out[5] = M[1] * M[6] - M[0] * M[7];
  out[6] = M[1] * M[5] - M[2] * M[4];
  out[7] = M[2] * M[3] - M[0] * M[5];
  out[8] = M[0] * M[4] - M[1] * M[3];
}

/// C - 1 = H + H^T + H^T H, twice Green's strain.
template <class S>
PALPATE_INLINE void metric_change_of(const S* H, S* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j)
      out[3 * i + j] = out[3 * j + i] =
          H[3 * i + j] + H[3 * j + i] + H[i] * H[j] + H[3 + i] * H[3 + j] + H[6 + i] * H[6 + j];
}

/// out = A B.
template <class S>
PALPATE_INLINE void product_of(const S* A, const S* B, S* out) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      out[3 * i + j] = A[3 * i] * B[j] + A[3 * i + 1] * B[3 + j] + A[3 * i + 2] * B[6 + j];
}

/// Volumetric energy U = K/2 (J - 1)^2 [Pa] from dilation = J - 1, finite at every J, and its first
/// two derivatives by J.
template <class S>
PALPATE_INLINE void quadratic_volume(const S& bulk, const S& dilation, S& U, S& U1, S& U2) {
  U1 = bulk * dilation;
  U = U1 * dilation * 0.5;
  U2 = bulk;
}

/// A state for laws that end where the volume is gone. J is det F as it is; lanes where it is not
/// positive are put to rest (H = 0) in everything else, so that nothing there is NaN: the law gives
/// them infinite energy, zero stress and its tangent at rest.
template <class S>
struct SoundState {
  S J, dilation, J_sound;  ///< dilation = J_sound - 1
  S H[9], F[9];
  S g[9];  ///< F^-T

  PALPATE_INLINE explicit SoundState(const S* H_given) {
    const S zero = H_given[0] * 0.0;
    const GradientInvariants<S> given(H_given);
    const S change = given.trace + given.minors + given.determinant;
    J = change + 1.0;
    for (int i = 0; i < 9; ++i) F[i] = H[i] = J > 0.0 ? H_given[i] : zero;
    for (int i = 0; i < 9; i += 4) F[i] += 1.0;
    dilation = J > 0.0 ? change : zero;
    J_sound = dilation + 1.0;
  }

  PALPATE_INLINE void invert() {
    cofactors_of(F, g);
    const S inverse_J = (H[0] * 0.0 + 1.0) / J_sound;
    for (S& entry : g) entry *= inverse_J;
  }
};

/// C = scale (1 + d) with traceless d: the shape of the strain, free of its volume.
/// shape_change: det(1 + d) - 1, of second order in d; log_det: log det(1 + d).
template <class S>
struct ShapeState {
  S e[9];  ///< C - 1
  S scale, d[9], d_squared;
  S shape_change, det, log_det;

  PALPATE_INLINE ShapeState(const S* H, const S& J) {
    metric_change_of(H, e);
    const S third = (e[0] + e[4] + e[8]) * (1.0 / 3);
    scale = third + 1.0;
    const S inverse = (third * 0.0 + 1.0) / scale;
    for (int i = 0; i < 9; ++i) d[i] = (i % 4 == 0 ? e[i] - third : e[i]) * inverse;
    d_squared =
        d[0] * d[0] + d[4] * d[4] + d[8] * d[8] + 2.0 * (d[1] * d[1] + d[2] * d[2] + d[5] * d[5]);
    const S determinant = d[0] * (d[4] * d[8] - d[5] * d[7]) + d[1] * (d[5] * d[6] - d[3] * d[8]) +
                          d[2] * (d[3] * d[7] - d[4] * d[6]);
    shape_change = determinant - d_squared * 0.5;
    // det(1 + d) = J^2 / scale^3; the second form is right where the shape is nearly flat.
    const S ratio = J * inverse;
    det = shape_change > -0.5 ? shape_change + 1.0 : ratio * ratio * inverse;
    S log_less;
    log_of(shape_change, det, log_det, log_less);
  }
};

}  // namespace palpate::fem
