#pragma once

#include <cstring>

#include "libfem/elements/element_kernels.hpp"
#include "libfem/materials/kinematics.hpp"

namespace palpate::fem {

// Energy, force and stiffness of eight elements at once, compiled for every instruction set by
// element_kernels.cpp.

// Between points in memory (three numbers and a fourth that is zero) and Packs of a coordinate of
// eight lanes. A lane is one load or store of a whole point: number by number, gathering and
// scattering took as long as the kernel between them.

typedef double Quad __attribute__((vector_size(kPointStride * sizeof(double))));

PALPATE_INLINE void load_quad(const double* from, Quad& to) {
  std::memcpy(&to, from, sizeof(Quad));
}

/// to: x, y and z of point[lane], each lane one of `points` rows.
PALPATE_INLINE void gather_points(const double* points, const std::int32_t* point, Pack* to) {
  Pack pair[4];  // lanes k and k + 4
  for (int k = 0; k < 4; ++k) {
    Quad low, high;
    load_quad(points + std::ptrdiff_t{kPointStride} * point[k], low);
    load_quad(points + std::ptrdiff_t{kPointStride} * point[k + 4], high);
    pair[k] = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
  }
  const Pack xz01 = __builtin_shufflevector(pair[0], pair[1], 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack xz23 = __builtin_shufflevector(pair[2], pair[3], 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack y01 = __builtin_shufflevector(pair[0], pair[1], 1, 9, 3, 11, 5, 13, 7, 15);
  const Pack y23 = __builtin_shufflevector(pair[2], pair[3], 1, 9, 3, 11, 5, 13, 7, 15);
  to[0] = __builtin_shufflevector(xz01, xz23, 0, 1, 8, 9, 4, 5, 12, 13);
  to[1] = __builtin_shufflevector(y01, y23, 0, 1, 8, 9, 4, 5, 12, 13);
  to[2] = __builtin_shufflevector(xz01, xz23, 2, 3, 10, 11, 6, 7, 14, 15);
}

/// points[point[lane]] += x, y and z of the lane, in the order of lanes.
PALPATE_INLINE void scatter_points(const Pack* from, const std::int32_t* point, double* points) {
  const Pack zero = Pack{};
  const Pack xy_even = __builtin_shufflevector(from[0], from[1], 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack xy_odd = __builtin_shufflevector(from[0], from[1], 1, 9, 3, 11, 5, 13, 7, 15);
  const Pack z_even = __builtin_shufflevector(from[2], zero, 0, 8, 2, 10, 4, 12, 6, 14);
  const Pack z_odd = __builtin_shufflevector(from[2], zero, 1, 9, 3, 11, 5, 13, 7, 15);
  const Pack pair[4] = {// lanes k and k + 4
                        __builtin_shufflevector(xy_even, z_even, 0, 1, 8, 9, 4, 5, 12, 13),
                        __builtin_shufflevector(xy_odd, z_odd, 0, 1, 8, 9, 4, 5, 12, 13),
                        __builtin_shufflevector(xy_even, z_even, 2, 3, 10, 11, 6, 7, 14, 15),
                        __builtin_shufflevector(xy_odd, z_odd, 2, 3, 10, 11, 6, 7, 14, 15)};
  const auto add = [&](int lane, const Quad& force) {
    double* to = points + std::ptrdiff_t{kPointStride} * point[lane];
    Quad sum;
    load_quad(to, sum);
    sum += force;
    std::memcpy(to, &sum, sizeof(Quad));
  };
  for (int k = 0; k < 4; ++k) add(k, __builtin_shufflevector(pair[k], pair[k], 0, 1, 2, 3));
  for (int k = 0; k < 4; ++k) add(k + 4, __builtin_shufflevector(pair[k], pair[k], 4, 5, 6, 7));
}

PALPATE_INLINE void displacement_gradient(const Pack* gradient, const Pack* displacement, Pack* H) {
  Pack sum[9] = {};  // kept in registers: H may alias what is read
  for (int a = 0; a < kElementNodes; ++a)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) sum[3 * i + j] += displacement[3 * a + i] * gradient[3 * a + j];
  for (int i = 0; i < 9; ++i) H[i] = sum[i];
}

/// force_a[i] = sum_q sum_J P_q[iJ] G_qa[J].
PALPATE_INLINE void sum_forces(const Pack* gradient, const Pack* P, Pack* force) {
  for (int a = 0; a < kElementNodes; ++a) {
    Pack sum[3] = {};
    for (int q = 0; q < kElementPoints; ++q) {
      const Pack* G = gradient + 3 * (kElementNodes * q + a);
      for (int i = 0; i < 3; ++i) {
        const Pack* row = P + 9 * q + 3 * i;
        sum[i] += row[0] * G[0] + row[1] * G[1] + row[2] * G[2];
      }
    }
    for (int i = 0; i < 3; ++i) force[3 * a + i] = sum[i];
  }
}

/// K_ab[i][k] += sum_JL G_a[J] A[iJ][kL] G_b[L].
PALPATE_INLINE void add_stiffness(const Pack* gradient, const Pack* A, Pack* stiffness) {
  for (int b = 0; b < kElementNodes; ++b) {
    Pack T[27];  // [iJ][k]
    for (int iJ = 0; iJ < 9; ++iJ)
      for (int k = 0; k < 3; ++k) {
        Pack sum = Pack{};
        for (int L = 0; L < 3; ++L) {
          const int kL = 3 * k + L;
          sum += (iJ <= kL ? A[9 * iJ + kL] : A[9 * kL + iJ]) * gradient[3 * b + L];
        }
        T[3 * iJ + k] = sum;
      }
    for (int a = b; a < kElementNodes; ++a) {
      Pack* block = stiffness + 9 * (a * (a + 1) / 2 + b);
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
          block[3 * i + k] += gradient[3 * a] * T[9 * i + k] +
                              gradient[3 * a + 1] * T[9 * i + 3 + k] +
                              gradient[3 * a + 2] * T[9 * i + 6 + k];
    }
  }
}

/// J - 1, summed from the small terms, and dJ/dF.
template <class S>
PALPATE_INLINE void dilation_of(const S* H, S& dilation, S* cofactor) {
  S F[9];
  for (int i = 0; i < 9; ++i) F[i] = i % 4 == 0 ? H[i] + 1.0 : H[i];
  cofactors_of(F, cofactor);
  const GradientInvariants<S> in(H);
  dilation = in.trace + in.minors + in.determinant;
}

/// A[iJ][kL] += pressure d2J/dF_iJ dF_kL, upper triangle: e_ikm e_JLn F_mn.
PALPATE_INLINE void add_second_derivative_of_J(const Pack* H, const Pack& pressure, Pack* A) {
  for (int i = 0; i < 3; ++i)
    for (int k = i + 1; k < 3; ++k)
      for (int J = 0; J < 3; ++J)
        for (int L = 0; L < 3; ++L) {
          if (J == L) continue;
          const int m = 3 - i - k, n = 3 - J - L;
          const bool is_even = ((k - i + 3) % 3 == 1) == ((L - J + 3) % 3 == 1);
          const Pack F = m == n ? H[3 * m + n] + 1.0 : H[3 * m + n];
          A[9 * (3 * i + J) + 3 * k + L] += is_even ? pressure * F : -(pressure * F);
        }
}

/// U and its derivatives; +inf, 0, 0 where the volume is gone. Nothing on lanes without weight.
PALPATE_INLINE void volumetric(const LawKernels& law, const Pack* constants, const Pack& weight,
                               const Pack& dilation, Pack& U, Pack& U1, Pack& U2) {
  const Pack zero = Pack{};
  // One comparison, with a constant: several joined, g++ 12 makes lane by lane.
  const Pack room = weight > 0.0 ? dilation + 1.0 : zero;
  const Pack gone = weight > 0.0 ? zero + __builtin_inf() : zero;
  law.volumetric(constants, room > 0.0 ? dilation : zero, U, U1, U2);
  U = room > 0.0 ? U : gone;
  U1 = room > 0.0 ? U1 : zero;
  U2 = room > 0.0 ? U2 : zero;
}

/// The volume change of eight elements, averaged.
struct Averaged {
  Pack H[9 * kElementPoints], dilation[kElementPoints], cofactor[9 * kElementPoints];
  Pack U, U2;                     // at the mean of the dilation
  Pack pressure[kElementPoints];  // the mean of U1 there; 0 at points of weight 0
};

PALPATE_INLINE void average(const CellBatch& batch, const LawKernels& law, const Pack* displacement,
                            Averaged& out) {
  Pack dilation_mode = Pack{}, pressure_mode = Pack{};
  Pack weight = Pack{}, mode = Pack{};  // of any point that is not idle
  for (int q = 0; q < kElementPoints; ++q) {
    weight = batch.weight[q] > weight ? batch.weight[q] : weight;
    mode = batch.mode[q] > mode ? batch.mode[q] : mode;
    Pack* H = out.H + 9 * q;
    displacement_gradient(batch.gradient + 3 * kElementNodes * q, displacement, H);
    dilation_of(H, out.dilation[q], out.cofactor + 9 * q);
    dilation_mode += batch.weight[q] * batch.mode[q] * out.dilation[q];
  }
  Pack U1;
  volumetric(law, batch.constants, weight, mode * dilation_mode, out.U, U1, out.U2);
  for (int q = 0; q < kElementPoints; ++q) pressure_mode += batch.weight[q] * batch.mode[q] * U1;
  for (int q = 0; q < kElementPoints; ++q) out.pressure[q] = batch.mode[q] * pressure_mode;
}

/// A quadrature point of eight elements: W and, as wanted, its derivatives P and A by H. U, U1, U2:
/// the volumetric part of W there. C: dJ/dF.
struct CellPoint {
  int q;
  const Pack *H, *C;
  Pack dilation, U, U1, U2, W;
  Pack *P, *A;
};

/// Replaces a share of U(J) at a point by U(theta) (M14).
template <Want kWant>
PALPATE_INLINE void use_averaged(const Averaged& averaged, const CellBatch& batch, CellPoint& at) {
  at.W = at.dilation + 1.0 > 0.0 ? at.W + batch.averaged * (averaged.U - at.U) : at.W;
  const Pack* C = at.C;
  const Pack mean = averaged.pressure[at.q];
  const Pack pressure = batch.averaged * (mean - at.U1), U2 = at.U2 * batch.averaged;
  if constexpr (kWant != Want::energy)
    for (int i = 0; i < 9; ++i) at.P[i] += pressure * C[i];
  if constexpr (kWant == Want::stiffness) {
    for (int i = 0; i < 9; ++i)
      for (int j = i; j < 9; ++j) at.A[9 * i + j] -= U2 * (C[i] * C[j]);
    const Pack most = Pack{} + batch.max_pressure_Pa;
    Pack bounded = mean < most ? mean : most;
    bounded = bounded > -most ? bounded : -most;
    add_second_derivative_of_J(at.H, batch.averaged * batch.geometric_scale * (bounded - at.U1),
                               at.A);
  }
}

/// Replaces W by the potential of a step in time (M14a).
template <Want kWant>
PALPATE_INLINE void use_step(const CellBatch& batch, CellPoint& at) {
  const Pack *held = batch.held + 6 * at.q, *H = at.H, *C = at.C;
  Pack *P = at.P, *A = at.A;
  constexpr int kEntry[9] = {0, 3, 4, 3, 1, 5, 4, 5, 2};
  const double beyond = batch.stiffening - 1;
  Pack strain[9], work = Pack{};  // twice Green's strain
  metric_change_of(H, strain);
  for (int i = 0; i < 9; ++i) work += held[kEntry[i]] * strain[i];
  at.W = at.dilation + 1.0 > 0.0 ? at.W + beyond * (at.W - at.U) + 0.5 * work : at.W;
  if constexpr (kWant != Want::energy)
    for (int i = 0; i < 3; ++i)
      for (int J = 0; J < 3; ++J) {
        const int iJ = 3 * i + J;
        P[iJ] += beyond * (P[iJ] - at.U1 * C[iJ]) + held[kEntry[iJ]];
        for (int L = 0; L < 3; ++L) P[iJ] += H[3 * i + L] * held[kEntry[3 * L + J]];
      }
  if constexpr (kWant == Want::stiffness) {
    for (int i = 0; i < 9; ++i)
      for (int j = i; j < 9; ++j) A[9 * i + j] += beyond * (A[9 * i + j] - at.U2 * (C[i] * C[j]));
    add_second_derivative_of_J(H, -(beyond * batch.geometric_scale) * at.U1, A);
    for (int i = 0; i < 3; ++i)
      for (int J = 0; J < 3; ++J)
        for (int L = J; L < 3; ++L)
          A[9 * (3 * i + J) + 3 * i + L] += batch.geometric_scale * held[kEntry[3 * J + L]];
  }
}

/// Replaces W by the potential of a softening material (M54b).
template <Want kWant>
PALPATE_INLINE void use_softening(const CellBatch& batch, CellPoint& at) {
  const Pack* C = at.C;
  Pack *P = at.P, *A = at.A, added, reduction, slope;
  const Pack shape = at.dilation + 1.0 > 0.0 ? at.W - at.U : Pack{};
  soften(batch.softening, batch.peak[at.q], shape, added, reduction, slope);
  at.W = at.W + added;
  if constexpr (kWant != Want::energy) {
    Pack shape_P[9];
    for (int i = 0; i < 9; ++i) shape_P[i] = P[i] - at.U1 * C[i];
    for (int i = 0; i < 9; ++i) P[i] -= reduction * shape_P[i];
    if constexpr (kWant == Want::stiffness) {
      for (int i = 0; i < 9; ++i)
        for (int j = i; j < 9; ++j)
          A[9 * i + j] += slope * (shape_P[i] * shape_P[j]) -
                          reduction * (A[9 * i + j] - at.U2 * (C[i] * C[j]));
      add_second_derivative_of_J(at.H, batch.geometric_scale * (reduction * at.U1), A);
    }
  }
}

/// K += D B B^T: B derivative of the dilation's mean, D that of the pressure's.
PALPATE_INLINE void add_mean(const Averaged& averaged, const CellBatch& batch, Pack* stiffness) {
  Pack B[3 * kElementNodes], DB[3 * kElementNodes], C[9 * kElementPoints], D = Pack{};
  for (int q = 0; q < kElementPoints; ++q) {
    const Pack share = batch.weight[q] * batch.mode[q];
    for (int i = 0; i < 9; ++i) C[9 * q + i] = averaged.cofactor[9 * q + i] * share;
    D += batch.weight[q] * averaged.U2 * (batch.mode[q] * batch.mode[q] * batch.averaged);
  }
  sum_forces(batch.gradient, C, B);
  for (int i = 0; i < 3 * kElementNodes; ++i) DB[i] = D * B[i];
  for (int a = 0; a < kElementNodes; ++a)
    for (int b = 0; b <= a; ++b)
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
          stiffness[9 * (a * (a + 1) / 2 + b) + 3 * i + k] += B[3 * a + i] * DB[3 * b + k];
}

template <Remembers kHistory, Want kWant>
PALPATE_INLINE void integrate(const CellBatch& batch, const LawKernels& law,
                              const Pack* displacement, CellResult& out) {
  const Pack zero = Pack{};
  out.energy = zero;
  out.min_J = zero + 1e300;
  if constexpr (kWant == Want::stiffness)
    for (int i = 0; i < 9 * kElementBlocks; ++i) out.stiffness[i] = zero;
  Averaged averaged;
  average(batch, law, displacement, averaged);
  Pack stress[9 * kElementPoints];
  for (int q = 0; q < kElementPoints; ++q) {
    const Pack* constants = batch.constants + batch.constant_count * q;
    const Pack weight = batch.weight[q];
    Pack A[81], J;
    CellPoint at;
    at.q = q;
    at.H = averaged.H + 9 * q;
    at.C = averaged.cofactor + 9 * q;
    at.dilation = averaged.dilation[q];
    at.P = kWant == Want::energy ? nullptr : stress + 9 * q;
    at.A = kWant == Want::stiffness ? A : nullptr;
    law.evaluate(constants, at.H, batch.geometric_scale, J, at.W, at.P, at.A);
    volumetric(law, constants, weight, at.dilation, at.U, at.U1, at.U2);
    if constexpr (kHistory == Remembers::time) use_step<kWant>(batch, at);
    if constexpr (kHistory == Remembers::peak) use_softening<kWant>(batch, at);
    use_averaged<kWant>(averaged, batch, at);
    out.energy += weight > 0.0 ? at.W * weight : zero;
    const Pack there = weight > 0.0 ? J : out.min_J;
    out.min_J = there < out.min_J ? there : out.min_J;
    if constexpr (kWant != Want::energy)
      for (int i = 0; i < 9; ++i) at.P[i] = weight > 0.0 ? at.P[i] * weight : zero;
    if constexpr (kWant == Want::stiffness) {
      for (int i = 0; i < 9; ++i)
        for (int j = i; j < 9; ++j) A[9 * i + j] = weight > 0.0 ? A[9 * i + j] * weight : zero;
      add_stiffness(batch.gradient + 3 * kElementNodes * q, A, out.stiffness);
    }
  }
  if constexpr (kWant != Want::energy) sum_forces(batch.gradient, stress, out.force);
  if constexpr (kWant == Want::stiffness) add_mean(averaged, batch, out.stiffness);
}

}  // namespace palpate::fem
