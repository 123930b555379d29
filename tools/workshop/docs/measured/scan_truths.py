"""Scans of known bodies (docs/measured-data.md): assets, replayed along scans of their window.

    python3 tools/workshop/docs/measured/scan_truths.py PALPATE OUT ASSET.palp...

A raster and a spiral with a sine of 2 Hz in depth, and a free hand that lifts off, two minutes each
of 66 rows/s. To the forces come noise of 0.2 % of the largest (a robot's has 0.1 to 0.5), and of
that a bias (5, -3, 8 %), a drift (4, 0, -6 % in a minute), a delay of 7 ms and a frame turned by (0.06,
-0.04, 0.05) rad. Prints of each scan, in %, median and p95: the force of passes held out; stiffness
and friction of asset and truth at 40 places (from 0.55 to 0.65 of the scan's depth, and from two
slides against each other); in mm the height there; in ms, degrees, and % in a minute the errors of
delay, turn and drift. With --presses instead: a raster to 0.54 of that depth alone, and beside eight
presses to all of it, with a bias of their own; of each p95 of the force of passes held
out, and of eight presses elsewhere, and stiffness at 0.35 and 0.8 of the depth. With --mesh: the
raster turned by 20 degrees and moved by 30 mm, alone, and with the mesh (body.h5 beside the asset) and
three landmarks that are 3 mm off; of each the force held out, and stiffness and friction; of the
registration the error of its turn, of the place of the window's middle, and what it leaves (rms).
With --balls: the free hand with balls of 0.7 and 1.5 times the radius of the asset's own.
"""

import csv
import json
import pathlib
import re
import subprocess
import sys

import h5py
import numpy as np

DEFAULTS = """[defaults]
force_on = "tool"
columns = { time = "t_s", position = ["x_m", "y_m", "z_m"], force = ["fx_N", "fy_N", "fz_N"] }
units = { time = "s", position = "m", force = "N" }
"""
SCAN = '[[recording]]\nfile = "scan.csv"\nkind = "scan"\n'
PRESSES = '[[recording]]\nfile = "{}_*.csv"\n'
RATE_HZ, SECONDS, DELAY_S, NOISE = 66, 120, 7e-3, 2e-3
BIAS, DRIFT, TURN = (0.05, -0.03, 0.08), (0.04, 0, -0.06), (0.06, -0.04, 0.05)


def table(path, *columns):
    with open(path, newline="") as f:
        return np.array([[float(r[c]) for c in columns] for r in csv.DictReader(f)])


def save(path, header, *columns):
    np.savetxt(path, np.column_stack(columns), "%.9g", ",", header=header, comments="")


