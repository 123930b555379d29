"""Presses of a simulator of one's own as samples, fitted: own_simulator.py FOLDER.

Here the simulator is Hertz's formula for a ball on a half-space; put yours in its place.
"""
import os
import sys

import numpy as np

import palpate

YOUNG_PA, POISSON, RADIUS_M = 10e3, 0.45, 0.008


def simulate(depth_m):
    return 4 / 3 * YOUNG_PA / (1 - POISSON**2) * np.sqrt(RADIUS_M) * depth_m**1.5


depth_m = np.linspace(0.0005, 0.004, 8)
points = np.array([[x, y, 0.03] for x in (0.02, 0.06) for y in (0.02, 0.06)])
count, rows = len(points), len(points) * len(depth_m)
inward = np.array([0.0, 0.0, -1.0])
samples = {
    "points/position": points,
    "points/normal": np.tile(inward, (count, 1)),
    "rows/point": np.repeat(np.arange(count), len(depth_m)),
    "rows/experiment": np.repeat(np.arange(count), len(depth_m)),
    "rows/deflection": np.tile(depth_m, count)[:, None] * inward,
    "rows/force": np.tile(simulate(depth_m), count)[:, None] * inward,  # of the tool on the body
    "probe/shape": ["sphere"], "probe/radius": [RADIUS_M], "probe/friction": [0.3],
    "body/poisson": [POISSON],
}
curves = palpate.fit(samples, os.path.join(sys.argv[1], "curves.h5"), quiet=True)
for point, kinds in curves.items():
    fitted = np.interp(0.0033, kinds["normal"]["at_m"], kinds["normal"]["value_N"])
    print(f"{point}: {fitted:.4f} N at 3.3 mm, simulated {simulate(0.0033):.4f} N")
