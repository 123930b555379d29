#include "libfem/materials/law_kernels.hpp"
#include "libfem/materials/fung.hpp"
#include "libfem/materials/neo_hookean_isochoric.hpp"
#include "libfem/materials/yeoh.hpp"

namespace palpate::fem {

template struct LawKernels<NeoHookeanIsochoric>;
template struct LawKernels<NeoHookeanIsochoricLog>;
template struct LawKernels<NeoHookeanIsochoricSimo>;
template struct LawKernels<Yeoh>;
template struct LawKernels<Fung>;

}  // namespace palpate::fem
