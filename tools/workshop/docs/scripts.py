"""What the scripts below this folder share: calls of the program, its tables, and figures."""
import csv
import os
import subprocess
import sys


class Program:
    """`palpate`, called with its arguments. accepts: statuses that do not end the script; with 3
    not all of the input was good."""

    def __init__(self, path, accepts=(0, 3)):
        self.path, self.accepts = path, accepts

    def tried(self, *arguments):
        """How it ended, and what it printed."""
        return subprocess.run([self.path, *arguments], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, check=False)

    def __call__(self, *arguments, also=()):
        """Its standard output. also: statuses that are accepted here."""
        done = self.tried(*arguments)
        if done.returncode not in (*self.accepts, *also):
            sys.exit(f"palpate {' '.join(arguments)}: {done.stderr}")
        return done.stdout


def table(path):
    """The rows of a CSV file."""
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def normal_curves(path):
    """The rows of normal curves, of what `tabulate` wrote."""
    return [row for row in table(path) if row["curve"] == "normal"]


def pyplot():
    """matplotlib.pyplot, whose SVG files have the same bytes from the same numbers."""
    import matplotlib
    matplotlib.use("svg")
    matplotlib.rcParams["svg.hashsalt"] = "palpate"
    matplotlib.rcParams["svg.fonttype"] = "none"  # texts, not outlines: half of the lines
    import matplotlib.pyplot
    return matplotlib.pyplot


def save(figure, folder, name):
    """Writes name.svg and forgets the figure."""
    figure.tight_layout()
    figure.savefig(os.path.join(folder, name + ".svg"), metadata={"Date": None})
    pyplot().close(figure)
