// Compiled for AVX2 and FMA (CMakeLists.txt).
#define PALPATE_SET avx2
#include "libfem/solve/factor/dense_kernels.inc"
