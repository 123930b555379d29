#!/usr/bin/env python3
"""Every recording of the shared data and cases in one table: estimator, contact, modulus, reference,
grade.

    python3 tools/workshop/docs/measured/recordings.py PALPATE SHARED docs/measured/recordings.md [NANITE]

PALPATE: the program. SHARED: the folder with `data` and `cases`. NANITE: the folder tests/data of
nanite (github.com/AFM-analysis/nanite, 77636ddf2b1e), for the values that its tests publish. Contact and grade are `import`'s,
moduli those of `modulus`; of compressed cylinders `calibrate`'s, each specimen by itself. References
are the instrument's, published ones, the truth of a case, or a global fit of this script: least
squares of the tip's law over all readings of the way in as the file has them, any contact, free part
flat. Needs python3-numpy.
"""
import glob
import json
import math
import os
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import Program, table

CANTILEVER = 'cantilever = { stiffness = 0.2, sensitivity = "100 nm" }\n'  # assumed
PYRAMID = 'probe = { shape = "pyramid", radius = "20 nm", half_angle = "20 deg" }\n'
CASE = ('columns = { time = "t_s", depth = "pos_mm", force = ["force_N"] }\n'
        'units = { time = "s", position = "mm", force = "N" }\nforce_on = "body"\ncycle = "mean"\n')
SPHERE_MM = 100  # of the Hertz case, which no file states


def tables(folder, files, keys):
    """Rows of `import` and of `modulus`, by file."""
    manifest = os.path.join(folder, "manifest.toml")
    with open(manifest, "w", encoding="utf-8") as out:
        out.write('repeats = "keep"\n[defaults]\nposition = ["0 mm", "0 mm", "0 mm"]\n'
                  'normal = [0, 0, -1]\nplausible = ["0.001 Pa", "100 GPa"]\n' + keys)
        for file in files:
            out.write(f'[[recording]]\nfile = "{os.path.abspath(file)}"\n')
    samples, moduli = (os.path.join(folder, name) for name in ("samples.h5", "moduli.csv"))
    palpate("import", manifest, "-o", samples, "--force")
    palpate("modulus", manifest, "-o", moduli, also=(1,))  # 1: none has one
    out = [{os.path.basename(row["file"]): row for row in table(path)}
           for path in (os.path.join(folder, "samples.import.csv"), moduli)]
    with open(os.path.join(folder, "samples.import.json"), encoding="utf-8") as source:
        estimators = {os.path.basename(row["file"]): row.get("estimator", "")
                      for row in json.load(source)["recordings"]}
    return out[0], out[1], estimators


def global_fit(travel_m, force_N, power):
    """Contact and factor of F = b + a (x - c)^power, over all readings."""
    def squares(contact_m):
        bent = np.maximum(0, travel_m - contact_m) ** power
        columns = np.stack([np.ones_like(bent), bent / bent.max()], 1)
        found, *_ = np.linalg.lstsq(columns, force_N, rcond=None)
        return float(np.sum((force_N - columns @ found) ** 2)), found[1] / bent.max()
    low, high = travel_m.min(), travel_m.max()
    for _ in range(6):
        tried = np.linspace(low, high, 201)[:-1]
        best = min(range(len(tried)), key=lambda i: squares(tried[i])[0])
        low, high = tried[max(best - 1, 0)], tried[min(best + 1, len(tried) - 1)]
    return tried[best], squares(tried[best])[1]


def numbers(file, first, separator=",", decimal="."):
    rows = []
    with open(file, encoding="latin-1") as source:
        for line in source.read().splitlines()[first:]:
            cells = [cell.replace(decimal, ".") for cell in line.split(separator)]
            try:
                rows.append([float(cell) if cell.strip() else math.nan for cell in cells])
            except ValueError:
                continue
    return np.array([row for row in rows if len(row) == len(rows[0])])


def pyramid_modulus(factor):
    return factor * (1 - 0.25) / (0.7453 * math.tan(math.radians(20)))


def afm_reference(file):
    """Of a curve whose way in is two columns: height [nm] and volts, 100 nm and 20 nN each."""
    with open(file, encoding="latin-1") as source:
        first = next((i for i, line in enumerate(source) if line.startswith("Extend")), -1) + 1
    rows = numbers(file, first) if first else numbers(file, 0, "\t", ",")
    rows = rows[~np.isnan(rows[:, 0]) & ~np.isnan(rows[:, 1])]
    if not first:  # NT-MDT: from the deepest row outward, saturated at its largest value
        rows = rows[::-1] * [-1, 1, 1]
        rows = rows[rows[:, 1] < rows[:, 1].max()]
    bend_m = 100e-9 * rows[:, 1]
    height_m = 1e-9 * rows[:, 0]
    contact_m, factor = global_fit(height_m - bend_m + bend_m[0], 0.2 * bend_m, 2)
    return contact_m - height_m[0], pyramid_modulus(factor), height_m[0]


