#pragma once

#include <limits>

#include "libfem/materials/kinematics.hpp"
#include "libfem/materials/materials.hpp"

namespace palpate::fem {

/// Which invariants an isochoric law reads beside the first.
enum class Uses { first, first_and_second, first_and_fibre };

/// Energy of shape and its derivatives by the invariants x1 = I1 J^(-2/3) - 3 and x2: the second,
/// I2 J^(-4/3) - 3, or the fibre's, a.C a - 1. Laws of x1 alone leave the rest unset.
template <class S>
struct ShapeTerms {
  S w, w1, w2, w11, w12, w22;
};

/// Laws W = w(x1, x2) + K/2 (J - 1)^2 with the part of shape apart from that of volume.
/// A law derives from this and gives `template <class S> static void shape(const S* constants,
/// const S& x1, const S& x2, ShapeTerms<S>& out)`; constants[0] is the bulk modulus, and with
/// kUses == first_and_fibre the last three are the unit fibre direction at rest.
/// geometric_scale: W is read as a function of F and J; geometric_scale scales dW/dJ times the
/// second derivative of J. 1 is the exact tangent. At 0 laws of x1 (and the fibre) with rising,
/// convex w have a positive semidefinite one: I1 J^(-2/3) and (J - 1)^2 are convex in F and J. The
/// second invariant is not. Source: Bonet and Wood, Nonlinear Continuum Mechanics for Finite
/// Element Analysis (2008), 6.5.
template <class Law, Uses kUses = Uses::first>
struct IsochoricLaw {
  /// The shear modulus is twice the sum of the derivatives of w by I1 and I2 at rest.
  static SmallStrain small_strain(const LawConstants& constants) {
    ShapeTerms<double> rest;
    Law::template shape<double>(constants.data(), 0.0, 0.0, rest);
    return of_shear_and_bulk(2 * (kUses == Uses::first_and_second ? rest.w1 + rest.w2 : rest.w1),
                             constants[0]);
  }

  /// U(J), the whole part of W that carries the bulk modulus.
  template <class S>
  static PALPATE_INLINE void volumetric(const S* constants, const S& dilation, S& U, S& U1, S& U2) {
    quadratic_volume(constants[0], dilation, U, U1, U2);
  }

  /// As NeoHookean::evaluate.
  template <class S>
  static PALPATE_INLINE void evaluate(const S* constants, const S* H, double geometric_scale, S& J,
                                      S& W, S* P, S* A) {
    SoundState<S> state(H);
    J = state.J;
    const ShapeState<S> shape(state.H, state.J_sound);
    Invariants<S> at;
    at.evaluate(shape);
    S fibre_stretched[3];
    if constexpr (kUses == Uses::first_and_fibre) {
      const S* a = constants + Law::kConstants - 3;
      stretch_along(a, shape.e, at.x2);
      for (int i = 0; i < 3; ++i)
        fibre_stretched[i] =
            state.F[3 * i] * a[0] + state.F[3 * i + 1] * a[1] + state.F[3 * i + 2] * a[2];
    }
    ShapeTerms<S> terms;
    Law::template shape<S>(constants, at.x1, at.x2, terms);
    S U, U1, U2;
    volumetric(constants, state.dilation, U, U1, U2);
    const S infinite = J * 0.0 + std::numeric_limits<double>::infinity();
    W = J > 0.0 ? terms.w + U : infinite;
    if (!P) return;

    // Halves of the derivatives of x1 and x2 by F.
    state.invert();
    S m1[9], m2[9];
    at.first_derivative(shape, state.g, m1);
    if constexpr (kUses == Uses::first_and_second) at.second_derivative(shape, state.g, m2);
    if constexpr (kUses == Uses::first_and_fibre)
      for (int i = 0; i < 9; ++i)
        m2[i] = fibre_stretched[i / 3] * constants[Law::kConstants - 3 + i % 3];
    const S pressure_part = state.J_sound * U1;
    for (int i = 0; i < 9; ++i) {
      P[i] = 2.0 * terms.w1 * m1[i] + pressure_part * state.g[i];
      if constexpr (kUses != Uses::first) P[i] += 2.0 * terms.w2 * m2[i];
    }
    if (!A) return;

    tangent(constants, geometric_scale, state, shape, at, terms, pressure_part,
            S(state.J_sound * state.J_sound * U2), m1, m2, A);
  }

 private:
  template <class S>
  struct Invariants {
    S x1, x2, root, j1;  ///< root: det(1 + d)^(-1/3); j1: J^(-2/3)

    PALPATE_INLINE void evaluate(const ShapeState<S>& shape) {
      S change;
      expm1_of(S(shape.log_det * (-1.0 / 3)), change);
      root = change + 1.0;
      x1 = 3.0 * change;
      if constexpr (kUses == Uses::first_and_second)
        x2 = 3.0 * change * (change + 2.0) - 0.5 * shape.d_squared * (root * root);
      j1 = root / shape.scale;
    }

