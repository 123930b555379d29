#include "libfem/elements/element_kernels.hpp"

#include "libfem/elements/cell_integrals.hpp"

namespace palpate::fem {
namespace {

// One copy per instruction set: the compiler does not widen vectors by itself across calls.
#define PALPATE_CELL_KERNELS(set, target)                                                          \
  target void gather_##set(const double* rows, const std::int32_t* points, Pack* displacement) {   \
    for (int a = 0; a < kElementNodes; ++a)                                                        \
      gather_points(rows, points + kLanes * a, displacement + 3 * a);                              \
  }                                                                                                \
  target void scatter_##set(const Pack* force, const std::int32_t* points, double* rows) {         \
    for (int a = 0; a < kElementNodes; ++a)                                                        \
      scatter_points(force + 3 * a, points + kLanes * a, rows);                                    \
  }                                                                                                \
  template <bool kAverages, Remembers kWhat>                                                       \
  target void energy_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,           \
                           CellResult& out) {                                                      \
    run<kAverages, kWhat, Want::energy>(batch, law, u, 1.0, out);                                  \
  }                                                                                                \
  template <bool kAverages, Remembers kWhat>                                                       \
  target void force_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,            \
                          CellResult& out) {                                                       \
    run<kAverages, kWhat, Want::force>(batch, law, u, 1.0, out);                                   \
  }                                                                                                \
  template <bool kAverages, Remembers kWhat>                                                       \
  target void stiffness_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,        \
                              double geometric_scale, CellResult& out) {                           \
    run<kAverages, kWhat, Want::stiffness>(batch, law, u, geometric_scale, out);                   \
  }                                                                                                \
  template <bool kAverages, Remembers kWhat>                                                       \
  constexpr CellKernels kernels_##set{gather_##set, scatter_##set, energy_##set<kAverages, kWhat>, \
                                      force_##set<kAverages, kWhat>,                               \
                                      stiffness_##set<kAverages, kWhat>};

PALPATE_CELL_KERNELS(portable, )
PALPATE_CELL_KERNELS(avx2, __attribute__((target("avx2"))))
PALPATE_CELL_KERNELS(avx512, __attribute__((target("avx512f"))))
#undef PALPATE_CELL_KERNELS

template <bool kAverages, Remembers kWhat>
CellKernels kernels_of(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx512:
      return kernels_avx512<kAverages, kWhat>;
    case InstructionSet::avx2: {
      // Stiffness spills sixteen registers either way, and a fifth more with the wider ones.
      CellKernels out = kernels_avx2<kAverages, kWhat>;
      out.stiffness = kernels_portable<kAverages, kWhat>.stiffness;
      return out;
    }
    default:
      return kernels_portable<kAverages, kWhat>;
  }
}

}  // namespace

CellKernels cell_kernels(ElementKind kind, InstructionSet set) {
  return averages(kind) ? kernels_of<true, Remembers::nothing>(set)
                        : kernels_of<false, Remembers::nothing>(set);
}

CellKernels cell_kernels_in_time(InstructionSet set) {
  return kernels_of<true, Remembers::time>(set);
}

CellKernels cell_kernels_softening(InstructionSet set) {
  return kernels_of<true, Remembers::peak>(set);
}

}  // namespace palpate::fem