def in_units(metres, deviation, micrometres):
    scale, unit = (1e6, "µm") if micrometres else (1e3, "mm")
    return f"{round(scale * metres, 3) + 0.0:.3f} ± {scale * deviation:.3f} {unit}"


def pressure(value):
    for size, unit in ((1e6, "MPa"), (1e3, "kPa")):
        if value >= size:
            return f"{value / size:.4g} {unit}"
    return f"{value:.4g} Pa"


def cell(row, key):
    return float(row[key]) if row and row.get(key) else math.nan


def line(name, file, imported, moduli, estimators, micrometres, reference, modulus=None):
    base = os.path.basename(file)
    row, other = imported[base], moduli.get(base)
    if row["status"] == "refused":
        return [name, "", "refused", "", reference, row["reason"]]
    if modulus is None:
        E, error = cell(other, "young_Pa"), cell(other, "young_deviation_Pa")
        modulus = f"{pressure(E)} ± {100 * error / E:.2g} % ({other['model']})" if E > 0 else ""
        if modulus and other["grade"] != "good":
            modulus += ", " + other["grade"]
    contact = in_units(cell(row, "contact_m"), cell(row, "contact_deviation_m"), micrometres)
    return [name, estimators[base], contact, modulus, reference, row["grade"]]


def chiaro(folder):
    files = glob.glob(os.path.join(DATA, "indentation", "fmt-chiaro*"))
    found = tables(folder, files, "")
    for file in files:
        with open(file, encoding="latin-1") as source:
            own = next(float(l.split()[-1]) for l in source if l.startswith("E[v=0.500]"))
        hertz = found[1][os.path.basename(file)]["others"]
        yield line("Chiaro, AEBP1 indentation 2", file, *found, True,
                   f"instrument: {own} Pa (hertz; here {hertz.split(' (')[0]})")


def microscopes(folder):
    named = [("AFMWorkshop, single 2018", "afm-workshop-fd_single_2018*"),
             ("NT-MDT, gel", "ntmdt*"), ("AFMWorkshop map", "afm-workshop-map16/*.csv")]
    for name, pattern in named:
        files = sorted(glob.glob(os.path.join(DATA, "indentation", pattern)))
        found = tables(folder, files, PYRAMID + CANTILEVER)
        for i, file in enumerate(files):
            travel_m, E, first_m = afm_reference(file)
            at = first_m + travel_m
            yield line(f"{name} {i + 1}" if len(files) > 1 else name, file, *found, True,
                       f"global fit: {1e6 * at:.3f} µm, {pressure(E)}")
    files = glob.glob(os.path.join(DATA, "indentation", "afm-workshop-fd_single_2021*"))
    found = tables(folder, files, PYRAMID)
    for file in files:
        rows = numbers(file, 12)
        contact_m, factor = global_fit(1e-9 * rows[:, 0], 1e-9 * rows[:, 1], 2)
        yield line("AFMWorkshop, single 2021", file, *found, True,
                   f"global fit: {1e6 * contact_m:.3f} µm, {pressure(pyramid_modulus(factor))}")


def compressions(folder):
    with open(os.path.join(DATA, "compression", "hyperelastic_parameters.json"),
              encoding="utf-8") as source:
        published = json.load(source)["engineering"]
    for silicone in ("EF10_100T", "EF10_50T"):
        files = sorted(glob.glob(os.path.join(DATA, "compression", silicone + "_*.csv")))
        found = tables(folder, files, 'probe = { shape = "flat", radius = "25 mm" }\n')
        young = 3e3 * published[silicone]["Neo Hookean"]["parameters"][0]
        for file in files:
            tests = os.path.join(folder, "tests.toml")
            with open(tests, "w", encoding="utf-8") as out:
                out.write('[material]\nlaw = "neo-hookean-isochoric"\nyoung = "10 kPa"\n'
                          'poisson = 0.49999\n[[test]]\nkind = "uniaxial"\n'
                          f'file = "{os.path.abspath(file)}"\nstrain = "Engineering Strain"\n'
                          'stress = "Engineering Stress"\n')
            one = json.loads(palpate("calibrate", tests, "-o", os.path.join(folder, "m.toml"),
                                     "--json"))
            [E] = one["parameters"]
            yield line(os.path.basename(file)[:-4], file, *found, False,
                       f"published, all five specimens: {pressure(young)}",
                       f"{pressure(E['value'])} ± {100 * E['deviation'] / E['value']:.2g} % "
                       "(neo-Hookean cylinder)")


