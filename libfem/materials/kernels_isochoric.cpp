#include "libfem/materials/fung.hpp"
#include "libfem/materials/holzapfel_gasser_ogden.hpp"
#include "libfem/materials/law_kernels.hpp"
#include "libfem/materials/mooney_rivlin.hpp"
#include "libfem/materials/neo_hookean_isochoric.hpp"
#include "libfem/materials/veronda_westmann.hpp"
#include "libfem/materials/yeoh.hpp"

namespace palpate::fem {

template struct CompiledKernels<NeoHookeanIsochoric>;
template struct CompiledKernels<NeoHookeanIsochoricLog>;
template struct CompiledKernels<NeoHookeanIsochoricSimo>;
template struct CompiledKernels<Yeoh>;
template struct CompiledKernels<Fung>;

template struct CompiledKernels<MooneyRivlin>;
template struct CompiledKernels<VerondaWestmann>;
template struct CompiledKernels<HolzapfelGasserOgden>;

}  // namespace palpate::fem
