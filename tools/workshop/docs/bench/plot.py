"""Draws the tables of `palpate_bench` that are worth a picture, one SVG each.

    palpate_bench fem
    palpate_bench rivals --run OUT
    python3 tools/workshop/docs/bench/plot.py docs/bench

Needs python3-matplotlib.
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import pyplot, save, table

JND_PERCENT = 7


def by_name(rows, name):
    """The rows of each name, in their order."""
    return {each: [row for row in rows if row[name] == each]
            for each in dict.fromkeys(row[name] for row in rows)}


def error_figure(folder, file, series, level, upright=None, **labels):
    """Errors of named series, each a list of (x, error, larger error) in percent, both axes logarithmic,
    with thin lines to the larger error, a line at a level {percent: label} and an upright one."""
    figure, axis = pyplot().subplots(figsize=(7.6, 4.4))
    for mark, (name, points) in zip("*osD^vP8X<", series.items()):
        x, error, larger = zip(*points)
        line, = axis.plot(x, error, mark + "-", label=name, ms=9 if mark == "*" else 6)
        axis.vlines(x, error, larger, color=line.get_color(), alpha=0.6)
    for percent, label in level.items():
        axis.axhline(percent, color="black", ls="--", lw=1, label=label)
    for x, label in (upright or {}).items():
        axis.axvline(x, color="black", ls=":", lw=1, label=label)
    axis.set(xscale="log", yscale="log", **labels)
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5))
    save(figure, folder, file)


def rivals(folder):
    for body, rows in by_name(table(os.path.join(folder, "rivals.csv")), "body").items():
        methods = by_name(rows, "rival")
        methods = {"Palpate": methods.pop("Palpate"), **methods}
        for column, file, upright, label in [
                ("tick_median_us", "tick", {1000: "1 kHz"}, "median time of a tick in contact [µs]"),
                ("preparation_cpu_s", "preparation", {}, "CPU of preparation [s]")]:
            error_figure(folder, f"rivals_{body}_{file}",
                         {name: [(float(r[column]), 100 * float(r["median_rel"]), 100 * float(r["p95_rel"]))
                                 for r in rows] for name, rows in methods.items()},
                         {JND_PERCENT: "JND, 7 %"}, upright, title=body, xlabel=label,
                         ylabel="force error [%]: median, thin line to p95")


def speed(folder):
    error_figure(folder, "fem_speed",
                 {name: [(float(r["CPU_s"]), float(r["mean_percent"]), abs(float(r["worst_percent"])))
                         for r in rows]
                  for name, rows in by_name(table(os.path.join(folder, "fem_speed.csv")), "series").items()},
                 {0.3: "error of the reference"}, title="press of 10 mm, cylinder",
                 xlabel="CPU of a press of ten rows [s]", ylabel="force error [%]: mean, thin line to the worst row")


def rates(folder):
    rows = table(os.path.join(folder, "fem_rates.csv"))
    nodes = [float(r["nodes"]) for r in rows]
    figure, axis = pyplot().subplots(figsize=(5, 3.4))
    for column, factor, label in [("factor_s", 1, "factor, single precision"),
                                  ("double_factor_s", 1, "factor, double precision"),
                                  ("solve_ms", 1e-3, "solve"),
                                  ("stiffness_ms", 1e-3, "assembly of the stiffness")]:
        axis.plot(nodes, [factor * float(r[column]) for r in rows], "o-", ms=4, label=label)
    axis.set(xscale="log", yscale="log", xlabel="nodes", ylabel="CPU [s]")
    axis.grid(alpha=0.3, which="both")
    axis.legend(fontsize=7)
    save(figure, folder, "fem_rates")


def main():
    folder = sys.argv[1]
    for draw in (rates, speed, rivals):
        draw(folder)


main()
