#!/usr/bin/env python3
"""Reference values of material laws from W(F) alone, by 60-digit differences (needs mpmath).

    python3 make_points.py [CASES.json] > points.csv

Without CASES.json: W, P and the tangent's action of every law at a strain of 1e-6, and of the laws that
the shared reference cases lack, at their deformation gradients. With it, the cases MAT/* come first.
The energies are written as in the laws' sources, apart from the program's own formulas.
"""
import json
import sys

from mpmath import mp, mpf, matrix, det, log, exp, eigsy, sqrt

mp.dps = 60
DIRECTION = "0.3 -0.7 0.2 0.5 0.1 -0.4 0.6 -0.2 0.8"
STATES = {
    "identity": "1 0 0 0 1 0 0 0 1", "uniax_1.5_iso": "1.5 0 0 0 0.8 0 0 0 0.8",
    "compress_0.6": "0.6 0 0 0 1.25 0 0 0 1.25", "equibiax_1.3": "1.3 0 0 0 1.3 0 0 0 0.6",
    "shear_0.5": "1 0.5 0 0 1 0 0 0 1", "vol_0.9": "0.9 0 0 0 0.9 0 0 0 0.9",
    "general": "1.1 0.25 -0.15 0.05 0.85 0.3 -0.2 0.1 1.2"}
MU, K, LAMBDA = mpf(1) / 3, mpf(10), mpf(3)


def invariants(F):
    C = F.T * F
    J = det(F)
    I1 = C[0, 0] + C[1, 1] + C[2, 2]
    C2 = C * C
    I2 = (I1 * I1 - C2[0, 0] - C2[1, 1] - C2[2, 2]) / 2
    return C, J, I1, J ** (-mpf(2) / 3) * I1 - 3, J ** (-mpf(4) / 3) * I2 - 3


def volume(J):
    return K / 2 * (J - 1) ** 2


def neo_hookean(F):
    _, J, I1, _, _ = invariants(F)
    return MU / 2 * (I1 - 3) - MU * log(J) + LAMBDA / 2 * log(J) ** 2


def ogden(terms):
    def W(F):
        C, J, *_ = invariants(F)
        stretches = [sqrt(c) * J ** (-mpf(1) / 3) for c in eigsy(C, eigvals_only=True)]
        return sum(mpf(m) / mpf(a) * (sum(s ** mpf(a) for s in stretches) - 3) for m, a in terms) + volume(J)
    return W


def holzapfel(kappa, direction):
    def W(F):
        C, J, _, x1, _ = invariants(F)
        a = matrix([mpf(v) for v in direction])
        a = a / sqrt((a.T * a)[0])
        E = mpf(kappa) * x1 + (1 - 3 * mpf(kappa)) * ((a.T * C * a)[0] - 1)
        k1, k2 = mpf("0.5"), mpf("1.5")
        fibre = k1 / (2 * k2) * (exp(k2 * E * E) - 1) if E > 0 else mpf(0)
        return MU / 2 * x1 + fibre + volume(J)
    return W


def text(values):
    return " ".join(mp.nstr(mpf(v), 17) for v in values)


