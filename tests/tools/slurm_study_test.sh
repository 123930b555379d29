#!/usr/bin/env bash
# A study of 3 bodies x 3 materials x 20 points on a Slurm of two nodes: one task is killed, one node
# drained and resumed, one job hits its time limit. After `study resume` the samples of every case
# equal those of one process byte for byte. Argument: the program.
set -euo pipefail
palpate=$1
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
folder=$(mktemp -d)
. "$here/slurm.sh"
start_slurm "$folder/slurm"
trap 'stop_slurm; rm -rf "$folder"' EXIT
cd "$folder"
fail() { echo "FAILED: $*"; tail -n 20 study/jobs/*.log 2>/dev/null; exit 1; }

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
task_minutes = 0.1
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
# Processes of simulating tasks, once there are `count`.
simulating() {
  local found
  for ((i = 0; i < 600; ++i)); do
    mapfile -t found < <(pgrep -f "study task $folder/study $folder/study/jobs/[0-9]*-simulate" || true)
    [ ${#found[@]} -ge "$1" ] && { printf '%s\n' "${found[@]}"; return; }
    sleep 0.2
  done
  fail "no task simulates"
}
mapfile -t tasks < <(simulating 2)
sleep 2
echo "killed: $(tr '\0' ' ' < "/proc/${tasks[0]}/cmdline")"
kill -KILL "${tasks[0]}"
echo "stopped until its time limit: $(tr '\0' ' ' < "/proc/${tasks[1]}/cmdline")"
job=$(tr '\0' '\n' < "/proc/${tasks[1]}/environ" | sed -n 's/^SLURM_JOB_ID=//p')
kill -STOP "${tasks[1]}"
scontrol update JobId="$job" TimeLimit=1
drained=$(squeue --noheader --states=R --format='%A %N' | awk -v job="$job" '$1 != job { print $2 }' | head -n 1)
drained=${drained:-n1}
scontrol update NodeName="$drained" State=DRAIN Reason=test
sleep 8
sinfo --noheader --format='%N %T'
scontrol update NodeName="$drained" State=RESUME
wait_for_slurm 600
grep -q "DUE TO TIME LIMIT" "$folder"/slurm/n?.log study/jobs/*.log || fail "no job hit its time limit"

status=0; "$palpate" study status study --json > status.json || status=$?
cat status.json
done_before=$(sed 's/.*"done":\([0-9]*\).*/\1/' status.json)
[ "$done_before" -lt 9 ] && [ "$done_before" -ge 5 ] || fail "$done_before cases done before resume"
"$palpate" study resume study 2>&1 | tee resume.txt
grep -q "slurm: 2 simulate tasks" resume.txt || fail "resume submits more or less than what is missing"
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

# Points that place themselves: each merge asks for a round, and the last job submits it.
sed -e 's/test_points = 20/test_points = "auto"\ntolerance = 0\nbudget = 16/' \
  -e 's/^length_unit/surface = "thick.off"\n&/' -e 's/press_steps = 1/press_steps = 2/' base.toml > placed.toml
cat >> placed.toml <<'TOML'
[experiments.region]
box = [["9 mm", "9 mm", "29 mm"], ["71 mm", "71 mm", "31 mm"]]
TOML
printf 'scene = "placed.toml"\n[cluster]\ntask_minutes = 0.1\n' > rounds.toml
"$palpate" study rounds.toml -o rounds --on slurm
wait_for_slurm 600
"$palpate" study status rounds | tee status.txt
grep -q "1 cases: 1 done" status.txt || fail "rounds do not end"
mkdir alone
"$palpate" simulate placed.toml -o alone/samples.h5 --quiet || true
for file in samples.h5 placed.h5 placement.csv; do
  cmp rounds/cases/*/$file alone/$file || fail "rounds have another $file"
done
echo "PASSED: 9 cases x 20 points, and one in rounds, with the bytes of one process"
