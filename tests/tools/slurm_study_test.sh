#!/usr/bin/env bash
# A study of 3 bodies x 3 materials x 20 points on a Slurm of two nodes: one task is killed. After
# `study resume` the samples of every case equal those of one process byte for byte. Argument: the
# program.
set -euo pipefail
palpate=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
. "$here/slurm.sh"
start_slurm "$folder/slurm"
trap 'stop_slurm; rm -rf "$folder"' EXIT
cd "$folder"
fail() { echo "FAILED: $*"; tail -n 20 study/task-*.log 2>/dev/null; exit 1; }

. "$here/block.sh"
block thick 80 30; block flat 80 20; block small 60 20
cat > base.toml <<'TOML'
[body]
length_unit = "mm"
mesh_size = "20 mm"
fixed = [ { below = { axis = "z", at = "1 mm" } } ]
[material]
young = "10 kPa"
poisson = 0.45
[probe]
radius = "8 mm"
[experiments]
test_points = 20
depth = "2 mm"
press_steps = 1
drag_depths = []
surface = false
[validate]
points = 1
causes = false
TOML
cat > study.toml <<'TOML'
scene = "base.toml"
[cluster]
options = ["--mem=1G"]
[bodies.thick]
surface = "thick.off"
"experiments.region" = { box = [["15 mm", "15 mm", "29 mm"], ["65 mm", "65 mm", "31 mm"]] }
[bodies.flat]
surface = "flat.off"
"experiments.region" = { box = [["15 mm", "15 mm", "19 mm"], ["65 mm", "65 mm", "21 mm"]] }
[bodies.small]
surface = "small.off"
"experiments.region" = { box = [["12 mm", "12 mm", "19 mm"], ["48 mm", "48 mm", "21 mm"]] }
[materials.soft]
young = "5 kPa"
[materials.firm]
young = "20 kPa"
poisson = 0.4
[materials.rubber]
law = "yeoh"
c10 = "2 kPa"
TOML

"$palpate" study study.toml -o study --on slurm
for ((i = 0; i < 600; ++i)); do
  mapfile -t tasks < <(pgrep -f "study task $folder/study" || true)
  [ ${#tasks[@]} -ge 2 ] && break
  sleep 0.2
done
[ ${#tasks[@]} -ge 2 ] || fail "no two tasks run"
kill -KILL "${tasks[0]}"
wait_for_slurm 600
"$palpate" study status study || true
"$palpate" study resume study --on slurm
wait_for_slurm 300
"$palpate" study status study | tee status.txt
grep -q "9 cases: 9 done" status.txt || fail "not all cases are done"

"$palpate" study study.toml -o one --quiet 2> one.log || { cat one.log; fail "one process"; }
cases=0
for samples in one/cases/*/samples.h5; do
  cmp "$samples" "study/${samples#one/}" || fail "other bytes than one process"
  cases=$((cases + 1))
done
[ $cases -eq 9 ] || fail "$cases cases"
# Columns that do not tell of time and memory.
stable() { awk -F, '{ $(NF-1) = $(NF-2) = ""; print }' "$1/results.csv"; }
diff <(stable one) <(stable study) || fail "results differ"

echo "PASSED: 9 cases x 20 points with the bytes of one process"
