// For processors without AVX2 or FMA, whose last digits are their own.
#define PALPATE_SET portable
#include "libfem/solve/factor/dense_kernels.inc"
