"""Imports fragments into Blender (the wheel `bpy`), drops them as rigid bodies, and prints their final state as JSON.

python3 blender_drops.py FILE.glb FRAMES
"""

import contextlib
import json
import math
import os
import sys

import bpy
import bmesh  # Part of bpy, so it is imported second.

# Thickness of the floor, and its distance below the lowest fragment, m.
FLOOR_M, GAP_M = 0.5, 0.05


@contextlib.contextmanager
def quiet():
    """Importers talk on the standard output, from C too."""
    kept = os.dup(1)
    os.dup2(2, 1)
    yield
    os.dup2(kept, 1)


def measured(mesh):
    """Whether a mesh is closed once equal vertices are one, and its volume."""
    copy = bmesh.new()
    copy.from_mesh(mesh)
    bmesh.ops.remove_doubles(copy, verts=copy.verts, dist=0.0)
    closed = all(edge.is_manifold for edge in copy.edges)
    volume_m3 = copy.calc_volume(signed=True)
    copy.free()
    return closed, volume_m3


def add_body(piece, kind, shape):
    bpy.context.view_layer.objects.active = piece
    bpy.ops.rigidbody.object_add(type=kind)
    piece.rigid_body.collision_shape = shape
    piece.rigid_body.use_margin = True
    piece.rigid_body.collision_margin = 0.001


def main(path, frames):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=path)
    scene = bpy.context.scene
    pieces = sorted((own for own in scene.objects if own.type == "MESH"), key=lambda own: own["fragment"])
    rows = []
    bpy.ops.rigidbody.world_add()
    for piece in pieces:
        add_body(piece, "ACTIVE", "CONVEX_HULL")
        piece.rigid_body.mass = piece["mass_kg"]
        closed, volume_m3 = measured(piece.data)
        rows.append({
            "name": piece.name,
            "closed": closed,
            "volume_m3": volume_m3,
            "extras": {"volume_m3": piece["volume_m3"], "mass_kg": piece["mass_kg"]},
            "materials": [own.name for own in piece.data.materials],
        })
    lowest_m = min((piece.matrix_world @ vertex.co).z for piece in pieces for vertex in piece.data.vertices)
    top_m = lowest_m - GAP_M
    bpy.ops.mesh.primitive_cube_add(size=1.0, location=(0.0, 0.0, top_m - 0.5 * FLOOR_M), scale=(20.0, 20.0, FLOOR_M))
    add_body(bpy.context.object, "PASSIVE", "BOX")
    scene.rigidbody_world.point_cache.frame_end = frames
    for frame in range(1, frames + 1):
        scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    heights = [piece.evaluated_get(graph).matrix_world.translation.z for piece in pieces]
    return {
        "version": bpy.app.version_string,
        "pieces": rows,
        "finite": all(map(math.isfinite, heights)),
        "lowest_m": min(heights),
        "highest_m": max(heights),
        "floor_m": top_m,
    }


with quiet():
    reported = main(sys.argv[1], int(sys.argv[2]))
print(json.dumps(reported))
