"""Palpate in Python: assets over NumPy paths, the files of a run as arrays, and the program's commands.

    import palpate
    with palpate.open("asset.palp") as asset:
        ticks = asset.contact().tick(path_m)          # (n, 3) -> structured array (n,)
    statement = palpate.run("organ.toml", "out", quick=True)
    curves = palpate.curves("out/curves.h5")          # with their bands

The engine needs NumPy alone. Reading HDF5 files needs h5py, plots need matplotlib, frames pandas;
`run`, `fit`, `curves` and `command` start the program `palpate`.
"""
import builtins as _builtins
import os as _os

from ._engine import (AIR, FLAG_BLOCKED, FLAG_BORDER, FLAG_CAPPED, FLAG_CROWDED, FLAG_EXTRAPOLATED,
                      FLAG_FRICTIONLESS, FLAG_HELD_BACK, FLAG_INSIDE, FLAG_OTHER_RADIUS, FLAG_OUTSIDE, FLAG_RAMP,
                      FLAG_TOO_DEEP, FLAG_UNFINISHED, OUTPUT, SLIP, STICK, Asset, Batch, Contact, deform_together,
                      sentence, tick_together)
from .files import Error, by_point, curves, frame, read, statement, write_samples
from .plots import plot_curve, plot_curves, plot_path, plot_statement
from .program import command, fit, run


def open(path):
    """The asset in a .palp file. OSError where it cannot be read, Error where it is refused."""
    with _builtins.open(path, "rb") as file:
        return Asset(file.read(), _os.fspath(path))
