#include "libfem/materials/holzapfel_gasser_ogden.hpp"
#include "libfem/materials/law_kernels.hpp"
#include "libfem/materials/mooney_rivlin.hpp"
#include "libfem/materials/veronda_westmann.hpp"

namespace palpate::fem {

template struct CompiledKernels<MooneyRivlin>;
template struct CompiledKernels<VerondaWestmann>;
template struct CompiledKernels<HolzapfelGasserOgden>;

}  // namespace palpate::fem
