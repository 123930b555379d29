#include "libfem/solve/element_kernels.hpp"

namespace palpate::fem {
namespace {

enum class Want { energy, force, stiffness };

template <int kNodes>
PALPATE_INLINE void displacement_gradient(const Pack* gradient, const Pack* displacement, Pack* H) {
  for (int i = 0; i < 9; ++i) H[i] = Pack{};
  for (int a = 0; a < kNodes; ++a)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) H[3 * i + j] += displacement[3 * a + i] * gradient[3 * a + j];
}

/// force_a[i] += sum_J P[iJ] G_a[J].
template <int kNodes>
PALPATE_INLINE void add_force(const Pack* gradient, const Pack* P, Pack* force) {
  for (int a = 0; a < kNodes; ++a)
    for (int i = 0; i < 3; ++i)
      force[3 * a + i] += P[3 * i] * gradient[3 * a] + P[3 * i + 1] * gradient[3 * a + 1] +
                          P[3 * i + 2] * gradient[3 * a + 2];
}

/// K_ab[i][k] += sum_JL G_a[J] A[iJ][kL] G_b[L].
template <int kNodes>
PALPATE_INLINE void add_stiffness(const Pack* gradient, const Pack* A, Pack* stiffness) {
  for (int b = 0; b < kNodes; ++b) {
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
    for (int a = b; a < kNodes; ++a) {
      Pack* block = stiffness + 9 * (a * (a + 1) / 2 + b);
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
          block[3 * i + k] += gradient[3 * a] * T[9 * i + k] + gradient[3 * a + 1] * T[9 * i + 3 + k] +
                              gradient[3 * a + 2] * T[9 * i + 6 + k];
    }
  }
}

/// J - 1, summed from the small terms, and dJ/dF.
PALPATE_INLINE void dilation_of(const Pack* H, Pack& dilation, Pack* cofactor) {
  const Pack f00 = H[0] + 1.0, f11 = H[4] + 1.0, f22 = H[8] + 1.0;
  cofactor[0] = f11 * f22 - H[5] * H[7];
  cofactor[1] = H[5] * H[6] - H[3] * f22;
  cofactor[2] = H[3] * H[7] - f11 * H[6];
  cofactor[3] = H[2] * H[7] - H[1] * f22;
  cofactor[4] = f00 * f22 - H[2] * H[6];
  cofactor[5] = H[1] * H[6] - f00 * H[7];
  cofactor[6] = H[1] * H[5] - H[2] * f11;
  cofactor[7] = H[2] * H[3] - f00 * H[5];
  cofactor[8] = f00 * f11 - H[1] * H[3];
  const Pack minors =
      H[4] * H[8] - H[5] * H[7] + H[0] * H[8] - H[2] * H[6] + H[0] * H[4] - H[1] * H[3];
  const Pack determinant = H[0] * (H[4] * H[8] - H[5] * H[7]) + H[1] * (H[5] * H[6] - H[3] * H[8]) +
                           H[2] * (H[3] * H[7] - H[4] * H[6]);
  dilation = H[0] + H[4] + H[8] + minors + determinant;
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
  const double least = law.least_dilation;
  law.volumetric(constants, dilation > least ? dilation : zero, U, U1, U2);
  U = weight > 0.0 ? (dilation > least ? U : zero + __builtin_inf()) : zero;
  U1 = (weight > 0.0) & (dilation > least) ? U1 : zero;
  U2 = (weight > 0.0) & (dilation > least) ? U2 : zero;
}

/// The volume change of eight cells, projected on the modes.
template <int kPoints, int kModes>
struct Projected {
  Pack dilation[kPoints], cofactor[9 * kPoints];
  Pack U[kPoints], U2[kPoints];  // at the projected dilation
  Pack pressure[kPoints];        // U1 there, projected in turn
};

template <int kNodes, int kPoints, int kModes>
PALPATE_INLINE void project(const CellBatch& batch, const LawKernels& law, const Pack* displacement,
                            Projected<kPoints, kModes>& out) {
  Pack dilation_mode[kModes], pressure_mode[kModes];
  for (int m = 0; m < kModes; ++m) dilation_mode[m] = pressure_mode[m] = Pack{};
  for (int q = 0; q < kPoints; ++q) {
    Pack H[9];
    displacement_gradient<kNodes>(batch.gradient + 3 * kNodes * q, displacement, H);
    dilation_of(H, out.dilation[q], out.cofactor + 9 * q);
    for (int m = 0; m < kModes; ++m)
      dilation_mode[m] += batch.weight[q] * batch.mode[kPoints * m + q] * out.dilation[q];
  }
  for (int q = 0; q < kPoints; ++q) {
    Pack theta = Pack{}, U1;
    for (int m = 0; m < kModes; ++m) theta += batch.mode[kPoints * m + q] * dilation_mode[m];
    volumetric(law, batch.constants + batch.constant_count * q, batch.weight[q], theta, out.U[q], U1,
               out.U2[q]);
    for (int m = 0; m < kModes; ++m)
      pressure_mode[m] += batch.weight[q] * batch.mode[kPoints * m + q] * U1;
  }
  for (int q = 0; q < kPoints; ++q) {
    out.pressure[q] = Pack{};
    for (int m = 0; m < kModes; ++m)
      out.pressure[q] += batch.mode[kPoints * m + q] * pressure_mode[m];
  }
}

/// Replaces a share of U(J) at a point by U(theta); P and A only as wanted.
template <Want kWant, int kPoints, int kModes>
PALPATE_INLINE void use_projected(const Projected<kPoints, kModes>& projected, const CellBatch& batch,
                                  const LawKernels& law, int q, const Pack* H, double bend, Pack& W,
                                  Pack* P, Pack* A) {
  Pack U, U1, U2;
  volumetric(law, batch.constants + batch.constant_count * q, batch.weight[q], projected.dilation[q],
             U, U1, U2);
  W = projected.dilation[q] > law.least_dilation ? W + batch.averaged * (projected.U[q] - U) : W;
  const Pack* C = projected.cofactor + 9 * q;
  const Pack pressure = batch.averaged * (projected.pressure[q] - U1);
  U2 *= batch.averaged;
  if constexpr (kWant != Want::energy)
    for (int i = 0; i < 9; ++i) P[i] += pressure * C[i];
  if constexpr (kWant == Want::stiffness) {
    for (int i = 0; i < 9; ++i)
      for (int j = i; j < 9; ++j) A[9 * i + j] -= U2 * (C[i] * C[j]);
    const Pack most = Pack{} + batch.most_pressure_Pa;
    Pack bounded = projected.pressure[q] < most ? projected.pressure[q] : most;
    bounded = bounded > -most ? bounded : -most;
    add_second_derivative_of_J(H, batch.averaged * bend * (bounded - U1), A);
  }
}

/// K += sum_mn D_mn B_m B_n^T: B_m derivative of the dilation's mode m, D that of the pressure's.
template <int kNodes, int kPoints, int kModes>
PALPATE_INLINE void add_modes(const Projected<kPoints, kModes>& projected, const CellBatch& batch,
                              Pack* stiffness) {
  const Pack zero = Pack{};
  Pack B[kModes][3 * kNodes], DB[kModes][3 * kNodes];
  for (int m = 0; m < kModes; ++m) {
    for (Pack& b : B[m]) b = zero;
    for (Pack& b : DB[m]) b = zero;
    for (int q = 0; q < kPoints; ++q) {
      const Pack share = batch.weight[q] * batch.mode[kPoints * m + q];
      Pack C[9];
      for (int i = 0; i < 9; ++i) C[i] = projected.cofactor[9 * q + i] * share;
      add_force<kNodes>(batch.gradient + 3 * kNodes * q, C, B[m]);
    }
  }
  for (int m = 0; m < kModes; ++m)
    for (int n = 0; n < kModes; ++n) {
      Pack D = zero;
      for (int q = 0; q < kPoints; ++q)
        D += batch.weight[q] * projected.U2[q] *
             (batch.mode[kPoints * m + q] * batch.mode[kPoints * n + q] * batch.averaged);
      for (int i = 0; i < 3 * kNodes; ++i) DB[m][i] += D * B[n][i];
    }
  for (int m = 0; m < kModes; ++m)
    for (int a = 0; a < kNodes; ++a)
      for (int b = 0; b <= a; ++b)
        for (int i = 0; i < 3; ++i)
          for (int k = 0; k < 3; ++k)
            stiffness[9 * (a * (a + 1) / 2 + b) + 3 * i + k] += B[m][3 * a + i] * DB[m][3 * b + k];
}

template <int kNodes, int kPoints, int kModes, Want kWant>
PALPATE_INLINE void run(const CellBatch& batch, const LawKernels& law, const Pack* displacement,
                        double bend, CellResult& out) {
  const Pack zero = Pack{};
  out.energy = zero;
  out.least_J = zero + 1e300;
  if constexpr (kWant != Want::energy)
    for (int i = 0; i < 3 * kNodes; ++i) out.force[i] = zero;
  if constexpr (kWant == Want::stiffness)
    for (int i = 0; i < 9 * blocks_of(kNodes); ++i) out.stiffness[i] = zero;
  Projected<kPoints, kModes == 0 ? 1 : kModes> projected;
  if constexpr (kModes > 0) project<kNodes>(batch, law, displacement, projected);
  for (int q = 0; q < kPoints; ++q) {
    const Pack* gradient = batch.gradient + 3 * kNodes * q;
    const Pack* constants = batch.constants + batch.constant_count * q;
    const Pack weight = batch.weight[q];
    Pack H[9], P[9], A[81], J, W;
    displacement_gradient<kNodes>(gradient, displacement, H);
    if constexpr (kWant == Want::energy) law.energy(constants, H, J, W);
    if constexpr (kWant == Want::force) law.stress(constants, H, J, W, P);
    if constexpr (kWant == Want::stiffness) law.tangent(constants, H, bend, J, W, P, A);
    if constexpr (kModes > 0) use_projected<kWant>(projected, batch, law, q, H, bend, W, P, A);
    out.energy += weight > 0.0 ? W * weight : zero;
    out.least_J = (weight > 0.0) & (J < out.least_J) ? J : out.least_J;
    if constexpr (kWant != Want::energy) {
      for (int i = 0; i < 9; ++i) P[i] = weight > 0.0 ? P[i] * weight : zero;
      add_force<kNodes>(gradient, P, out.force);
    }
    if constexpr (kWant == Want::stiffness) {
      for (int i = 0; i < 9; ++i)
        for (int j = i; j < 9; ++j) A[9 * i + j] = weight > 0.0 ? A[9 * i + j] * weight : zero;
      add_stiffness<kNodes>(gradient, A, out.stiffness);
    }
  }
  if constexpr (kModes > 0 && kWant == Want::stiffness)
    add_modes<kNodes>(projected, batch, out.stiffness);
}

// One copy per instruction set: the compiler does not widen vectors by itself across calls.
#define PALPATE_CELL_KERNELS(set, target)                                                         \
  template <int kNodes, int kPoints, int kModes>                                                  \
  target void energy_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,          \
                           CellResult& out) {                                                     \
    run<kNodes, kPoints, kModes, Want::energy>(batch, law, u, 1.0, out);                          \
  }                                                                                               \
  template <int kNodes, int kPoints, int kModes>                                                  \
  target void force_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,           \
                          CellResult& out) {                                                      \
    run<kNodes, kPoints, kModes, Want::force>(batch, law, u, 1.0, out);                           \
  }                                                                                               \
  template <int kNodes, int kPoints, int kModes>                                                  \
  target void stiffness_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,       \
                              double bend, CellResult& out) {                                     \
    run<kNodes, kPoints, kModes, Want::stiffness>(batch, law, u, bend, out);                      \
  }                                                                                               \
  template <int kNodes, int kPoints, int kModes>                                                  \
  constexpr CellKernels kernels_##set{energy_##set<kNodes, kPoints, kModes>,                      \
                                      force_##set<kNodes, kPoints, kModes>,                       \
                                      stiffness_##set<kNodes, kPoints, kModes>};

