"""Voronoi cells by voro++ (multivoro), each intersected with the mesh by Manifold (manifold3d)."""

import manifold3d
import multivoro
import numpy as np
from exchange import serve


def solid(positions, triangles):
    """The mesh as it is, and, where that is no manifold, with its equal vertices merged."""
    mesh = manifold3d.Mesh(np.asarray(positions, np.float32), np.asarray(triangles, np.uint32))
    made = manifold3d.Manifold(mesh)
    if made.status() != manifold3d.Error.NoError:
        mesh.merge()
        made = manifold3d.Manifold(mesh)
    if made.status() != manifold3d.Error.NoError:
        raise ValueError(f"manifold3d: {made.status().name}")
    return made


def prepare(positions, triangles, sites):
    margin = 0.1 * (positions.max(0) - positions.min(0)).max()
    limits = np.stack([positions.min(0) - margin, positions.max(0) + margin])
    return (solid(positions, triangles), sites, limits), ""


def run(prepared):
    whole, sites, limits = prepared
    cells = multivoro.compute_voronoi(points=sites, radii=np.zeros(len(sites)), limits=limits)
    fragments = []
    for cell in cells:
        piece = (whole ^ manifold3d.Manifold.hull_points(np.array(cell.get_vertices()))).to_mesh64()
        fragments.append((piece.vert_properties[:, :3], piece.tri_verts))
    return fragments


serve(prepare, run)
