// For processors without AVX2 or FMA, whose last digits are their own.
#define PALPATE_SET portable
#include "libfem/solve/factor/dense_kernels.inc"

namespace palpate::fem {

const DenseKernels& dense_kernels_avx2();

const DenseKernels& dense_kernels(InstructionSet set) {
  return set == InstructionSet::portable ? dense_kernels_portable() : dense_kernels_avx2();
}

}  // namespace palpate::fem
