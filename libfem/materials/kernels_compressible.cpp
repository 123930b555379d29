#include "libfem/materials/law_kernels.hpp"
#include "libfem/materials/neo_hookean.hpp"
#include "libfem/materials/st_venant_kirchhoff.hpp"
#include "libfem/materials/stable_neo_hookean.hpp"

namespace palpate::fem {

template struct LawKernels<NeoHookean>;
template struct LawKernels<NeoHookeanSimo>;
template struct LawKernels<StableNeoHookean>;
template struct LawKernels<StVenantKirchhoff>;

}  // namespace palpate::fem
