#include "libfem/elements/element_kernels.hpp"

#include "libfem/elements/cell_integrals.hpp"

namespace palpate::fem {
namespace {

// One copy per instruction set: the compiler does not widen vectors by itself across calls.
#define PALPATE_CELL_KERNELS(set, target)                                                        \
  target void gather_##set(const double* rows, const std::int32_t* points, Pack* displacement) { \
    for (int a = 0; a < kElementNodes; ++a)                                                      \
      gather_points(rows, points + kLanes * a, displacement + 3 * a);                            \
  }                                                                                              \
  target void scatter_##set(const Pack* force, const std::int32_t* points, double* rows) {       \
    for (int a = 0; a < kElementNodes; ++a)                                                      \
      scatter_points(force + 3 * a, points + kLanes * a, rows);                                  \
  }                                                                                              \
  template <bool kAverages, bool kInTime>                                                        \
  target void energy_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,         \
                           CellResult& out) {                                                    \
    run<kAverages, kInTime, Want::energy>(batch, law, u, 1.0, out);                              \
  }                                                                                              \
  template <bool kAverages, bool kInTime>                                                        \
  target void force_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,          \
                          CellResult& out) {                                                     \
    run<kAverages, kInTime, Want::force>(batch, law, u, 1.0, out);                               \
  }                                                                                              \
  template <bool kAverages, bool kInTime>                                                        \
  target void stiffness_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,      \
                              double geometric_scale, CellResult& out) {                         \
    run<kAverages, kInTime, Want::stiffness>(batch, law, u, geometric_scale, out);               \
  }                                                                                              \
  template <bool kAverages, bool kInTime>                                                        \
  constexpr CellKernels kernels_##set{                                                           \
      gather_##set, scatter_##set, energy_##set<kAverages, kInTime>,                             \
      force_##set<kAverages, kInTime>, stiffness_##set<kAverages, kInTime>};

PALPATE_CELL_KERNELS(portable, )
PALPATE_CELL_KERNELS(avx2, __attribute__((target("avx2"))))
PALPATE_CELL_KERNELS(avx512, __attribute__((target("avx512f"))))
#undef PALPATE_CELL_KERNELS

template <bool kAverages, bool kInTime>
CellKernels kernels_of(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx512:
      return kernels_avx512<kAverages, kInTime>;
    case InstructionSet::avx2: {
      // Stiffness spills sixteen registers either way, and a fifth more with the wider ones.
      CellKernels out = kernels_avx2<kAverages, kInTime>;
      out.stiffness = kernels_portable<kAverages, kInTime>.stiffness;
      return out;
    }
    default:
      return kernels_portable<kAverages, kInTime>;
  }
}

}  // namespace

CellKernels cell_kernels(ElementKind kind, InstructionSet set) {
  return averages(kind) ? kernels_of<true, false>(set) : kernels_of<false, false>(set);
}

CellKernels cell_kernels_in_time(InstructionSet set) { return kernels_of<true, true>(set); }

}  // namespace palpate::fem
