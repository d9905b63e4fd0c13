"""The pieces of one impact by fracture-modes (Sellán et al. 2022). The argument is the folder of its source.

Its number of pieces follows from its modes, not from a number of sites. Three of its dependencies are replaced: Mosek, which needs a
license, by Clarabel, which minimizes the same function; `sparse_sqrt`, whose value it never uses, and polyscope, its viewer, by nothing.
"""

import sys
from types import ModuleType

import clarabel
import gpytoolbox
import numpy as np
import tetgen
from exchange import Stopwatch, serve
from gpytoolbox.copyleft import lazy_cage
from scipy import sparse

CAGE_FACES = 2000
MODES = 10
projection = Stopwatch()


def conic_solve(D, M, Us, c, d, verbose=False):
    """Minimizes the sum of |(Du)_e| over u with u'MU = 0 for each U of Us, and u'Mc = 1."""
    D, unknowns = sparse.csr_matrix(D), D.shape[1]
    groups = D.shape[0] // d
    used = np.nonzero(np.add.reduce([np.diff(D[k * groups : (k + 1) * groups].indptr) for k in range(d)]))[0]
    rows = [sparse.hstack([sparse.csr_matrix((len(used), unknowns)), -sparse.eye(len(used))])]
    for k in range(d):
        rows.append(sparse.hstack([-D[k * groups + used], sparse.csr_matrix((len(used), len(used)))]))
    order = np.arange(len(used) * (d + 1)).reshape(d + 1, -1).T.reshape(-1)
    cones = sparse.vstack(rows).tocsr()[order]
    equal = sparse.csr_matrix(np.stack([M @ U for U in [*Us, c]]))
    equal = sparse.hstack([equal, sparse.csr_matrix((len(Us) + 1, len(used)))])
    settings = clarabel.DefaultSettings()
    settings.verbose = verbose
    size = unknowns + len(used)
    solution = clarabel.DefaultSolver(
        sparse.csc_matrix((size, size)),
        np.concatenate([np.zeros(unknowns), np.ones(len(used))]),
        sparse.vstack([equal, cones]).tocsc(),
        np.concatenate([np.zeros(len(Us)), [1.0], np.zeros(cones.shape[0])]),
        [clarabel.ZeroConeT(len(Us) + 1), *[clarabel.SecondOrderConeT(d + 1)] * len(used)],
        settings,
    ).solve()
    return np.array(solution.x)[:unknowns]


def stopped(silence=True):
    projection.stop()
    return projection.times_ms[-1] / 1e3


def module(name, **values):
    sys.modules[name] = made = ModuleType(name)
    made.__dict__.update(values)


def prepare(positions, triangles, sites):
    from fracture_utility import compute_fracture_modes as modes_of_library
    from fracture_utility import fracture_modes, fracture_modes_parameters

    # The library measures the projection of an impact between these two calls.
    sys.modules[fracture_modes.__module__].tic = projection.start
    sys.modules[fracture_modes.__module__].toc = stopped
    library = sys.modules[modes_of_library.__module__]
    library.conic_solve, library.sparse_sqrt = conic_solve, lambda matrix: matrix
    low, side = positions.min(0), (positions.max(0) - positions.min(0)).max()
    positions, triangles = gpytoolbox.normalize_points(positions), triangles.astype(np.int32)
    cage = lazy_cage(positions, triangles, num_faces=CAGE_FACES)
    nodes, tetrahedra = tetgen.TetGen(*cage).tetrahedralize()[:2]
    modes = fracture_modes(nodes, tetrahedra)
    modes.compute_modes(parameters=fracture_modes_parameters(num_modes=MODES, d=1))
    modes.impact_precomputation(v_fine=positions, f_fine=triangles)
    made_low, made_side = positions.min(0), (positions.max(0) - positions.min(0)).max()
    projection.times_ms.clear()
    projection.cpu_ms.clear()
    place = (made_low, side / made_side, low)
    contact = nodes[np.argmin(np.linalg.norm(nodes - ((sites[0] - low) / place[1] + made_low), axis=1))]
    return (modes, contact, place), f"{len(tetrahedra)} tetrahedra, {MODES} modes, at most {modes.precomputed_num_pieces} pieces"


def run(prepared):
    modes, contact, (low, scale, origin) = prepared
    modes.impact_projection(contact_point=contact, direction=np.array([1.0]))
    labels = modes.fine_vertex_labels_after_impact[modes.fine_triangles[:, 0]]
    fragments = []
    for label in range(modes.n_pieces_after_impact):
        used, faces = np.unique(modes.fine_triangles[labels == label], return_inverse=True)
        fragments.append(((modes.fine_vertices[used] - low) * scale + origin, faces.reshape(-1, 3)))
    return fragments


sys.path.insert(0, sys.argv[4])
module("mosek")
module("polyscope")
module("sksparse")
module("sksparse.cholmod", cholesky=None)
serve(prepare, run, projection)
