"""A robot's scan of an asset, in two steps.

    python3 scan.py PATH.csv SCAN_PATH.csv       a raster about the middle of a path of `palpate new --path`
    python3 scan.py SCAN_PATH.csv FORCES.csv LOG.csv   with the forces on the tool that `palpate replay` answers
"""

import csv
import math
import pathlib
import sys

LINES, SPEED_M_S, STROKE_HZ, RATE_HZ = 24, 0.01, 2.0, 66


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def axes(places):
    """Unit vectors of the path's press and slide, and how far they go [m]."""
    pressed = next(p for p, q in zip(places[1:], places) if p == q != places[0])
    press = [p - s for p, s in zip(pressed, places[0])]
    depth_m = math.hypot(*press)
    down = [x / depth_m for x in press]
    away = [[x - p for x, p in zip(place, pressed)] for place in places]
    asides = [[x - dot(d, down) * n for x, n in zip(d, down)] for d in away]
    along = max(asides, key=lambda d: math.hypot(*d))
    length_m = math.hypot(*along)
    return down, depth_m, [x / length_m for x in along], length_m


def raster(places):
    """Times and places: lines to and fro while the tool goes in and out of the body."""
    down, depth_m, along, length_m = axes(places)
    aside = [down[k - 2] * along[k - 1] - down[k - 1] * along[k - 2] for k in range(3)]
    line_s = length_m / SPEED_M_S
    for i in range(int(LINES * line_s * RATE_HZ)):
        time_s = i / RATE_HZ
        line, share = divmod(time_s / line_s, 1)
        u = (share if line % 2 == 0 else 1 - share) - 0.5
        v = (line + share) / LINES - 0.5
        w = depth_m * (0.8 - 0.2 * math.cos(2 * math.pi * STROKE_HZ * time_s))
        step = [length_m * (u * a + v * b) + w * n for a, b, n in zip(along, aside, down)]
        yield time_s, *(s + d for s, d in zip(places[0], step))


def rows(name, *columns):
    with open(name) as file:
        return [[float(row[c]) for c in columns] for row in csv.DictReader(file)]


place, force = ("x_m", "y_m", "z_m"), ("fx_N", "fy_N", "fz_N")
output = pathlib.Path(sys.argv[-1])
output.parent.mkdir(exist_ok=True)
if len(sys.argv) == 3:
    header, table = ("t_s", *place), raster(rows(sys.argv[1], *place))
else:
    header = ("t_s", *place, *force)
    table = map(list.__add__, rows(sys.argv[1], "t_s", *place), rows(sys.argv[2], *force))
output.write_text("\n".join(",".join(map(str, row)) for row in [header, *table]) + "\n")
