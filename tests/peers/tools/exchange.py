"""Files that the comparison and the programs of the peers exchange.

A file of meshes holds, little-endian: the number of meshes (u32); for each mesh the numbers of vertices and triangles (u32, u32),
the positions (f64, x y z) and the triangles (u32, counter-clockwise seen from outside). Each program is called as
`PROGRAM INPUT OUTPUT RUNS [ARGUMENT]`. INPUT holds `mesh.bin` (one mesh) and `sites.bin` (the number of sites (u32), then their
positions). The program writes `fragments.bin` and `result.json` into OUTPUT: `times_ms` and `cpu_ms` (processor time), one per run,
`prepare_ms`, the work that is done once per mesh, and `note`; or `rejected`, the reason. It begins no run after 30 seconds of runs.
"""

import json
import sys
import time
from pathlib import Path

import numpy as np

LIMIT_MS = 30_000.0


def read_meshes(path):
    """Pairs of positions (n, 3) and triangles (m, 3)."""
    data, at, meshes = Path(path).read_bytes(), 4, []
    for _ in range(int.from_bytes(data[:4], "little")):
        vertices, triangles = np.frombuffer(data, "<u4", 2, at)
        positions = np.frombuffer(data, "<f8", 3 * vertices, at + 8).reshape(-1, 3)
        at += 8 + positions.nbytes
        indices = np.frombuffer(data, "<u4", 3 * triangles, at).reshape(-1, 3)
        at += indices.nbytes
        meshes.append((positions.copy(), indices.copy()))
    return meshes


def write_meshes(path, meshes):
    parts = [len(meshes).to_bytes(4, "little")]
    for positions, triangles in meshes:
        parts.append(np.array([len(positions), len(triangles)], "<u4").tobytes())
        parts.append(np.ascontiguousarray(positions, "<f8").tobytes())
        parts.append(np.ascontiguousarray(triangles, "<u4").tobytes())
    Path(path).write_bytes(b"".join(parts))


def read_sites(path):
    data = Path(path).read_bytes()
    return np.frombuffer(data, "<f8", -1, 4).reshape(-1, 3).copy()


def write_sites(path, sites):
    Path(path).write_bytes(len(sites).to_bytes(4, "little") + np.ascontiguousarray(sites, "<f8").tobytes())


class Stopwatch:
    """Wall and processor time of the runs so far, ms."""

    def __init__(self):
        self.times_ms, self.cpu_ms = [], []

    def start(self):
        self.begun = time.perf_counter(), time.process_time()

    def stop(self):
        self.times_ms.append(1e3 * (time.perf_counter() - self.begun[0]))
        self.cpu_ms.append(1e3 * (time.process_time() - self.begun[1]))


def serve(prepare, run, own=None):
    """Runs a program of a peer.

    `prepare(positions, triangles, sites)` returns the prepared object and a note; it raises `ValueError` to reject the mesh.
    `run(prepared)` returns the fragments. `own`, where given, is a stopwatch that `run` itself starts and stops.
    """
    source, target, runs = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3])
    result = {}
    try:
        [(positions, triangles)], sites = read_meshes(source / "mesh.bin"), read_sites(source / "sites.bin")
        begun = time.perf_counter()
        prepared, result["note"] = prepare(positions, triangles, sites)
        result["prepare_ms"] = 1e3 * (time.perf_counter() - begun)
        whole, fragments = Stopwatch(), []
        while len(whole.times_ms) < runs and sum(whole.times_ms) < LIMIT_MS:
            whole.start()
            fragments = run(prepared)
            whole.stop()
        measured = own or whole
        result["times_ms"], result["cpu_ms"] = measured.times_ms, measured.cpu_ms
        write_meshes(target / "fragments.bin", [mesh for mesh in fragments if len(mesh[1])])
    except (ValueError, RuntimeError) as error:
        result = {"rejected": (str(error).strip() or type(error).__name__).splitlines()[0]}
    (target / "result.json").write_text(json.dumps(result))
