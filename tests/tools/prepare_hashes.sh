#!/bin/bash
# What `prepare` makes of real surfaces must not differ with the machine's load: of each, body.h5
# twice alone and twice beside a machine kept busy, all of one hash.
# prepare_hashes.sh PALPATE SURFACES_DIR
set -u
palpate=$(realpath "$1") surfaces=$2
[ -d "$surfaces" ] || { echo "SKIPPED: needs shared data: $surfaces"; exit 0; }
surfaces=$(realpath "$surfaces")
work=$(mktemp -d) busy=()
stop() {
  [ ${#busy[@]} -gt 0 ] && kill "${busy[@]}" && wait "${busy[@]}"
  busy=()
} 2>/dev/null
trap 'stop; rm -rf "$work"' EXIT
cd "$work" || exit 1

scenes=()
for mesh in "$surfaces"/*.{obj,off,vtk,ply,stl}; do
  [ -f "$mesh" ] || continue
  name=$(basename "$mesh")
  case $name in  # so that each is an organ's size; others as `new` guesses
    sofa_liver2.obj) unit='110 mm' ;; sofa_liver-smooth.obj) unit='33 mm' ;;
    odedstein_hand_closed.obj) unit='200 mm' ;; sofa_liver.vtk) unit=mm ;; *) unit= ;;
  esac
  if "$palpate" new "$mesh" -o "$name.toml" ${unit:+--unit "$unit"} --quiet 2> "$name.log"; then
    scenes+=("$name")
  else
    echo "no scene for $name: $(head -1 "$name.log")"
  fi
done
[ ${#scenes[@]} -gt 0 ] || { echo "SKIPPED: needs shared data: a mesh in $surfaces"; exit 0; }

prepare() { # run: one body and its hash for each scene
  for name in "${scenes[@]}"; do
    if "$palpate" prepare "$name.toml" -o "$name.$1.h5" 2> "$name.$1.log"; then
      sha256sum < "$name.$1.h5" | cut -c1-16
    else
      echo "refused:$(grep -m1 error "$name.$1.log" | sha256sum | cut -c1-8)"
    fi > "$name.$1.hash"
    rm -f "$name.$1.h5"
  done
}
prepare 1
prepare 2
for ((i = 0; i < 2 * $(nproc); ++i)); do yes > /dev/null & busy+=($!); done
prepare 3
prepare 4
stop

failed=0
printf '%-28s %-16s %-16s %-16s %-16s  %s\n' surface alone alone busy busy volume
for name in "${scenes[@]}"; do
  read -r a b c d <<< "$(cat "$name".[1-4].hash | tr '\n' ' ')"
  printf '%-28s %s %s %s %s %s\n' "$name" "$a" "$b" "$c" "$d" \
    "$(grep -m1 -o 'volume: .*degrees ([a-z_0-9]*)' "$name.1.log")"
  [ "$a" = "$b" ] && [ "$a" = "$c" ] && [ "$a" = "$d" ] || failed=1
done
[ $failed = 0 ] && echo "all bodies equal" || echo "FAILED: bodies differ"
exit $failed
