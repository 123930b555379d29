"""What half and twice of each named constant change.

    git worktree add COPY; python3 vary.py instrument COPY
    cmake -S COPY -B COPY/build/release -DCMAKE_BUILD_TYPE=Release \\
      -DCMAKE_CXX_FLAGS="-include $PWD/tune.hpp"; ninja -C COPY/build/release palpate
    python3 rigs.py RIGS SHARED; python3 COPY/docs/tutorial/presses.py RIGS/presses
    palpate run COPY/data/scenes/block.toml --quick -o RIGS/block     (fibre_block, cylinder,
                                                   lying_capsule as well; by COPY's program)
    python3 vary.py measure COPY SUITE RIGS >> measured.jsonl      (one suite after the other)
    python3 vary.py table . measured.jsonl > docs/bench/constants.csv

A change counts in deviations of the figure that it moves: of a contact point the one that import
states, of a p95 a quarter of its 95 % interval, else a share of the figure (SHARES). Constants are
varied in groups; a group that moves a figure by more than a tenth of its deviation is halved.
"""
import csv
import json
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np

TYPES = ("double|float|int|unsigned|Eigen::Index|std::size_t|std::int64_t|std::uint64_t|"
         "std::ptrdiff_t")
STATEMENT = re.compile(r"((?:\b(?:inline|static) )*)constexpr (static )?(%s) "
                       r"(k[A-Z][^;{}\[\]]*);" % TYPES)
LITERAL = re.compile(r"^[\s0-9eE.+\-*/()xu']+$")
SHARES = {"force": 0.03, "median": 0.15, "p95": 0.3, "mesh": 0.3, "scene": 0.1}
SUITES = {"recordings": r"libfit/recordings/(?!relaxation)|tools/manifest",
          "relaxation": r"libfit/recordings/relaxation",
          "setup": r"tools/(setup|scene|commands)",
          "meshes": r"libfem/(mesh|probes)|tools/stages/body",
          "presses": r"libfem/(?!mesh/(fill|read|repair)|calibrate)|libfit/experiments",
          "assets": r"libfit/(fit|refine|core|shape|validation|certify|runtime|io)"}
GROUP = 8


def sources(root):
    listed = subprocess.check_output(["git", "-C", root, "ls-files", "libfem", "libfit", "tools"],
                                     text=True).split()
    return {f: pathlib.Path(root, f).read_text() for f in listed
            if re.search(r"\.(cpp|hpp|h)$", f) and "workshop" not in f and f[-9:] != "palpate.h"}


def parts(names):
    """`kA = f(1, 2), kB = 3` at the commas outside brackets."""
    return re.split(r",(?![^()<>]*[)>])", names)


def constants(root):
    """(file, name, literal) of each named numeric constant."""
    for file, text in sources(root).items():
        for match in STATEMENT.finditer(re.sub(r"//[^\n]*", "", text)):
            for part in parts(match[4]):
                name, _, value = part.partition("=")
                if LITERAL.match(value):
                    yield file, name.strip(), " ".join(value.split())


def instrument(root):
    """Makes each constant that no type, case or other constant needs one that tune.hpp reads."""
    texts = sources(root)
    bare = {f: re.sub(r"//[^\n]*", "", t) for f, t in texts.items()}
    whole = "\n".join(bare.values())

    def is_needed_early(file, name):
        scope = whole if file.endswith(".hpp") else bare[file]
        return any(re.search(p % name, scope) for p in (
            r"\[\s*[^\]\n;]*\b%s\b[^\]\n;]*\]\s*(?:;|=|\{|,|\))", r"<[^<>;\n()&|]*\b%s\b[^<>;\n]*>",
            r"case %s\b", r"static_assert\([^;]*\b%s\b", r"constexpr [^;=]*=[^;]*\b%s\b(?!\s*=)",
            r"\{\{[^;]*\b%s\b[^;]*\}\};"))

    for file, text in texts.items():
        def replaced(match):
            before, in_class, kind, names = match.groups()
            known, tuned = [], []
            for part in parts(names):
                name, _, value = (x.strip() for x in part.partition("="))
                value = re.sub(r"//[^\n]*", "", value).strip()
                fixed = not LITERAL.match(value) or is_needed_early(file, name)
                (known if fixed else tuned).append((name, value))
            own = "inline" if file.endswith(".hpp") else "static"
            if in_class or ("static" in before and file.endswith(".hpp")):
                own = "static inline"
            out = [f"{before}constexpr {in_class or ''}{kind} {n} = {v};" for n, v in known]
            out += [f'{own} const {kind} {n} = palpate_tune::tune<{kind}>("{file}:{n}", {v});'
                    for n, v in tuned]
            return " ".join(out) if tuned else match[0]

        new = STATEMENT.sub(replaced, text)
        if new != text:
            pathlib.Path(root, file).write_text(new)


