"""Recordings for vary.py: python3 rigs.py FOLDER SHARED makes two rigs, `faults` with one press for
each fault that a real recording has, and `holds` with a body that relaxes, pressed at two rates; and
a manifest of the silicone compressions in SHARED/data, `compressions`."""
import math
import pathlib
import random
import sys

BALL = '{ shape = "sphere", radius = "5 mm", friction = 0.3 }'


def manifest(folder, places):
    """One recording NAME.csv at each place (x, y) in mm on the surface z = 30 mm."""
    text = f"""surface = "../presses/phantom.off"
length_unit = "mm"
[defaults]
columns = {{ time = "t", depth = "z", force = "F" }}
units = {{ time = "s", position = "mm", force = "N" }}
force_on = "body"
probe = {BALL}
"""
    for name, (x, y) in places.items():
        text += f'[[recording]]\nfile = "rig/{name}.csv"\nposition = [{x}, {y}, 30]\n'
    (folder / "manifest.toml").write_text(text)


def write(folder, name, rows):
    (folder / "rig").mkdir(parents=True, exist_ok=True)
    lines = [f"{t:.4f},{z:.4f},{f:.4f}\n" for t, z, f in rows]
    (folder / "rig" / f"{name}.csv").write_text("t,z,F\n" + "".join(lines))


def press(stiffness=0.2, touch=1.0, top=4.0, rows=400, cycles=1, noise=0.004):
    """Rows (s, mm, N) of Hertz's law, down and up; 15 % less force on the way up."""
    out = []
    for _ in range(cycles):
        for i in range(rows):
            s = i / (rows / 2)
            z = top * (s if s < 1 else 2 - s)
            force = stiffness * max(0, z - touch) ** 1.5 * (1 if s < 1 else 0.85)
            out.append([0.02 * len(out), z, force + random.gauss(0, noise)])
    return out


def faults():
    spikes, stuck = press(), press()
    for i in range(20, 400, 45):
        spikes[i][2] += 0.4
    for i in range(100, 112):
        stuck[i][2] = stuck[100][2]
    yield "spikes", spikes
    yield "coarse_sensor", [[t, z, round(f / 0.05) * 0.05] for t, z, f in press()]
    yield "drift", [[t, z, f + 0.0002 * i + 0.02 * math.sin(4 * z)]
                    for i, (t, z, f) in enumerate(press())]
    yield "stuck", stuck
    yield "adhesion", [[t, z, f - (0.05 if 310 < i < 330 else 0)]
                       for i, (t, z, f) in enumerate(press())]
    yield "cycles", press(cycles=4)
    yield "begins_in_contact", press(touch=-0.05)
    yield "noise", press(noise=0.03)
    yield "noisy_travel", [[t, z + random.gauss(0, 0.02), f] for t, z, f in press()]
    yield "tilted", [[t, z, f + 0.03 * z] for t, z, f in press(touch=2.5, noise=0.01)]
    yield "breaks", [[t, z, f if z < 3.2 else f - (z - 3.2)] for t, z, f in press()]
    yield "few_rows", [[t, z, round(f, 2)] for t, z, f in press()[::6]]
    yield "stiffens", [[t, z, 0.03 * (math.exp(1.1 * max(0, z - 1)) - 1) + random.gauss(0, 0.004)]
                       for t, z, f in press()]
    yield "wrong_sign", press(stiffness=-0.2)


def relaxing(stiffness, touch, speed, dt=0.06, hold=6.0):
    """Prony series with shares 0.3 and 0.2 of 1 s and 8 s; 4 mm deep at `speed` (mm/s)."""
    rows, before, branches = [], 0.0, [0.0, 0.0]
    ramp = 4 / speed
    for i in range(int((2 * ramp + hold) / dt)):
        t = i * dt
        z = min(speed * t, 4.0) if t < ramp + hold else max(0.0, 4 - speed * (t - ramp - hold))
        slow = stiffness * max(0, z - touch) ** 1.5
        for j, (share, tau) in enumerate(((0.3, 1.0), (0.2, 8.0))):
            a = math.exp(-dt / tau)
            branches[j] = a * branches[j] + share * (tau / dt) * (1 - a) * (slow - before)
        before = slow
        rows.append((t, z, max(0, slow + sum(branches)) + random.gauss(0, 0.004)))
    return rows


def compressions(folder, shared):
    folder.mkdir(parents=True, exist_ok=True)
    text = """[defaults]
force_on = "body"
normal = [0, 0, -1]
probe = { shape = "flat", radius = "25 mm" }
"""
    for file in sorted(pathlib.Path(shared, "data/compression").resolve().glob("EF10*.csv")):
        point, x = ("EF100", 90) if "100T" in file.name else ("EF50", 0)
        text += f'[[recording]]\nfile = "{file}"\npoint = "{point}"\n'
        text += f'position = ["{x} mm", "0 mm", "0 mm"]\n'
    (folder / "manifest.toml").write_text(text)


if __name__ == "__main__":
    root = pathlib.Path(sys.argv[1])
    random.seed(7)
    places = {}
    for k, (name, rows) in enumerate(faults()):
        write(root / "faults", name, rows)
        places[name] = (20 + 10 * (k % 5), 20 + 15 * (k // 5))
    manifest(root / "faults", places)
    places = {}
    for k, (place, speed) in enumerate((p, v) for p in ((30, 30), (50, 50)) for v in (4.0, 0.8)):
        write(root / "holds", f"p{k}", relaxing(0.16, 0.6 + 0.05 * k, speed))
        places[f"p{k}"] = place
    manifest(root / "holds", places)
    compressions(root / "compressions", sys.argv[2])
