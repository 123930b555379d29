#!/usr/bin/env python3
"""Curves from presses of a robot: encoders jitter, the tool leans, the sensor's frame turns.

    python3 tools/workshop/docs/measured/robot_presses.py PALPATE FOLDER [SEEDS]

writes presses of a ball with a Hertz contact (four points, 3 mm deep, 1 mm/s, 100 readings a
second, white noise of 5 mN, a frame of the sensor that turns from 1 to 3 degrees) and their
manifest into FOLDER, imports and fits them, and prints how far the curves are from the truth: the
force over it at the full depth, and the rms of the difference over the largest force. Jitter is
sideways to the normal; "on all axes" is along it too. Leans are of the tool's way, whose force
stays along the normal. Seeds are 1 to SEEDS (3).
"""
import math
import os
import random
import statistics
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import Program, normal_curves

RADIUS_M, DEPTH_M, FREE_M, SPEED_M_S, INTERVAL_S, NOISE_N = 5e-3, 3e-3, 1e-3, 1e-3, 0.01, 5e-3
YOUNG_PA = (6000, 8000, 10000, 14000)


def hertz_N(depth_m, young_Pa):
    return 16 / 9 * young_Pa * math.sqrt(RADIUS_M) * max(0.0, depth_m) ** 1.5


def write_press(path, place_m, young_Pa, jitter_m, lean_deg, on_all_axes, rng):
    way = FREE_M + DEPTH_M
    rows = int(2 * way / SPEED_M_S / INTERVAL_S) + 1
    lean, turn = math.tan(math.radians(lean_deg)), rng.uniform(0, 2 * math.pi)
    with open(path, "w", encoding="utf-8") as out:
        out.write("t_s,x_mm,y_mm,z_mm,fx_N,fy_N,fz_N\n")
        for i in range(rows):
            depth_m = way - abs(way - SPEED_M_S * INTERVAL_S * i) - FREE_M
            aside_m = lean * max(0.0, depth_m)
            noise_m = [rng.gauss(0, jitter_m) for _ in range(3)]
            if not on_all_axes:
                noise_m[2] = 0.0
            at_m = (place_m[0] + aside_m * math.cos(turn) + noise_m[0],
                    place_m[1] + aside_m * math.sin(turn) + noise_m[1],
                    place_m[2] - depth_m + noise_m[2])
            push_N = hertz_N(depth_m, young_Pa)
            frame = math.radians(1 + 2 * i / (rows - 1))
            force_N = (push_N * math.sin(frame), 0.0, -push_N * math.cos(frame))
            numbers = [1e3 * x for x in at_m] + [f + rng.gauss(0, NOISE_N) for f in force_N]
            out.write(f"{i * INTERVAL_S:.3f}," + ",".join(f"{x:.7f}" for x in numbers) + "\n")


def curves_off(jitter_m, lean_deg, on_all_axes, seed):
    """Of each point that is not refused the force over the truth at full depth, and the rms over
    the largest force."""
    rng = random.Random(f"{seed} {jitter_m} {lean_deg} {on_all_axes}")
    manifest, samples, curves, table = (
        os.path.join(FOLDER, name)
        for name in ("manifest.toml", "samples.h5", "curves.h5", "curves.csv"))
    with open(manifest, "w", encoding="utf-8") as out:
        out.write('[defaults]\nnormal = [0, 0, -1]\nforce_on = "body"\ncolumns = { time = "t_s", '
                  'position = ["x_mm", "y_mm", "z_mm"], force = ["fx_N", "fy_N", "fz_N"] }\n'
                  'units = { time = "s", position = "mm", force = "N" }\n'
                  f'probe = {{ shape = "sphere", radius = "{RADIUS_M} m" }}\n')
        for p, young_Pa in enumerate(YOUNG_PA):
            place_m = (0.02 * p, 0.0, 0.0)
            write_press(os.path.join(FOLDER, f"press_{p}.csv"), place_m, young_Pa, jitter_m,
                        lean_deg, on_all_axes, rng)
            out.write(f'[[recording]]\nfile = "press_{p}.csv"\npoint = "p{p}"\n'
                      f'position = [{1e3 * place_m[0]}, 0, 0]\n')
    imported = palpate.tried("import", manifest, "-o", samples, "--force")
    if imported.returncode not in (0, 3):
        if "could be imported" not in imported.stderr:
            sys.exit(f"palpate import: {imported.stderr}")
        return []
    palpate("fit", samples, "-o", curves)
    palpate("tabulate", "--steps", "100", curves, "-o", table)
    rows = normal_curves(table)
    out = []
    for p, young_Pa in enumerate(YOUNG_PA):
        of_point = [(float(r["at_m"]), float(r["value_N"])) for r in rows if r["name"] == f"p{p}"]
        if not of_point:
            continue
        of_point = [(at, value) for at, value in of_point if at <= DEPTH_M]
        largest_N = hertz_N(DEPTH_M, young_Pa)
        at, value = of_point[-1]
        rms_N = math.sqrt(statistics.fmean((v - hertz_N(x, young_Pa)) ** 2 for x, v in of_point))
        out.append((value / hertz_N(at, young_Pa), rms_N / largest_N))
    return out


def main():
    print("| jitter | lean | force over the truth at full depth, median (worst) | rms off, median |"
          " worst |\n|---|---|---|---|---|")
    for on_all_axes in (False, True):
        for lean_deg in (0, 2, 5, 10):
            for jitter_m in (0, 1e-7, 1e-5, 1e-4, 3e-4):
                if on_all_axes and (lean_deg > 0 or jitter_m < 1e-5):
                    continue
                off = [one for seed in range(1, SEEDS + 1)
                       for one in curves_off(jitter_m, lean_deg, on_all_axes, seed)]
                name = f"{1e3 * jitter_m:g} mm{' on all axes' if on_all_axes else ''} | {lean_deg}°"
                if not off:
                    print(f"| {name} | all are refused | | |", flush=True)
                    continue
                ratios, rms = [o[0] for o in off], [o[1] for o in off]
                worst = max(ratios, key=lambda r: abs(r - 1))
                print(f"| {name} | {statistics.median(ratios):.3f} ({worst:.3f}) | "
                      f"{100 * statistics.median(rms):.2g} % | {100 * max(rms):.2g} % |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    palpate, FOLDER = Program(sys.argv[1]), sys.argv[2]
    SEEDS = int(sys.argv[3]) if len(sys.argv) == 4 else 3
    os.makedirs(FOLDER, exist_ok=True)
    main()