class Body:
    """An asset, and coordinates of its window [m]: along, aside, into it."""

    tool = ()  # of replay: the tip

    def __init__(self, palpate, asset, folder):
        self.palpate, self.asset, self.folder = palpate, asset, folder

    def find_window(self):
        path = self.folder / "window.csv"
        path.unlink(missing_ok=True)
        command = [self.palpate, "new", self.asset, "--path", "-o", path]
        subprocess.run(command, check=True, capture_output=True)
        place = table(path, "x_m", "y_m", "z_m")
        pressed = place[np.flatnonzero((np.diff(place, axis=0) == 0).all(1))[0]]
        into = pressed - place[0]
        into /= np.linalg.norm(into)
        beside = place - place[0] - np.outer((place - place[0]) @ into, into)
        self.reach_m = 0.8 * np.linalg.norm(beside, axis=1).max()
        along = beside[np.linalg.norm(beside, axis=1).argmax()]
        along /= np.linalg.norm(along)
        self.axes, self.origin = np.array([along, np.cross(into, along), into]), place[0]
        self.depth_m = (pressed - self.origin) @ into - self.touch(np.zeros((1, 2)))[0]
        self.grid = np.linspace(-1.3 * self.reach_m, 1.3 * self.reach_m, 41)
        at = np.array([(a, b) for a in self.grid for b in self.grid])
        self.height = self.touch(at).reshape(41, 41)

    def replay(self, t, at):
        """Force on the tool of every row, and contact."""
        path, forces = self.folder / "path.csv", self.folder / "forces.csv"
        save(path, "t_s,x_m,y_m,z_m", t, self.origin + at @ self.axes)
        # Its status is 3 where a jump from one press to the next ends a contact.
        command = [self.palpate, "replay", self.asset, path, "-o", forces, *self.tool]
        subprocess.run(command, check=False, capture_output=True)
        out = table(forces, "fx_N", "fy_N", "fz_N", "contact", "depth_m")
        return out[:, :3] @ self.axes.T, out[:, 3:]

    def touch(self, at):
        """Third coordinate of the surface at others."""
        down = np.arange(-0.03, 0.03, 2e-4)
        line = np.repeat(at, len(down), axis=0)
        depth = np.tile(down, len(at))
        _, contact = self.replay(1e-3 * np.arange(len(depth)), np.column_stack([line, depth]))
        of = contact.reshape(len(at), -1, 2)
        first = of[:, :, 0].argmax(1)
        return np.where(of[:, :, 0].any(1), down[first] - of[np.arange(len(at)), first, 1], np.nan)

    def surface(self, a, b):
        cell = self.grid[1] - self.grid[0]
        i, j = (np.clip((x - self.grid[0]) / cell, 0, 39.999) for x in (a, b))
        s, t, i, j = i % 1, j % 1, i.astype(int), j.astype(int)
        line = lambda k: (1 - t) * self.height[k, j] + t * self.height[k, j + 1]
        return (1 - s) * line(i) + s * line(i + 1)

    def scan(self, kind, t, waves, share_of_depth=1):
        """Places at times t [s]: the tool comes down in the first half second."""
        share, reach = np.clip(t / SECONDS, 0, 1), self.reach_m
        depth = self.depth_m * (0.5 - 0.4 * np.cos(4 * np.pi * t))
        if kind == "raster":
            line = 30 * share
            a, b = reach * (2 * abs((line + 1) % 2 - 1) - 1), 0.8 * reach * (2 * line / 30 - 1)
        elif kind == "spiral":
            angle = 30 * np.pi * np.sqrt(share)
            a, b = reach * angle / (30 * np.pi) * np.array([np.cos(angle), np.sin(angle)])
        else:
            sum_of = lambda wave: sum(w * np.sin(2 * np.pi * f * t + p) for f, w, p in wave)
            sines = [sum_of(wave) / sum(w for _, w, _ in wave) for wave in waves]
            a, b = reach * sines[0], 0.8 * reach * sines[1]
            depth = self.depth_m * (0.4 + 0.6 * sines[2])
        depth *= share_of_depth
        depth -= 1.3 * self.depth_m * np.clip(1 - 2 * t, 0, 1)
        return np.column_stack([a, b, self.surface(a, b) + depth])

    def pressed(self, places, directions, level=0.6):
        """Force about a level of the depth, and friction there, by slides fore and back."""
        s, at = np.arange(0, 3, 0.005), []
        for place, direction in zip(places, directions):
            for turn in (0, 1, -1):
                side = 0.25 * self.reach_m * turn * np.clip(s - 2, -1, 0)[:, None] * direction
                levels = [level] * 3 if turn else [level - 0.05, level + 0.05, level + 0.05]
                down = np.interp(s, [0, 1, 1.1, 2], [-1, *levels])
                a, b = (place + side).T
                at.append(np.column_stack([a, b, self.known(a, b) + self.depth_m * down]))
                at.append(np.column_stack([a[-1:], b[-1:], self.known(a[-1:], b[-1:]) - 0.01]))
        at = np.vstack(at)
        force, _ = self.replay(5e-3 * np.arange(len(at)), at)
        of = force.reshape(len(places), 3, len(s) + 1, 3)
        softer, stiffer, fore, back = of[:, 0, 200], of[:, 0, 220], of[:, 1, -2], of[:, 2, -2]
        size = lambda f: np.linalg.norm(f, axis=1)
        return size(stiffer) - size(softer), size(fore - back) / size(fore + back)


