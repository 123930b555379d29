"""The files of a run as dicts of NumPy arrays, named as in docs/formats.md."""
import csv
import difflib
import json
import os
import re
import tempfile

import numpy as np

# Type and unit of each data set of a samples.h5 but a probe's own numbers, as the program writes them: a list
# that a test of the program writes.
with open(os.path.join(os.path.dirname(__file__), "samples.json"), encoding="utf-8") as _file:
    _COLUMNS = json.load(_file)
_MAX_M = {"points/position": 10, "rows/deflection": 1}  # from the first one: of bodies and presses in mm, more


class Error(Exception):
    """Bad input or surroundings, in the program's words. where, what, remedy: its three parts."""

    def __init__(self, where, what, remedy=""):
        super().__init__(f"{where}: {what}" + (f"\n  {remedy}" if remedy else ""))
        self.where, self.what, self.remedy = where, what, remedy


def read(path):
    """The arrays of a body.h5, samples.h5, curves.h5 or model.h5 by name: read(p)["rows/force"].

    Attributes of the file are under "attributes"; codes such as "rows/status" come with the names of
    their values under "rows/status/names". Error where the file is none of these.
    """
    import h5py
    try:
        file = h5py.File(path, "r")
    except FileNotFoundError:
        raise
    except OSError as error:
        raise Error(os.fspath(path), f"is no HDF5 file, or damaged ({error})",
                    "Make it again with the command that wrote it.") from None
    with file:
        if not _text(file.attrs.get("schema", "")).startswith("palpate-") or file.attrs.get("version") != 1:
            raise Error(os.fspath(path), "is not a file of this version of Palpate",
                        "Give body.h5, samples.h5, curves.h5 or model.h5.")
        found = {"attributes": {key: _text(value) for key, value in file.attrs.items()}}

        def keep(name, item):
            if isinstance(item, h5py.Dataset):
                found[name] = item.asstr()[...] if item.dtype.kind in "SO" else item[...]
                if "names" in item.attrs:
                    found[name + "/names"] = [_text(word) for word in item.attrs["names"]]
            else:
                found.update({f"{name}/{key}": _text(value) for key, value in item.attrs.items()})

        file.visititems(keep)
    return found


def _text(value):
    return value.decode() if isinstance(value, bytes) else value


def write_samples(path, samples):
    """Writes a samples.h5: of a simulator of your own, or of `read` with something changed.

    samples: arrays by name in SI, as docs/formats/samples.md lists them. Given the others,
    rows/{kind,step,torque,force_error,status} and points/name may be left out: presses, counted on,
    without torque, error unknown, good. Error where a name is none of these, a code or an index is no whole
    number, or lengths are no metres. `palpate fit` checks the rest.
    """
    import h5py
    full = {name: value for name, value in samples.items() if name != "attributes"}
    for name in ("points/position", "points/normal", "rows/point", "rows/experiment", "rows/deflection",
                 "rows/force"):
        if name not in full:
            raise Error("samples", f"there is no {name}", "docs/formats/samples.md lists what samples hold.")
    _check(full)
    rows, experiment = len(full["rows/deflection"]), np.asarray(full["rows/experiment"])
    first = np.flatnonzero(np.r_[True, experiment[1:] != experiment[:-1]]) if rows else []
    counted = np.arange(rows) - np.repeat(first, np.diff(np.r_[first, rows]))
    for name, value in (("rows/kind", np.zeros(rows)), ("rows/step", counted), ("rows/status", np.zeros(rows)),
                        ("rows/torque", np.zeros((rows, 3))), ("rows/force_error", np.full(rows, np.nan)),
                        ("points/name", [f"p{i + 1:04d}" for i in range(len(full["points/position"]))])):
        full.setdefault(name, value)
    partial = f"{os.fspath(path)}.partial-{os.getpid()}"
    try:
        with h5py.File(partial, "w") as file:
            file.attrs["schema"], file.attrs["version"] = "palpate-samples", np.int32(1)
            for name, value in full.items():
                if name.endswith("/names"):
                    continue
                kind, unit = _column(name)
                made = file.create_dataset(name, data=np.asarray(value).astype(object if kind == "text" else kind),
                                           dtype=h5py.string_dtype() if kind == "text" else kind)
                made.attrs["unit"] = unit
                if name + "/names" in full:
                    made.attrs["names"] = full[name + "/names"]
        os.replace(partial, path)
    finally:
        if os.path.exists(partial):
            os.remove(partial)


