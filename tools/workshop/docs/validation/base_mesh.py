#!/usr/bin/env python3
"""Forces against those on a base mesh 2.5 times as fine, row by row with the errors of both.

    python3 tools/workshop/docs/validation/base_mesh.py PALPATE SCENE...

Presses four test points of each scene in four steps and drags there as is the default, as the scene
is and with mesh_size a 2.5th of its base's edges (0.28 times the cube root of the volume). Prints a
row of docs/validation.md's table of thin bodies for each: the base's edge, the difference of the
forces over the finer one (median and largest, in percent), what the rows state (median), and how
many differ by at most what both state, and what they state alone; of presses first, then how many
rows of drags are within. Needs h5py and numpy.
"""
import os
import re
import subprocess
import sys
import tempfile

import h5py
import numpy as np

FINER, GOOD, PRESS = 2.5, 0, 0


def pressed(palpate, scene, mesh_size_m, folder):
    with open(scene, encoding="utf-8") as source:
        text = source.read()
    text = re.sub(r"(?m)^(drag_\w+|mesh_size|tolerance|budget|placement)\s*=.*\n", "", text)
    text = re.sub(r"(?m)^(test_points|press_steps)\s*=.*$", r"\1 = 4", text)
    if "press_steps" not in text:
        text = text.replace("[experiments]", "[experiments]\npress_steps = 4", 1)
    if mesh_size_m:
        text = text.replace("[body]", f'[body]\nmesh_size = "{1e3 * mesh_size_m:g} mm"', 1)
    name = os.path.join(os.path.dirname(os.path.abspath(scene)), f".base_mesh_{os.getpid()}.toml")
    with open(name, "w", encoding="utf-8") as target:
        target.write(text)
    body, samples = (os.path.join(folder, f"{file}.h5") for file in ("body", "samples"))
    try:
        subprocess.run([palpate, "prepare", name, "-o", body], check=True, capture_output=True)
        subprocess.run([palpate, "simulate", body, "-o", samples],
                       capture_output=True, check=False)  # 3: some rows did not converge
    finally:
        os.remove(name)
    return body, samples


def volume_m3(body):
    with h5py.File(body) as file:
        x, triangles = file["surface/vertices"][...], file["surface/triangles"][...]
    a, b, c = (x[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6


def rows(samples):
    with h5py.File(samples) as file:
        return [file[f"rows/{key}"][...] for key in ("force", "force_error", "status", "kind")]


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    print("| body | base edge | error | stated | within | own | drags within | own |\n"
          "|---|---|---|---|---|---|---|---|")
    for scene in sys.argv[2:]:
        with tempfile.TemporaryDirectory() as folder:
            body, samples = pressed(sys.argv[1], scene, 0, folder)
            edge_m = 0.28 * np.cbrt(volume_m3(body))
            force_N, error_N, status, kind = rows(samples)
            _, samples = pressed(sys.argv[1], scene, edge_m / FINER, folder)
            finer_N, finer_error_N, finer_status, _ = rows(samples)
        off_N, size_N = (np.linalg.norm(x, axis=1) for x in (force_N - finer_N, finer_N))
        good = (status == GOOD) & (finer_status == GOOD)
        press, drag = good & (kind == PRESS), good & (kind != PRESS)
        within, own = off_N <= error_N + finer_error_N, off_N <= error_N
        off, stated = (100 * x[press] / size_N[press] for x in (off_N, error_N))
        print(f"| {os.path.basename(scene)} | {1e3 * edge_m:.0f} mm | {np.median(off):.1f} / "
              f"{off.max():.1f} | {np.median(stated):.1f} | {within[press].sum()} of {press.sum()} "
              f"| {own[press].sum()} | {within[drag].sum()} of {drag.sum()} | {own[drag].sum()} |",
              flush=True)


if __name__ == "__main__":
    main()
