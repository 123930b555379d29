#include "libfem/solve/factor/dense_kernels.hpp"

namespace palpate::fem {

const DenseKernels& dense_kernels_avx2();
const DenseKernels& dense_kernels_portable();

const DenseKernels& dense_kernels(InstructionSet set) {
  return set == InstructionSet::portable ? dense_kernels_portable() : dense_kernels_avx2();
}

}  // namespace palpate::fem
