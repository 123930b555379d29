#pragma once

#include "libfem/materials/element_kernel.hpp"

namespace palpate::fem {

/// Dense linear algebra of the factor, column by column; the lower triangle of a symmetric matrix
/// counts. Eigen computes it, compiled for AVX2 with FMA and once more without, so that every
/// processor that has both makes the same bytes (a wider vector would sum in another order). Its
/// blocks are those of one fixed cache, not of the processor's. Not safe on sizes below zero.
struct DenseKernels {
  /// Factors the first `own` columns of a front of `size` and subtracts their product from the
  /// others (partial Cholesky). False where it is not positive definite.
  bool (*factor_front)(float* front, int size, int own);
  bool (*factor_front_double)(double* front, int size, int own);
  /// Replaces a Cholesky factor by all entries of the inverse of its matrix.
  void (*invert_from_factor)(float* factor, int size);
  /// Factors a general matrix with row exchanges (LU); solves with the factors, in place of x.
  void (*factor_general)(float* matrix, int size, int* exchanges);
  void (*solve_general)(const float* factors, int size, const int* exchanges, float* x);
  /// y = A x of a symmetric and of a general square matrix.
  void (*multiply_symmetric)(const float* A, int size, const float* x, float* y);
  void (*multiply)(const double* A, int size, const double* x, double* y);
};

/// The kernels for an instruction set; those for AVX2 serve AVX-512 as well.
const DenseKernels& dense_kernels(InstructionSet set = best_instruction_set());

}  // namespace palpate::fem
