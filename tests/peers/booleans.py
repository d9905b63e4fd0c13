"""The exact-boolean method: every Euclidean Voronoi cell intersected with the mesh, by manifold3d (PyPI wheel).

Usage: booleans.py INPUT.json RUNS. INPUT.json holds `positions` (x y z), `triangles` (counter-clockwise seen from outside) and
`sites`, in triples. Prints one JSON document: milliseconds per run, and properties of the output. Cells and the tree of the mesh are
made beforehand and not timed: other programs make the cells in a few milliseconds.
"""

import json
import sys
import time

import manifold3d as m3
import numpy as np


def solid(positions, triangles):
    mesh = m3.Mesh(np.asarray(positions, np.float32), np.asarray(triangles, np.uint32))
    mesh.merge()
    return m3.Manifold(mesh)


def cells(sites, low, high):
    """The box from low to high, cut by the bisectors between each site and all others."""
    margin = 0.1 * (high - low).max()
    box = m3.Manifold.cube(tuple(high - low + 2 * margin)).translate(tuple(low - margin))
    for own, site in enumerate(sites):
        cell = box
        for other in np.argsort(((sites - site) ** 2).sum(1))[1:]:
            normal = site - sites[other]
            length = np.linalg.norm(normal)
            middle = 0.5 * (site + sites[other])
            cell = cell.trim_by_plane(tuple(normal / length), float(middle @ normal / length))
        cell.num_tri()  # Evaluates the cell, which is lazy.
        yield cell


def main():
    with open(sys.argv[1]) as file:
        given = json.load(file)
    positions, triangles, sites = (np.array(given[key]).reshape(-1, 3) for key in ("positions", "triangles", "sites"))
    whole = solid(positions, triangles)
    if whole.status() != m3.Error.NoError:
        print(json.dumps({"refused": str(whole.status())}))
        return
    if whole.volume() < 0.0:
        whole = solid(positions, triangles[:, ::-1])
    low, high = positions.min(0), positions.max(0)
    made = list(cells(sites, low, high))
    times_ms, worked = [], time.process_time()
    for _ in range(int(sys.argv[2])):
        begun = time.perf_counter()
        pieces = [(whole ^ cell).to_mesh() for cell in made]
        times_ms.append(1e3 * (time.perf_counter() - begun))
    cores = 1e3 * (time.process_time() - worked) / sum(times_ms)
    several = sum(len((whole ^ cell).decompose()) > 1 for cell in made)
    volume = sum((whole ^ cell).volume() for cell in made)
    print(json.dumps({
        "times_ms": times_ms,
        "cores": cores,
        "fragments": sum(len(piece.tri_verts) > 0 for piece in pieces),
        "triangles": int(sum(len(piece.tri_verts) for piece in pieces)),
        "several": int(several),
        "volume_error": volume / whole.volume() - 1.0,
    }))


main()
