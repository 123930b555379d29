"""Pictures by matplotlib, which is imported when one is asked for."""
import numpy as np


def _axes(axes):
    if axes is not None:
        return axes
    from matplotlib.figure import Figure  # not pyplot: no window, no global state
    return Figure(figsize=(6, 4), layout="constrained").add_subplot()


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


def plot_path(asset, position_m, dt_s=0.001, axes=None):
    """The force on a tip that goes along position_m (n, 3), one row every dt_s, on a contact of its own.
    Times at which it slips are shaded. Returns the axes."""
    from . import SLIP
    axes = _axes(axes)
    ticks = asset.contact().tick(position_m, dt_s=dt_s)
    time_s = dt_s * np.arange(len(ticks))
    for i, name in enumerate("xyz"):
        axes.plot(time_s, ticks["force_on_tool_N"][:, i], label=f"$F_{name}$")
    limits = axes.get_ylim()
    axes.fill_between(time_s, 0, 1, where=ticks["state"] == SLIP, transform=axes.get_xaxis_transform(),
                      color="0.9", linewidth=0, label="slips")
    axes.set(xlabel="time [s]", ylabel="force on the tool [N]", ylim=limits)
    axes.legend()
    return axes