def _check(samples):
    """Refuses arrays that the file would hold otherwise than they are meant."""
    for name, value in samples.items():
        (kind, _), value = _column(name), np.asarray(value)
        if not kind and not name.endswith("/names"):
            near = difflib.get_close_matches(name, _COLUMNS, 1)
            raise Error("samples", f"{name} is no array of samples" + (f"; is it {near[0]}?" if near else ""),
                        "docs/formats/samples.md lists what samples hold.")
        if kind.startswith("int") and value.dtype.kind in "iuf":
            limits = np.iinfo(kind)
            bad = ~((value == np.floor(value)) & (value >= limits.min) & (value <= limits.max))
            if bad.any():
                raise Error(f"samples: {name}", f"{value[bad][0]} is no whole number from {limits.min} to {limits.max}",
                            "docs/formats/samples.md says what it counts.")
        if name in _MAX_M and value.dtype.kind in "iuf" and value.ndim == 2:
            far_m = np.abs(value - (value[:1] if name == "points/position" else 0)).max(initial=0)
            if far_m > _MAX_M[name]:
                raise Error(f"samples: {name}", f"reaches over {far_m:.3g} m", "Lengths are in metres.")


def _column(name):
    """Type and unit of a data set of samples; empty where it is none."""
    name = re.sub(r"^probe_\d+/", "probe/", name)
    if name.startswith("probe/") and name not in _COLUMNS:
        return "float64", "rad" if name.endswith("angle") else "m"
    return _COLUMNS.get(name, ("", ""))


def by_point(samples):
    """Rows of samples by the name of their test point: {"p0001": {"force": (n, 3), ...}, ...}."""
    rows = {name[5:]: value for name, value in samples.items()
            if name.startswith("rows/") and not name.endswith("/names")}
    return {str(name): {key: value[rows["point"] == point] for key, value in rows.items()}
            for point, name in enumerate(samples["points/name"])}


def curves(path, steps=50):
    """Curves of a curves.h5, model.h5 or asset: {point: {"normal": {"at_m", "value_N", "slope_N_m",
    "deviation_N"}, ...}}, each (steps + 1,).

    point: its name, or the vertex's number. deviation_N: standard error of the value, NaN where it is
    not known; only curves.h5 knows.
    """
    from .program import command
    table = {}
    with tempfile.TemporaryDirectory() as folder:
        def rows_of(name, **options):
            output = os.path.join(folder, name)
            command("tabulate", path, output=output, steps=steps, quiet=True, **options)
            with open(output, newline="", encoding="utf-8") as file:
                yield from csv.DictReader(file)

        for row in rows_of("curves.csv"):
            one = table.setdefault(row["name"] or row["point"], {}).setdefault(row["curve"], {})
            for key in ("at_m", "value_N", "slope_N_m"):
                one.setdefault(key, []).append(float(row[key]))
        if not os.fspath(path).endswith(".palp") and read(path)["attributes"]["schema"] == "palpate-curves":
            for row in rows_of("band.csv", band=True):
                table[row["name"] or row["point"]][row["curve"]].setdefault("deviation_N", []).append(
                    float(row["deviation_N"]))
    for point in table.values():
        for name, curve in point.items():
            point[name] = {key: np.array(value) for key, value in curve.items()}
            point[name].setdefault("deviation_N", np.full(len(curve["at_m"]), np.nan))
    return table


def statement(path):
    """The error statement of a run: of its folder, its statement.json, or its asset.palp, as a dict."""
    path = os.fspath(path)
    if os.path.isdir(path):
        path = os.path.join(path, "statement.json")
    if path.endswith(".palp"):
        from . import open as open_asset
        with open_asset(path) as asset:
            return asset.meta.get("statement")
    with open(path, encoding="utf-8") as file:
        return json.load(file)


def frame(arrays):
    """A pandas DataFrame of arrays of one length: of a dict, or of `Contact.tick`'s. Vectors become a
    column for each component, force_0 and on."""
    import pandas
    names = arrays.dtype.names if isinstance(arrays, np.ndarray) else arrays
    columns = {}
    for name in names:
        value = np.asarray(arrays[name])
        if value.ndim == 1:
            columns[name] = value
        else:
            columns.update({f"{name}_{i}": part for i, part in enumerate(value.reshape(len(value), -1).T)})
    return pandas.DataFrame(columns)
