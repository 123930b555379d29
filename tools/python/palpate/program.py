"""The program's commands: in a process of their own, answered as dicts."""
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from contextlib import contextmanager

from .files import Error, statement, write_samples

_FILE_KEYS = ("surface", "tetmesh", "mesh", "test_points")


def program():
    """Path of `palpate`: $PALPATE_PROGRAM, bin/ of the prefix this package is installed in, or PATH."""
    given = os.environ.get("PALPATE_PROGRAM")
    here = os.path.dirname(os.path.abspath(__file__))
    beside = os.path.normpath(os.path.join(here, *[os.pardir] * 4, "bin", "palpate"))
    found = given or (beside if os.access(beside, os.X_OK) else shutil.which("palpate"))
    if not found:
        raise Error("palpate", "the program is not installed beside this module, nor in PATH",
                    "Install the package palpate, or set PALPATE_PROGRAM.")
    return found


def command(name, *arguments, **options):
    """Runs `palpate NAME ARGUMENTS --OPTION VALUE ...` and returns its answer (--json) as a dict.

    options: jobs=1 is --jobs 1, quick=True is --quick; None and False are left out, lists joined by
    commas. A dict among the arguments is a scene, as scene.toml has it (files named from the current
    folder), or samples (`write_samples`). What the program says goes to sys.stderr, unless
    quiet=True. Its exit status is under "exit_status": 0, or 3 where something asked for failed
    ("failures").
    Error where input or surroundings are bad, ValueError on wrong usage; KeyboardInterrupt once the
    program has kept what is done.
    """
    words = [program(), name]
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile("w+", encoding="utf-8") as answer:
        words += [_as_file(argument, folder, i) for i, argument in enumerate(arguments)]
        for key, value in options.items():
            flag = "--" + key.rstrip("_").replace("_", "-")
            if value is True:
                words.append(flag)
            elif value is not None and value is not False:
                words += [flag, ",".join(map(str, value)) if isinstance(value, (list, tuple)) else str(value)]
        # A session of its own: an interrupt reaches it once, from here.
        process = subprocess.Popen(words + ["--json"], stdin=subprocess.DEVNULL, stdout=answer,
                                   stderr=subprocess.PIPE, text=True, start_new_session=True)
        with _ended(process):
            said = []
            for line in process.stderr:
                said.append(line)
                if not options.get("quiet"):
                    sys.stderr.write(line)
            process.wait()
        answer.seek(0)
        text = answer.read()
    reply = json.loads(text) if text else {}
    if process.returncode in (0, 3):
        return {**reply, "exit_status": process.returncode}
    if process.returncode == 130:
        raise KeyboardInterrupt(reply.get("interrupted", ""))
    if process.returncode == 2:
        raise ValueError("".join(said).strip())
    errors = reply.get("errors") or [{"where": name, "what": f"ended with status {process.returncode}"}]
    raise Error(errors[0]["where"], errors[0]["what"], errors[0].get("remedy", ""))


@contextmanager
def _ended(process):
    """Interrupts the process where the caller is, and waits until it has kept what is done."""
    try:
        yield
    except BaseException:
        process.send_signal(signal.SIGINT)
        process.communicate()
        raise
    finally:
        process.stderr.close()


def run(scene, output, **options):
    """All stages from a scene (a dict, or the path of a scene.toml) to an asset in the folder `output`,
    going on where it was interrupted; options of `palpate run`: quick, jobs, force. Returns the error
    statement."""
    os.makedirs(os.path.dirname(os.path.abspath(output)), exist_ok=True)
    command("run", scene, output=output, **options)
    return statement(output)


def fit(samples, output, **options):
    """Curves of samples (a dict of arrays, or a path) into the file `output`; options of `palpate fit`,
    such as degree=3. Returns them as `curves` does."""
    from .files import curves
    command("fit", samples, output=output, **options)
    return curves(output)


def _as_file(argument, folder, number):
    if not isinstance(argument, Mapping):
        return os.fspath(argument)
    if any(name.startswith("rows/") for name in argument):
        path = os.path.join(folder, f"samples{number}.h5")
        write_samples(path, argument)
    else:
        path = os.path.join(folder, "scene.toml")
        with open(path, "w", encoding="utf-8") as file:
            file.write(toml(_from_here(argument)))
    return path


def _from_here(value, key=None):
    if isinstance(value, Mapping):
        return {name: _from_here(item, name) for name, item in value.items()}
    is_file = key in _FILE_KEYS and isinstance(value, (str, os.PathLike))
    if is_file and value not in ("auto", "vertices") and not str(value).startswith("$"):
        return os.path.abspath(value)
    return value


def toml(scene):
    """A dict as TOML. Texts carry units as in a scene ("12 mm"); numbers are SI."""
    def value(item):
        if isinstance(item, Mapping):
            return "{ " + ", ".join(f"{json.dumps(k)} = {value(v)}" for k, v in item.items()) + " }"
        if isinstance(item, (bool, str)):
            return json.dumps(item, ensure_ascii=False).replace("\x7f", "\\u007f")
        if isinstance(item, os.PathLike):
            return value(os.fspath(item))
        if hasattr(item, "tolist"):  # NumPy's arrays and numbers
            return value(item.tolist())
        if isinstance(item, (list, tuple)):
            return "[" + ", ".join(map(value, item)) + "]"
        if isinstance(item, (int, float)):
            return repr(item)
        raise TypeError(f"a scene holds no {type(item).__name__}")

    plain = [f"{json.dumps(k)} = {value(v)}" for k, v in scene.items() if not isinstance(v, Mapping)]
    tables = [f"\n[{json.dumps(k)}]\n" + "\n".join(f"{json.dumps(n)} = {value(v)}" for n, v in t.items())
              for k, t in scene.items() if isinstance(t, Mapping)]
    return "\n".join(plain + tables) + "\n"
