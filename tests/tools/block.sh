# Blocks as OFF files, for scripts.
block() { # name, side and height in mm: a grid on each side, so that there are vertices to press on
  awk -v w="$2" -v h="$3" 'BEGIN { n = 8; v = f = ""; nv = nf = 0
    for (side = 0; side < 6; ++side) {
      first = nv
      for (j = 0; j <= n; ++j) for (i = 0; i <= n; ++i) {
        s = i / n; t = j / n
        if (side == 0) p = s*w " " t*w " " h; else if (side == 1) p = t*w " " s*w " " 0
        else if (side == 2) p = s*w " " 0 " " t*h; else if (side == 3) p = t*w " " w " " s*h
        else if (side == 4) p = 0 " " t*w " " s*h; else p = w " " s*w " " t*h
        v = v p "\n"; ++nv }
      for (j = 0; j < n; ++j) for (i = 0; i < n; ++i) {
        a = first + j*(n+1) + i; b = a+1; c = b+n+1; d = a+n+1
        f = f "3 " a " " b " " c "\n3 " a " " c " " d "\n"; nf += 2 } }
    printf "OFF\n%d %d 0\n%s%s", nv, nf, v, f }' > "$1.off"
}
