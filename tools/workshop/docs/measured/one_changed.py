#!/usr/bin/env python3
"""One recording of a batch changed: import and warm fit against both from nothing.

python3 tools/workshop/docs/measured/one_changed.py PALPATE FOLDER [RECORDINGS [ROWS [told|untold]]]
writes synthetic presses of a sphere (a Hertz contact, noise 2 mN) and their manifest into FOLDER
and prints CPU and wall seconds, and whether both ways end in the same bytes.
"""
import math
import os
import random
import resource
import subprocess
import sys
import time


def press(path, number, rows, factor, rng):
    stiffness = factor * (4000 + 3000 * math.sin(0.1 * (number % 100)) + 200 * rng.random())
    contact_mm = 0.5 + 0.1 * rng.random()
    with open(path, "w") as out:
        out.write("t [s],depth [mm],force [N]\n")
        for i in range(rows):
            travel_mm = -1 + 6 * i / (rows - 1)
            depth_m = max(0.0, travel_mm - contact_mm) * 1e-3
            force = 16 / 9 * stiffness * math.sqrt(5e-3) * depth_m**1.5 + rng.gauss(0, 0.002)
            out.write(f"{0.01 * i:.4f},{travel_mm + 2:.5f},{force:.6f}\n")


def run(*line):
    before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.time()
    subprocess.run(line, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return cpu, time.time() - begin


def main(palpate, folder, recordings=10000, rows=240, tip="told"):
    rng, recordings, rows = random.Random(1), int(recordings), int(rows)
    os.makedirs(f"{folder}/r", exist_ok=True)
    for old in os.listdir(folder):
        if old.endswith(".h5") or ".import." in old:
            os.remove(f"{folder}/{old}")
    with open(f"{folder}/manifest.toml", "w") as out:
        out.write('[defaults]\ncolumns = { time = "t", depth = "depth", force = "force" }\n'
                  'force_on = "body"\nunits = { position = "mm" }\n')
        if tip == "told":
            out.write('probe = { shape = "sphere", radius = "5 mm" }\n')
        for k in range(recordings):
            press(f"{folder}/r/{k:05}.csv", k, rows, 1, rng)
            out.write(f'[[recording]]\nfile = "r/{k:05}.csv"\npoint = "p{k:05}"\n'
                      f"position = [{2 * (k % 100)}, {2 * (k // 100)}, 0]\nnormal = [0, 0, -1]\n")
    at = lambda name: f"{folder}/{name}"
    steps = {"import": run(palpate, "import", at("manifest.toml"), "-o", at("samples.h5")),
             "fit": run(palpate, "fit", at("samples.h5"), "-o", at("curves.h5"))}
    changed = recordings // 2
    press(f"{folder}/r/{changed:05}.csv", changed, rows, 1.1, rng)
    steps["import, one changed"] = run(palpate, "import", at("manifest.toml"), "-o",
                                       at("samples.h5"))
    steps["fit, warm"] = run(palpate, "fit", at("samples.h5"), "-o", at("warm.h5"),
                             "--warm-start", at("curves.h5"))
    for name, (cpu, wall) in steps.items():
        print(f"{name:20} {cpu:8.2f} s CPU {wall:8.2f} s wall")
    s = list(steps.values())
    print("whole over changed: CPU %.1f, wall %.1f" % tuple(
        (s[0][k] + s[1][k]) / (s[2][k] + s[3][k]) for k in (0, 1)))
    run(palpate, "fit", at("samples.h5"), "-o", at("whole.h5"))
    same = open(at("warm.h5"), "rb").read() == open(at("whole.h5"), "rb").read()
    print("curves of the warm fit are", "those of a whole fit, every byte" if same else "others")


if __name__ == "__main__":
    main(*sys.argv[1:])
