"""Values of the bed of rings (B0) to (B3a) along paths over a flat, even body, by the return map with
absolute anchors: another language and another way than the engine's. Rewrites the files beside it:
x_m, y_m and depth_m of each row are read, the other columns computed.

    python3 make_rings.py [--plain]      --plain: limits without (B3a)
"""
import math
import pathlib
import sys

A, B, D, N, LAMBDA, MU_0, MU_1 = 12.0, 4500.0, 0.008, 8, 0.71, 0.285, 16.0
edge = [D * ((i + 1) / N) ** 1.5 for i in range(N)]
slope = [A + 2 * B * e for e in edge]
c = [slope[0]] + [b - a for a, b in zip(slope, slope[1:])]
threshold = [0.0] + [(a + b) / 2 for a, b in zip(edge, edge[1:])]


def row(x, y, depth, anchor, lost, is_plain):
    reach = [max(depth - t, 0.0) for t in threshold]
    normal = A * depth + B * depth * depth
    share = 1.0
    if depth > 0 and not is_plain:
        share = normal / sum(k * h for k, h in zip(c, reach))
    tx = ty = stored = 0.0
    for i in range(N):
        limit = share * (MU_0 + MU_1 * depth) * reach[i] / LAMBDA
        qx, qy = x - anchor[i][0], y - anchor[i][1]
        size = math.hypot(qx, qy)
        if size > limit:
            before = size * size
            qx, qy = qx * limit / size, qy * limit / size
            anchor[i] = (x - qx, y - qy)
            lost += 0.5 * LAMBDA * c[i] * (before - limit * limit)
        tx += LAMBDA * c[i] * qx
        ty += LAMBDA * c[i] * qy
        stored += 0.5 * LAMBDA * c[i] * (qx * qx + qy * qy)
    return [x, y, depth, tx, ty, max(normal, 0.0) if depth > 0 else 0.0, stored, lost], lost


for file in sorted(pathlib.Path(__file__).parent.glob("rings_*.csv")):
    lines = file.read_text().splitlines()
    out, anchor, lost = lines[:2], [(0.0, 0.0)] * N, 0.0
    for line in lines[2:]:
        x, y, depth = map(float, line.split(",")[:3])
        numbers, lost = row(x, y, depth, anchor, lost, "--plain" in sys.argv)
        out.append(",".join(f"{v:.15g}" for v in numbers))
    file.write_text("\n".join(out) + "\n")
