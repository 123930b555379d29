#include "libfem/materials/fung.hpp"
#include "libfem/materials/law_kernels.hpp"
#include "libfem/materials/neo_hookean_isochoric.hpp"
#include "libfem/materials/yeoh.hpp"

namespace palpate::fem {

template struct CompiledKernels<NeoHookeanIsochoric>;
template struct CompiledKernels<NeoHookeanIsochoricLog>;
template struct CompiledKernels<NeoHookeanIsochoricSimo>;
template struct CompiledKernels<Yeoh>;
template struct CompiledKernels<Fung>;

}  // namespace palpate::fem
