#!/usr/bin/env python3
"""How much of the forces of drawn truths an asset's interval holds (docs/method.md, M11d).

    python3 tools/workshop/docs/validation/coverage.py PALPATE SCENE OUT [TRUTHS]

SCENE: with young_deviation, and with poisson_deviation or friction_deviation where wanted. It is
run once. Then 30 truths are made: their moduli are the middles of 30 equally likely parts of what
young_deviation says, Poisson's ratio and friction are drawn from theirs (seeds 1 to 30). Fresh paths
of each are simulated, and printed is the share of all rows above the floor whose force over the
asset's is within the statement's interval, less what the interval has for how the body is held,
which the truths share. All rows of a truth go with its modulus, so 30 moduli drawn at random would
leave the share uncertain by 4 %.
"""
import json
import math
import os
import random
import re
import statistics
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import Program, table


def number(text, key, default=0.0):
    """The first value of a key, in the unit that it has."""
    found = re.search(rf'^{key} = "?([0-9.e+-]+)', text, re.MULTILINE)
    return float(found.group(1)) if found else default


def with_number(text, key, value):
    return re.sub(rf'^({key} = "?)[0-9.e+-]+', rf"\g<1>{value:.6g}", text, count=1, flags=re.MULTILINE)


def truth(text, seed, truths):
    """The scene of a body that may be the user's: the modulus log-normal, the others normal."""
    draw = random.Random(seed).gauss
    young = number(text, "young_deviation")
    of_one = statistics.NormalDist().inv_cdf((seed - 0.5) / truths)
    factor = math.exp(of_one * math.sqrt(math.log(1 + young**2)))
    poisson = number(text, "poisson") + number(text, "poisson_deviation") * draw(0, 1)
    friction = number(text, "friction") * (1 + number(text, "friction_deviation") * draw(0, 1))
    for key, value in (("young", number(text, "young") * factor), ("poisson", min(poisson, 0.499)),
                       ("friction", max(friction, 0.0))):
        text = with_number(text, key, value)
    return text


def main():
    program, scene, out = Program(sys.argv[1]), sys.argv[2], sys.argv[3]
    truths = int(sys.argv[4]) if len(sys.argv) > 4 else 30
    program("run", scene, "-o", out)
    with open(os.path.join(out, "statement.json"), encoding="utf-8") as file:
        statement = json.load(file)
    stated = statement["interval"]
    high = (1 + stated["high_rel"]) ** math.sqrt(1 - stated["held"])
    low = 1 / high
    with open(scene, encoding="utf-8") as file:
        text = file.read()
    shares = []
    for seed in range(1, truths + 1):
        drawn, rows = os.path.join(os.path.dirname(scene), f".truth{seed}.toml"), os.path.join(out, "rows.csv")
        with open(drawn, "w", encoding="utf-8") as file:
            file.write(truth(text, seed, truths))
        program("validate", os.path.join(out, "asset.palp"), drawn, "--no-causes", "--points", "3",
                "--seed", str(seed), "--rows", rows, "--reference", os.path.join(out, f"truth{seed}"))
        os.remove(drawn)
        ratios = []
        for row in table(rows):
            true_N, stated_N = (math.hypot(*(float(row[k]) for k in keys))
                                for keys in (("fx_N", "fy_N", "fz_N"), ("ex_N", "ey_N", "ez_N")))
            if true_N > statement["floor_N"]:
                ratios.append(true_N / stated_N)
        inside = sum(low <= ratio <= high for ratio in ratios) / len(ratios)
        shares.append(inside)
        print(f"truth {seed}: {100 * inside:.0f} % of {len(ratios)} rows", flush=True)
    print(f"{100 * (low - 1):+.0f} to {100 * (high - 1):+.0f} %: {100 * sum(shares) / len(shares):.1f} % "
          "of the rows")


if __name__ == "__main__":
    main()
