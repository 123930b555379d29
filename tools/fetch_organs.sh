#!/usr/bin/env bash
# Fetches the meshes of real organs that scenes name below $PALPATE_DATA, each with its checksum and
# licence: tools/fetch_organs.sh FOLDER, then export PALPATE_DATA=FOLDER. What is there and right
# stays. PALPATE_MIRROR names another place with the same tree (a folder as file:///...).
set -euo pipefail
[ $# -eq 1 ] || { echo "usage: tools/fetch_organs.sh FOLDER" >&2; exit 2; }
folder=$1
from=${PALPATE_MIRROR:-https://raw.githubusercontent.com}

# name below FOLDER | sha256 | repository/commit/path | licence
organs='
surfaces/sofa_liver.vtk|322e455b9e170751e97a4613672edd16c416307ec7fd13e8c5d3b9cfa9282347|sofa-framework/sofa/2a278d891fe68ae5a835259bd62a2844df1670a1/share/mesh/liver.vtk|LGPL-2.1-or-later
surfaces/sofa_liver2.obj|ec6eb61a425bce51bba1bbae0b8416156cbf725afb51ae0150c7954ac4234818|sofa-framework/sofa/2a278d891fe68ae5a835259bd62a2844df1670a1/share/mesh/liver2.obj|LGPL-2.1-or-later
surfaces/odedstein_hand_closed.obj|cb2fb353cca21db7b9dcdef96e3fc01dc42489c24b69c64c1ea0a0741d16edc4|odedstein/meshes/835213277571d625722d25880c9c3010c6f45a5a/objects/hand/hand_closed.obj|CC-BY-4.0
'
is_right() { [ -f "$1" ] && echo "$2  $1" | sha256sum --check --status; }

status=0
while IFS='|' read -r name sum path licence; do
  [ -n "$name" ] || continue
  if is_right "$folder/$name" "$sum"; then
    echo "$name: is there"
    continue
  fi
  mkdir -p "$(dirname "$folder/$name")"
  if ! curl --fail --silent --show-error --location --output "$folder/$name.partial" "$from/$path"; then
    echo "$name: cannot be had from $from/$path; save it there by hand" >&2
    rm -f "$folder/$name.partial"
    status=1
  elif is_right "$folder/$name.partial" "$sum"; then
    mv "$folder/$name.partial" "$folder/$name"
    echo "$name: fetched from $path ($licence)"
  else
    echo "$name: what came from $from/$path is not the file that was meant (checksum); nothing is kept" >&2
    rm -f "$folder/$name.partial"
    status=1
  fi
done <<<"$organs"
exit "$status"
