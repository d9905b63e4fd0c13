"""Cell Fracture, Blender's add-on, by Blender's Python package. The argument is the folder of the add-on.

Its tolerances are absolute (0.005 for merging, 0.001 of random noise on each corner of a cell). The mesh is therefore scaled to a
longest side of 200 units, at which it gives its best results, and the fragments are scaled back.
"""

import contextlib
import os
import random
import sys
from pathlib import Path

import bpy
import numpy as np

# Blender itself passes its own arguments too, and does not look for modules beside the script.
if "--" in sys.argv:
    sys.argv = sys.argv[sys.argv.index("--") :]
sys.path.insert(0, str(Path(__file__).parent))
from exchange import serve  # noqa: E402

SIDE = 200.0


def prepare(positions, triangles, sites):
    scale = SIDE / (positions.max(0) - positions.min(0)).max()
    return (positions * scale, triangles, sites * scale, scale), f"scaled to a longest side of {SIDE:g}"


def placed(name, positions, triangles):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(positions.tolist(), [], triangles.tolist())
    mesh.update()
    placed = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(placed)
    return placed


def triangulated(made, scale):
    mesh = made.data
    mesh.calc_loop_triangles()
    corners = np.zeros(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners)
    positions = np.zeros(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", positions)
    matrix = np.array(made.matrix_world)
    return (positions.reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]) / scale, corners.reshape(-1, 3)


def run(prepared):
    positions, triangles, sites, scale = prepared
    random.seed(1)
    for old in list(bpy.data.objects):
        bpy.data.objects.remove(old, do_unlink=True)
    whole, points = placed("whole", positions, triangles), placed("sites", sites, np.zeros((0, 3), int))
    points.parent = whole
    bpy.context.view_layer.objects.active = whole
    from cell_fracture import main_object

    with open(os.devnull, "w") as nothing, contextlib.redirect_stdout(nothing):
        made = main_object(
            bpy.context, bpy.context.collection, whole, 0,
            source={"VERT_CHILD"}, source_limit=0, source_noise=0.0, cell_scale=(1.0, 1.0, 1.0), margin=0.0,
            recursion=0, recursion_source_limit=8, recursion_clamp=250, recursion_chance=0.25, recursion_chance_select="SIZE_MIN",
            use_smooth_faces=False, use_sharp_edges=True, use_sharp_edges_apply=True, use_data_match=True, use_island_split=True,
            material_index=0, use_interior_vgroup=False, use_recenter=True, use_remove_original=True,
            use_debug_points=False, use_debug_redraw=False, use_debug_bool=False,
        )
        bpy.context.view_layer.update()
    return [triangulated(own, scale) for own in made]


def load(folder):
    """The add-on as the package `cell_fracture`: its folder has another name in the extension than in Blender 3."""
    import importlib.util

    spec = importlib.util.spec_from_file_location("cell_fracture", Path(folder) / "__init__.py", submodule_search_locations=[folder])
    sys.modules["cell_fracture"] = module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)


bpy.ops.wm.read_factory_settings(use_empty=True)
load(sys.argv[4])
serve(prepare, run)