def rotation(turn):
    angle = np.linalg.norm(turn)
    x, y, z = np.asarray(turn) / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def record(body, path, t, place, random, largest=None, bias=BIAS, drift=DRIFT):
    """Writes what the rig records at times t of a tool at place(t), and returns the largest force."""
    fine = 15
    ticks = t[0] + np.arange(fine * len(t)) / (fine * RATE_HZ)
    force = body.replay(ticks, place(ticks - DELAY_S))[0][::fine] @ body.axes
    largest = largest or np.linalg.norm(force, axis=1).max()
    force = force @ rotation(TURN).T - largest * (np.array(bias) + t[:, None] / 60 * drift)
    force += random.normal(0, NOISE * largest, force.shape)
    at = body.origin + place(t) @ body.axes
    save(path, "t_s,x_m,y_m,z_m,fx_N,fy_N,fz_N", t, at, force)
    return largest


def measured(body, kind, folder, share=1):
    """Writes the scan of a body, to a share of its depth, and returns its largest force."""
    random = np.random.default_rng(5)
    waves = [
        [(f, 1 + random.random(), 6 * random.random()) for f in of]
        for of in ((0.31, 0.43, 0.57), (0.27, 0.39, 0.61), (0.8, 1.3, 1.9))
    ]
    t = np.arange(SECONDS * RATE_HZ) / RATE_HZ
    (folder / "manifest.toml").write_text(DEFAULTS + SCAN)
    place = lambda at: body.scan(kind, at, waves, share)
    return record(body, folder / "scan.csv", t, place, random)


def press(body, folder, name, largest, seed):
    """Writes eight presses to all of the depth, each in and out in 3 s from 3 mm above."""
    random = np.random.default_rng(seed)
    t = np.arange(3 * RATE_HZ) / RATE_HZ
    for k in range(8):
        away, angle = 0.7 * body.reach_m * np.sqrt(random.random()), 6.3 * random.random()
        at = away * np.array([[np.cos(angle), np.sin(angle)]])
        level = body.surface(*at.T)[0]

        def place(s):
            share = np.clip(1.5 - abs(s - 1.5), 0, 1)
            down = (body.depth_m + 3e-3) * share - 3e-3
            return np.column_stack([np.repeat(at, len(s), axis=0), level + down])

        bias = 0.05 * random.normal(size=3)
        record(body, folder / f"{name}_{k + 1}.csv", t, place, random, largest, bias, (0, 0, 0))


def found_body(truth, folder):
    found = Body(truth.palpate, folder / "run/asset.palp", folder)
    found.axes, found.origin = truth.axes, truth.origin
    found.depth_m, found.reach_m = truth.depth_m, truth.reach_m
    truth.known = found.known = truth.surface
    random = np.random.default_rng(6)
    angle = random.uniform(0, 2 * np.pi, (2, 40))
    away = 0.6 * truth.reach_m * np.sqrt(random.random(40))
    place = away[:, None] * np.column_stack([np.cos(angle[0]), np.sin(angle[0])])
    return found, place, np.column_stack([np.cos(angle[1]), np.sin(angle[1])])


def both(x):
    return f"{np.nanmedian(x):.1f}, {np.nanquantile(x, 0.95):.1f}"


