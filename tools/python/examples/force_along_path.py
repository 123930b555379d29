"""The force on a tip along a path of one's own: force_along_path.py ASSET.palp [PICTURE.png]."""
import sys

import numpy as np

import palpate

with palpate.open(sys.argv[1]) as asset:
    (low, high), rate_hz = asset.box_m, 1000
    # From above the middle down to a third of the body, to the side, and up again.
    middle, down, aside = (low + high) / 2, np.array([0, 0, low[2] - high[2]]), np.array([high[0] - low[0], 0, 0])
    corners = np.cumsum([[*middle[:2], high[2] + 0.005], down / 3, aside / 5, -down / 3], axis=0)
    steps = [max(2, int(np.ceil(length / 2e-5))) for length in np.linalg.norm(np.diff(corners, axis=0), axis=1)]
    path_m = np.vstack([np.linspace(a, b, n) for a, b, n in zip(corners, corners[1:], steps)])
    ticks = asset.contact().tick(path_m)
    touching = ticks["state"] != palpate.AIR
    print(f"{len(ticks)} ticks, {touching.sum()} in contact, {(ticks['state'] == palpate.SLIP).sum()} slipping")
    print(f"greatest force {np.linalg.norm(ticks['force_on_tool_N'], axis=1).max():.3f} N, "
          f"slips cost {1e3 * ticks['dissipated_J'][-1]:.3f} mJ")
    if len(sys.argv) > 2:
        palpate.plot_path(asset, path_m, dt_s=1 / rate_hz).figure.savefig(sys.argv[2], dpi=100)
