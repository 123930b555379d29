"""The path of two tools that walk_bits printed, from Python and from `palpate replay`: one_path.py COUPLED.palp
TWO.csv [PROGRAM]. Ends with status 0 where force and torque of every row have the bits of C."""
import csv
import os
import subprocess
import sys
import tempfile

import numpy as np

import palpate

FELT = ["fx_N", "fy_N", "fz_N", "tx_Nm", "ty_Nm", "tz_Nm"]
SCENE = """[body]
surface = "body.off"
length_unit = "mm"
[material]
young = "10 kPa"
[probe]
radius = "{mm} mm"
{tool}"""
TOOL = """[tool]
shape = "capsule"
radius = "{mm} mm"
length = "{length} mm"
balls = [["-{mm} mm", 0, 0], [0, 0, 0], ["{mm} mm", 0, 0]]
"""


def columns(path, names):
    """(tools, ticks, names)"""
    with open(path, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    table = np.array([[float(row[name]) for name in names] for row in rows])
    return table.reshape(-1, 2, len(names)).transpose(1, 0, 2)


def different(felt, wanted):
    return np.count_nonzero((np.ascontiguousarray(felt).view(np.uint64)
                             != np.ascontiguousarray(wanted).view(np.uint64)).any(axis=-1))


def from_python(asset, two):
    radius = asset.probe_radius_m
    tools = [asset.contact(radius, [0, 0, radius]), asset.contact(radius, [[i * radius, 0, 0] for i in (-1, 0, 1)])]
    ticks = palpate.tick_together(tools, columns(two, ["x_m", "y_m", "z_m"]),
                                  orientation=columns(two, ["qw", "qx", "qy", "qz"]))
    both = np.count_nonzero((ticks["touching"][0] > 0) & (ticks["touching"][1] > 1))
    assert both > 100, f"both tools touch in {both} ticks"
    return np.concatenate([ticks["force_on_tool_N"], ticks["torque_on_tool_Nm"]], axis=-1)


def from_replay(asset, path, two, program):
    mm = f"{1e3 * asset.probe_radius_m:g}"
    with tempfile.TemporaryDirectory() as folder:
        scenes = []
        for name, tool in (("ball", ""), ("capsule", TOOL.format(mm=mm, length=f"{4e3 * asset.probe_radius_m:g}"))):
            scenes.append(os.path.join(folder, name + ".toml"))
            with open(scenes[-1], "w", encoding="utf-8") as file:
                file.write(SCENE.format(mm=mm, tool=tool))
        forces = os.path.join(folder, "forces.csv")
        subprocess.run([program, "replay", path, two, "-o", forces, "--tool", ",".join(scenes), "--quiet"], check=True)
        return columns(forces, FELT)


def main():
    path, two = sys.argv[1:3]
    wanted, failed = columns(two, FELT), 0
    with palpate.open(path) as asset:
        felt = {"Python": from_python(asset, two)}
        if len(sys.argv) > 3:
            felt["replay"] = from_replay(asset, path, two, sys.argv[3])
    for name, each in felt.items():
        count = different(each, wanted)
        failed += count
        print(f"{name}: {wanted.shape[1]} ticks of two tools, {count} rows differ from C")
    sys.exit(1 if failed else 0)


main()