def cases(folder):
    curves = os.path.join(CASES, "curves")
    truths = sorted(glob.glob(os.path.join(curves, "T*__TRUTH.csv")))
    for truth in truths:
        name = os.path.basename(truth)[:-len("__TRUTH.csv")]
        files = [f for f in sorted(glob.glob(os.path.join(curves, name + "__*.csv"))) if f != truth]
        is_sphere = name == "T5_hertz"
        keys = CASE + (f'probe = {{ shape = "sphere", radius = "{SPHERE_MM} mm" }}\n'
                       if is_sphere else "")
        found = tables(folder, files, keys)
        begin_mm = numbers(os.path.join(curves, name + "__N0.csv"), 1)[0, 1]
        depth_mm, force_N = numbers(truth, 1)[-1]
        young = 9 / 16 * force_N / (1e-3 * depth_mm) ** 1.5 / math.sqrt(1e-3 * SPHERE_MM)
        for file in files:
            contact_mm = numbers(file, 1)[0, 1] - begin_mm
            yield line(os.path.basename(file)[:-4], file, *found, False,
                       f"truth: {contact_mm:.3f} mm" + (f", {pressure(young)}" if is_sphere else ""))


def nanite(folder):
    """Hertz with a ball of 10 um, way in alone: tests/test_indent.py, test_open_jpk_variation.py."""
    for name, published in (("spot3-0192", 14741.958), ("flipsign_2015.05.22-15.31.49.352", 5230.009)):
        file = os.path.join(NANITE, f"fmt-jpk-fd_{name}.jpk-force")
        found = tables(folder, [file], 'probe = { shape = "sphere", radius = "10 um" }\n')
        E, error = next((float(r["young_Pa"]), float(r["young_deviation_Pa"]))
                        for r in table(os.path.join(folder, "moduli.models.csv"))
                        if r["model"] == "hertz")
        grade = found[1][os.path.basename(file)]["grade"]
        yield line(f"nanite, {name.split('_')[0]}", file, *found, True,
                   f"nanite: {pressure(published)} (here {100 * (E / published - 1):+.1f} %)",
                   f"{pressure(E)} ± {100 * error / E:.2g} % (hertz)" +
                   ("" if grade == "good" else ", " + grade))


HEADER = """# The shared recordings in one table

`python3 tools/workshop/docs/measured/recordings.py PALPATE SHARED docs/measured/recordings.md NANITE` writes this page (NANITE: its tests' data). Contact, its deviation (one standard deviation, in the file's own travel) and grade are those of `import`, `contact = "auto"`. Modulus and its model are those of `modulus` with contact and baseline free, with that fit's own grade where it is not good. Of compressed cylinders they are `calibrate`'s, each specimen by itself. No modulus: the tip is not told, or the curve is that of no contact model. For the AFM curves, whose files state no tip and, but for one, no cantilever, 0.2 N/m, 100 nm/V and a four-sided pyramid of 20° are assumed. For the Hertz case it is a ball of 100 mm (a sphere's modulus is 1.5 % above a paraboloid's there). The cases' two presses are taken together (`cycle = "mean"`). Global fit: least squares of the tip's law by the script itself, over all readings of the way in, free part flat.

| recording | estimator | contact | modulus | reference | grade |
|---|---|---|---|---|---|
"""

if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    palpate = Program(sys.argv[1])
    SHARED, OUT, NANITE = (*sys.argv[2:], None)[:3]
    DATA, CASES = os.path.join(SHARED, "data"), os.path.join(SHARED, "cases")
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        for part in (chiaro, microscopes, compressions, cases, *([nanite] if NANITE else [])):
            rows.extend(part(scratch))
    with open(OUT, "w", encoding="utf-8") as page:
        page.write(HEADER)
        for row in rows:
            page.write("| " + " | ".join(row) + " |\n")
    print(f"{len(rows)} recordings, {sum(row[-1] == 'good' for row in rows)} good, "
          f"{sum(row[-1] == 'fair' for row in rows)} fair, "
          f"{sum(row[-1] == 'poor' for row in rows)} poor")
