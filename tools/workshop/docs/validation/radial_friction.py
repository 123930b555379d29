#!/usr/bin/env python3
"""By how much friction stiffens a press, and what a slide leaves of it.

    python3 tools/workshop/docs/validation/radial_friction.py PALPATE

Presses the middle of data/scenes/block.toml 9 mm deep and drags there, with friction 0.3 and with
none, at several Poisson's ratios and heights. Prints a table for docs/validation.md: the force
with friction over that without, less 1, in percent, at 3, 6 and 9 mm, and along a drag at 7.2 mm
(its first direction) after 0.35, 2.8 and 8 mm. Needs h5py and numpy.
"""
import os
import re
import sys
import tempfile

import h5py
import numpy as np

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.insert(0, os.path.join(HERE, ".."))
from scripts import Program  # noqa: E402

SCENE = os.path.join(HERE, "..", "..", "..", "..", "data", "scenes", "block.toml")
CASES = ((0.3, 0.1), (0.45, 0.1), (0.49, 0.1), (0.49, 22), (0.45, 22))  # nu; held below [mm]
DRAG_M = 7.2e-3


def forces_N(palpate, poisson, held_mm, friction, folder):
    with open(SCENE, encoding="utf-8") as source:
        text = source.read()
    text = re.sub(r"(?m)^drag_\w+\s*=.*\n", "", text)
    for key, value in (("poisson", poisson), ("friction", friction), ("depth", '"9 mm"'),
                       ("press_steps", 9)):
        text = re.sub(rf"(?m)^{key}\s*=.*$", f"{key} = {value}", text)
    text = text.replace('at = "0.1 mm"', f'at = "{held_mm} mm"')
    surface = os.path.abspath(os.path.join(os.path.dirname(SCENE), "../bodies/block.obj"))
    text = re.sub(r'(?m)^surface\s*=.*$', f'surface = "{surface}"', text)
    scene, points, samples = (os.path.join(folder, name)
                              for name in ("block.toml", "points.csv", "samples.h5"))
    for name, content in ((scene, text), (points, "x_m,y_m,z_m\n0.05,0.05,0.04\n")):
        with open(name, "w", encoding="utf-8") as target:
            target.write(content)
    if os.path.exists(samples):
        os.remove(samples)
    palpate("simulate", scene, "--points", points, "-o", samples)
    with h5py.File(samples) as file:
        row = {key: file[f"rows/{key}"][...] for key in ("kind", "deflection", "force")}
    press = row["kind"] == 0
    deep = (row["kind"] == 1) & np.isclose(-row["deflection"][:, 2], DRAG_M)
    normal_N = -row["force"][:, 2]
    return normal_N[press], normal_N[deep][:8]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    palpate = Program(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        for poisson, held_mm in CASES:
            without = forces_N(palpate, poisson, held_mm, 0, folder)
            with_it = forces_N(palpate, poisson, held_mm, 0.3, folder)
            with np.errstate(divide="ignore", invalid="ignore"):
                press, drag = (100 * (b / a - 1) for a, b in zip(without, with_it))
            cells = [f"{x:.1f}" for x in (*press[[2, 5, 8]], *drag[[0, 3, 7]])]
            print(f"| {poisson} | {40 - held_mm:.0f} mm | {', '.join(cells[:3])} | "
                  f"{', '.join(cells[3:])} |", flush=True)


if __name__ == "__main__":
    main()