PALPATE_CELL_KERNELS(portable, )
PALPATE_CELL_KERNELS(avx2, __attribute__((target("avx2"))))
PALPATE_CELL_KERNELS(avx512, __attribute__((target("avx512f"))))
#undef PALPATE_CELL_KERNELS

template <ElementKind kKind>
CellKernels kernels_of(InstructionSet set) {
  constexpr ElementShape shape = shape_of(kKind);
  switch (set) {
    case InstructionSet::avx512: return kernels_avx512<shape.nodes, shape.points, shape.modes>;
    case InstructionSet::avx2: {
      // Stiffness spills sixteen registers either way, and a fifth more with the wider ones.
      CellKernels out = kernels_avx2<shape.nodes, shape.points, shape.modes>;
      out.stiffness = kernels_portable<shape.nodes, shape.points, shape.modes>.stiffness;
      return out;
    }
    default: return kernels_portable<shape.nodes, shape.points, shape.modes>;
  }
}

}  // namespace

CellKernels cell_kernels(ElementKind kind, InstructionSet set) {
  switch (kind) {
    case ElementKind::tet4: return kernels_of<ElementKind::tet4>(set);
    case ElementKind::tet10_blend:
    case ElementKind::tet10_p0: return kernels_of<ElementKind::tet10_p0>(set);
    case ElementKind::tet10_p1: return kernels_of<ElementKind::tet10_p1>(set);
    default: return kernels_of<ElementKind::tet10>(set);
  }
}

}  // namespace palpate::fem
