"""Motion of the surface around a contact against the force: is it C f with one symmetric C?

    python3 sway.py FIGURE.svg NAME=RUN/samples.h5 ...

Beside samples.h5 lie samples.surface.h5 and body.h5. For each row the ring of vertices between 3.5
and 5.5 contact radii of the point that face as it does has a nearest rigid motion (M33); w is its
translation at the contact point. Prints the share of w that C f and, beyond it, a cubic of the force
along the normal explain at each body (1 - rms of the rest / rms of w), by least squares over the
presses and drags of each point.
"""
import sys
from pathlib import Path

import h5py
import matplotlib.pyplot as plt
import numpy as np


def normals_of(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    area = np.cross(b - a, c - a)
    out = np.zeros_like(vertices)
    for k in range(3):
        np.add.at(out, triangles[:, k], -area)
    return out / np.linalg.norm(out, axis=1)[:, None]


def translation(place, vertices, moved):
    """Of the rigid motion nearest to `moved` at the vertices, at the place."""
    arm = vertices - place
    rows = np.zeros((len(arm), 3, 6))
    rows[:, :, :3] = np.eye(3)
    for k, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
        rows[:, j, 3 + k] = arm[:, i]
        rows[:, i, 3 + k] = -arm[:, j]
    return np.linalg.lstsq(rows.reshape(-1, 6), moved.reshape(-1), rcond=None)[0][:3]


def symmetric_rows(force):
    """Rows of C f over the six numbers of C."""
    x, y, z = force.T
    o = np.zeros_like(x)
    return np.stack([np.stack(r, -1) for r in ((x, o, o, y, z, o), (o, y, o, x, o, z),
                                               (o, o, z, o, x, y))], 1)


def motions_of(path):
    """(force, w, frame) of each point: rows x 3 along the normal and two tangents."""
    with h5py.File(path) as samples, h5py.File(path.with_suffix(".surface.h5")) as surface, \
            h5py.File(path.parent / "body.h5") as body:
        vertices, triangles = body["surface/vertices"][:], body["surface/triangles"][:]
        rows = {k: samples["rows/" + k][:] for k in ("point", "experiment", "step", "force",
                                                     "deflection", "status")}
        moved = {(p, e, s): d for p, e, s, d in zip(
            surface["rows/point"][:], surface["rows/experiment"][:], surface["rows/step"][:],
            surface["rows/displacement"][:])}
        places, inward = samples["points/position"][:], samples["points/normal"][:]
        radius = samples["probe/radius"][0]
    facing = normals_of(vertices, triangles)
    depth = max(d @ inward[p] for d, p in zip(rows["deflection"], rows["point"]))
    contact = np.sqrt(radius * depth)
    for p, (place, u) in enumerate(zip(places, inward)):
        away = np.linalg.norm(vertices - place, axis=1) / contact
        ring = (away > 3.5) & (away < 5.5) & (facing @ u > 0.3)
        mine = [i for i in np.flatnonzero((rows["point"] == p) & (rows["status"] == 0))
                if (p, rows["experiment"][i], rows["step"][i]) in moved]
        if ring.sum() < 12 or len(mine) < 6:
            continue
        t = np.cross(u, [1, 0, 0] if abs(u[0]) < 0.9 else [0, 1, 0])
        frame = np.stack([u, t / np.linalg.norm(t), np.cross(u, t / np.linalg.norm(t))])
        w = [translation(place, vertices[ring],
                         moved[p, rows["experiment"][i], rows["step"][i]].reshape(-1, 3)[ring])
             for i in mine]
        yield rows["force"][mine] @ frame.T, np.array(w) @ frame.T, depth


def explained(matrix, w):
    fit = matrix @ np.linalg.lstsq(matrix, w, rcond=None)[0]
    return fit, 1 - np.sqrt(((w - fit) ** 2).sum() / (w ** 2).sum())


def main():
    figure, bodies = sys.argv[1], [a.split("=", 1) for a in sys.argv[2:]]
    axes = plt.subplots(2, len(bodies), figsize=(4 * len(bodies), 7), squeeze=False)[1]
    print("body, points, largest w over the depth, share explained by C f, with a cubic of f_n too")
    for column, (name, path) in zip(axes.T, bodies):
        shares, size = [], []
        for force, w, depth in motions_of(Path(path)):
            linear = symmetric_rows(force).reshape(-1, 6)
            fit, share = explained(linear, w.reshape(-1))
            along = np.zeros((len(w), 3, 2))
            along[:, 0, 0], along[:, 0, 1] = force[:, 0] ** 2, force[:, 0] ** 3
            both = explained(np.hstack([linear, along.reshape(-1, 2)]), w.reshape(-1))[1]
            shares.append((share, both))
            size.append(np.linalg.norm(w, axis=1).max() / depth)
            order = np.argsort(force[:, 0])
            for ax, k in zip(column, (0, 1)):
                ax.plot(force[order, 0], 1e3 * w[order, k], "k.", ms=4)
                ax.plot(force[order, 0], 1e3 * fit.reshape(-1, 3)[order, k], "C1-", lw=0.8)
        column[0].set_title(name)
        column[0].set_ylabel("motion along the normal [mm]")
        column[1].set_ylabel("across [mm]")
        column[1].set_xlabel("force along the normal [N]")
        print(name, len(shares), *(f"{np.median(v):.3f}" for v in (size, *zip(*shares))), sep=", ")
    plt.tight_layout()
    plt.savefig(figure)


if __name__ == "__main__":
    main()
