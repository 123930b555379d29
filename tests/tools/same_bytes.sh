#!/usr/bin/env bash
# The files of `palpate run` for a scene, and the same by its stages one by one, by two shards and
# merge, with one thread, and after three kills: equal to the byte, but for times of a tick.
# usage: same_bytes.sh PROGRAM SCENE FOLDER [--whole]; without --whole with fewer points and rows.
set -euo pipefail
program=$1 scene=$2 folder=$3 whole=${4:-}
name=$(basename "$scene" .toml)
if grep -q PALPATE_DATA "$scene" && [ ! -d "${PALPATE_DATA:-}" ]; then
  echo "SKIPPED: $name needs PALPATE_DATA"
  exit 0
fi
rm -rf "$folder"
mkdir -p "$folder/scenes"
cp -r "$(dirname "$scene")/../bodies" "$folder/"
own="$folder/scenes/$name.toml"
few='s/^(test_points) *= *[0-9]+/\1 = 5/; s/^budget *=.*/budget = 16/; s/^(press_steps|drag_steps) *=.*/\1 = 4/;
  s/^drag_depths *= *\[ *("[^"]*").*/drag_depths = [\1]/; s/^(points|pairs|cycles) *=.*/\1 = 2/; s/^causes *=.*//'
if [ "$whole" = --whole ]; then cp "$scene" "$own"; else
  sed -E "$few" "$scene" | sed 's/^\[tool\]/[tool]\npaths = 2\nheld_out = 2/' > "$own"; fi
family=$(sed -n 's/^family *= *"\(.*\)".*/--family \1/p' "$own")

run() { "$program" run "$own" -o "$folder/$1" "${@:2}" >>"$folder/log" 2>&1 || [ $? = 3 ]; }
stage() { "$program" "$@" >>"$folder/log" 2>&1 || [ $? = 3 ]; }

rest() {  # of a folder with samples.h5: what comes after
  local d=$folder/$1 body=$folder/$1/body.h5
  [ -f "$d/placed.h5" ] && body=$d/placed.h5
  stage fit "$d/samples.h5" -o "$d/curves.h5" $family
  stage refine "$d/curves.h5" --body "$body" --samples "$d/samples.h5" -o "$d/model.h5"
  stage export "$d/model.h5" -o "$d/asset.palp" --scene "$own" --engine "$d/engine"
  stage validate "$d/asset.palp" "$own" --body "$d/body.h5" --reference "$d" \
    --rows "$d/validation.csv" --statement "$d/statement.json"
}

untimed() { sed -E 's/("tick_ns": )[0-9.e+-]+/\1/; s/[0-9]+ ns( per tick)? on this machine//g' "$1"; }

# Equal files: every one of the second folder that is in the first; statements without ticks.
same() {
  local failed=0 compared=0
  for file in "$folder/$2"/*; do
    local base=${file##*/}
    [ -f "$file" ] && [ -f "$folder/run/$base" ] || continue
    case $base in report.html | run.log) continue ;; esac
    if [ "$base" = statement.json ]; then
      cmp -s <(untimed "$folder/run/$base") <(untimed "$file") ||
        { echo "$name: $1: $base differs"; failed=1; }
    else
      cmp -s "$folder/run/$base" "$file" || { echo "$name: $1: $base differs"; failed=1; }
    fi
    compared=$((compared + 1))
  done
  [ $failed = 0 ] && echo "$name: $1: $compared files are the same"
  return $failed
}

status=0
started=$(date +%s%N)
run run
took_ms=$((($(date +%s%N) - started) / 1000000))

mkdir "$folder/stages"
stage prepare "$own" -o "$folder/stages/body.h5"
stage simulate "$folder/stages/body.h5" -o "$folder/stages/samples.h5"
rest stages
same "stages one by one" stages || status=1

mkdir -p "$folder/merged/shards"
while :; do
  for k in 1 2; do stage simulate "$own" --shard "$k/2" -o "$folder/merged/shards"; done
  stage merge "$folder/merged/shards" -o "$folder/merged/samples.h5"
  [ -f "$folder/merged/samples.h5" ] && break
done
for file in body.h5 placed.h5; do
  for from in "$folder/merged/shards/$file" "$folder/merged/$file" "$folder/stages/$file"; do
    [ -f "$from" ] && { [ "$from" -ef "$folder/merged/$file" ] || cp "$from" "$folder/merged/$file"; break; }
  done
done
rest merged
same "two shards and merge" merged || status=1

run one --jobs 1
same "one thread" one || status=1

kills=0
for share in 20 45 70; do
  "$program" run "$own" -o "$folder/killed" >>"$folder/log" 2>&1 &
  pid=$!
  sleep "$(awk -v ms=$took_ms -v share=$share 'BEGIN { print ms * share / 1e5 / 2 }')"
  kill -9 $pid 2>/dev/null && kills=$((kills + 1))
  wait $pid 2>/dev/null || true
done
run killed
same "after $kills kills" killed || status=1
exit $status
