"""Rows of a run's held-out paths in which the ball touches its body at separate places.

    python3 second_contact.py RUN ...

A place of the simulated surface (reference.surface.h5, each triangle sampled) counts as touched
within NEAR radii of the ball. Touched places that are farther than APART radii from each other are
of separate contacts. One line a run: rows, those with one contact, those with more.
"""

import sys

import h5py
import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

NEAR = 0.05  # radii; half and twice: 8 and 9 rows of the dragon for 8, none of bust and SOFA's liver
APART = 0.25  # radii; samples of an edge of 6 mm are 0.09 apart under a ball of 5 mm
SIDE = 14  # samples along an edge


def contacts(triangles, centre, radius):
    near = np.linalg.norm(triangles.mean(1) - centre, axis=1) < 3 * radius
    weights = np.array(
        [(i, j, SIDE - i - j) for i in range(SIDE + 1) for j in range(SIDE + 1 - i)]) / SIDE
    places = np.einsum("bk,tkd->tbd", weights, triangles[near]).reshape(-1, 3)
    touched = places[np.linalg.norm(places - centre, axis=1) < (1 + NEAR) * radius]
    if len(touched) == 0:
        return 0
    pairs = cKDTree(touched).query_pairs(APART * radius, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), pairs.T), shape=(len(touched),) * 2)
    _, label = connected_components(graph, directed=False)
    return int((np.bincount(label) > 3).sum())


for run in sys.argv[1:]:
    with h5py.File(run + "/body.h5") as body, h5py.File(run + "/reference.h5") as rows, \
            h5py.File(run + "/reference.surface.h5") as moved:
        radius = float(rows["probe/radius"][0])
        vertices, corners = body["surface/vertices"][:], body["surface/triangles"][:]
        point = rows["rows/point"][:].ravel()
        normal = rows["points/normal"][:]
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        centre = (rows["points/position"][:] - radius * normal)[point] + rows["rows/deflection"][:]
        good = np.flatnonzero(rows["rows/status"][:].ravel() == 0)
        counts = [contacts((vertices + moved["rows/displacement"][i].reshape(-1, 3))[corners],
                           centre[i], radius) for i in good]
        print(run, len(counts), "rows,", counts.count(1), "of one contact,",
              sum(n > 1 for n in counts), "of more")
