// A BLAS and LAPACK to preload, each function of which ends the program with its name on stderr.

#include <cstdio>
#include <cstdlib>

#define ABORTS(name)                                                \
  extern "C" void name() {                                          \
    std::fputs("the program called " #name " of LAPACK\n", stderr); \
    std::abort();                                                   \
  }
#include "lapack_names.inc"
