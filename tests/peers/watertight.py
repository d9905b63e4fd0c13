"""Reads fragments with trimesh and tells as JSON what it makes of them.

python3 watertight.py FILE.glb|FILE.obj ...

Vertices are merged where they are the same point bit by bit; normals and texture coordinates do not count.
"""

import json
import sys

import numpy as np
import trimesh


def solid(meshes):
    corners = np.concatenate([mesh.vertices[mesh.faces].reshape(-1, 3) for mesh in meshes])
    points, faces = np.unique(corners, axis=0, return_inverse=True)
    return trimesh.Trimesh(points, faces.reshape(-1, 3), process=False)


def row(name, meshes):
    mesh = solid(meshes)
    materials = sorted({getattr(getattr(m.visual, "material", None), "name", None) or "" for m in meshes})
    return {
        "name": name,
        "watertight": bool(mesh.is_watertight and mesh.is_winding_consistent),
        "volume_m3": float(mesh.volume),
        "centre_m": mesh.center_mass.tolist(),
        "inertia_m5": mesh.moment_inertia.tolist(),
        "triangles": len(mesh.faces),
        "materials": materials,
    }


rows = []
for path in sys.argv[1:]:
    scene = trimesh.load_scene(path, process=False)
    nodes = {}
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        # A mesh of two primitives becomes two nodes, of which the second is named after the first.
        parent = scene.graph.transforms.parents.get(node, node)
        name = node if parent == scene.graph.base_frame else parent
        mesh = scene.geometry[geometry].copy()
        mesh.apply_transform(transform)
        nodes.setdefault(name if path.endswith(".glb") else path, []).append(mesh)
    rows += [row(name, meshes) for name, meshes in nodes.items()]
print(json.dumps(rows))
