#pragma once

#include "libfem/materials/pack.hpp"

namespace palpate::fem {

inline constexpr int kTetNodes = 10;
inline constexpr int kTetPoints = 4;                                     ///< quadrature points
inline constexpr int kTetBlocks = kTetNodes * (kTetNodes + 1) / 2;       ///< node pairs a >= b

/// Eight ten-node tetrahedra of one law. Index order is slowest first; the last one is the lane.
/// gradient: dN_a/dX_j, [point][node][j] [1/m]. weight: rest volume of the point [m^3], 0 on an
/// idle lane and on a point of another law. constants: [point][constant].
struct ElementBatch {
  const Pack* gradient;
  const Pack* weight;
  const Pack* constants;
};

/// What eight elements give. energy [J]; least_J over their points; force: dE/du_a, [node][i] [N];
/// stiffness: d2E/du_a du_b for a >= b, block a(a+1)/2 + b, 3 x 3 row major [N/m].
struct ElementResult {
  Pack energy;
  Pack least_J;
  Pack force[3 * kTetNodes];
  Pack stiffness[9 * kTetBlocks];
};

/// The kernels of one law, chosen for this processor when first called.
/// displacement: [node][i] [m]. bend: see the law's evaluate().
struct ElementKernels {
  void (*energy)(const ElementBatch&, const Pack* displacement, ElementResult&);
  void (*force)(const ElementBatch&, const Pack* displacement, ElementResult&);
  void (*stiffness)(const ElementBatch&, const Pack* displacement, double bend, ElementResult&);
};

namespace kernel {

enum class Want { energy, force, stiffness };

PALPATE_INLINE void displacement_gradient(const Pack* gradient, const Pack* displacement, Pack* H) {
  for (int i = 0; i < 9; ++i) H[i] = Pack{};
  for (int a = 0; a < kTetNodes; ++a)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) H[3 * i + j] += displacement[3 * a + i] * gradient[3 * a + j];
}

PALPATE_INLINE void add_force(const Pack* gradient, const Pack* P, Pack* force) {
  for (int a = 0; a < kTetNodes; ++a)
    for (int i = 0; i < 3; ++i)
      force[3 * a + i] += P[3 * i] * gradient[3 * a] + P[3 * i + 1] * gradient[3 * a + 1] +
                          P[3 * i + 2] * gradient[3 * a + 2];
}

/// K_ab[i][k] += sum_JL G_a[J] A[iJ][kL] G_b[L].
PALPATE_INLINE void add_stiffness(const Pack* gradient, const Pack* A, Pack* stiffness) {
  for (int b = 0; b < kTetNodes; ++b) {
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
    for (int a = b; a < kTetNodes; ++a) {
      Pack* block = stiffness + 9 * (a * (a + 1) / 2 + b);
      for (int i = 0; i < 3; ++i)
        for (int k = 0; k < 3; ++k)
          block[3 * i + k] += gradient[3 * a] * T[9 * i + k] + gradient[3 * a + 1] * T[9 * i + 3 + k] +
                              gradient[3 * a + 2] * T[9 * i + 6 + k];
    }
  }
}

template <class Law, Want kWant>
PALPATE_INLINE void run(const ElementBatch& batch, const Pack* displacement, double bend,
                        ElementResult& out) {
  const Pack zero = Pack{};
  out.energy = zero;
  out.least_J = zero + 1e300;
  if constexpr (kWant != Want::energy)
    for (Pack& f : out.force) f = zero;
  if constexpr (kWant == Want::stiffness)
    for (Pack& k : out.stiffness) k = zero;
  for (int q = 0; q < kTetPoints; ++q) {
    const Pack* gradient = batch.gradient + 3 * kTetNodes * q;
    const Pack weight = batch.weight[q];
    Pack H[9], P[9], A[81], J, W;
    displacement_gradient(gradient, displacement, H);
    Law::evaluate(batch.constants + Law::kConstants * q, H, bend, J, W,
                                 kWant == Want::energy ? static_cast<Pack*>(nullptr) : P,
                  kWant == Want::stiffness ? A : static_cast<Pack*>(nullptr));
    out.energy += weight > 0.0 ? W * weight : zero;
    out.least_J = (weight > 0.0) & (J < out.least_J) ? J : out.least_J;
    if constexpr (kWant != Want::energy) {
      for (int i = 0; i < 9; ++i) P[i] = weight > 0.0 ? P[i] * weight : zero;
      add_force(gradient, P, out.force);
    }
    if constexpr (kWant == Want::stiffness) {
      for (int i = 0; i < 9; ++i)
        for (int j = i; j < 9; ++j) A[9 * i + j] = weight > 0.0 ? A[9 * i + j] * weight : zero;
      add_stiffness(gradient, A, out.stiffness);
    }
  }
}

// One copy per instruction set; the compiler does not widen vectors by itself across calls.
template <class Law, Want kWant>
__attribute__((target("avx512f"))) void run_avx512(const ElementBatch& batch, const Pack* u,
                                                   double bend, ElementResult& out) {
  run<Law, kWant>(batch, u, bend, out);
}
template <class Law, Want kWant>
__attribute__((target("avx2"))) void run_avx2(const ElementBatch& batch, const Pack* u, double bend,
                                              ElementResult& out) {
  run<Law, kWant>(batch, u, bend, out);
}
template <class Law, Want kWant>
void run_portable(const ElementBatch& batch, const Pack* u, double bend, ElementResult& out) {
  run<Law, kWant>(batch, u, bend, out);
}

template <class Law, Want kWant>
void dispatch(const ElementBatch& batch, const Pack* u, double bend, ElementResult& out) {
  static const auto chosen = __builtin_cpu_supports("avx512f") ? &run_avx512<Law, kWant>
                             : __builtin_cpu_supports("avx2")  ? &run_avx2<Law, kWant>
                                                               : &run_portable<Law, kWant>;
  chosen(batch, u, bend, out);
}

}  // namespace kernel

template <class Law>
inline constexpr ElementKernels kElementKernels{
    [](const ElementBatch& batch, const Pack* u, ElementResult& out) {
      kernel::dispatch<Law, kernel::Want::energy>(batch, u, 1.0, out);
    },
    [](const ElementBatch& batch, const Pack* u, ElementResult& out) {
      kernel::dispatch<Law, kernel::Want::force>(batch, u, 1.0, out);
    },
    [](const ElementBatch& batch, const Pack* u, double bend, ElementResult& out) {
      kernel::dispatch<Law, kernel::Want::stiffness>(batch, u, bend, out);
    }};

}  // namespace palpate::fem
