"""The force on a tip along a path of one's own: force_along_path.py ASSET.palp [FOLDER].

FOLDER gets the path, its forces as `palpate replay` writes them, and their picture."""
import pathlib
import sys

import numpy as np

import palpate

RATE_HZ, SPEED_M_S = 1000, 0.02


def through(*corners):
    """Rows a tick apart on the straight ways between the corners."""
    ways = [np.linspace(a, b, max(2, int(np.ceil(np.linalg.norm(b - a) * RATE_HZ / SPEED_M_S))))
            for a, b in zip(corners, corners[1:])]
    return np.vstack(ways)


with palpate.open(sys.argv[1]) as asset:
    low, high = asset.box_m
    above, below = np.array([*(low + high)[:2] / 2, high[2] + 0.002]), np.array([*(low + high)[:2] / 2, low[2]])
    search = through(above, below)
    touched = np.argmax(asset.contact().tick(search)["state"] != palpate.AIR)
    deep = search[touched] - [0, 0, 0.8 * asset.range_m]
    path_m = through(above, deep, deep + [2 * asset.range_m, 0, 0], above + [2 * asset.range_m, 0, 0])

    ticks = asset.contact().tick(path_m)
    print(f"{len(ticks)} ticks, {np.count_nonzero(ticks['state'])} in contact, "
          f"{np.count_nonzero(ticks['state'] == palpate.SLIP)} slipping")
    print(f"greatest force {np.linalg.norm(ticks['force_on_tool_N'], axis=1).max():.3f} N, "
          f"slips cost {1e3 * ticks['dissipated_J'][-1]:.3f} mJ")
    if len(sys.argv) > 2:
        folder = pathlib.Path(sys.argv[2])
        np.savetxt(folder / "path.csv", np.column_stack([np.arange(len(path_m)) / RATE_HZ, path_m]), delimiter=",",
                   header="t_s,x_m,y_m,z_m", comments="")
        palpate.command("replay", sys.argv[1], folder / "path.csv", output=folder / "forces.csv", quiet=True)
        palpate.plot_path(folder / "forces.csv").figure.savefig(folder / "path.png", dpi=100)
