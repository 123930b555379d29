"""docs/scenes.md out of the shipped scenes, docs/validation.md and docs/bench/scenes.csv: gallery.py. --check
compares it, --pictures draws docs/scenes/*.png anew, --measure SCENE ... runs scenes for that table, with the
program that PALPATE_PROGRAM names.

A scene's first lines say what it is; what it shows are those keys that at most two scenes have. Figures are
those of the row or the section of docs/validation.md that names the scene.
"""
import collections
import csv
import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import tomllib

ROOT = pathlib.Path(__file__).parents[3]
SCENES = sorted((ROOT / "data/scenes").glob("*.toml"))
PICTURES = ROOT / "docs/scenes"
MEASURED = ROOT / "docs/bench/scenes.csv"
QUICK = {row["scene"]: row for row in csv.DictReader(MEASURED.open())}
VALIDATION = (ROOT / "docs/validation.md").read_text()


def keys(scene):
    """The names a scene uses, as section.key; of nested tables of materials the keys, too."""
    for section, tables in tomllib.loads(scene.read_text()).items():
        for table in tables if isinstance(tables, list) else [tables]:
            for key in table:
                yield f"{section}.{key}"


def about(scene):
    """The first sentence above the first table, which says what the scene is."""
    head = re.match(r"(?:#.*\n)+", scene.read_text())[0].replace("# ", "").replace("\n", " ")
    sentences = re.split(r"(?<=[.;]) ", head.strip())
    kept = [s for s in sentences if not re.search(r"Costs|minutes|Made by|coordinates are|then set|saves it", s)]
    return kept[0].rstrip(";,.")


def figures(scene):
    """p95 and CPU of the scene's row, of its quick run with a link to the section that names it."""
    for line in VALIDATION.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if f"`{scene.name}`" in cells[0] and len(cells) > 8:
            p95 = re.search(r"/ ([0-9.]+) /", cells[2])[1]
            return f"{p95} % | {re.sub('[^0-9]', '', cells[8][:4])} s"
    own = QUICK.get(scene.stem)
    quick, cpu = (f"{own['p95']} % (quick); ", f"{own['cpu_s']} s") if own else ("", "")
    section = ""
    for line in VALIDATION.splitlines():
        if line.startswith("#"):
            section = line.lstrip("# ")
        elif scene.name in line:
            return f"{quick}[{section.lower()}](validation.md#{section.lower().replace(' ', '-')}) | {cpu}"
    return f"{quick.rstrip('; ')} | {cpu}"


def balls(scene):
    """The probe and the tool that lie on the window: their axis from end to end, and their radius, in metres."""
    length = lambda table, key: float(str(table.get(key, "0 mm")).split()[0]) / 1e3
    tool = scene.get("tool", scene["probe"])
    size = length(tool, "radius") or length(tool, "tip_radius")
    along = max(length(tool, "length") / 2 - size, 0)
    apart = [0] if "pairs" not in scene.get("validate", {}) else [-2 * size, 2 * size]
    return [((at - along, at + along), size) for at in apart]


