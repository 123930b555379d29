#!/usr/bin/env bash
# Installs every Debian package that Palpate needs and that is not there yet (tools/packages.txt), then
# those that the page of `palpate report` is built with (tools/packages_page.txt) and those named as
# arguments. It goes on without any of these that cannot be had, and names it.
set -euo pipefail
here=$(dirname "${BASH_SOURCE[0]}")

# Of the packages read from stdin, those that are not installed; Node.js may come from elsewhere.
missing() {
  while read -r package; do
    [ -n "$package" ] || continue
    case "$package" in
      nodejs) command -v node >/dev/null && continue ;;
      npm | chromium) command -v "$package" >/dev/null && continue ;;
    esac
    dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || echo "$package"
  done
}

as_root() {
  if [ "$(id -u)" -eq 0 ]; then "$@"
  elif command -v sudo >/dev/null; then sudo "$@"
  else echo "packages: not root and no sudo; run as root: $*" >&2; return 1; fi
}
install() {
  echo "packages: installing $*"
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends "$@"
}

mapfile -t needed < <(missing < "$here/packages.txt")
mapfile -t optional < <({ cat "$here/packages_page.txt"; printf '%s\n' "$@"; } | missing)
if [ ${#needed[@]} -gt 0 ] || [ ${#optional[@]} -gt 0 ]; then as_root apt-get update -q || true; fi
if [ ${#needed[@]} -eq 0 ]; then
  echo "packages: all of $(grep -c . "$here/packages.txt") are installed"
else
  install "${needed[@]}"
fi
if [ ${#optional[@]} -gt 0 ] && ! install "${optional[@]}"; then
  for package in "${optional[@]}"; do
    install "$package" ||
      echo "packages: going on without $package, which the page of palpate report or some tests are made with"
  done
fi
