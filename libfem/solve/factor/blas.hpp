#pragma once

#include <string>

namespace palpate::fem {

/// Makes BLAS and CHOLMOD's OpenMP compute in the calling thread alone, and maps the memory that
/// OpenBLAS works in for it. Cheap when called again. Throws std::bad_alloc where there is no such
/// memory: OpenBLAS itself asks for it again and again, for ever.
void use_one_blas_thread();

/// The file of the BLAS that computes, where it is another than OpenBLAS (one that was preloaded);
/// empty where it is OpenBLAS.
std::string foreign_blas();

}  // namespace palpate::fem