def draw(scene):
    """The body from above its side: window red, held part blue, test points dark, stiff part green."""
    import h5py
    import matplotlib
    import numpy as np
    from PIL import Image
    matplotlib.use("Agg")
    from matplotlib import pyplot as plt
    from matplotlib.collections import PolyCollection
    with tempfile.TemporaryDirectory() as folder:
        made = pathlib.Path(folder, "body.h5")
        subprocess.run([os.environ["PALPATE_PROGRAM"], "prepare", scene, "-o", made], check=True, capture_output=True)
        with h5py.File(made) as body:
            places, corners = body["surface/vertices"][:], body["surface/triangles"][:]
            window, points = body["surface/is_reachable"][:] > 0, body["test_points/position"][:]
            nodes, held_node = body["volume/nodes"][:], body["volume/is_held"][:] > 0
        # A vertex is held where the node next to it is, and no farther than held nodes reach.
        held = np.array([held_node[((nodes - place) ** 2).sum(1).argmin()] for place in places])
        if held_node.any():
            low, high = nodes[held_node].min(0) - 1e-6, nodes[held_node].max(0) + 1e-6
            held &= ((places > low) & (places < high)).all(1)
        # Looks at the window from its side that is nearer to the viewer, tilted by half a right angle.
        out = places[window].mean(0) - places.mean(0)
        turn = np.arctan2(out[1], out[0]) + np.pi / 5 if np.hypot(*out[:2]) > abs(out[2]) else -np.pi / 3
        towards = np.array([np.cos(turn) * 0.8, np.sin(turn) * 0.8, 0.6])
        right = np.array([-np.sin(turn), np.cos(turn), 0])
        view = np.column_stack([right, np.cross(towards, right), towards])
        seen = places @ view
        triangle = places[corners]
        normal = np.cross(triangle[:, 1] - triangle[:, 0], triangle[:, 2] - triangle[:, 0])
        normal /= np.linalg.norm(normal, axis=1, keepdims=True) + 1e-30
        light = 0.55 + 0.45 * np.clip(normal @ (towards + [0, 0, 0.5]) / 1.3, 0, 1)
        colour = np.full((len(corners), 3), (0.85, 0.80, 0.76))
        colour[held[corners].all(1)] = (0.35, 0.55, 0.85)
        colour[window[corners].any(1)] = (0.85, 0.33, 0.28)
        order = np.argsort(seen[corners, 2].mean(1))
        order = order[(normal @ towards)[order] > 0]
        figure, axes = plt.subplots(figsize=(2.2, 1.7), dpi=100)
        axes.add_collection(PolyCollection(seen[corners[order]][..., :2], facecolors=colour[order] * light[order, None],
                                           edgecolors="face", linewidths=0.3))
        for part in tomllib.loads(scene.read_text()).get("inclusion", []):
            size = float(part["sphere"]["radius"].split()[0]) / 1e3
            at = np.array([float(x.split()[0]) / 1e3 for x in part["sphere"]["center"]])
            axes.add_patch(plt.Circle((at @ right, at @ np.cross(towards, right)), size, color=(0.05, 0.4, 0.15, 0.65), lw=0))
        axes.plot(*(points @ view)[:, :2].T, ".", color="#402010", markersize=2)
        for ends, size in balls(tomllib.loads(scene.read_text())):
            on = places[window][np.argmin(((places[window] - places[window].mean(0)) ** 2).sum(1))]
            for along in np.linspace(*ends, 1 if ends[0] == ends[1] else 40):
                at = on + [along * np.sin(turn), -along * np.cos(turn), size]
                axes.add_patch(plt.Circle((at @ right, at @ np.cross(towards, right)), size, color="#60606a", lw=0,
                                          alpha=0.6 if ends[0] == ends[1] else 1))
        axes.set_aspect("equal")
        axes.autoscale()
        axes.axis("off")
        figure.subplots_adjust(0, 0, 1, 1)
        figure.savefig(pathlib.Path(folder, "picture.png"))
        PICTURES.mkdir(exist_ok=True)
        Image.open(pathlib.Path(folder, "picture.png")).convert("RGB").quantize(32).save(
            PICTURES / f"{scene.stem}.png", optimize=True)


def measure(scene):
    """p95 [%] and CPU time [s] of its quick run by one thread."""
    with tempfile.TemporaryDirectory() as folder:
        began = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([os.environ["PALPATE_PROGRAM"], "run", scene, "-o", folder, "--quick", "--jobs", "1"], check=True)
        ended = resource.getrusage(resource.RUSAGE_CHILDREN)
        error = json.loads(pathlib.Path(folder, "statement.json").read_text())["force_error"]
        return {"scene": scene.stem, "p95": f"{100 * error['p95_rel']:.1f}",
                "cpu_s": round(ended.ru_utime + ended.ru_stime - began.ru_utime - began.ru_stime)}


if "--measure" in sys.argv:
    for scene in SCENES:
        if scene.stem in sys.argv:
            QUICK[scene.stem] = measure(scene)
    with MEASURED.open("w", newline="") as file:
        table = csv.DictWriter(file, ("scene", "p95", "cpu_s"), lineterminator="\n")
        table.writeheader()
        table.writerows(QUICK[name] for name in sorted(QUICK))
if "--pictures" in sys.argv:
    for scene in SCENES:
        draw(scene)
used = {scene: set(keys(scene)) for scene in SCENES}
times = collections.Counter(key for names in used.values() for key in names)
lines = ["""# Scenes to start from

`tools/workshop/docs/gallery.py` makes this page. Copy a scene, name your mesh, and keep what it shows. A [scene](formats/scene.md) for a mesh of your own is proposed by `palpate new`. Errors (19 of 20 forces are off by less) and CPU time are those of [validation](validation.md#assets). Red is the window, blue what is held, green what is stiffer, grey the ball or tool; dots are the first test points. Quick runs shared a machine, which may double their CPU time.

| | scene | what it is | keys that few others have | error | CPU |
|---|---|---|---|---|---|"""]
for scene in SCENES:
    rare = ", ".join(f"`{key}`" for key in sorted(used[scene], key=lambda key: (times[key], key)) if times[key] <= 2)
    lines.append(f"| ![{scene.stem}](scenes/{scene.stem}.png) | [{scene.stem}](../data/scenes/{scene.name}) | {about(scene)} | {rare} | {figures(scene)} |")
page, text = ROOT / "docs/scenes.md", "\n".join(lines) + "\n"
if "--check" in sys.argv:
    sys.exit(None if page.read_text() == text else "docs/scenes.md: gallery.py writes another one")
page.write_text(text)
