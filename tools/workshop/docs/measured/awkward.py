#!/usr/bin/env python3
"""Awkward recordings, and what `import` says of each.

    python3 tools/workshop/docs/measured/awkward.py PALPATE docs/measured/awkward.md

PALPATE: the program. Presses of a ball of 5 mm on 10 kPa (incompressible; Sneddon), 3 mm deep after
2 mm of free travel at 2 mm/s and out again, 200 readings a second, noise of 2 mN, each with one
thing that rigs do. Silent is a recording whose apparent modulus is off by more than 10 % and of which
`import` says nothing, though it can be seen in it. Ends with status 1 where one is. Needs
python3-numpy.
"""
import gzip
import os
import sys
import tempfile

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import Program, table

RADIUS_M, YOUNG_PA, HZ, SPEED_M_S, FREE_M, DEPTH_M = 5e-3, 1e4, 200, 2e-3, 2e-3, 3e-3
KEYS = 'probe = { shape = "sphere", radius = "5 mm" }\n'


ANGLE = np.linspace(0, 1.2, 4001)  # artanh of the contact's radius over the ball's
DEPTH, AREA = (RADIUS_M * np.tanh(ANGLE) * ANGLE,
               RADIUS_M ** 2 * ((np.tanh(ANGLE) ** 2 + 1) * ANGLE - np.tanh(ANGLE)))


def ball(depth_m):
    """Sneddon's sphere (1965)."""
    return YOUNG_PA / 0.75 * np.interp(depth_m, DEPTH, AREA)


class Press:
    """Time, travel and force of a press; `change` edits them."""

    def __init__(self, seed, hold_s=0, hz=HZ, cycles=1, free_m=FREE_M, noise_N=2e-3):
        way_s = (free_m + DEPTH_M) / SPEED_M_S
        count = int(round((cycles * (2 * way_s + hold_s)) * hz)) + 1
        self.t = np.arange(count) / hz
        phase = self.t % (2 * way_s + hold_s)
        self.d = SPEED_M_S * np.clip(np.minimum(phase, 2 * way_s + hold_s - phase), 0, way_s)
        self.random = np.random.default_rng(seed)
        self.free_m = free_m
        self.f = ball(self.d - free_m) + noise_N * self.random.standard_normal(count)

    def text(self, header="t_s,depth_mm,force_N", depth=1e3, force=1.0, form="{:.5f},{:.6f},{:.6f}"):
        rows = (form.format(*row) for row in zip(self.t, depth * self.d, force * self.f))
        return header + "\n" + "\n".join(rows) + "\n"


def edited(change, **settings):
    def make(seed):
        press = Press(seed, **settings)
        change(press)
        return press.text()
    return make


def slow_noise(press, share):
    n = len(press.t)
    spectrum = np.fft.rfft(press.random.standard_normal(n))
    spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))
    spectrum[0] = 0
    noise = np.fft.irfft(spectrum, n)
    press.f += share * press.f.max() * noise / noise.std()


def step(p):
    p.f += np.where(p.d > 4e-3, 0.06 * p.f.max(), 0)


def soft_saturation(p):
    p.f = 0.8 * p.f.max() * np.tanh(p.f / (0.8 * p.f.max()))


def saturated(p):
    p.f = np.minimum(p.f, 0.5 * p.f.max())


def stiff_below(p):
    p.f += ball(p.d - p.free_m) * np.maximum(p.d - p.free_m, 0) / DEPTH_M


def unipolar(p):
    p.f = np.maximum(p.f - 2e-3, 0)


