#!/usr/bin/env python3
"""Curves from noisy presses of a body that relaxes: contacts known, found, and freed in the fit.

    python3 tools/workshop/docs/measured/timed_presses.py PALPATE FOLDER [SEEDS]

writes six presses of a ball (three points, 2 and 20 mm/s, each 4 mm deep, held for 6 s and taken
out; one branch of 0.5 and 1 s; white noise of 1 % of the largest force) and their manifests into
FOLDER, imports and fits them, and prints what is left of the rows and how far the curves are from
slow motion's from a quarter of the depth on. Forces are Lee and Radok's integral while the contact
grows; the way out lets rings go one by one, as a bed does. Needs python3-numpy and python3-h5py.
"""
import json
import os
import sys

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import Program, normal_curves

SHARE, TIME_S, RADIUS_M, DEPTH_M, INTERVAL_S = 0.5, 1.0, 5e-3, 4e-3, 0.01
YOUNG_PA = (4000, 5000, 6500)
POINTS = ((0, 0, 0), (0.02, 0, 0), (0, 0.02, 0))


def slow_N(depth_m, young_Pa):
    return 16 / 9 * young_Pa * np.sqrt(RADIUS_M) * np.maximum(depth_m, 0) ** 1.5


def press(young_Pa, speed_m_s, noise, rng):
    """Time, travel from 1 mm above the body, force on the tool's axis."""
    in_s = (DEPTH_M + 1e-3) / speed_m_s
    time_s = np.arange(0, 1 + in_s + 6 + in_s, INTERVAL_S)
    at = np.interp(time_s, [0, 1, 1 + in_s, 7 + in_s, 7 + 2 * in_s],
                   [-1e-3, -1e-3, DEPTH_M, DEPTH_M, -1e-3])
    fine = 5  # steps of an interval; forces by an exact step of each ring's dashpot
    grid = np.linspace(0, DEPTH_M, 401)
    stiffness = np.diff(np.diff(slow_N(grid, young_Pa)) / np.diff(grid), prepend=0)
    ring = grid[:-1]
    v, force = np.zeros_like(ring), []
    decay = np.exp(-INTERVAL_S / fine / TIME_S)
    depth = at[0]
    for target in at:
        start = depth
        for step in range(fine):
            depth = start + (target - start) * (step + 0.5) / fine
            y = np.maximum(depth - ring, SHARE * v / (1 + SHARE))
            v = y + (v - y) * decay
        depth = target
        force.append(np.sum(stiffness * np.maximum(
            0, (1 + SHARE) * (depth - ring) - SHARE * v)))
    force = np.array(force)
    return time_s, at + 1e-3, force + rng.normal(0, noise * force.max(), len(force))


def measured(folder, contact, free):
    """Of each point the residual over the largest force, and the curve's mean error; errors of the
    contacts [mm]."""
    manifest, samples, curves = (os.path.join(folder, name)
                                 for name in ("manifest.toml", "samples.h5", "curves.h5"))
    with open(manifest, "w", encoding="utf-8") as out:
        out.write('[defaults]\nnormal = [0, 0, -1]\nforce_on = "body"\n' + contact +
                  f'probe = {{ shape = "sphere", radius = "{RADIUS_M} m" }}\n')
        for p, place in enumerate(POINTS):
            for k in range(2):
                out.write(f'[[recording]]\nfile = "press_{p}_{k}.csv"\npoint = "p{p}"\n'
                          f'position = ["{place[0]} m", "{place[1]} m", "{place[2]} m"]\n')
    palpate("import", manifest, "-o", samples, "--force")
    palpate("fit", samples, "-o", curves, *(["--free", "contact"] if free else []))
    table = os.path.join(folder, "curves.csv")
    palpate("tabulate", "--steps", "100", curves, "-o", table)
    errors = []
    rows = normal_curves(table)
    for p, young_Pa in enumerate(YOUNG_PA):
        at, value = np.array([[float(r["at_m"]), float(r["value_N"])] for r in rows
                              if int(r["point"]) == p]).T
        deep = at >= DEPTH_M / 4
        errors.append(np.mean(value[deep] / slow_N(at[deep], young_Pa) - 1))
    with h5py.File(curves) as h5:
        left = h5["points/rms_residual"][:] / [1.5 * slow_N(DEPTH_M, E) for E in YOUNG_PA]
    with open(os.path.join(folder, "samples.import.json"), encoding="utf-8") as source:
        contact_mm = [1e3 * r["contact_m"] - 1 for r in json.load(source)["recordings"]]
    return left, errors, contact_mm


def main():
    rms = lambda values: float(np.sqrt(np.mean(np.square(values))))
    print("| contact | force left | curve off slow motion's, rms | largest | contacts off, mm rms |\n"
          "|---|---|---|---|---|")
    for name, contact, free in (("known", 'contact = "1 mm"\n', False), ("found", "", False),
                                ("freed in the fit", "", True)):
        left, off, contacts = [], [], []
        for seed in range(SEEDS):
            rng = np.random.default_rng(seed)
            for p, young_Pa in enumerate(YOUNG_PA):
                for k, speed in enumerate((2e-3, 20e-3)):
                    with open(os.path.join(FOLDER, f"press_{p}_{k}.csv"), "w",
                              encoding="utf-8") as out:
                        out.write("t_s,depth_mm,F_N\n")
                        for t, z, f in zip(*press(young_Pa, speed, 0.01, rng)):
                            out.write(f"{t:.3f},{1e3 * z:.6f},{f:.8f}\n")
            a, b, c = measured(FOLDER, contact, free)
            left.extend(a), off.extend(b), contacts.extend(c)
        print(f"| {name} | {100 * np.mean(left):.2g} % | {100 * rms(off):.2g} % | "
              f"{100 * max(map(abs, off)):.2g} % | {rms(contacts):.3f} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    palpate, FOLDER = Program(sys.argv[1]), sys.argv[2]
    SEEDS = int(sys.argv[3]) if len(sys.argv) == 4 else 3
    os.makedirs(FOLDER, exist_ok=True)
    main()
