"""Scans of a robot (docs/measured-data.md): an asset from each file, replayed at passes held out.

    python3 tools/workshop/docs/measured/scans.py PALPATE OUT SCAN.csv.gz...

Prints, of held-out rows above a tenth of the largest force, median and p95 in % of the vector's error
and of the magnitude's, and the angle in degrees: of the asset, and of the mean of the eight fitted
rows nearest in place and velocity times 0.05 s.
"""

import csv
import pathlib
import subprocess
import sys

import h5py
import numpy as np

MANIFEST = """[[recording]]
file = "{file}"
kind = "scan"
force_on = "tool"
columns = {{ time = "t_s", position = ["x_mm", "y_mm", "z_mm"], force = ["fx_N", "fy_N", "fz_N"] }}
units = {{ time = "s", position = "mm", force = "N" }}
"""


def states(path):
    """Place and velocity times 0.05 s of each row, its force, whether it begins a pass."""
    with h5py.File(path) as f:
        point = f["rows/point"][:]
        place = f["points/position"][:][point] + f["rows/deflection"][:]
        time, force, experiment = f["rows/time"][:], f["rows/force"][:], f["rows/experiment"][:]
    velocity = np.zeros_like(place)
    for e in np.unique(experiment):
        of = experiment == e
        velocity[of] = np.gradient(place[of], time[of], axis=0)
    return np.hstack([place, 0.05 * velocity]), force


def nearest(fitted, asked):
    known, force = states(fitted)
    state, wanted = states(asked)
    answer = np.empty_like(wanted)
    for i in range(0, len(state), 256):
        away = ((state[i : i + 256, None, :] - known) ** 2).sum(-1)
        answer[i : i + 256] = force[np.argpartition(away, 8, axis=1)[:, :8]].mean(1)
    return answer, wanted


def figures(answer, force):
    size = np.linalg.norm(force, axis=1)
    counts = size > 0.1 * size.max()
    answer, force, size = answer[counts], force[counts], size[counts]
    answered = np.linalg.norm(answer, axis=1)
    cosine = (answer * force).sum(1) / np.maximum(answered * size, 1e-12)
    parts = (
        100 * np.linalg.norm(answer - force, axis=1) / size,
        100 * abs(answered - size) / size,
        np.degrees(np.arccos(np.clip(cosine, -1, 1))),
    )
    return "; ".join(f"{np.median(p):.1f}, {np.quantile(p, 0.95):.0f}" for p in parts)


def main():
    palpate, out, *scans = sys.argv[1:]
    for scan in map(pathlib.Path, scans):
        folder = pathlib.Path(out) / scan.name.split(".")[0]
        folder.mkdir(parents=True, exist_ok=True)
        manifest = folder / "manifest.toml"
        manifest.write_text(MANIFEST.format(file=scan.resolve()))
        subprocess.run([palpate, "run", manifest, "-o", folder / "run"], check=False)
        run = folder / "run"
        with open(run / "validation.csv", newline="") as f:
            rows = list(csv.DictReader(f))
        column = lambda names: np.array([[float(r[n]) for n in names] for r in rows])
        asset = figures(column(["ex_N", "ey_N", "ez_N"]), column(["fx_N", "fy_N", "fz_N"]))
        rival = figures(*nearest(run / "samples.h5", run / "samples.held_out.h5"))
        print(f"| {folder.name} | {asset} | {rival} |")


if __name__ == "__main__":
    main()
