#!/usr/bin/env bash
# Installs, builds and runs all tests. --all adds slow validation; --sanitize adds the engine's and the
# readers' tests under address and undefined-behaviour sanitizers; --werror treats warnings as errors.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
preset=release
sanitize=false
select=(-LE slow)
for argument in "$@"; do
  case "$argument" in
    --all) select=() ;;
    --sanitize) sanitize=true ;;
    --werror) preset=ci ;;
    *) echo "usage: tools/test.sh [--all] [--sanitize] [--werror]" >&2; exit 2 ;;
  esac
done

bash tools/install_packages.sh
cmake --preset "$preset"
cmake --build --preset "$preset"
if $sanitize; then
  cmake --preset ci-sanitize
  cmake --build --preset ci-sanitize --target sanitized_tests
  ctest --test-dir build/ci-sanitize -L sanitized --output-on-failure -j2
fi
ctest --test-dir "build/$preset" "${select[@]}" --output-on-failure -j2
