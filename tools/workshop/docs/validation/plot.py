"""Draws the force curves that the slow tests record, one SVG per case.

    PALPATE_VALIDATION_CURVES=curves.csv bash tools/test.sh --all
    python3 tools/workshop/docs/validation/plot.py curves.csv docs/validation

Needs python3-matplotlib. Bands are each row's stated error; crosses are the reference: for AXI an
independent solution, else ours on a mesh 1.6 times finer.
"""
import collections
import math
import os
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import pyplot, save, table


def draw(case, curves, folder):
    figure, axes = pyplot().subplots(1, len(curves), figsize=(4 * len(curves), 3), squeeze=False)
    for axis, (name, rows) in zip(axes[0], sorted(curves.items(), reverse=True)):
        x, force, error, reference = zip(*sorted(rows))
        axis.fill_between(x, [f - e for f, e in zip(force, error)],
                          [f + e for f, e in zip(force, error)], alpha=0.3, lw=0)
        axis.plot(x, force, label="Palpate, its stated error")
        known = [(a, r) for a, r in zip(x, reference) if not math.isnan(r)]
        if known:
            axis.plot(*zip(*known), "kx", ms=4, label="reference")
        axis.set_xlabel("depth [mm]" if name == "press" else "travel [mm]")
        axis.set_ylabel("force along it [N]")
        axis.set_title(f"{case}: {name}", fontsize=9)
        axis.grid(alpha=0.3)
        axis.legend(fontsize=7)
    stem = re.sub(r"[^a-z0-9]+", "_", case.lower()).strip("_")
    save(figure, folder, stem)


def main():
    source, folder = sys.argv[1:3]
    cases = collections.defaultdict(lambda: collections.defaultdict(list))
    for row in table(source):
        cases[row["case"]][row["curve"]].append(
            tuple(float(row[k]) for k in ("at_mm", "force_N", "error_N", "reference_N")))
    for case, curves in cases.items():
        draw(case, curves, folder)


main()
