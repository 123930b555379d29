"""Error against number of test points, even and adaptive, on one set of held-out experiments.

    python3 tools/workshop/docs/validation/placement.py measure PALPATE data/scenes/liver.toml FOLDER
    python3 tools/workshop/docs/validation/placement.py draw docs/validation

`measure` simulates (some 130 different points of 10 s of CPU for the liver; what FOLDER holds is
used again) and writes docs/validation/placement.csv; `draw` makes placement.svg of it, for which it
needs python3-matplotlib.
"""
import csv
import json
import os
import re
import shutil
import subprocess
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import pyplot, save, table

EVEN = (72, 60, 48, 36, 24, 12)  # the first lends the others the points they share
ADAPTIVE = (38, 31, 25, 20, 16)  # the first simulates what the others need
HELD_OUT = 12
LEAST_PREDICTED = 20
COLUMNS = ("placement", "points", "predicted_points", "predicted_median_rel", "predicted_p95_rel",
           "predicted_max_rel", "random_p95_rel", "paths_median_rel", "paths_p95_rel",
           "paths_max_rel", "interpolation_p95_rel", "curve_fit_p95_rel", "curve_family_p95_rel",
           "friction_law_p95_rel")


def scene_with(text, base, test_points):
    text = re.sub(r"(?m)^test_points = .*$", "test_points = " + test_points, text)
    return re.sub(r'(?m)^surface = "(.*)"', lambda m: 'surface = "%s"' % os.path.abspath(
        os.path.join(base, m.group(1))), text)


def call(*arguments):
    print(" ".join(arguments), file=sys.stderr)
    return subprocess.run(arguments, check=True, stdout=subprocess.PIPE, text=True).stdout


def measured(palpate, placement, points, scene, folder, body, work):
    """A row of the table: the asset of the folder's samples against all that it did not see."""
    at = lambda name: os.path.join(folder, name)
    call(palpate, "fit", at("samples.h5"), "-o", at("curves.h5"), "--jobs", "1")
    call(palpate, "refine", at("curves.h5"), "--body", body, "-o", at("model.h5"))
    call(palpate, "export", at("model.h5"), "-o", at("asset.palp"))
    # Presses and drags at the points of the largest other even set, but for those it shares.
    others = EVEN[0] if (placement, points) != ("even", EVEN[0]) else EVEN[1]
    predicted = json.loads(call(palpate + "_bench", "predict", at("model.h5"),
                                os.path.join(work, f"even{others}", "samples.h5"),
                                "--without", at("curves.h5"), "--json"))
    # The same at the held-out points themselves: few, but nobody's.
    random = lambda: json.loads(call(palpate + "_bench", "predict", at("model.h5"),
                                     os.path.join(work, "reference", "reference.h5"), "--json"))
    statement = json.loads(call(palpate, "validate", at("asset.palp"), scene, "--points",
                                str(HELD_OUT), "--body", body, "--reference",
                                os.path.join(work, "reference"), "--jobs", "1", "--json"))
    near, far = predicted["force_error"], statement["force_error"]
    p95 = {k: v["p95_rel"] for k, v in statement["causes"].items()}
    values = [predicted["probes"], near["median_rel"], near["p95_rel"], near["max_rel"],
              random()["force_error"]["p95_rel"],
              far["median_rel"], far["p95_rel"], far["max_rel"], p95["interpolation"],
              p95["curve_fit"], p95["curve_family"], p95["friction_law"]]
    return [placement, points] + [round(v, 5) for v in values]


def simulated(palpate, placement, points, scene_path, work):
    """Folder, scene and body of a placement, simulated or found."""
    with open(scene_path) as file:
        text = file.read()
    folder = os.path.join(work, f"{placement}{points}")
    os.makedirs(folder, exist_ok=True)
    is_smaller = placement == "adaptive" and points != ADAPTIVE[0]
    lender = os.path.join(work, f"adaptive{ADAPTIVE[0]}" if is_smaller else f"even{EVEN[0]}",
                          "samples.h5")
    own = os.path.join(folder, "samples.h5")
    if os.path.exists(lender) and not os.path.exists(own):
        shutil.copy(lender, own)  # points that it does not want are dropped
    scene, body = os.path.join(folder, "scene.toml"), os.path.join(folder, "body.h5")
    wanted = str(points) if placement == "even" else f'"auto"\ntolerance = 0\nbudget = {points}'
    with open(scene, "w") as file:
        file.write(scene_with(text, os.path.dirname(scene_path), wanted))
    call(palpate, "prepare", scene, "-o", body)
    call(palpate, "simulate", scene, "-o", os.path.join(folder, "samples.h5"), "--jobs", "1",
         "--resume")
    return folder, scene, os.path.join(folder, "placed.h5") if placement == "adaptive" else body


def measure(palpate, scene_path, work):
    for points in EVEN[:2]:
        simulated(palpate, "even", points, scene_path, work)
    rows = []
    for placement, points in [("even", n) for n in EVEN] + [("adaptive", n) for n in ADAPTIVE]:
        folder, scene, body = simulated(palpate, placement, points, scene_path, work)
        rows.append(measured(palpate, placement, points, scene, folder, body, work))
        print(rows[-1], file=sys.stderr)
    with open("docs/validation/placement.csv", "w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(sorted(rows, key=lambda row: (row[0] != "even", row[1])))


def draw(folder):
    rows = table(os.path.join(folder, "placement.csv"))
    figure, axes = pyplot().subplots(1, 3, figsize=(11, 3.4), sharex=True)
    for axis, column, title in (
            (axes[0], "predicted_p95_rel", "presses and drags between even points"),
            (axes[1], "random_p95_rel", "the same at 12 random points"),
            (axes[2], "paths_p95_rel", "paths from those 12 points")):
        # Both begin with the same twelve points.
        first = [r for r in rows if r["placement"] == "even"][:1]
        for placement, style in (("even", "o-"), ("adaptive", "s-")):
            own = [r for r in rows if r["placement"] == placement]
            own = own if placement == "even" else first + own
            if column == "predicted_p95_rel":  # of a few points a quantile says nothing
                own = [r for r in own if int(r["predicted_points"]) >= LEAST_PREDICTED]
            axis.plot([int(r["points"]) for r in own], [100 * float(r[column]) for r in own], style,
                      label=placement)
        axis.axhline(7, color="grey", lw=0.8, ls="--")
        axis.set_xlabel("test points simulated")
        axis.set_ylabel("force error, p95 [%]")
        axis.set_ylim(bottom=0)
        axis.set_title(title, fontsize=10)
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)
    save(figure, folder, "placement")


if sys.argv[1] == "measure":
    measure(*sys.argv[2:5])
else:
    draw(sys.argv[2])