def line(palpate, truth, kind, folder):
    folder.mkdir(parents=True, exist_ok=True)
    largest = measured(truth, kind, folder)
    command = [palpate, "run", folder / "manifest.toml", "-o", folder / "run"]
    subprocess.run(command, check=False, capture_output=True)
    error = json.loads((folder / "run/statement.json").read_text())["force_error"]
    with h5py.File(folder / "run/samples.scan_curves.h5") as f:
        number = np.array(f.attrs["recording"].decode().split(), float)
    found, place, slide = found_body(truth, folder)
    pairs = list(zip(truth.pressed(place, slide), found.pressed(place, slide)))
    height = 1e3 * abs(found.touch(place) - truth.touch(place))
    off = [both(100 * abs(b / a - 1)) for a, b in pairs]
    off.append(f"{np.nanmedian(height):.2f}, {np.nanquantile(height, 0.95):.2f}")
    print(
        f"| {truth.asset.stem}, {kind} | "
        f"{100 * error['median_rel']:.1f}, {100 * error['p95_rel']:.1f} | {' | '.join(off)} | "
        f"{1e3 * (0.01 * number[0] - DELAY_S):.1f} | "
        f"{np.degrees(np.linalg.norm(number[4:7] - TURN)):.1f} | "
        f"{100 * np.linalg.norm(number[7:10] / largest - DRIFT):.1f} |",
        flush=True,
    )


def presses_beside(palpate, truth, folder):
    folder.mkdir(parents=True, exist_ok=True)
    largest = measured(truth, "raster", folder, 0.6)
    press(truth, folder, "press", largest, 7)
    press(truth, folder, "later", largest, 8)
    (folder / "later.toml").write_text(DEFAULTS + PRESSES.format("later"))
    for name, beside in (("raster", ""), ("raster, presses", PRESSES.format("press"))):
        manifest = folder / "manifest.toml"
        manifest.write_text(DEFAULTS + SCAN + beside + "[validate]\nhold_out = 5\n")
        command = [palpate, "run", manifest, "-o", folder / "run", "--force"]
        with open(folder / f"{name}.log", "w") as log:
            subprocess.run(command, check=False, stderr=log)
        of = json.loads((folder / "run/statement.json").read_text())
        kinds = of.get("by_kind")
        kinds = kinds or {"scan": of["force_error"]}
        command = [palpate, "validate", folder / "run/asset.palp", folder / "later.toml", "--json"]
        later = subprocess.run(command, check=False, capture_output=True, text=True).stdout
        error = json.loads(later)["force_error"]
        found, place, slide = found_body(truth, folder)
        off = []
        for level in (0.35, 0.8):
            known, other = (b.pressed(place, slide, level)[0] for b in (truth, found))
            off.append(both(100 * abs(other / known - 1)))
        held = "; ".join(f"{k} {100 * e['p95_rel']:.1f}" for k, e in kinds.items())
        print(
            f"| {truth.asset.stem}, {name} | {held} | {100 * error['median_rel']:.1f}, "
            f"{100 * error['p95_rel']:.1f} | {' | '.join(off)} |",
            flush=True,
        )


def kabsch(a, b):
    """Rotation and translation that bring rows of a nearest to those of b."""
    u, _, v = np.linalg.svd((a - a.mean(0)).T @ (b - b.mean(0)))
    turn = (u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v).T
    return turn, b.mean(0) - turn @ a.mean(0)


