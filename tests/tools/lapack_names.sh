#!/usr/bin/env bash
# Prints ABORTS(name) for each function of BLAS and LAPACK that a program or a library which it loads
# imports: lapack_names.sh PROGRAM. These are the names of Fortran, which end with one underscore, and
# those of cblas and lapacke.
set -euo pipefail
ldd "$1" | grep -o '/[^ ]*' | xargs nm -D --undefined-only "$1" |
  sed -nE 's/^ +U ((cblas_|LAPACKE_)[a-z0-9_]+|[a-z][a-z0-9]+_)(@.*)?$/ABORTS(\1)/p' | LC_ALL=C sort -u
