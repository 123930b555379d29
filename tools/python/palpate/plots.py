"""Pictures by matplotlib, which is imported when one is asked for."""
import csv

import numpy as np


def _axes(axes):
    if axes is not None:
        return axes
    from matplotlib.figure import Figure  # not pyplot: no window, no global state
    return Figure(figsize=(6, 4), layout="constrained").add_subplot()


def _columns(path):
    """The columns of a CSV table by name, as texts."""
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return {name: [row[name] for row in rows] for name in (rows[0] if rows else ())}


def plot_curve(curve, axes=None, label=None):
    """One curve of `curves(...)[point]` over its depth, with a band of two standard errors where they are
    known. Returns the axes; axes.figure.savefig("curve.png") keeps it."""
    axes = _axes(axes)
    at_mm = 1e3 * curve["at_m"]
    line, = axes.plot(at_mm, curve["value_N"], label=label)
    if np.isfinite(curve["deviation_N"]).any():
        low, high = (curve["value_N"] + sign * 2 * curve["deviation_N"] for sign in (-1, 1))
        axes.fill_between(at_mm, low, high, color=line.get_color(), alpha=0.25, linewidth=0)
    axes.set(xlabel="deflection [mm]", ylabel="force [N]")
    return axes


def plot_curves(path, curve="normal", axes=None):
    """One curve of every point in the table that `palpate tabulate curves.h5 -o curves.csv` writes. Returns the
    axes."""
    axes = _axes(axes)
    table = {name: np.array(column) for name, column in _columns(path).items()}
    for point in dict.fromkeys(table["point"]):
        own = (table["point"] == point) & (table["curve"] == curve)
        axes.plot(1e3 * table["at_m"][own].astype(float), table["value_N"][own].astype(float),
                  label=table["name"][own][0] if own.any() else None)
    axes.set(xlabel="deflection [mm]", ylabel="force [N]")
    return axes


def plot_statement(path, axes=None):
    """Bars of the 95th percentile and the median of errors by kind of path and by cause: of the statement.json of a
    run, or of its folder or asset. Returns the axes."""
    from .files import statement
    stated, axes = statement(path), _axes(axes)
    lines = {name: error for section in ("by_path", "causes") for name, error in stated[section].items()}
    for key, height, label in (("p95_rel", 0.8, "95th percentile"), ("median_rel", 0.4, "median")):
        axes.barh([name.replace("_", " ") for name in lines], [100 * (error[key] or 0) for error in lines.values()],
                  height, label=label)
    axes.invert_yaxis()
    axes.set(xlabel="error [% of the force]")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1), ncol=2, frameon=False)
    return axes


def plot_path(path, axes=None):
    """Force on the first tool over time, from the FORCES.csv that `palpate replay` writes. Times at which the tool
    slips are shaded. Returns the axes."""
    axes = _axes(axes)
    table = {name: np.array(column, float) for name, column in _columns(path).items()}
    table = {name: column[table["tool"] == 0] for name, column in table.items()}
    for name in "xyz":
        axes.plot(table["t_s"], table[f"f{name}_N"], label=f"$F_{name}$")
    limits = axes.get_ylim()
    axes.fill_between(table["t_s"], 0, 1, where=table["sliding"] == 1, transform=axes.get_xaxis_transform(),
                      color="0.9", linewidth=0, label="slips")
    axes.set(xlabel="time [s]", ylabel="force on the tool [N]", ylim=limits)
    axes.legend()
    return axes
