"""The made-up rig of the tutorial's pictures: python3 docs/tutorial/presses.py FOLDER, then in it
palpate run manifest.toml -o measured. Sixteen presses by Hertz's law, stiffer around (45, 35) mm,
and one whose force has the wrong sign."""
import math
import pathlib
import random
import sys

CELLS = 8  # of a side of the block, 80 x 80 x 30 mm

folder = pathlib.Path(sys.argv[1])
(folder / "rig").mkdir(parents=True, exist_ok=True)
random.seed(42)


def press(name, stiffness, touch_mm, sign=1):
    """Down by 4 mm and up again; N/mm^1.5, noise of 4 mN, an offset of 10 mN."""
    rows = "t,z,F\n"
    for i in range(320):
        travel = 0.025 * min(i, 320 - i)
        force = sign * stiffness * max(0, travel - touch_mm) ** 1.5 + random.gauss(0, 0.004) + 0.01
        rows += f"{0.02 * i:.2f},{travel:.3f},{force:.4f}\n"
    (folder / "rig" / f"{name}.csv").write_text(rows)


manifest = """surface = "phantom.off"
length_unit = "mm"
[defaults]
columns = { time = "t", depth = "z", force = "F" }
units = { time = "s", position = "mm", force = "N" }
force_on = "body"
probe = { shape = "sphere", radius = "5 mm", friction = 0.3 }
"""
places = [(x, y) for y in (25, 35, 45, 55) for x in (25, 35, 45, 55)]
for k, (x, y) in enumerate(places + [(40, 40)], start=1):
    lump = math.exp(-((x - 45) ** 2 + (y - 35) ** 2) / (2 * 9**2))
    if k <= len(places):
        press(f"p{k:02}", 0.16 * (1 + 0.9 * lump), 1 + random.uniform(-0.3, 0.3))
    else:
        press(f"p{k:02}", 0.2, 1, -1)
    manifest += f'[[recording]]\nfile = "rig/p{k:02}.csv"\nposition = [{x}, {y}, 30]\n'
(folder / "manifest.toml").write_text(manifest)

vertices, faces = [], []
for side in (lambda u, v: (u, v, 1), lambda u, v: (v, u, 0), lambda u, v: (u, 0, v),
             lambda u, v: (v, 1, u), lambda u, v: (0, v, u), lambda u, v: (1, u, v)):
    first = len(vertices)
    for j in range(CELLS + 1):
        for i in range(CELLS + 1):
            x, y, z = side(i / CELLS, j / CELLS)
            vertices.append(f"{80 * x:g} {80 * y:g} {30 * z:g}")
    for j in range(CELLS):
        for i in range(CELLS):
            a = first + j * (CELLS + 1) + i
            b, c, d = a + 1, a + CELLS + 2, a + CELLS + 1
            faces += [f"3 {a} {b} {c}", f"3 {a} {c} {d}"]
(folder / "phantom.off").write_text(
    "\n".join([f"OFF\n{len(vertices)} {len(faces)} 0", *vertices, *faces]) + "\n")
