"""Scans of a robot (docs/measured-data.md): an asset from each file, replayed at passes held out.

    python3 tools/workshop/docs/measured/scans.py PALPATE OUT SCAN.csv.gz...

Prints, of held-out rows above a tenth of the largest force, median and p95 in % of the vector's error
and of the magnitude's, and the angle in degrees: of the asset, and of its rivals:

- the mean of the eight fitted rows nearest in place and velocity times 0.05 s
- heights and stiffnesses of half seconds, each a line through its rows, by inverse distance
- one curve of depth for all

The last is where the recording repeats itself: the eight rows where they are all within 0.7 mm, and
the share of rows of which that is so.
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


def nearest(known, force, state):
    answer, away_m = np.empty((len(state), 3)), np.empty(len(state))
    for i in range(0, len(state), 256):
        away = ((state[i : i + 256, None, :] - known) ** 2).sum(-1)
        of = np.argpartition(away, 8, axis=1)[:, :8]
        answer[i : i + 256] = force[of].mean(1)
        away_m[i : i + 256] = np.sqrt(np.take_along_axis(away, of, 1).max(1))
    return answer, away_m


def depths(body, place):
    """Depth of each place below the surface at its nearest vertex, and the inward normal there."""
    with h5py.File(body) as f:
        vertex, normal = f["test_points/position"][:], f["test_points/normal"][:]
    of = np.concatenate(
        [((p[:, None, :] - vertex) ** 2).sum(-1).argmin(1) for p in np.array_split(place, 100)]
    )
    return ((place - vertex[of]) * normal[of]).sum(1), normal[of]


def depth_rivals(body, known, force, asked):
    """Inverse distance of heights and stiffnesses, and one curve for all."""
    depth, normal = depths(body, known)
    push = (force * normal).sum(1)
    asked_depth, asked_normal = depths(body, asked)
    lines, places = [], []
    for rows in np.array_split(np.arange(len(known)), len(known) // 33):  # half a second at 66 Hz
        if np.ptp(depth[rows]) > 0.3e-3:
            slope, level = np.polyfit(depth[rows], push[rows], 1)
            if slope > 0:
                lines.append((-level / slope, slope)), places.append(known[rows].mean(0))
    lines, places = np.array(lines), np.array(places)
    size = np.empty(len(asked))
    for i, p in enumerate(asked):
        away = ((places - p) ** 2).sum(1)
        of = np.argpartition(away, 8)[:8]
        height, slope = np.average(lines[of], axis=0, weights=1 / (away[of] + 1e-12))
        size[i] = np.clip(slope * (asked_depth[i] - height), 0, push.max())
    edges = np.quantile(depth, np.linspace(0, 1, 41))
    of = np.clip(np.searchsorted(edges, depth) - 1, 0, 39)
    middle = [(np.median(depth[of == k]), np.median(push[of == k])) for k in range(40)]
    one = np.interp(asked_depth, *np.transpose(middle))
    return size[:, None] * asked_normal, one[:, None] * asked_normal


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
        known, force = states(run / "samples.h5")
        state, wanted = states(run / "samples.held_out.h5")
        rows, away_m = nearest(known, force, state)
        rivals = [rows, *depth_rivals(run / "samples.scan_body.h5", known[:, :3], force, state[:, :3])]
        close = away_m < 0.7e-3
        floor = f"{figures(rows[close], wanted[close])} ({100 * close.mean():.0f})" if close.any() else "-"
        print("|", " | ".join([folder.name, asset, *(figures(r, wanted) for r in rivals), floor]), "|")


if __name__ == "__main__":
    main()
