#include "libfem/elements/element_kernels.hpp"

namespace palpate::fem {
namespace {

#include "libfem/elements/cell_integrals.inc"

// One copy per instruction set: the compiler does not widen vectors by itself across calls.
#define PALPATE_CELL_KERNELS(set, target)                                                        \
  template <int kNodes>                                                                          \
  target void gather_##set(const double* rows, const std::int32_t* points, Pack* displacement) { \
    for (int a = 0; a < kNodes; ++a)                                                             \
      gather_points(rows, points + kLanes * a, displacement + 3 * a);                            \
  }                                                                                              \
  template <int kNodes>                                                                          \
  target void scatter_##set(const Pack* force, const std::int32_t* points, double* rows) {       \
    for (int a = 0; a < kNodes; ++a) scatter_points(force + 3 * a, points + kLanes * a, rows);   \
  }                                                                                              \
  template <int kNodes, int kPoints, int kModes>                                                 \
  target void energy_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,         \
                           CellResult& out) {                                                    \
    run<kNodes, kPoints, kModes, Want::energy>(batch, law, u, 1.0, out);                         \
  }                                                                                              \
  template <int kNodes, int kPoints, int kModes>                                                 \
  target void force_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,          \
                          CellResult& out) {                                                     \
    run<kNodes, kPoints, kModes, Want::force>(batch, law, u, 1.0, out);                          \
  }                                                                                              \
  template <int kNodes, int kPoints, int kModes>                                                 \
  target void stiffness_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,      \
                              double geometric_scale, CellResult& out) {                         \
    run<kNodes, kPoints, kModes, Want::stiffness>(batch, law, u, geometric_scale, out);          \
  }                                                                                              \
  template <int kNodes, int kPoints, int kModes>                                                 \
  constexpr CellKernels kernels_##set{                                                           \
      gather_##set<kNodes>, scatter_##set<kNodes>, energy_##set<kNodes, kPoints, kModes>,        \
      force_##set<kNodes, kPoints, kModes>, stiffness_##set<kNodes, kPoints, kModes>};

PALPATE_CELL_KERNELS(portable, )
PALPATE_CELL_KERNELS(avx2, __attribute__((target("avx2"))))
PALPATE_CELL_KERNELS(avx512, __attribute__((target("avx512f"))))
#undef PALPATE_CELL_KERNELS

template <ElementKind kKind>
CellKernels kernels_of(InstructionSet set) {
  constexpr ElementShape shape = shape_of(kKind);
  switch (set) {
    case InstructionSet::avx512:
      return kernels_avx512<shape.nodes, shape.points, shape.modes>;
    case InstructionSet::avx2: {
      // Stiffness spills sixteen registers either way, and a fifth more with the wider ones.
      CellKernels out = kernels_avx2<shape.nodes, shape.points, shape.modes>;
      out.stiffness = kernels_portable<shape.nodes, shape.points, shape.modes>.stiffness;
      return out;
    }
    default:
      return kernels_portable<shape.nodes, shape.points, shape.modes>;
  }
}

}  // namespace

CellKernels cell_kernels(ElementKind kind, InstructionSet set) {
  switch (kind) {
    case ElementKind::tet4:
      return kernels_of<ElementKind::tet4>(set);
    case ElementKind::tet10_blend:
    case ElementKind::tet10_p0:
      return kernels_of<ElementKind::tet10_p0>(set);
    case ElementKind::tet10_p1:
      return kernels_of<ElementKind::tet10_p1>(set);
    default:
      return kernels_of<ElementKind::tet10>(set);
  }
}

}  // namespace palpate::fem