class Stuck(Exception):
    pass


class Program:
    def __init__(self, root, rigs):
        self.path = os.path.join(root, "build/release/tools/palpate")
        self.scenes = os.path.join(root, "data/scenes")
        self.shared = os.path.join(root, "../shared")
        self.rigs = rigs
        self.folder = tempfile.mkdtemp(prefix="vary-")
        self.figures = {}

    def run(self, name, tuned, *arguments):
        bound = (4 << 30, 4 << 30)  # a constant out of range must not take the machine's memory
        environment = dict(os.environ, OMP_NUM_THREADS="1", PALPATE_TUNE=tuned)
        try:
            done = subprocess.run([self.path, *arguments], env=environment, cwd=self.folder,
                                  capture_output=True, timeout=60,
                                  preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, bound))
        except subprocess.TimeoutExpired:
            raise Stuck from None
        self.figures[name + " status"] = (done.returncode, 0)

    def set(self, name, value, deviation):
        self.figures[name] = (float(value), abs(float(deviation)))

    def samples(self, name, path):
        try:
            force = np.linalg.norm(h5py.File(path)["rows/force"][...], axis=1)
        except OSError:
            return
        self.set(name + " rows", len(force), 0)
        for i, value in enumerate(force):
            self.set(f"{name} row {i}", value, SHARES["force"] * max(value, 0.1 * force.max()))

    def imported(self, name, manifest, tuned):
        self.run(name, tuned, "import", manifest, "-o", f"{name}.h5")
        self.samples(name, os.path.join(self.folder, f"{name}.h5"))
        try:
            with open(os.path.join(self.folder, f"{name}.import.csv"), encoding="utf-8") as file:
                rows = list(csv.DictReader(file))
        except OSError:
            return
        for i, row in enumerate(rows):
            grades = ["", "good", "fair", "poor", "refused"]
            self.set(f"{name} grade {i}", grades.index(row["grade"]), 0)
            if row["contact_m"]:
                deviation_m = row["contact_deviation_m"] or 1e-5
                self.set(f"{name} contact {i}", row["contact_m"], deviation_m)

    def statement(self, name, path):
        try:
            error = json.loads(pathlib.Path(path).read_text())["force_error"]
        except OSError:
            return
        spread = error["p95_rel_high"] - error["p95_rel_low"]
        self.set(name + " p95", error["p95_rel"], max(spread, 0.2 * error["p95_rel"]) / 3.92)
        self.set(name + " median", error["median_rel"], SHARES["median"] * error["median_rel"])

    def measure(self, suite, tuned):
        """Figures of a suite: {name: (value, deviation)}."""
        self.figures = {}
        shutil.rmtree(self.folder)
        os.mkdir(self.folder)
        try:
            getattr(self, suite)(tuned)
        except Stuck:
            return {"stuck": (1, 0)}
        return self.figures

    def recordings(self, tuned):
        for rig in ("presses", "faults", "compressions"):
            self.imported(rig, os.path.join(self.rigs, rig, "manifest.toml"), tuned)
        for path in sorted(pathlib.Path(self.shared, "cases/odd").glob("*.toml")):
            self.imported(path.stem, str(path), tuned)

    def relaxation(self, tuned):
        self.imported("holds", os.path.join(self.rigs, "holds/manifest.toml"), tuned)

    def setup(self, tuned):
        for path in sorted(pathlib.Path(self.shared, "data/surfaces").glob("*.o*")):
            self.run(path.stem, tuned, "new", str(path), "-o", path.stem + ".toml")
            made = pathlib.Path(self.folder, path.stem + ".toml")
            text = re.sub(r"#.*", "", made.read_text()) if made.exists() else ""
            for i, number in enumerate(re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", text)):
                self.set(f"{path.stem} number {i}", number, SHARES["scene"] * float(number))

    def meshes(self, tuned):
        elephant = os.path.join(self.shared, "data/surfaces/cgal_elephant-with-holes.off")
        self.run("new", "", "new", elephant, "-o", "elephant.toml")
        for scene in ("liver", "breast", "clot", "elephant"):
            folder = self.folder if scene == "elephant" else self.scenes
            self.run(scene, tuned, "prepare", f"{folder}/{scene}.toml", "-o", scene + ".h5")

            def visit(name, data, scene=scene):
                if isinstance(data, h5py.Dataset) and data.dtype.kind in "fi" and data.size:
                    total = np.abs(np.nan_to_num(np.asarray(data[...], float))).sum()
                    self.set(f"{scene} {name}", total, SHARES["mesh"] * total)
                    self.set(f"{scene} numbers of {name}", data.size, SHARES["mesh"] * data.size)

            made = os.path.join(self.folder, scene + ".h5")
            if os.path.exists(made):
                h5py.File(made).visititems(visit)

    def presses(self, tuned):
        for scene, place in (("block", "0.03,0.03,0.04"), ("fibre_block", "0.03,0.03,0.04"),
                             ("cylinder", "0.02211827,0.02026766,0.02045455")):
            pathlib.Path(self.folder, "place.csv").write_text("x_m,y_m,z_m\n" + place + "\n")
            self.run(scene, tuned, "simulate", f"{self.rigs}/{scene}/body.h5", "--points",
                     "place.csv", "-o", scene + ".h5")
            self.samples(scene, os.path.join(self.folder, scene + ".h5"))

    def assets(self, tuned):
        """From finished runs in RIGS/SCENE, whose samples and reference are taken as they are."""
        for scene in ("block", "cylinder", "lying_capsule"):
            out = os.path.join(self.folder, scene)
            shutil.copytree(os.path.join(self.rigs, scene), out)
            for file in ("curves.h5", "model.h5", "asset.palp", "statement.json"):
                os.remove(os.path.join(out, file))
            self.run(scene, tuned, "run", f"{self.scenes}/{scene}.toml", "--quick", "-o", out)
            self.statement(scene, os.path.join(out, "statement.json"))


def moved(base, now):
    """Largest change in deviations, and the figure that changes so."""
    worst = (0.0, "")
    for name in sorted(base.keys() | now.keys()):
        was, deviation = base.get(name, (np.nan, 0))
        value = now.get(name, (np.nan, 0))[0]
        if was != value and not (np.isnan(was) and np.isnan(value)):
            change = abs(was - value) / deviation if deviation > 0 else np.inf
            worst = max(worst, (np.nan_to_num(change, nan=1e9, posinf=1e9), name))
    return worst


def measure(root, suite, rigs):
    program = Program(root, rigs)
    base = program.measure(suite, "")
    tuned = re.findall(r'tune<[^>]*>\("([^"]+)"', "".join(sources(root).values()))
    names = [n for n in tuned if re.match(SUITES[suite], n)]

    def vary(group, factor):
        now = program.measure(suite, ",".join(f"{n}={factor}" for n in group))
        change, figure = moved(base, now)
        if change > 0.1 and len(group) > 1:
            half = len(group) // 2
            vary(group[:half], factor)
            vary(group[half:], factor)
            return
        for name in group:
            print(json.dumps({"name": name, "factor": factor, "change": change, "figure": figure,
                              "was": base.get(figure, (None,))[0],
                              "now": now.get(figure, (None,))[0]}), flush=True)

    for i in range(0, len(names), GROUP):
        vary(names[i:i + GROUP], 0.5)
        vary(names[i:i + GROUP], 2)


def table(root, measured):
    """CSV of the constants of the code that move a figure."""
    results = {}
    for line in pathlib.Path(measured).read_text().splitlines():
        row = json.loads(line)
        results.setdefault(row["name"], {}).setdefault(row["factor"], []).append(row)
    out = csv.writer(sys.stdout, lineterminator="\n")
    out.writerow(["file", "name", "value", "half", "twice"])
    for file, name, value in constants(root):
        rows = results.get(f"{file}:{name}", {})
        said = []
        for factor in (0.5, 2):
            worst = max(rows.get(factor, []), key=lambda r: r["change"], default=None)
            if worst is None:
                break
            same = worst["change"] <= 0.1
            numbers = [f"{v:.3g}" if isinstance(v, float) else "none"
                       for v in (worst["was"], worst["now"])]
            said.append("same" if same else f"{worst['figure']} {numbers[0]} to {numbers[1]}")
        if len(said) == 2:
            out.writerow([file, name, value, *said])


if __name__ == "__main__":
    {"instrument": instrument, "measure": measure, "table": table}[sys.argv[1]](*sys.argv[2:])
