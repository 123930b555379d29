#pragma once

#include "libfem/materials/law_row.hpp"

namespace palpate::fem {

// The kernels of a law take seconds to compile, so the files kernels_*.cpp share the work; each
// lists its laws as
//   template struct CompiledKernels<Yeoh>;
template <class Law>
const ElementKernels CompiledKernels<Law>::value = kElementKernels<Law>;

}  // namespace palpate::fem
