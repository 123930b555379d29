#!/usr/bin/env python3
"""The tables of docs/measured/moduli.md that are of recordings.

    PYTHONPATH=... python3 tools/workshop/docs/measured/moduli.py PALPATE SHARED AFMFORMATS

PALPATE: the program. SHARED: the folder with `data`. AFMFORMATS: the folder tests/data of
github.com/AFM-analysis/afmformats (731b5ad88bbb), whose Python package reads the readings of the
global fits: least squares of a Hertz law over all readings of the way in, any contact, free part
flat, by this script. Needs python3-numpy and afmformats. Writes both tables to standard output.
"""
import os
import sys
import tempfile

import afmformats
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import Program, table

CURVES = (("cc_pr14-brain", "cc_pr14-brain-2021.06.30.jpk-force"),
          ("cc_pr14-polymergel", "cc_pr14-polymergel-2021.06.30.jpk-force"),
          ("fd_2020.02.07 (qi)", "fd_2020.02.07-16.29.05.036.jpk-qi-data"),
          ("fd_flipsign", "fd_flipsign_2015.05.22-15.31.49.352.jpk-force"),
          ("fd_map-data-reference", "fd_map-data-reference-points.jpk-force-map"),
          ("fd_map0d_extracted", "fd_map0d_extracted.jpk-force-map"),
          ("fd_map2x2_extracted", "fd_map2x2_extracted.jpk-force-map"),
          ("fd_qi-data-2021", "fd_qi-data-2021.04.13.jpk-qi-series"),
          ("fd_spot3-0192", "fd_spot3-0192.jpk-force"),
          ("sr_cell1-0008", "sr_cell1-0008.jpk-force"))


def ball(radius):
    return f'probe = {{ shape = "sphere", radius = "{radius}" }}\n'


def moduli(files, keys):
    """Rows of `modulus`, and of its models, by file as they are told."""
    with tempfile.TemporaryDirectory() as folder:
        manifest, out = (os.path.join(folder, name) for name in ("manifest.toml", "m.csv"))
        with open(manifest, "w", encoding="utf-8") as text:
            text.write('repeats = "keep"\n[defaults]\nposition = ["0 mm", "0 mm", "0 mm"]\n'
                       'normal = [0, 0, -1]\nplausible = ["0.001 Pa", "100 GPa"]\n' + keys)
            for file in files:
                text.write(f'[[recording]]\nfile = "{os.path.abspath(file)}"\n')
        palpate("modulus", manifest, "-o", out)
        return [table(path) for path in (out, out[:-4] + ".models.csv")]


def way_in(curve):
    """Travel of the tip from its first reading, force, and where that reading lies: of the first
    segment that goes in by half of the whole travel."""
    segment, force_N = np.asarray(curve["segment"]), np.asarray(curve["force"])
    tip_m = -(np.asarray(curve["height (measured)"]) +
              force_N / curve.metadata["spring constant"])
    for number in np.unique(segment):
        of = segment == number
        if tip_m[of][-1] - tip_m[of][0] > np.ptp(tip_m) / 2:
            return tip_m[of] - tip_m[of][0], force_N[of], tip_m[of][0]
    sys.exit("a curve has no way in")


def global_fit(travel_m, force_N):
    """Contact and factor of F = b + a (x - c)^1.5."""
    def squares(contact_m):
        bent = np.maximum(0, travel_m - contact_m) ** 1.5
        columns = np.stack([np.ones_like(bent), bent / max(bent.max(), 1e-300)], 1)
        found, *_ = np.linalg.lstsq(columns, force_N, rcond=None)
        return float(np.sum((force_N - columns @ found) ** 2)), found[1] / max(bent.max(), 1e-300)
    low, high = travel_m.min(), travel_m.max()
    for _ in range(6):
        tried = np.linspace(low, high, 401)[:-1]
        best = min(range(len(tried)), key=lambda i: squares(tried[i])[0])
        low, high = tried[max(best - 1, 0)], tried[min(best + 1, len(tried) - 1)]
    return tried[best], squares(tried[best])[1]


def as_csv(folder, name, travel_m, force_N):
    path = os.path.join(folder, name)
    with open(path, "w", encoding="utf-8") as out:
        out.write("d_um,F_nN\n" + "".join(f"{1e6 * d:.7f},{1e9 * f:.9g}\n"
                                          for d, f in zip(travel_m, force_N)))
    return path


def spaced(value):
    return (f"{value:.2f}" if value < 1000 else f"{value:,.0f}").replace(",", " ")


