"""Draws what `palpate` makes of real recordings, one SVG each: the curve with its 90 % band and the
measured rows, and the residual of readings that the fit has not seen beside the sensor's noise.

    python3 tools/workshop/docs/measured/plot.py PALPATE DATA docs/measured

Needs python3-matplotlib and python3-h5py. Not seen by the fit: of five repeats one, in turn; of a
single recording every other reading.
"""
import glob
import os
import sys
import tempfile

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import Program, normal_curves, pyplot, save

PROBE = 'probe = { shape = "%s", radius = "%s" }\n'
COMMON = 'force_on = "body"\nnormal = [0, 0, -1]\nposition = ["0 mm", "0 mm", "0 mm"]\n'
RECORDINGS = [  # name, title, pattern, keys, first row of numbers, units on the axes
    ("silicone_100", "silicone EF10_100T, five repeats", "compression/EF10_100T_*.csv",
     PROBE % ("flat", "25 mm"), None, (1e3, "mm", 1, "N")),
    ("silicone_50", "silicone EF10_50T, five repeats", "compression/EF10_50T_*.csv",
     PROBE % ("flat", "25 mm"), None, (1e3, "mm", 1, "N")),
]


def imported(folder, name, files, keys, rows=40):
    """Depth, force, its error and the noise of one reading, from files as one point."""
    manifest = os.path.join(folder, name + ".toml")
    with open(manifest, "w", encoding="utf-8") as out:
        out.write("[defaults]\npoint = \"p\"\nrows = %d\n" % rows + COMMON + keys)
        for file in files:
            out.write('[[recording]]\nfile = "%s"\n' % os.path.abspath(file))
    palpate("import", manifest, "-o", os.path.join(folder, name + ".h5"))
    with h5py.File(os.path.join(folder, name + ".h5")) as h5:
        good = h5["rows/status"][:] == 0
        return (-h5["rows/deflection"][:, 2][good], -h5["rows/force"][:, 2][good],
                h5["rows/force_error"][:][good], float(np.median(h5["recordings/noise"])))


def fitted(folder, name):
    """Depth, value and standard error of the normal curve."""
    path = os.path.join(folder, name)
    palpate("fit", path + ".h5", "-o", path + ".curves.h5")
    palpate("tabulate", "--band", "--steps", "200", path + ".curves.h5", "-o", path + ".csv")
    rows = normal_curves(path + ".csv")
    return [np.array([float(r[k]) for r in rows]) for k in ("at_m", "value_N", "deviation_N")]


def halves(folder, file, header):
    """Two files of every other reading each."""
    with open(file, encoding="latin-1") as source:
        lines = source.read().splitlines()
    first = next(i for i, line in enumerate(lines) if line.startswith(header)) + 1
    out = []
    for k in range(2):
        out.append(os.path.join(folder, f"half{k}" + os.path.splitext(file)[1]))
        with open(out[-1], "w", encoding="latin-1") as half:
            half.write("\n".join(lines[:first] + lines[first + k::2]) + "\n")
    return out


def held_out(folder, files, keys, header):
    """Depths and residuals of readings that the fit has not seen."""
    if header:
        files = halves(folder, files[0], header)
    depth, residual = [], []
    for k, file in enumerate(files):
        imported(folder, "seen", [f for f in files if f != file], keys)
        at, value, _ = fitted(folder, "seen")
        d, f, _, _ = imported(folder, "unseen", [file], keys, rows=60)
        inside = d <= at[-1]
        depth.append(d[inside]), residual.append(f[inside] - np.interp(d[inside], at, value))
    return np.concatenate(depth), np.concatenate(residual)


def draw(name, title, pattern, keys, header, units):
    files = sorted(glob.glob(os.path.join(DATA, pattern)))
    if not files:
        sys.exit(f"no recordings at {os.path.join(DATA, pattern)}")
    metre, length, newton, force = units
    with tempfile.TemporaryDirectory() as folder:
        d, f, error, noise = imported(folder, "all", files, keys)
        at, value, deviation = fitted(folder, "all")
        far, residual = held_out(folder, files, keys, header)
    figure, (left, right) = pyplot().subplots(1, 2, figsize=(9, 3.6))
    left.fill_between(at * metre, (value - 1.645 * deviation) * newton,
                      (value + 1.645 * deviation) * newton, color="0.8", label="90 % band")
    left.plot(at * metre, value * newton, color="black", linewidth=1, label="curve")
    left.errorbar(d * metre, f * newton, error * newton, fmt=".", markersize=4, linewidth=0.8,
                  label="measured rows")
    left.set_title(title, fontsize=9), left.legend(fontsize=8)
    right.axhspan(-1.645 * noise * newton, 1.645 * noise * newton, color="0.8",
                  label="noise of one reading, 90 %")
    right.plot(far * metre, residual * newton, ".", markersize=3,
               label="not seen by the fit, less the curve")
    right.legend(fontsize=8)
    for axes in (left, right):
        axes.set_xlabel(f"depth, {length}")
    left.set_ylabel(f"force, {force}"), right.set_ylabel(f"residual, {force}")
    save(figure, OUT, name)
    rms = float(np.sqrt(np.mean(residual ** 2)))
    print(f"{name}: held-out rms {rms * newton:.3g} {force} ({100 * rms / f.max():.2g} % of the "
          f"largest), noise of one reading {noise * newton:.3g} {force}")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    palpate, DATA, OUT = Program(sys.argv[1], accepts=(0,)), *sys.argv[2:]
    for recording in RECORDINGS:
        draw(*recording)
