"""Voronoi cells restricted to the mesh by geogram, on tetrahedra made by TetGen."""

import geogram
import numpy as np
import tetgen
from exchange import serve


def prepare(positions, triangles, sites):
    maker = tetgen.TetGen(positions, triangles.astype(np.int32))
    nodes, tetrahedra = maker.tetrahedralize(quality=False, nobisect=True)[:2]
    if len(tetrahedra) == 0:
        raise ValueError("TetGen: no tetrahedra")
    return (sites, np.ascontiguousarray(nodes), np.ascontiguousarray(tetrahedra, np.uint32)), f"{len(tetrahedra)} tetrahedra by TetGen"


def boundary(tetrahedra, corners):
    """Faces of the tetrahedra that belong to one of them only, seen from outside."""
    a, b, c, d = (corners[tetrahedra[:, corner]] for corner in range(4))
    flipped = np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) < 0.0
    ordered = np.where(flipped[:, None], tetrahedra[:, [1, 0, 2, 3]], tetrahedra)
    faces = np.concatenate([ordered[:, face] for face in ([0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3])])
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[first[count == 1]]


def run(prepared):
    sites, nodes, tetrahedra = prepared
    made = geogram.Voronoi(sites, domain_vertices=nodes, domain_simplices=tetrahedra)
    corners, simplices, owner = np.array(made.q), np.array(made.t, np.int64), np.array(made.tseed)
    fragments = []
    for site in range(len(sites)):
        used, faces = np.unique(boundary(simplices[owner == site], corners), return_inverse=True)
        fragments.append((corners[used], faces.reshape(-1, 3)))
    return fragments


serve(prepare, run)
