#!/usr/bin/env python3
"""The modulus that `calibrate` finds where `import` had to find the contact.

    python3 tools/workshop/docs/measured/calibrated_presses.py PALPATE FOLDER [SEEDS]

simulates presses of a ball (8 mm, 4 mm deep, three points) on blocks of 8.3 kPa, 30 and 15 mm high
on a rigid ground, and writes them into FOLDER as recordings: 2 to 3 mm of free travel that nobody is
told, 2 mm/s, 100 readings a second, noise white or as 1/f. `import` finds the contacts, or is told
them, and `calibrate` starts from 20 kPa. "As exact" is with the deviations of the contacts set to
0 in samples.h5. Prints a table: mean modulus, its scatter over SEEDS (5), the mean half width of
the 95 % interval, and in how many seeds the interval holds the truth. Needs python3-numpy and
python3-h5py.
"""
import json
import os
import sys

import h5py
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import Program

YOUNG_PA, RADIUS_M, DEPTH_M, SPEED_M_S, INTERVAL_S = 8300, 8e-3, 4e-3, 2e-3, 0.01
POINTS = ((40, 40), (32, 40), (40, 32))  # mm
CELLS = 8

SCENE = """[body]
surface = "block.off"
length_unit = "mm"
mesh_size = "20 mm"
fixed = [ {{ below = {{ axis = "z", at = "1 mm" }} }} ]
[material]
young = "{young} Pa"
poisson = 0.45
[probe]
radius = "8 mm"
friction = 0.3
[experiments]
test_points = 4
region = {{ box = [["20 mm", "20 mm", "{below} mm"], ["60 mm", "60 mm", "{above} mm"]] }}
depth = "4 mm"
press_steps = 16
drag_depths = ["3 mm"]
drag_distance = "5 mm"
drag_directions = 0
"""


def block_off(height_mm):
    """A block of 80 x 80 mm with a grid on every side; the repair welds the borders."""
    vertices, faces = [], []
    sides = (lambda s, t: (s, t, 1), lambda s, t: (t, s, 0), lambda s, t: (s, 0, t),
             lambda s, t: (t, 1, s), lambda s, t: (0, t, s), lambda s, t: (1, s, t))
    for side in sides:
        first = len(vertices)
        for j in range(CELLS + 1):
            for i in range(CELLS + 1):
                x, y, z = side(i / CELLS, j / CELLS)
                vertices.append(f"{80 * x} {80 * y} {height_mm * z}")
        for j in range(CELLS):
            for i in range(CELLS):
                a = first + j * (CELLS + 1) + i
                b, c, d = a + 1, a + CELLS + 2, a + CELLS + 1
                faces += [f"3 {a} {b} {c}", f"3 {a} {c} {d}"]
    return "\n".join(["OFF", f"{len(vertices)} {len(faces)} 0", *vertices, *faces, ""])


def path(name):
    return os.path.join(FOLDER, name)


def write(name, text):
    with open(path(name), "w", encoding="utf-8") as out:
        out.write(text)


def simulated(height_mm):
    """Of each point the force over depth, as a function."""
    write("block.off", block_off(height_mm))
    for name, young in (("truth.toml", YOUNG_PA), ("guess.toml", 20000)):
        write(name, SCENE.format(young=young, below=height_mm - 1, above=height_mm + 1))
    write("points.csv", "x_m,y_m,z_m\n" +
          "".join(f"{x / 1e3},{y / 1e3},{height_mm / 1e3}\n" for x, y in POINTS))
    palpate("simulate", path("truth.toml"), "--points", path("points.csv"), "-o", path("truth.h5"))
    out = []
    with h5py.File(path("truth.h5")) as file:
        point, depth, force = (np.array(file["rows"][name])
                               for name in ("point", "deflection", "force"))
        for p in range(len(POINTS)):
            of = point == p
            d, f = -depth[of][:, 2], -force[of][:, 2]
            order = np.argsort(d)
            # The force over that of a Hertz contact is smooth over the depth.
            shape = np.polynomial.Polynomial.fit(d[order], f[order] / d[order] ** 1.5, 4)
            out.append(lambda x, shape=shape: shape(np.maximum(x, 1e-6)) *
                       np.maximum(x, 0) ** 1.5)
    return out