    /// J^(-2/3) (F - I1/3 F^-T) = J^(-2/3) F^-T dev C.
    PALPATE_INLINE void first_derivative(const ShapeState<S>& shape, const S* g, S* out) const {
      product_of(g, shape.d, out);
      for (int i = 0; i < 9; ++i) out[i] *= root;
    }

    /// J^(-4/3) (I1 F - F C - 2/3 I2 F^-T) = J^(-4/3) F^-T dev (I1 C - C^2).
    PALPATE_INLINE void second_derivative(const ShapeState<S>& shape, const S* g, S* out) const {
      S inner[9];
      product_of(shape.d, shape.d, inner);
      for (int i = 0; i < 9; ++i) inner[i] = shape.d[i] - inner[i];
      for (int i = 0; i < 9; i += 4) inner[i] += shape.d_squared * (1.0 / 3);
      product_of(g, inner, out);
      for (int i = 0; i < 9; ++i) out[i] *= root * root;
    }
  };

  template <class S>
  static PALPATE_INLINE void stretch_along(const S* a, const S* e, S& out) {
    out = a[0] * a[0] * e[0] + a[1] * a[1] * e[4] + a[2] * a[2] * e[8] +
          2.0 * (a[0] * a[1] * e[1] + a[0] * a[2] * e[2] + a[1] * a[2] * e[5]);
  }

  template <class S>
  static PALPATE_INLINE void tangent(const S* constants, double geometric_scale,
                                     const SoundState<S>& state, const ShapeState<S>& shape,
                                     const Invariants<S>& at, const ShapeTerms<S>& terms,
                                     const S& pressure_part, const S& stiff_part, const S* m1,
                                     const S* m2, S* A) {
    const S* g = state.g;
    const S* F = state.F;
    const S zero = state.J * 0.0;
    // A = c11 m1 m1 + c1g (m1 g + g m1) + cgg g g + ... + diagonal - geometric g_iL g_kJ
    const S first = 2.0 * terms.w1;
    const S I1 = at.x1 + 3.0;
    const S c11 = 4.0 * terms.w11, c1g = first * (-2.0 / 3);
    S c12 = zero, c22 = zero, c2g = zero;
    S cgg = stiff_part + first * I1 * (1.0 / 9);
    S geometric = pressure_part - first * I1 * (1.0 / 3);  // J dW/dJ at fixed F
    S diagonal = first * at.j1, second = zero;
    S C[9], B[9];
    if constexpr (kUses != Uses::first) {
      c12 = 4.0 * terms.w12;
      c22 = 4.0 * terms.w22;
    }
    if constexpr (kUses == Uses::first_and_second) {
      const S I2 = at.x2 + 3.0;
      c2g = terms.w2 * (-8.0 / 3);
      cgg += terms.w2 * I2 * (-4.0 / 9);
      geometric += terms.w2 * I2 * (-4.0 / 3);
      second = 2.0 * terms.w2 * (at.j1 * at.j1);
      diagonal += second * shape.scale * 3.0;
      for (int i = 0; i < 9; ++i) C[i] = shape.e[i];
      for (int i = 0; i < 9; i += 4) C[i] += 1.0;
      for (int i = 0; i < 3; ++i)
        for (int k = i; k < 3; ++k)
          B[3 * i + k] = B[3 * k + i] =
              F[3 * i] * F[3 * k] + F[3 * i + 1] * F[3 * k + 1] + F[3 * i + 2] * F[3 * k + 2];
    }
    geometric *= geometric_scale;
    cgg += geometric;
    for (int a = 0; a < 9; ++a) {
      const int i = a / 3, K = a % 3;
      S r1 = c11 * m1[a] + c1g * g[a], rg = c1g * m1[a] + cgg * g[a], r2 = zero;
      if constexpr (kUses != Uses::first) {
        r1 += c12 * m2[a];
        rg += c2g * m2[a];
        r2 = c12 * m1[a] + c22 * m2[a] + c2g * g[a];
      }
      for (int b = a; b < 9; ++b) {
        const int k = b / 3, L = b % 3;
        S entry = r1 * m1[b] + rg * g[b] - geometric * (g[3 * i + L] * g[3 * k + K]);
        if constexpr (kUses != Uses::first) entry += r2 * m2[b];
        if constexpr (kUses == Uses::first_and_second) {
          entry += second * (2.0 * (F[a] * F[b]) - F[3 * i + L] * F[3 * k + K]);
          if (i == k) entry -= second * C[3 * K + L];
          if (K == L) entry -= second * B[3 * i + k];
        }
        if constexpr (kUses == Uses::first_and_fibre)
          if (i == k) {
            const S* direction = constants + Law::kConstants - 3;
            entry += 2.0 * terms.w2 * (direction[K] * direction[L]);
          }
        if (a == b) entry += diagonal;
        A[9 * a + b] = entry;
      }
    }
  }
};

}  // namespace palpate::fem
