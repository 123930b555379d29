#include "libfem/materials/law_kernels.hpp"
#include "libfem/materials/ogden.hpp"

namespace palpate::fem {

template struct CompiledKernels<Ogden>;

}  // namespace palpate::fem
