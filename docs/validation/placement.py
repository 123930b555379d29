"""Error against number of test points, even and adaptive, on one set of held-out experiments.

    python3 docs/validation/placement.py measure build/ci/tools/palpate data/scenes/liver.toml FOLDER
    python3 docs/validation/placement.py draw docs/validation

`measure` simulates (25 minutes of CPU for the liver; what FOLDER holds is used again) and writes
docs/validation/placement.csv; `draw` makes placement.svg of it. Needs python3-matplotlib to draw.
"""
import csv
import json
import os
import re
import subprocess
import sys

EVEN = (12, 36, 72)
ADAPTIVE = (16, 20, 25, 31, 38)
HELD_OUT = 12
COLUMNS = ("placement", "points", "median_rel", "p95_rel", "max_rel", "within_jnd",
           "interpolation_median_rel", "interpolation_p95_rel", "family_p95_rel")


def scene_with(text, base, test_points):
    text = re.sub(r"(?m)^test_points = .*$", "test_points = " + test_points, text)
    return re.sub(r'(?m)^surface = "(.*)"', lambda m: 'surface = "%s"' % os.path.abspath(
        os.path.join(base, m.group(1))), text)


def call(*arguments):
    print(" ".join(arguments), file=sys.stderr)
    return subprocess.run(arguments, check=True, stdout=subprocess.PIPE, text=True).stdout


def measured(palpate, scene, folder, body, reference):
    """Asset of the folder's samples, compared with the held-out experiments."""
    at = lambda name: os.path.join(folder, name)
    call(palpate, "fit", at("samples.h5"), "-o", at("curves.h5"), "--jobs", "1")
    call(palpate, "refine", at("curves.h5"), "--body", body, "-o", at("model.h5"))
    call(palpate, "export", at("model.h5"), "-o", at("asset.palp"))
    return json.loads(call(palpate, "validate", at("asset.palp"), scene, "--points", str(HELD_OUT),
                           "--body", body, "--reference", reference, "--curves", at("curves.h5"),
                           "--model", at("model.h5"), "--jobs", "1", "--json"))


def row_of(placement, points, statement):
    error, causes = statement["force_error"], statement["causes"]
    return (placement, points, error["median_rel"], error["p95_rel"], error["max_rel"],
            error["within_jnd"], causes["interpolation"]["median_rel"],
            causes["interpolation"]["p95_rel"], causes["curve_family"]["p95_rel"])


def measure(palpate, scene_path, work):
    with open(scene_path) as file:
        text = file.read()
    rows = []
    for placement, points in [("even", n) for n in EVEN] + [("adaptive", n) for n in ADAPTIVE]:
        folder = os.path.join(work, placement if placement == "adaptive" else f"even{points}")
        os.makedirs(folder, exist_ok=True)
        scene = os.path.join(folder, "scene.toml")
        wanted = str(points) if placement == "even" else f'"auto"\ntolerance = 0\nbudget = {points}'
        with open(scene, "w") as file:
            file.write(scene_with(text, os.path.dirname(scene_path), wanted))
        body, samples = os.path.join(folder, "body.h5"), os.path.join(folder, "samples.h5")
        call(palpate, "prepare", scene, "-o", body)
        call(palpate, "simulate", scene, "-o", samples, "--jobs", "1", "--resume")
        if placement == "adaptive":
            body = os.path.join(folder, "placed.h5")
        rows.append(row_of(placement, points, measured(palpate, scene, folder, body,
                                                       os.path.join(work, "reference"))))
        print(rows[-1], file=sys.stderr)
    with open("docs/validation/placement.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)


def draw(folder):
    import matplotlib
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "palpate"  # the same bytes from the same numbers
    import matplotlib.pyplot as plt
    with open(os.path.join(folder, "placement.csv"), newline="") as file:
        rows = list(csv.DictReader(file))
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.6), sharex=True)
    for axis, column, title in ((axes[0], "p95_rel", "force error, p95"),
                                (axes[1], "interpolation_p95_rel", "its part by interpolation, p95")):
        # Both begin with the same twelve points.
        first = [r for r in rows if r["placement"] == "even"][:1]
        for placement, style in (("even", "o-"), ("adaptive", "s-")):
            own = [r for r in rows if r["placement"] == placement]
            own = own if placement == "even" else first + own
            axis.plot([int(r["points"]) for r in own], [100 * float(r[column]) for r in own], style,
                      label=placement)
        axis.axhline(7, color="grey", lw=0.8, ls="--")
        axis.set_xlabel("test points simulated")
        axis.set_ylabel("% of force")
        axis.set_ylim(bottom=0)
        axis.set_title(title, fontsize=10)
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(os.path.join(folder, "placement.svg"), metadata={"Date": None})


if sys.argv[1] == "measure":
    measure(*sys.argv[2:5])
else:
    draw(sys.argv[2])
