"""Reads fragments with trimesh and prints their properties as JSON.

python3 watertight.py FILE.glb|FILE.obj ...

Vertices with bitwise equal positions are merged; normals and texture coordinates do not count. `declared` is the surface that
EXT_mesh_manifold declares, for a .glb whose meshes have it: all of its triangles, merged only by the lists of the extension.
"""

import json
import struct
import sys

import numpy as np
import trimesh

KINDS = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
LANES = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


def solid(meshes):
    corners = np.concatenate([mesh.vertices[mesh.faces].reshape(-1, 3) for mesh in meshes])
    points, faces = np.unique(corners, axis=0, return_inverse=True)
    return trimesh.Trimesh(points, faces.reshape(-1, 3), process=False)


def closed(mesh):
    return bool(mesh.is_watertight and mesh.is_winding_consistent)


def row(name, meshes):
    mesh = solid(meshes)
    # Merged by trimesh itself, without data of the file.
    merged = trimesh.util.concatenate(meshes)
    merged.merge_vertices(merge_tex=True, merge_norm=True)
    materials = sorted({getattr(getattr(m.visual, "material", None), "name", None) or "" for m in meshes})
    return {
        "name": name,
        "watertight": closed(mesh),
        "merged_watertight": closed(merged),
        "volume_m3": float(mesh.volume),
        "center_m": mesh.center_mass.tolist(),
        "inertia_m5": mesh.moment_inertia.tolist(),
        "triangles": len(mesh.faces),
        "materials": materials,
    }


class Container:
    """A binary glTF file, taken apart by hand: trimesh knows nothing of the extension."""

    def __init__(self, path):
        with open(path, "rb") as file:
            content = file.read()
        (length,) = struct.unpack_from("<I", content, 12)
        self.document = json.loads(content[20 : 20 + length])
        self.binary = content[28 + length :]

    def dense(self, view, offset, count, kind, lanes):
        view = self.document["bufferViews"][view]
        first = view.get("byteOffset", 0) + offset
        size = np.dtype(kind).itemsize * lanes
        assert view.get("byteStride", size) == size
        return np.frombuffer(self.binary, kind, count * lanes, first).reshape(-1, lanes)

    def read(self, index):
        accessor = self.document["accessors"][index]
        kind, lanes = KINDS[accessor["componentType"]], LANES[accessor["type"]]
        rows = self.dense(accessor["bufferView"], accessor.get("byteOffset", 0), accessor["count"], kind, lanes).copy()
        sparse = accessor.get("sparse")
        if sparse:
            places, values = sparse["indices"], sparse["values"]
            where = self.dense(places["bufferView"], places.get("byteOffset", 0), sparse["count"], KINDS[places["componentType"]], 1)
            rows[where[:, 0]] = self.dense(values["bufferView"], values.get("byteOffset", 0), sparse["count"], kind, lanes)
        return rows

    def declared(self):
        """By the name of its node, what the extension declares of a mesh."""
        reported = {}
        for node in self.document["nodes"]:
            mesh = self.document["meshes"][node["mesh"]] if "mesh" in node else {}
            extension = mesh.get("extensions", {}).get("EXT_mesh_manifold")
            if not extension:
                continue
            primitive = extension["manifoldPrimitive"]
            faces = self.read(primitive["indices"]).reshape(-1, 3)
            points = self.read(primitive["attributes"]["POSITION"]).astype(float)
            if "mergeIndices" in extension:
                # The lists must equal the sparse accessor.
                plain = self.read(mesh["primitives"][0]["indices"])[:0].reshape(-1)
                parts = [self.read(own["indices"]).reshape(-1) for own in mesh["primitives"]]
                plain = np.concatenate([plain, *parts])
                plain[self.read(extension["mergeIndices"])[:, 0]] = self.read(extension["mergeValues"])[:, 0]
                assert (plain.reshape(-1, 3) == faces).all(), node["name"]
            own = trimesh.Trimesh(points, faces, process=False)
            reported[node["name"]] = {
                "watertight": closed(own),
                "volume_m3": float(own.volume),
                "extras": node.get("extras"),
            }
        return reported


rows = []
for path in sys.argv[1:]:
    scene = trimesh.load_scene(path, process=False)
    declared = Container(path).declared() if path.endswith(".glb") else {}
    nodes = {}
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        # A mesh of two primitives becomes two nodes; the second is named after the first.
        parent = scene.graph.transforms.parents.get(node, node)
        name = node if parent == scene.graph.base_frame else parent
        mesh = scene.geometry[geometry].copy()
        mesh.apply_transform(transform)
        nodes.setdefault(name if path.endswith(".glb") else path, []).append(mesh)
    rows += [{**row(name, meshes), "declared": declared.get(name)} for name, meshes in nodes.items()]
print(json.dumps(rows))
