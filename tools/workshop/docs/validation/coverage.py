#!/usr/bin/env python3
"""How much of the forces of drawn truths an asset's interval holds (docs/method.md, M11d).

    python3 tools/workshop/docs/validation/coverage.py PALPATE SCENE OUT [TRUTHS]

SCENE: with young_deviation, and with poisson_deviation or friction_deviation where wanted. It is
run once. Then the modulus, Poisson's ratio and friction of 30 truths are drawn from their
deviations (seeds 1 to 30), fresh paths of each are simulated, and prints the share of all rows
above the floor whose force over the asset's is within the interval that the statement has, and how
many truths have 95 % of their own rows in it.
"""
import json
import math
import os
import random
import re
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from scripts import Program, table


def number(text, key, default=0.0):
    """The first value of a key, in the unit that it has."""
    found = re.search(rf'^{key} = "?([0-9.e+-]+)', text, re.MULTILINE)
    return float(found.group(1)) if found else default


def with_number(text, key, value):
    return re.sub(rf'^({key} = "?)[0-9.e+-]+', rf"\g<1>{value:.6g}", text, count=1, flags=re.MULTILINE)


def truth(text, seed):
    """The scene of a body drawn from what is known: the modulus log-normal, the others normal."""
    draw = random.Random(seed).gauss
    young = number(text, "young_deviation")
    factor = math.exp(draw(0, math.sqrt(math.log(1 + young**2))))
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
    low, high = 1 + statement["interval"]["low_rel"], 1 + statement["interval"]["high_rel"]
    with open(scene, encoding="utf-8") as file:
        text = file.read()
    shares, held = [], 0
    for seed in range(1, truths + 1):
        drawn, rows = os.path.join(os.path.dirname(scene), f".truth{seed}.toml"), os.path.join(out, "rows.csv")
        with open(drawn, "w", encoding="utf-8") as file:
            file.write(truth(text, seed))
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
        held += inside >= 0.95
        print(f"truth {seed}: {100 * inside:.0f} % of {len(ratios)} rows", flush=True)
    print(f"{100 * (low - 1):+.0f} to {100 * (high - 1):+.0f} %: {100 * sum(shares) / len(shares):.1f} % "
          f"of the rows; {held} of {truths} truths with 95 % of theirs")


if __name__ == "__main__":
    main()
