#!/usr/bin/env python3
"""Held-out force error of robots' recordings, every point held out once.

    python3 tools/workshop/docs/measured/robots.py PALPATE RADIUS FOLDER...

FOLDER: a robot's file, as `palpate new --recordings` takes it; RADIUS: of its ball, "4 mm". The
manifest that `new` proposes is run five times, each time without another fifth of the points
(`[validate] hold_out`). Prints for each folder the error of the asset beside that of the nearest
point and of inverse distance, median and p95 in percent of the rows above the floor: means of the
five runs, in how many of them the asset's median is below inverse distance's, and the runs.
"""
import json
import os
import statistics
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import Program, table

RIVALS = ("asset", "nearest_point", "inverse_distance")
FOLDS = 5


def points_of(out):
    """Names of the points that were imported, in order."""
    return list(dict.fromkeys(r["point"] for r in table(os.path.join(out, "samples.import.csv"))
                              if r["status"] == "imported"))


def errors(folder, scratch):
    proposed = os.path.join(scratch, "manifest.toml")
    palpate("new", folder, "--recordings", "-o", proposed)
    with open(proposed, encoding="utf-8") as source:
        text = source.read()
    text += f'\nprobe = {{ shape = "sphere", radius = "{RADIUS}" }}\n'
    manifest = os.path.join(scratch, "m.toml")

    def write(hold_out):
        with open(manifest, "w", encoding="utf-8") as target:
            target.write(f"{text}\n[validate]\nhold_out = {hold_out}\n")

    write(0)
    palpate("import", manifest, "-o", os.path.join(scratch, "samples.h5"))
    names, found = points_of(scratch), []
    for fold in range(FOLDS):
        write(json.dumps([n for k, n in enumerate(names)
                          if (k % FOLDS - k // FOLDS) % FOLDS == fold]))
        out = os.path.join(scratch, f"out{fold}")
        palpate("run", manifest, "-o", out)
        with open(os.path.join(out, "statement.json"), encoding="utf-8") as source:
            statement = json.load(source)
        found.append({"asset": statement["force_error"], **statement["baselines"]})
    return found


def main():
    print("| set | asset | nearest point | inverse distance | asset below | medians of the runs |\n"
          "|---|---|---|---|---|---|")
    for folder in sys.argv[3:]:
        with tempfile.TemporaryDirectory() as scratch:
            runs = errors(os.path.abspath(folder), scratch)
        cells = []
        for rival in RIVALS:
            cells.append(", ".join(
                f"{100 * statistics.mean(r[rival][key] for r in runs):.3g}"
                for key in ("median_rel", "p95_rel")))
        below = sum(r["asset"]["median_rel"] < r["inverse_distance"]["median_rel"] for r in runs)
        each = "; ".join(f"{100 * r['asset']['median_rel']:.3g}, "
                         f"{100 * r['inverse_distance']['median_rel']:.3g}" for r in runs)
        print(f"| {os.path.basename(os.path.normpath(folder))} | {' | '.join(cells)} | {below} of "
              f"{FOLDS} | {each} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    palpate, RADIUS = Program(os.path.abspath(sys.argv[1])), sys.argv[2]
    main()
