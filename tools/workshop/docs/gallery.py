"""docs/scenes.md out of the shipped scenes and docs/validation.md: gallery.py; --check compares it.

A scene's first lines say what it is; what it shows are those keys that at most two scenes have. Figures are
those of the row or the section of docs/validation.md that names the scene.
"""
import collections
import pathlib
import re
import sys
import tomllib

ROOT = pathlib.Path(__file__).parents[3]
SCENES = sorted((ROOT / "data/scenes").glob("*.toml"))
VALIDATION = (ROOT / "docs/validation.md").read_text()


def keys(scene):
    """The names a scene uses, as section.key; of nested tables of materials the keys, too."""
    for section, tables in tomllib.loads(scene.read_text()).items():
        for table in tables if isinstance(tables, list) else [tables]:
            for key in table:
                yield f"{section}.{key}"


def about(scene):
    """The first sentence above the first table, which says what the scene is."""
    head = re.match(r"(?:#.*\n)+", scene.read_text())[0].replace("# ", "").replace("\n", " ")
    sentences = re.split(r"(?<=[.;]) ", head.strip())
    kept = [s for s in sentences if not re.search(r"Costs|minutes|Made by|coordinates are|then set|saves it", s)]
    return kept[0].rstrip(";,.")


def figures(scene):
    """p95 and CPU of the scene's row; else a link to the section that names it."""
    for line in VALIDATION.splitlines():
        cells = [cell.strip() for cell in line.strip("|").split("|")]
        if f"`{scene.name}`" in cells[0] and len(cells) > 8:
            p95 = re.search(r"/ ([0-9.]+) /", cells[2])[1]
            return f"{p95} % | {re.sub('[^0-9]', '', cells[8][:4])} s"
    section = ""
    for line in VALIDATION.splitlines():
        if line.startswith("#"):
            section = line.lstrip("# ")
        elif scene.name in line:
            return f"[{section.lower()}](validation.md#{section.lower().replace(' ', '-')}) | "
    return " | "


used = {scene: set(keys(scene)) for scene in SCENES}
times = collections.Counter(key for names in used.values() for key in names)
lines = ["""# Scenes to start from

`tools/workshop/docs/gallery.py` makes this page. Copy a scene, name your mesh, and keep what it shows. A [scene](formats/scene.md) for a mesh of your own is proposed by `palpate new`. Errors (19 of 20 forces are off by less) and CPU time are those of [validation](validation.md#assets).

| scene | what it is | keys that few others have | error | CPU |
|---|---|---|---|---|"""]
for scene in SCENES:
    rare = ", ".join(f"`{key}`" for key in sorted(used[scene], key=lambda key: (times[key], key)) if times[key] <= 2)
    lines.append(f"| [{scene.stem}](../data/scenes/{scene.name}) | {about(scene)} | {rare} | {figures(scene)} |")
page, text = ROOT / "docs/scenes.md", "\n".join(lines) + "\n"
if "--check" in sys.argv:
    sys.exit(None if page.read_text() == text else "docs/scenes.md: gallery.py writes another one")
page.write_text(text)
