"""Prepares a mesh for the comparison, and judges the fragments of every tool in the same way.

`judge.py prepare MESH FOLDER SITES` writes `mesh.bin`, `sites.bin` and `input.json` into FOLDER.
`judge.py fragments FOLDER FILE` judges fragments (`.bin` or `.glb`) of the mesh in FOLDER and prints one JSON document.
"""

import json
import struct
import sys
from pathlib import Path

import igl
import numpy as np
from exchange import read_meshes, write_meshes, write_sites
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

SEED = 1
# Points of the estimate of the volume: at a third of the box, its standard error is 0.1 % of the volume.
VOLUME_POINTS = 2_000_000
SURFACE_POINTS = 20_000
# Radius of welding and of nothing else, as a share of the diagonal.
WELD = 1e-6


def read_obj(path):
    positions, triangles = [], []
    for line in Path(path).read_text(errors="replace").splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            positions.append([float(word) for word in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) for word in words[1:]]
            corners = [corner - 1 if corner > 0 else len(positions) + corner for corner in corners]
            triangles += [[corners[0], *pair] for pair in zip(corners[1:], corners[2:])]
    return np.array(positions), np.array(triangles)


def read_mesh(path):
    """Positions and triangles, with vertices of equal positions merged, triangles of two equal corners and unused vertices dropped."""
    positions, triangles = read_obj(path) if str(path).endswith(".obj") else igl.read_triangle_mesh(str(path))
    positions, index = np.unique(positions, axis=0, return_inverse=True)
    triangles = index.reshape(-1)[triangles]
    triangles = triangles[distinct(triangles)]
    used, index = np.unique(triangles, return_inverse=True)
    return positions[used], index.reshape(-1, 3)


def read_glb(path):
    """One mesh per node: all of its primitives, in the coordinates of the scene."""
    data = Path(path).read_bytes()
    length = struct.unpack_from("<I", data, 12)[0]
    scene, binary = json.loads(data[20 : 20 + length]), 28 + length

    def values(index, kind, width):
        accessor = scene["accessors"][index]
        view = scene["bufferViews"][accessor["bufferView"]]
        at = binary + view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        row = width * np.dtype(kind).itemsize
        stride = view.get("byteStride", row)
        return np.ndarray((accessor["count"], width), kind, data, at, (stride, np.dtype(kind).itemsize))

    nodes = scene["nodes"]
    parents = {child: parent for parent, node in enumerate(nodes) for child in node.get("children", [])}

    def place(index):
        """Sum of the translations of a node and its parents."""
        above = place(parents[index]) if index in parents else np.zeros(3)
        return above + np.array(nodes[index].get("translation", [0, 0, 0]))

    meshes = []
    for index, node in enumerate(nodes):
        if "mesh" not in node:
            continue
        positions, triangles, count = [], [], 0
        for part in scene["meshes"][node["mesh"]]["primitives"]:
            kind = {5123: "<u2", 5125: "<u4"}[scene["accessors"][part["indices"]]["componentType"]]
            positions.append(values(part["attributes"]["POSITION"], "<f4", 3) + place(index))
            triangles.append(values(part["indices"], kind, 1).reshape(-1, 3).astype(np.int64) + count)
            count += len(positions[-1])
        meshes.append((np.concatenate(positions), np.concatenate(triangles)))
    return meshes


def distinct(triangles):
    a, b, c = triangles.T
    return (a != b) & (b != c) & (c != a)


def signed_volume(positions, triangles):
    a, b, c = (positions[triangles[:, corner]] - positions.mean(0) for corner in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)


def welded(positions, triangles, radius):
    """The mesh with vertices closer than `radius` merged, without triangles that lose a corner."""
    pairs = cKDTree(positions).query_pairs(radius, output_type="ndarray")
    graph = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), (len(positions), len(positions)))
    count, index = connected_components(graph, directed=False)
    merged = np.zeros((count, 3))
    merged[index] = positions
    triangles = index[np.asarray(triangles, np.int64)]
    return merged, triangles[distinct(triangles)]


def edges(triangles):
    return np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])


def is_closed(triangles):
    """True where each edge has exactly two triangles, with opposite directions."""
    directed = edges(triangles)
    key = directed[:, 0] * (triangles.max() + 1) + directed[:, 1]
    opposite = directed[:, 1] * (triangles.max() + 1) + directed[:, 0]
    return len(np.unique(key)) == len(key) and np.array_equal(np.sort(key), np.sort(opposite))