def noise_of(kind, share, rows, rng):
    if kind == "white":
        return share * rng.normal(size=rows)
    spectrum = np.fft.rfft(rng.normal(size=rows))
    spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))
    spectrum[0] = 0
    slow = np.fft.irfft(spectrum, rows)
    return share * slow / slow.std()


def record(presses, height_mm, kind, share, rng, told):
    """A manifest of one recording at each point."""
    text = ('[defaults]\nforce_on = "body"\nnormal = [0, 0, -1]\n'
            'columns = { time = "t_s", depth = "d_mm", force = "F_N" }\n'
            'probe = { shape = "sphere", radius = "8 mm" }\n')
    for p, press in enumerate(presses):
        free_m = rng.uniform(2e-3, 3e-3)
        travel_m = np.arange(0, free_m + DEPTH_M, SPEED_M_S * INTERVAL_S)
        force_N = press(travel_m - free_m)
        force_N = force_N + noise_of(kind, share * force_N.max(), len(travel_m), rng)
        write(f"press_{p}.csv", "t_s,d_mm,F_N\n" + "".join(
            f"{INTERVAL_S * i:.2f},{1e3 * d:.6f},{f:.8f}\n"
            for i, (d, f) in enumerate(zip(travel_m, force_N))))
        text += (f'[[recording]]\nfile = "press_{p}.csv"\npoint = "p{p}"\n'
                 f'position = ["{POINTS[p][0]} mm", "{POINTS[p][1]} mm", "{height_mm} mm"]\n' +
                 (f'contact = "{1e3 * free_m} mm"\n' if told else ""))
    write("manifest.toml", text)


def modulus():
    found = json.loads(palpate("calibrate", path("guess.toml"), "--samples", path("s.h5"), "-o",
                               path("found.toml"), "--json"))["parameters"][0]
    return found["value"], found["low"], found["high"]


def main():
    print("| height | noise | presses | contact | modulus, kPa | scatter | interval, ± | holds 8.3 "
          "kPa |\n|---|---|---|---|---|---|---|---|")
    for height_mm in (30, 15):
        presses = simulated(height_mm)
        for kind, share in (("white", 0.01), ("white", 0.03), ("1/f", 0.03)):
            for count in (1, 3):
                found = {"told": [], "found": [], "found, as exact": []}
                for seed in range(1, SEEDS + 1):
                    for contact in ("told", "found"):
                        rng = np.random.default_rng((seed, count))
                        record(presses[:count], height_mm, kind, share, rng, contact == "told")
                        palpate("import", path("manifest.toml"), "-o", path("s.h5"), "--force")
                        found[contact].append(modulus())
                    with h5py.File(path("s.h5"), "r+") as file:
                        file["recordings/contact_deviation"][...] = 0
                    found["found, as exact"].append(modulus())
                for contact, rows in found.items():
                    value, low, high = np.array(rows).T
                    held = np.sum((low <= YOUNG_PA) & (YOUNG_PA <= high))
                    print(f"| {height_mm} mm | {kind}, {100 * share:.0f} % | {count} | {contact} | "
                          f"{value.mean() / 1e3:.2f} | {value.std() / 1e3:.2f} | "
                          f"{(high - low).mean() / 2e3:.2f} | {held} of {SEEDS} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    palpate, FOLDER = Program(os.path.abspath(sys.argv[1])), os.path.abspath(sys.argv[2])
    SEEDS = int(sys.argv[3]) if len(sys.argv) == 4 else 5
    os.makedirs(FOLDER, exist_ok=True)
    main()
