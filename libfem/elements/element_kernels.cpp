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
  template <Remembers kHistory, Want kWant>                                                      \
  target void integrate_##set(const CellBatch& batch, const LawKernels& law, const Pack* u,      \
                              CellResult& out) {                                                 \
    integrate<kHistory, kWant>(batch, law, u, out);                                              \
  }                                                                                              \
  template <Remembers kHistory>                                                                  \
  constexpr CellKernels kernels_##set{                                                           \
      gather_##set,                                                                              \
      scatter_##set,                                                                             \
      {integrate_##set<kHistory, Want::energy>, integrate_##set<kHistory, Want::force>,          \
       integrate_##set<kHistory, Want::stiffness>}};

PALPATE_CELL_KERNELS(portable, )
PALPATE_CELL_KERNELS(avx2, __attribute__((target("avx2"))))
PALPATE_CELL_KERNELS(avx512, __attribute__((target("avx512f"))))
#undef PALPATE_CELL_KERNELS

template <Remembers kHistory>
CellKernels kernels_of(InstructionSet set) {
  switch (set) {
    case InstructionSet::avx512:
      return kernels_avx512<kHistory>;
    case InstructionSet::avx2: {
      // Stiffness spills sixteen registers either way, and a fifth more with the wider ones.
      CellKernels out = kernels_avx2<kHistory>;
      out.integrate[2] = kernels_portable<kHistory>.integrate[2];
      return out;
    }
    default:
      return kernels_portable<kHistory>;
  }
}

}  // namespace

CellKernels cell_kernels(Remembers history, InstructionSet set) {
  switch (history) {
    case Remembers::time:
      return kernels_of<Remembers::time>(set);
    case Remembers::peak:
      return kernels_of<Remembers::peak>(set);
    default:
      return kernels_of<Remembers::nothing>(set);
  }
}

}  // namespace palpate::fem