def parts(positions, triangles):
    """Volumes of the parts that share no vertex."""
    directed = edges(triangles)
    graph = coo_matrix((np.ones(len(directed)), (directed[:, 0], directed[:, 1])), (len(positions), len(positions)))
    index = connected_components(graph, directed=False)[1][triangles[:, 0]]
    return [signed_volume(positions, triangles[index == part]) for part in np.unique(index)]


def surface_points(positions, triangles, count, random):
    a, b, c = (positions[triangles[:, corner]] for corner in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    chosen = random.choice(len(triangles), count, p=area / area.sum())
    u, v = random.random((2, count, 1))
    u, v = np.where(u + v > 1, 1 - u, u), np.where(u + v > 1, 1 - v, v)
    return a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen]


def inside(positions, triangles, points):
    """Generalized winding number (Jacobson et al. 2013) above one half, of either sign."""
    winding = igl.fast_winding_number(positions, triangles.astype(np.int64), np.ascontiguousarray(points))
    return np.abs(winding) > 0.5


def prepare(path, folder, sites):
    positions, triangles = read_mesh(path)
    low, high = positions.min(0), positions.max(0)
    random = np.random.default_rng(SEED)
    points = low + (high - low) * random.random((VOLUME_POINTS, 3))
    kept = inside(positions, triangles, points)
    share, box = kept.mean(), float((high - low).prod())
    closed, exact = is_closed(triangles), abs(signed_volume(positions, triangles))
    error = float(np.sqrt(share * (1 - share) / VOLUME_POINTS) * box)
    estimate = float(share * box)
    is_exact = bool(closed and abs(estimate - exact) < 4.0 * error)
    diagonal = float(np.linalg.norm(high - low))
    rays = []
    for target in points[kept][-100:]:
        direction = random.normal(size=3)
        direction /= np.linalg.norm(direction)
        rays.append([*(target - diagonal * direction), *direction])
    write_meshes(folder / "mesh.bin", [(positions, triangles)])
    write_sites(folder / "sites.bin", points[kept][:sites])
    document = {
        "vertices": len(positions), "triangles": len(triangles), "closed": closed, "diagonal": diagonal,
        "signed_volume": signed_volume(positions, triangles), "winding_volume": estimate, "winding_error": error,
        "volume": exact if is_exact else estimate, "volume_is_exact": is_exact, "rays": rays,
    }
    (folder / "input.json").write_text(json.dumps(document))


def judged(folder, fragments):
    [(positions, triangles)] = read_meshes(folder / "mesh.bin")
    given = json.loads((folder / "input.json").read_text())
    closed, several, volumes, all_positions, all_triangles, count = 0, 0, [], [], [], 0
    for own in fragments:
        merged = welded(*own, WELD * given["diagonal"])
        volumes.append(signed_volume(*merged) if len(merged[1]) else 0.0)
        closed += bool(len(merged[1]) and volumes[-1] > 0.0 and is_closed(merged[1]))
        several += len(merged[1]) > 0 and sum(volume > 0.0 for volume in parts(*merged)) > 1
        all_positions.append(own[0])
        all_triangles.append(np.asarray(own[1], np.int64) + count)
        count += len(own[0])
    points = surface_points(positions, triangles, SURFACE_POINTS, np.random.default_rng(SEED))
    mesh = np.concatenate(all_positions), np.concatenate(all_triangles)
    distance = np.sqrt(igl.point_mesh_squared_distance(points, np.ascontiguousarray(mesh[0], float), mesh[1])[0])
    mean = sum(volumes) / len(volumes)
    return {
        "fragments": len(fragments), "closed": int(closed), "several": int(several),
        "negative": sum(volume <= 0.0 for volume in volumes),
        "slivers": sum(0.0 < volume < 0.01 * abs(mean) for volume in volumes),
        "triangles": len(mesh[1]), "volume": sum(volumes),
        "volume_error": abs(sum(volumes) - given["volume"]) / given["volume"],
        "surface_mean": float(distance.mean()) / given["diagonal"],
        "surface_max": float(distance.max()) / given["diagonal"],
    }


def main():
    if sys.argv[1] == "prepare":
        prepare(sys.argv[2], Path(sys.argv[3]), int(sys.argv[4]))
    else:
        path = sys.argv[3]
        fragments = read_glb(path) if path.endswith(".glb") else read_meshes(path)
        print(json.dumps(judged(Path(sys.argv[2]), fragments)))


main()