def on_mesh(palpate, truth, folder):
    folder.mkdir(parents=True, exist_ok=True)
    measured(truth, "raster", folder)
    with h5py.File(truth.asset.with_name("body.h5")) as f:
        vertices, triangles = f["surface/vertices"][:], f["surface/triangles"][:]
    with open(folder / "body.obj", "w") as f:
        f.writelines("v {:.9g} {:.9g} {:.9g}\n".format(*v) for v in 1e3 * vertices)
        f.writelines("f {} {} {}\n".format(*t) for t in triangles + 1)
    random = np.random.default_rng(9)
    unit = lambda v: v / np.linalg.norm(v)
    turn = rotation(np.radians(20) * unit(random.normal(size=3)))
    shift = 0.03 * unit(random.normal(size=3))
    to_rig = lambda p: (p - truth.origin) @ turn.T + truth.origin + shift
    rows = np.loadtxt(folder / "scan.csv", delimiter=",", skiprows=1)
    rows[:, 1:4], rows[:, 4:] = to_rig(rows[:, 1:4]), rows[:, 4:] @ turn.T
    save(folder / "scan.csv", "t_s,x_m,y_m,z_m,fx_N,fy_N,fz_N", rows)
    zero = np.zeros(1)
    center = truth.origin + truth.surface(zero, zero) * truth.axes[2]
    known = vertices[[(vertices @ d).argmax() for d in random.normal(size=(3, 3))]]
    touched = to_rig(known) + 3e-3 * np.array([unit(d) for d in random.normal(size=(3, 3))])
    text = 'surface = "body.obj"\nlength_unit = "mm"\n'
    quoted = lambda p: "[" + ", ".join(f'"{1e3 * x:.4f} mm"' for x in p) + "]"
    for rig, body in zip(touched, known):
        text += f"[[registration.landmarks]]\nrig = {quoted(rig)}\nbody = {quoted(body)}\n"
    for name, beside in (("alone", ""), ("mesh", text)):
        (folder / "manifest.toml").write_text(beside + DEFAULTS + SCAN)
        command = [palpate, "run", folder / "manifest.toml", "-o", folder / "run", "--force"]
        with open(folder / f"{name}.log", "w") as log:
            subprocess.run(command, check=False, stderr=log)
        error = json.loads((folder / "run/statement.json").read_text())["force_error"]
        found = f"{100 * error['median_rel']:.1f}, {100 * error['p95_rel']:.1f}"
        if beside:
            first, then = kabsch(touched, known), registration_of(folder / "run")
            total = then[0] @ first[0]
            angle = np.degrees(np.arccos((np.trace(total @ turn) - 1) / 2))
            middle = then[0] @ (first[0] @ to_rig(center) + first[1]) + then[1]
            start = np.degrees(np.arccos((np.trace(first[0] @ turn) - 1) / 2))
            left = json.loads((folder / "run/samples.import.json").read_text())["registration"]
            found += f" | {start:.1f} | {angle:.2f} | {1e3 * np.linalg.norm(middle - center):.2f}"
            found += f" | {1e3 * left['rms_m']:.2f}"
            body, place, slide = found_body(truth, folder)
            off = zip(truth.pressed(place, slide), body.pressed(place, slide))
            found += " | " + " | ".join(both(100 * abs(b / a - 1)) for a, b in off)
        print(f"| {truth.asset.parent.stem}, {name} | {found} |", flush=True)


def other_balls(palpate, truth, folder):
    folder.mkdir(parents=True, exist_ok=True)
    with h5py.File(truth.asset.with_name("body.h5")) as f:
        scene, radius_m = f["scene/text"][0].decode(), f["probe/radius"][0]
    for share in (0.7, 1.5):
        of = Body(palpate, truth.asset, folder)
        # The scene's [probe] has another radius.
        ball = re.sub(r"(?s)(\[probe\].*?radius = )[^\n]*", rf"\g<1>{share * radius_m:.6g}", scene)
        (folder / "tool.toml").write_text(ball)
        of.tool = ("--tool", folder / "tool.toml")
        of.find_window()
        of.depth_m = truth.depth_m
        line(palpate, of, "hand", folder / f"{share} radii")


def registration_of(run):
    with h5py.File(run / "samples.scan_curves.h5") as f:
        number = np.array(f.attrs["recording"].decode().split()[-12:], float)
    return number[:9].reshape(3, 3).T, number[9:]


def main():
    palpate, out, *assets = sys.argv[1:]
    truths = {"--presses": presses_beside, "--mesh": on_mesh, "--balls": other_balls}
    chosen = [truths[a] for a in assets if a in truths]
    assets = [a for a in assets if a not in truths]
    for asset in map(pathlib.Path, assets):
        folder = pathlib.Path(out) / asset.stem
        folder.mkdir(parents=True, exist_ok=True)
        truth = Body(palpate, asset, folder)
        truth.find_window()
        for of in chosen:
            of(palpate, truth, folder / of.__name__)
        if chosen:
            continue
        for kind in ("raster", "spiral", "hand"):
            line(palpate, truth, kind, folder / kind)


if __name__ == "__main__":
    main()
