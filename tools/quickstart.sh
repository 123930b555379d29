#!/usr/bin/env bash
# From a fresh Debian 12 or 13 to out/liver/asset.palp: installs, builds, runs the shipped liver scene.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
started=$SECONDS
step() { printf '\n== %s (%d s so far)\n' "$1" $((SECONDS - started)); }

step "installing packages"
bash tools/install_packages.sh
step "building (a few minutes the first time)"
cmake --preset release
cmake --build --preset release --target palpate
# The page of `palpate report`; without Node.js there is none, and `run` says so.
if command -v npm >/dev/null; then cmake --build --preset release --target palpate_page || true; fi
step "liver phantom to runtime asset"
status=0
build/release/tools/palpate run data/scenes/liver.toml -o out/liver || status=$?
[ "$status" -eq 0 ] || [ "$status" -eq 3 ] || exit "$status"  # 3: done, some items failed and are listed
step "done: out/liver/asset.palp, its engine in out/liver/engine, its statement in out/liver/statement.json"
if [ -e out/liver/report.html ]; then echo "open out/liver/report.html in a browser: look at the errors, and poke the liver"; fi
