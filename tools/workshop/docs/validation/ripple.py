#!/usr/bin/env python3
"""How much of an asset's force lies above 20 Hz along held-out paths, as a device plays them.

    python3 tools/workshop/docs/validation/ripple.py PALPATE RUN...

RUN: a folder that `palpate run` wrote. The tool moves at 20, 50 and 100 mm/s along the slides and the
wandering paths of its statement and back again, as a hand does: without motion above 20 Hz (a Hann
window of 100 ms). The asset is played at 1 kHz. Forces of the body itself have little above 20 Hz, for
they change over a contact's width, but they have some, where a touch and a slip begin: the figures
bound the asset's own ripple. Printed for each speed: median and p95 over paths of the largest and of
the root mean square above 20 Hz, in mN, and the latter of the force's.
"""
import csv
import os
import sys
import tempfile

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import Program, table

RATE_HZ, ABOVE_HZ, CLEAR_M = 1000, 20, 0.003


def rounded(corners, speed):
    """Places every millisecond along the corners and back, without motion above ABOVE_HZ."""
    corners = np.concatenate([corners, corners[-2::-1]])
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    along = np.arange(0, length[-1], speed / RATE_HZ)
    at = np.stack([np.interp(along, length, corners[:, k]) for k in range(3)], axis=1)
    window = np.hanning(2 * RATE_HZ // ABOVE_HZ + 1)
    held = np.pad(at, ((RATE_HZ // 4, RATE_HZ // 4), (0, 0)), mode="edge")
    return np.stack([np.convolve(held[:, k], window / window.sum(), "same") for k in range(3)],
                    axis=1)[len(window):-len(window)]


def above(force):
    """The part of a force above ABOVE_HZ; it begins and ends with zero."""
    spectrum = np.fft.rfft(force, axis=0)
    spectrum[np.fft.rfftfreq(len(force), 1 / RATE_HZ) <= ABOVE_HZ] = 0
    return np.fft.irfft(spectrum, len(force), axis=0)


def paths(run):
    """(name, places of the tip in metres) of each slide of a run's statement."""
    with h5py.File(os.path.join(run, "reference.h5")) as file:
        normal = dict(zip(file["points/name"].asstr(), file["points/normal"]))
    found = {}
    for row in table(os.path.join(run, "validation.csv")):
        if row["path"] not in ("straight", "oblique"):
            place, moved = (np.array([float(row[a + k]) for k in ("x_m", "y_m", "z_m")]) for a in ("", "d"))
            before = place - CLEAR_M * normal[row["point"]]  # the normal points inward
            found.setdefault((row["point"], row["path"]), [before, place]).append(place + moved)
    return [(path, np.array(corner)) for (_, path), corner in found.items()]


def main():
    program = Program(sys.argv[1])
    for run in sys.argv[2:]:
        for speed in (0.02, 0.05, 0.1):
            largest, rms, share = [], [], []
            for _, corners in paths(run):
                with tempfile.TemporaryDirectory() as folder:
                    path, out = (os.path.join(folder, n) for n in ("path.csv", "forces.csv"))
                    with open(path, "w", newline="", encoding="utf-8") as file:
                        writer = csv.writer(file)
                        writer.writerow(["t_s", "x_m", "y_m", "z_m"])
                        writer.writerows([i / RATE_HZ, *at] for i, at in enumerate(rounded(corners, speed)))
                    program("replay", os.path.join(run, "asset.palp"), path, "-o", out)
                    force = np.array([[float(r[k]) for k in ("fx_N", "fy_N", "fz_N")] for r in table(out)])
                rest = np.linalg.norm(above(force), axis=1)
                largest.append(rest.max())
                rms.append(np.sqrt((rest**2).mean()))
                share.append(rms[-1] / np.sqrt((force**2).sum(axis=1).mean()))
            say = lambda v, k: "{:.3g}, {:.3g}".format(*(k * np.percentile(v, [50, 95])))
            print(f"{run} {1000 * speed:.0f} mm/s, {len(rms)} paths: largest {say(largest, 1000)} mN; "
                  f"rms {say(rms, 1000)} mN, {say(share, 100)} % of the force", flush=True)


if __name__ == "__main__":
    main()