def spike(p):
    p.f[np.argmax(p.d) // 2] += 3 * p.f.max()


def burst(p):
    at = int(0.7 * np.argmax(p.d))
    p.f[at:at + HZ // 10] = -0.1 * p.f.max()


def softer_cycle(p):
    p.f[len(p.t) // 2:] *= 0.8


def drift(p):
    p.f += 0.1 * p.f.max() * p.t / p.t[-1]


def waves(p):
    p.f += 0.02 * p.f.max() * np.sin(2 * np.pi * p.d / 1e-3)


def coarse(p):
    step_N = p.f.max() / 30
    p.f = step_N * np.round(p.f / step_N)


def late(p):
    p.f = np.interp(p.t - 0.1, p.t, p.f)


def adhesive(p):
    back = np.arange(len(p.t)) > np.argmax(p.d)
    p.f -= np.where(back & (p.d > 1e-3), 0.1 * p.f.max() * np.clip((p.d - 1e-3) / 1e-3, 0, 1), 0)


def compliant(p):
    p.d += p.f * 2e-3


def tare(p):
    p.f[:HZ // 2] += 0.2 * p.f.max()


def both_negative(p):
    p.d, p.f = -p.d, -p.f


def reversed_force(p):
    p.f = -p.f


def swapped(p):
    p.d, p.f = 1e-3 * p.f, 1e3 * p.d


def flat(p):
    p.f = np.full(len(p.t), 0.1)


def noise_alone(p):
    p.f = 2e-3 * p.random.standard_normal(len(p.t))


def only_out(p):
    begin = np.argmax(p.d)
    p.t, p.d, p.f = p.t[begin:], p.d[begin:], p.f[begin:]


def stamps_repeat(p):
    p.t[len(p.t) // 3] = p.t[len(p.t) // 3 - 1]


def clock_back(p):
    p.t[len(p.t) // 3:] -= 0.5


def gap(p):
    keep = (p.d < 3.2e-3) | (p.d > 4e-3)
    p.t, p.d, p.f = p.t[keep], p.d[keep], p.f[keep]


def yields(p):
    p.f = np.where(p.d > 4e-3, 0.6 * p.f, p.f)


def creeps(p):
    held = p.d >= FREE_M + DEPTH_M - 1e-9
    since_s = np.maximum(p.t - p.t[np.argmax(held)], 0)
    sunk = 0.15 * (1 - np.exp(-since_s / 3))
    last = len(held) - 1 - np.argmax(held[::-1])
    sunk[last:] = sunk[last]  # out as deep in shares
    p.d = np.where(p.d > FREE_M, FREE_M + (p.d - FREE_M) * (1 + sunk), p.d)


def nothing(_):
    pass


def replaced(old, new):
    return lambda seed: Press(seed).text().replace(old, new)


def lines_of(change):
    def make(seed):
        lines = Press(seed).text().splitlines()
        change(lines)
        return "\n".join(lines) + "\n"
    return make


def word(lines):
    lines[300] = lines[300].rsplit(",", 1)[0] + ",overload"


def short_row(lines):
    lines[300] = lines[300].rsplit(",", 1)[0]


def axes_text(seed, jitter_mm=0.0, lean_deg=0.0):
    press = Press(seed)
    lean = np.radians(lean_deg)
    along = np.array([np.sin(lean), 0, -np.cos(lean)])
    at = np.outer(1e3 * press.d, along) + jitter_mm * press.random.standard_normal((len(press.t), 3)) * [1, 1, 0]
    force = np.outer(press.f, along)
    rows = [",".join(f"{v:.6f}" for v in (t, *a, *f)) for t, a, f in zip(press.t, at, force)]
    return "t_s,x_mm,y_mm,z_mm,fx_N,fy_N,fz_N\n" + "\n".join(rows) + "\n"


# Name, the file's bytes or text by its seed, keys of its entry beside the ball.
CASES = [
    ("as it should be", edited(nothing), ""),
    ("forces in mN, said to be N", lambda s: Press(s).text(force=1e3), ""),
    ("depths in µm, said to be mm", lambda s: Press(s).text(depth=1e6), ""),
    ("depth and force negative", edited(both_negative), ""),
    ("force of the other sign", edited(reversed_force), ""),
    ("columns swapped", edited(swapped), ""),
    ("units not said", replaced("t_s,depth_mm,force_N", "t,depth,force"), ""),
    ("grams", lambda s: Press(s).text(header="t_s,depth_mm,force (g)", force=1e3 / 9.80665), ""),
    ("decimal commas", lambda s: Press(s).text().replace(",", ";").replace(".", ","), ""),
    ("UTF-16", lambda s: Press(s).text().encode("utf-16"), ""),
    ("latin-1 in a comment", lambda s: b"# Kraft in N, Weg 5 \xb5m\n" + Press(s).text().encode(), ""),
    ("packed with gzip", lambda s: gzip.compress(Press(s).text().encode(), mtime=0), ""),
    ("ends in the middle of a row", lambda s: Press(s).text()[:20000], ""),
    ("a word among the numbers", lines_of(word), ""),
    ("a row too short", lines_of(short_row), ""),
    ("header alone", lambda s: "t_s,depth_mm,force_N\n", ""),
    ("empty", lambda s: "", ""),
    ("a time stamp repeats", edited(stamps_repeat), ""),
    ("the clock goes back", edited(clock_back), ""),
    ("readings missing in the press", edited(gap), ""),
    ("25 readings", edited(nothing, hz=5), ""),
    ("10 kHz", edited(nothing, hz=10000), ""),
    ("begins in contact", edited(nothing, free_m=0.0), ""),
    ("way out alone", edited(only_out), ""),
    ("way out alone, with `use`", edited(only_out), 'use = "retract"\n'),
    ("no contact: noise", edited(noise_alone), ""),
    ("no contact: a constant force", edited(flat), ""),
    ("noise of 0.1 N", edited(nothing, noise_N=0.1), ""),
    ("1/f of 3 %", edited(lambda p: slow_noise(p, 0.03)), ""),
    ("drift of 10 %", edited(drift), ""),
    ("drift of 10 %, with `drift`", edited(drift), 'drift = "line"\n'),
    ("waves of 2 %", edited(waves), ""),
    ("sensor of 30 steps", edited(coarse), ""),
    ("sensor without negative readings", edited(unipolar), ""),
    ("saturated at half", edited(saturated), ""),
    ("soft saturation", edited(soft_saturation), ""),
    ("one reading of three times the force", edited(spike), ""),
    ("a burst of 0.1 s", edited(burst), ""),
    ("force 0.1 s late", edited(late), ""),
    ("force 0.1 s late, with `force_delay`", edited(late), 'force_delay = "100 ms"\n'),
    ("tared after half a second", edited(tare), ""),
    ("a rig that gives 2 mm/N", edited(compliant), ""),
    ("a rig that gives 2 mm/N, with `compliance`", edited(compliant), "compliance = 2e-3\n"),
    ("a step of 6 % in the press", edited(step), ""),
    ("the tool breaks in", edited(yields), ""),
    ("a stiff layer below", edited(stiff_below), ""),
    ("adhesion on the way out", edited(adhesive), ""),
    ("two cycles, the second 20 % softer", edited(softer_cycle, cycles=2), ""),
    ("held force: creep", edited(creeps, hold_s=10), ""),
    ("three axes, jitter of 0.1 mm", lambda s: axes_text(s, jitter_mm=0.1), ""),
    ("three axes, lean of 10 degrees", lambda s: axes_text(s, lean_deg=10), ""),
    ("a ball of 5 µm, said", edited(nothing), 'probe = { shape = "sphere", radius = "5 um" }\n'),
    ("a ball of 50 mm, said", edited(nothing), 'probe = { shape = "sphere", radius = "50 mm" }\n'),
    ("a cone, said", edited(nothing), 'probe = { shape = "cone", half_angle = "60 deg" }\n'),
]


# Another body would make the same recording.
CANNOT_BE_SEEN = {"a rig that gives 2 mm/N", "a ball of 50 mm, said", "soft saturation",
                  "a stiff layer below"}


def first_row(path):
    return next(iter(table(path)), {}) if os.path.exists(path) else {}


def short(text):
    return text.replace("|", "\\|").replace("\n", " ")


def tried(name, make, keys, number, folder):
    content = make(1000 + number)
    path = os.path.join(folder, "a.csv" + (".gz" if name.startswith("packed") else ""))
    with open(path, "wb") as out:
        out.write(content if isinstance(content, bytes) else content.encode())
    manifest = os.path.join(folder, "manifest.toml")
    with open(manifest, "w", encoding="utf-8") as out:
        out.write(f'[[recording]]\nfile = "{os.path.basename(path)}"\nforce_on = "body"\n'
                  f'position = ["0 mm", "0 mm", "0 mm"]\nnormal = [0, 0, -1]\n'
                  f'{"" if "probe" in keys else KEYS}{keys}')
    samples = os.path.join(folder, "samples.h5")
    imported = palpate.tried("import", manifest, "-o", samples, "--force")
    row = first_row(os.path.join(folder, "samples.import.csv"))
    notes = [line[len("note: "):] for line in imported.stderr.splitlines() if line.startswith("note: ")]
    is_right, young = True, ""
    if row.get("status") != "imported":
        answer = "refused: " + (row.get("reason") or imported.stderr.strip().splitlines()[-2])
        is_said = True
    else:
        said = "; ".join([part for part in [row["reason"], *notes] if part])
        is_said = row["grade"] != "good" or bool(said)
        answer = row["grade"] + (": " + said if said else "")
        if row["young_Pa"]:
            young = f"{float(row['young_Pa']) / 1e3:.3g}"
            is_right = abs(float(row["young_Pa"]) - YOUNG_PA) < 0.1 * YOUNG_PA
    for leftover in os.listdir(folder):
        os.remove(os.path.join(folder, leftover))
    return answer, young, is_right or is_said


def main():
    silent, rows, plain, count = [], [], [], 0
    with tempfile.TemporaryDirectory() as folder:
        for number, (name, make, keys) in enumerate(CASES):
            answer, young, is_spoken = tried(name, make, keys, number, folder)
            count += 1
            if answer == "good":
                plain.append(f"{name} ({young or 'none'})")
            else:
                rows.append(f"| {name} | {short(answer)} | {young} |")
            if not is_spoken and name not in CANNOT_BE_SEEN:
                silent.append(name)
    head = __doc__.split("\n\n")
    with open(OUTPUT, "w", encoding="utf-8") as out:
        out.write("# Awkward recordings\n\n`python3 tools/workshop/docs/measured/awkward.py PALPATE "
                  "docs/measured/awkward.md` writes this page. " + " ".join(head[2].split())
                  .replace("PALPATE: the program. ", "")
                  .replace(" Ends with status 1 where one is. Needs python3-numpy.", "") +
                  "\n\n| recording | `import` | apparent modulus, kPa |\n|---|---|---|\n" +
                  "\n".join(rows) + "\n\nGood without a word, apparent modulus in kPa: " +
                  "; ".join(plain) + ".\n\n" +
                  f"{count} recordings, {len(silent)} silent{': ' if silent else ''}{', '.join(silent)}.\n")
    print(f"{count} recordings, {len(silent)} silent: {', '.join(silent) or 'none'}")
    sys.exit(1 if silent else 0)


if __name__ == "__main__":
    palpate, OUTPUT = Program(os.path.abspath(sys.argv[1])), sys.argv[2]
    main()
