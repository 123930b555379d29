#!/usr/bin/env bash
# The same experiments on a coarse block by threads, by shards and by Slurm: what each way takes
# beside the experiments, as ratios of one run. Writes a table (docs/bench/cluster.csv).
# Arguments: the program, the number of test points (49 experiments each), of shards, the table.
set -euo pipefail
palpate=$(realpath "$1"); points=$2; shards=$3; table=$(realpath "$4")
tests=$(cd "$(dirname "${BASH_SOURCE[0]}")/../../../tests/tools" && pwd)
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
. "$tests/block.sh"
block small 60 10
cat > scene.toml <<TOML
[body]
surface = "small.off"
length_unit = "mm"
mesh_size = "30 mm"
fixed = [ { below = { axis = "z", at = "1 mm" } } ]
[material]
young = "10 kPa"
poisson = 0.3
[probe]
radius = "29 mm"
[experiments]
test_points = $points
region = { facing = "+z" }
depth = "0.5 mm"
surface = false
press_steps = 1
drag_depths = ["0.5 mm"]
drag_distance = "0.3 mm"
drag_directions = 48
drag_steps = 1
TOML
"$palpate" prepare scene.toml -o body.h5 --quiet
experiments=$((49 * points))
now() { date +%s.%N; }
since() { awk -v a="$from" -v b="$(now)" "BEGIN { print b - a }"; }
# A command's processor seconds are appended to times.txt.
timed() { bash -c 'TIMEFORMAT="%U %S"; time "$@" 2>/dev/null' timed "$@" 2>> times.txt; }
echo "# $(grep -m1 'model name' /proc/cpuinfo | sed 's/.*: //'), $(nproc) cores; tools/workshop/bench/cluster.sh, $points points, $shards shards" > "$table"
echo "way,processes,experiments,wall_s,cpu_s,cpu_over_threads,overhead_ms_per_experiment,busy_share" >> "$table"
row() { # way, processes, wall; sums times.txt
  local cpu; cpu=$(awk '{ s += $1 + $2 } END { print s }' times.txt)
  reference=${reference:-$cpu}
  case $1 in # ways without experiments have no threads to be compared with
    *empty*) awk -v w="$1" -v p="$2" -v t="$3" -v c="$cpu" 'BEGIN {
      printf "%s,%d,0,%.1f,%.1f,,,\n", w, p, t, c }' ;;
    *) awk -v w="$1" -v p="$2" -v t="$3" -v c="$cpu" -v r="$reference" -v e=$experiments -v n=2 'BEGIN {
      printf "%s,%d,%d,%.1f,%.1f,%.3f,%.2f,%.3f\n", w, p, e, t, c, c / r, 1e3 * (c - r) / e, c / (n * t) }' ;;
  esac >> "$table"
  rm times.txt; tail -n 1 "$table"
}
from=$(now); timed "$palpate" simulate body.h5 -o one.h5 --jobs 2; row threads 1 "$(since)"
from=$(now)
export -f timed; export palpate shards
seq "$shards" | xargs -P 2 -I{} bash -c 'timed "$palpate" simulate body.h5 --shard {}/$shards -o shards --jobs 1'
timed "$palpate" merge shards -o shards/samples.h5
row shards $((shards + 1)) "$(since)"
cmp shards/samples.h5 one.h5
# Shards without points: what a process takes by itself.
from=$(now)
seq $((points + 1)) $((points + 20)) | xargs -P 2 -I{} bash -c 'timed "$palpate" simulate body.h5 --shard {}/'$((points + 20))' -o empty --jobs 1'
row empty_shards 20 "$(since)"
. "$tests/slurm.sh"
start_slurm "$folder/slurm"
trap 'stop_slurm; rm -rf "$folder"' EXIT
cat > job.sh <<'JOB'
#!/bin/bash
timed "$palpate" simulate body.h5 --shard $SLURM_ARRAY_TASK_ID/$shards -o slurmed --jobs 1
JOB
from=$(now)
sbatch --parsable --array=1-"$shards" --output=/dev/null --mem=500 job.sh > /dev/null
wait_for_slurm 1200
timed "$palpate" merge slurmed -o slurmed/samples.h5
row slurm $((shards + 1)) "$(since)"
cmp slurmed/samples.h5 one.h5
from=$(now)
sbatch --parsable --array=1-40 --output=/dev/null --mem=500 --wrap=true > /dev/null
wait_for_slurm 600
echo "0 0" > times.txt; row slurm_empty_tasks 40 "$(since)"
experiments=$((49 * points)); from=$(now)
timed "$palpate" simulate body.h5 -o again.h5 --jobs 2
row threads_again 1 "$(since)"
