#!/usr/bin/env bash
# Installs, builds and runs all tests. --all adds slow validation and a study on a real Slurm (slurm-wlm,
# munge, where they are installed); --sanitize adds the engine's and the
# readers' tests under address and undefined-behaviour sanitizers; --werror treats warnings and
# unformatted files as errors.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
preset=release
sanitize=false
select=(-LE "slow|slurm")
slow_tests=OFF
for argument in "$@"; do
  case "$argument" in
    --all) select=() slow_tests=ON ;;
    --sanitize) sanitize=true ;;
    --werror) preset=ci ;;
    *) echo "usage: tools/test.sh [--all] [--sanitize] [--werror]" >&2; exit 2 ;;
  esac
done

bash tools/install_packages.sh chromium mono-mcs mono-runtime
if [ "$preset" = ci ]; then
  echo "== formatting"
  git ls-files -z '*.cpp' '*.hpp' '*.h' '*.c' '*.inc' | xargs -0 clang-format --dry-run --Werror
fi
cmake --preset "$preset" -DPALPATE_SLOW_TESTS=$slow_tests
cmake --build --preset "$preset"
if $sanitize; then
  tests=(test_runtime test_damage test_several_tools test_assets test_io test_importers test_mesh_read)
  cmake --preset ci-sanitize -DPALPATE_SLOW_TESTS=OFF
  cmake --build --preset ci-sanitize --target "${tests[@]}"
  printf '%s\n' "${tests[@]}" | xargs -P 2 -I TEST bash -c 'echo "== TEST under sanitizers"
    "$(find build/ci-sanitize/tests -type f -name TEST)" --gtest_brief=1'
fi

# ctest's summary comes last; before it, what was skipped and why, read from its report.
report=build/$preset/ctest.xml
summary=build/$preset/ctest_summary.txt
: > "$summary"
status=0
ctest --test-dir "build/$preset" "${select[@]}" --output-on-failure -j2 --output-junit ctest.xml |
  awk -v summary="$summary" '/% tests passed, / { ended = 1 }
    { if (ended) print > summary; else { print; fflush() } }' || status=$?
skipped=$(grep -c '<skipped' "$report" || true)
reasons=$(sed -n '/: Skipped$/{n;p}' "$report" | sort | uniq -c | sort -rn |
  sed -E 's/^ *([0-9]+) (.*)/\1 x \2/' | paste -sd, | sed 's/,/, /g')
echo "skipped: $skipped tests${reasons:+ ($reasons)}"
cat "$summary"
exit "$status"