def line(*cells):
    print("| " + " | ".join(cells) + " |")


def published():
    indentation = os.path.join(SHARED, "data", "indentation")
    chiaro = os.path.join(indentation, "fmt-chiaro-txt_AEBP1_Indentation_002.txt")
    spot3, flip = (os.path.join(AFM, "fmt-jpk-fd_" + name + ".jpk-force")
                   for name in ("spot3-0192", "flipsign_2015.05.22-15.31.49.352"))
    print("| recording | model, tip | here | reference | |\n|---|---|---|---|---|")

    def row(name, model, file, keys, tip, reference, value=None):
        rows, models = moduli([file], keys)
        found = next(r for r in models if r["model"] == model)
        E, deviation = float(found["young_Pa"]), float(found["young_deviation_Pa"])
        grade = rows[0]["grade"]
        line(name, f"{model}, {tip}", f"{spaced(E)} ± {spaced(deviation)} Pa" +
             ("" if grade == "good" else f", {grade}"), reference,
             "" if value is None else f"{100 * (E / value - 1):+.2f} %")

    with tempfile.TemporaryDirectory() as folder:
        travel_m, force_N, _ = way_in(afmformats.load_data(spot3)[0])
        alone = as_csv(folder, "spot3.csv", travel_m, force_N)
        near = travel_m > travel_m[-1] - 1.1e-6 - 0.14e-6
        late = as_csv(folder, "late.csv", travel_m[near], force_N[near])
        tenth = ball("10 um")
        body = 'force_on = "body"\n'
        row("Chiaro, AEBP1 indentation 2", "hertz", chiaro, "", "27 µm",
            "117.007 Pa, the instrument", 117.007)
        row("the same", "sphere", chiaro, "", "27 µm", "")
        row("spot3-0192, as the file is", "hertz", spot3, tenth, "10 µm",
            "14 741.96 Pa, nanite, way in alone", 14741.958)
        row("approach alone", "hertz", alone, tenth + body, "10 µm", "14 741.96 Pa, nanite",
            14741.958)
        row("the last micrometre before contact and the press", "hertz", late, tenth + body,
            "10 µm", "14 838.9 Pa, nanite", 14838.9)
        row("approach alone", "hertz", alone, ball("40 nm") + body, "40 nm", "233 100 Pa, JPK",
            233100)
        cone = 'probe = {{ shape = "{}", radius = "1 nm", half_angle = "{} deg" }}\n'
        row("approach alone", "cone", alone, cone.format("cone", 30) + body, "30°",
            "341 176 Pa, nanite's formula by scipy", 341176)
        row("approach alone", "pyramid-3", alone, cone.format("pyramid-3", 20) + body, "20°",
            "387 683 Pa, nanite's formula by scipy", 387683)
        row("flipsign", "hertz", flip, tenth, "10 µm", "5 230 Pa, nanite", 5230)


def small_presses():
    files = [os.path.join(AFM, "fmt-jpk-" + file) for _, file in CURVES]
    rows, models = moduli(files, ball("5 um"))
    print("| file | model | E, Pa | contact, µm | global fit | hertz over it | grade |\n"
          "|---|---|---|---|---|---|---|")
    within = 0
    for name, file in CURVES:
        path = os.path.join(AFM, "fmt-jpk-" + file)
        of = lambda r: os.path.basename(r["file"]).split("#")[0] == os.path.basename(path)
        mine, hertz = [r for r in rows if of(r)], [r for r in models
                                                   if of(r) and r["model"] == "hertz"]
        curves = afmformats.load_data(path)
        for k, curve in enumerate(curves):
            travel_m, force_N, first_m = way_in(curve)
            contact_m, factor = global_fit(travel_m, force_N)
            fit_Pa = 9 / 16 * factor / np.sqrt(5e-6)
            r, ratio = mine[k], float(hertz[k]["young_Pa"]) / fit_Pa
            within += abs(ratio - 1) < 0.03
            line(name + (f" {k}" if len(curves) > 1 else ""), r["model"],
                 f"{float(r['young_Pa']):.4g} ± {float(r['young_deviation_Pa']):.2g}",
                 f"{1e6 * (float(r['contact_m']) - first_m):.3f} ± {1e6 * float(r['contact_deviation_m']):.3f}",
                 f"{1e6 * contact_m:.3f}", f"{ratio:.2f}", r["grade"])
    print(f"\n{within} of {len(rows)} within 3 % of the global fit")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    palpate, SHARED, AFM = Program(os.path.abspath(sys.argv[1])), *sys.argv[2:]
    published()
    print()
    small_presses()
