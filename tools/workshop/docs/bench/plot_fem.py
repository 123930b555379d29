"""Draws the tables of `palpate bench fem` that are worth a picture, one SVG each.

    palpate bench fem
    python3 tools/workshop/docs/bench/plot_fem.py docs/bench

Needs python3-matplotlib.
"""
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import pyplot, save, table


def read(folder, name):
    return table(os.path.join(folder, f"fem_{name}.csv"))


def accuracy(folder):
    rows = read(folder, "accuracy")
    ratios = sorted({row["poisson"] for row in rows})
    figure, axes = pyplot().subplots(1, len(ratios), figsize=(4.5 * len(ratios), 3.4), sharey=True)
    for axis, ratio in zip(axes, ratios):
        kinds = sorted({(r["element"], float(r["coarse"]) > 0) for r in rows})
        for element, has_coarse in kinds:
            here = sorted((float(r["CPU_s"]), float(r["mean_percent"]), r["size"]) for r in rows
                          if (r["element"], float(r["coarse"]) > 0, r["poisson"])
                          == (element, has_coarse, ratio))
            label = element + (", extrapolated" if has_coarse else "")
            axis.plot([h[0] for h in here], [h[1] for h in here], "o-", ms=4, label=label)
            for cpu, error, size in here:
                axis.annotate(size, (cpu, error), fontsize=6, xytext=(3, 3),
                              textcoords="offset points")
        axis.set(xscale="log", yscale="log", xlabel="CPU of a press [s]",
                 title=f"press of 10 mm, Poisson's ratio {ratio}")
        axis.grid(alpha=0.3, which="both")
    axes[0].set_ylabel("mean of |force error|, 1 to 10 mm [%]")
    axes[0].legend(fontsize=7)
    save(figure, folder, "fem_accuracy")


def rates(folder):
    rows = read(folder, "rates")
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
    accuracy(folder)
    rates(folder)


main()
