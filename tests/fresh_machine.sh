#!/usr/bin/env bash
# Runs README's two commands as they stand there, in clean roots of Debian 12 and 13 that hold a clone of
# this repository, then the shipped phantom by the packages' program in roots that hold nothing else.
#   fresh_machine.sh [FOLDER [SUITE...]]
# FOLDER (default: a temporary one) keeps logs, roots and compiler caches; a second run uses the latter
# two. The suites are bookworm and trixie. Mirror, certificates and settings of apt and npm are those of
# the machine that it runs on.
set -euo pipefail
source=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
skip() { echo "SKIPPED: $*"; exit 0; }
[ "$(id -u)" -eq 0 ] || skip "only root makes clean roots"
for program in debootstrap unshare git apt-get; do
  command -v $program >/dev/null || skip "there is no $program"
done
mapfile -t commands < <(sed -n '/^## Install/,/^## From/s/^    \(bash [^#]*[^# ]\).*/\1/p' "$source/README.md")
[ ${#commands[@]} -eq 2 ] || { echo "FAILED: README.md shows ${#commands[@]} commands, not 2"; exit 1; }
folder=${1:-$(mktemp -d)}
[ $# -gt 0 ] || trap 'rm -rf "$folder"' EXIT
mkdir -p "$folder"
suites=("${@:2}")
[ ${#suites[@]} -gt 0 ] || suites=(bookworm trixie)
mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | grep -v security | head -n 1)
/usr/lib/apt/apt-helper download-file "${mirror}dists/${suites[0]}/Release" "$folder/Release" >/dev/null 2>&1 ||
  skip "apt's first mirror does not answer"

# make_root ROOT: unpacks a clean suite, which reaches packages as this machine does.
make_root() {
  rm -rf "$1"
  debootstrap --variant=minbase "$suite" "$1.partial" "$mirror" || return
  cp /etc/resolv.conf "$1.partial/etc/"
  apt-config dump | grep -i '^Acquire::.*\(proxy\|check\|verify\)' > "$1.partial/etc/apt/apt.conf.d/90host" || true
  cp -a /usr/local/share/ca-certificates "$1.partial/usr/local/share/"
  cat /etc/npmrc ~/.npmrc > "$1.partial/root/.npmrc" 2>/dev/null || true
  mv "$1.partial" "$1"
}
# in_root ROOT COMMAND: runs it in a root, where its processes and mounts end with it.
in_root() {
  unshare --mount --pid --fork --kill-child --mount-proc --root="$1" --wd=/ \
    env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 bash -ec "$2" </dev/null
}

status=0
# timed NAME COMMAND...: runs a step, prints how it ended, and appends its output to the log.
timed() {
  local name=$1 started=$SECONDS result=passed
  shift
  echo "== $name" >> "$log"
  "$@" >> "$log" 2>&1 || result="FAILED ($?)" status=1
  printf '%-9s %-34s %-13s %5d s\n' "$suite" "$name" "$result" $((SECONDS - started))
  [ "$result" = passed ] || { tail -n 20 "$log"; return 1; }
}
pack() {
  in_root "$build" "cd /palpate/build/release; cpack -G DEB" &&
    cp "$build"/palpate/build/release/{palpate,libpalpate-engine[0-9]*}_*.deb "$user/root/"
}
play() {  # Status 3 of `run` means that it is done, and some items failed and are listed.
  in_root "$user" "apt-get update -q; apt-get install -y -q --no-install-recommends /root/*.deb
    palpate run /usr/share/palpate/scenes/liver.toml -o /root/liver || [ \$? -eq 3 ]" &&
    cmp "$user/root/liver/asset.palp" "$build/palpate/out/liver/asset.palp"
}

echo "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1), $(nproc) threads; logs in $folder"
for suite in "${suites[@]}"; do
  root=$folder/$suite build=$folder/$suite.build user=$folder/$suite.user log=$folder/$suite.log
  : > "$log"
  [ -e "$root" ] || timed "debootstrap" make_root "$root" || continue
  [ ! -e "$build/root/.cache" ] || { rm -rf "$folder/.cache"; mv "$build/root/.cache" "$folder/"; }
  rm -rf "$build" "$user"
  cp -a "$root" "$build"
  cp -a "$root" "$user"
  [ ! -e "$folder/.cache" ] || { echo "$suite has a compiler cache"; mv "$folder/.cache" "$build/root/"; }
  git clone --quiet --no-hardlinks "$source" "$build/palpate"
  for command in "${commands[@]}"; do
    timed "$command" in_root "$build" "cd /palpate; $command" || true
  done
  timed "packages" pack && timed "run by the packages' program" play || true
done
exit $status