YOUNG_K = text([9 * K * MU / (3 * K + MU), (3 * K - 2 * MU) / (2 * (3 * K + MU))])
YOUNG_L = text([MU * (3 * LAMBDA + 2 * MU) / (LAMBDA + MU), LAMBDA / (2 * (LAMBDA + MU))])
THIRD = mp.nstr(MU, 17)
# Name in the cases: law, its values (nan: left out), energy; the last two are not in the cases.
MATERIALS = {
    "NH_ln": ("neo-hookean", YOUNG_L, neo_hookean),
    "NH_iso_J1": ("neo-hookean-isochoric", YOUNG_K, lambda F: MU / 2 * invariants(F)[3] + volume(det(F))),
    "MooneyRivlin": ("mooney-rivlin", "0.12 0.05 0.45 10",
                     lambda F: mpf("0.12") * invariants(F)[3] + mpf("0.05") * invariants(F)[4]
                     + volume(det(F))),
    "Ogden1": ("ogden", "0.08 8 nan nan nan nan 0.45 10", ogden([("0.08", 8)])),
    "Ogden2": ("ogden", "0.3 2.5 -0.02 -3 nan nan 0.45 10", ogden([("0.3", "2.5"), ("-0.02", -3)])),
    "Ogden3": ("ogden", "0.63 1.3 0.0012 5 -0.01 -2 0.45 10",
               ogden([("0.63", "1.3"), ("0.0012", 5), ("-0.01", -2)])),
    "Yeoh": ("yeoh", "0.17 -0.01 0.004 0.45 10",
             lambda F: (lambda x: mpf("0.17") * x - mpf("0.01") * x ** 2 + mpf("0.004") * x ** 3)(
                 invariants(F)[3]) + volume(det(F))),
    "FungIso": ("fung", THIRD + " 1.5 0.45 10",
                lambda F: MU / 3 * (exp(mpf("1.5") * invariants(F)[3]) - 1) + volume(det(F))),
    "HGO": ("holzapfel-gasser-ogden", THIRD + " 0.5 1.5 1 2 2 0 0.45 10", holzapfel(0, (1, 2, 2))),
    "HGO_dispersed": ("holzapfel-gasser-ogden", THIRD + " 0.5 1.5 1 2 2 0.2 0.45 10",
                      holzapfel("0.2", (1, 2, 2)))}


def with_step(F, steps):
    G = F.copy()
    for entry, h in steps:
        G[entry // 3, entry % 3] += h
    return G


def derivatives(W, F, direction):
    """P and A : H by central differences of W; error about 1e-20."""
    h = mpf(10) ** -12
    P = [(W(with_step(F, [(i, h)])) - W(with_step(F, [(i, -h)]))) / (2 * h) for i in range(9)]
    along = lambda i, s, t: W(with_step(F, [(j, t * h * direction[j]) for j in range(9)] + [(i, s * h)]))
    A_H = [(along(i, 1, 1) - along(i, -1, 1) - along(i, 1, -1) + along(i, -1, -1)) / (4 * h * h)
           for i in range(9)]
    return P, A_H


def row(name, law, values, F_text, W, P, sigma, A_H):
    number = lambda v: mp.nstr(mpf(v), 15) if abs(mpf(v)) > mpf(10) ** -19 else "0"
    line = lambda vs: " ".join(number(v) for v in vs)
    print(",".join([name, law, values, F_text, number(W), line(P), line(sigma), line(A_H)]))


def computed(name, material, F_text):
    law, values, W = MATERIALS[material]
    F = matrix(3, 3)
    for i, entry in enumerate(F_text.split()):
        F[i // 3, i % 3] = mpf(float(entry))  # the double that a test reads
    P, A_H = derivatives(W, F, [mpf(v) for v in DIRECTION.split()])
    PM = matrix(3, 3)
    for i in range(9):
        PM[i // 3, i % 3] = P[i]
    sigma = PM * F.T / det(F)
    row(name, law, values, F_text, W(F), P, list(sigma), A_H)


def main():
    print("case,law,values,F,W,P,sigma,A_H")
    if len(sys.argv) > 1:
        for case in json.load(open(sys.argv[1])):
            if case["id"].startswith("MAT/") and case["inputs"]["material"] in MATERIALS:
                law, values, _ = MATERIALS[case["inputs"]["material"]]
                e = case["expected"]
                row(case["id"], law, values, text(case["inputs"]["F"]), e["W"], e["P"], e["sigma"], e["A_H"])
    for material in ("HGO", "HGO_dispersed"):
        for state, F in STATES.items():
            if state != "identity":  # the tangent jumps there
                computed("own/" + material + "/" + state, material, F)
    # H in multiples of 2^-40, so that 1 + H is a double exactly.
    H = [k * 2.0 ** -40 for k in (700001, -300007, 500009, 900001, -400009, 200003, 100003, 600011, 800011)]
    F = " ".join(repr(h + (i % 4 == 0)) for i, h in enumerate(H))
    for material in MATERIALS:
        computed("own/" + material + "/tiny", material, F)


main()
