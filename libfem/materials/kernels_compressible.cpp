#include "libfem/materials/law_kernels.hpp"
#include "libfem/materials/neo_hookean.hpp"
#include "libfem/materials/ogden.hpp"
#include "libfem/materials/st_venant_kirchhoff.hpp"
#include "libfem/materials/stable_neo_hookean.hpp"

namespace palpate::fem {

template struct CompiledKernels<NeoHookean>;
template struct CompiledKernels<NeoHookeanSimo>;
template struct CompiledKernels<StableNeoHookean>;
template struct CompiledKernels<StVenantKirchhoff>;

template struct CompiledKernels<Ogden>;

}  // namespace palpate::fem
