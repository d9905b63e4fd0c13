#!/usr/bin/env python3
"""Fractures meshes by Shatter and by other tools, and judges all fragments with one checker.

python3 compare.py MESH... [--sites N] [--runs N] [--work DIR] [--out FILE.md|FILE.json]...

The script installs pinned versions of the other tools into the folder of `--work`, from PyPI, npm and GitHub, and builds geogram and
Blast (g++, the headers of Boost). A tool that cannot be had has a row with the reason. `--source NAME=PATH` uses a local checkout
instead of a clone; its commit must be the pinned one. Each tool gets the same mesh. Tools that take sites get the same sites: points
inside the mesh, of a fixed seed. Shatter and fracture-modes place their cracks by themselves.
"""

import argparse
import json
import os
import platform
import shlex
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

TOOLS = Path(__file__).resolve().parent / "tools"
sys.path.insert(0, str(TOOLS))
import daemon  # noqa: E402
from install import NPM, PACKAGES, SOURCES, Installer, Unavailable  # noqa: E402

SHATTER, SKIN = "Shatter", "Shatter, skin"
COLUMNS = ["tool", "time, ms", "processor, ms", "once per mesh, s", "fragments", "closed", "volume error", "surface error, mean", "largest",
           "in several parts", "slivers"]


TIMES = ["times_ms", "cpu_ms"]


def commit(name):
    return SOURCES[name].commit[:7]


def pinned(name):
    versions = dict(package.split("==") for package in PACKAGES[name])
    return lambda package: f"{package} {versions[package]}"


def versions():
    voro, modes = pinned("voro++"), pinned("fracture-modes")
    return {
        "voro++ and Manifold": f"{voro('multivoro')}, {voro('manifold3d')} (PyPI)",
        "geogram": f"commit {commit('geogram')}, with its TetGen",
        "Blast": f"5.0.6, commit {commit('blast')}",
        "three-pinata": f"{NPM[0].rpartition('@')[2]} (npm)",
        "Blender Cell Fracture": f"add-on 0.2, commit {commit('cell-fracture')}, in bpy {PACKAGES['cell-fracture'][0][5:]} (PyPI)",
        "fracture-modes": f"commit {commit('fracture-modes')}, {modes('clarabel')} instead of Mosek",
    }


def blender(installer):
    """Command line of Blender's Python package, or else of a Blender on PATH."""
    add_on, script = installer.source("cell-fracture"), TOOLS / "blender_cells.py"
    try:
        return [installer.python("cell-fracture"), script], [add_on]
    except Unavailable as reason:
        if shutil.which("blender") is None:
            raise Unavailable(f"{reason}; no blender on PATH") from None
        return ["blender", "--background", "--factory-startup", "--python", script, "--"], [add_on]


def commands(installer):
    """Of each peer, a function that installs it and returns the words before and after the three common arguments."""
    return {
        "voro++ and Manifold": lambda: ([installer.python("voro++"), TOOLS / "voro_manifold.py"], []),
        "geogram": lambda: ([installer.built("geogram")], []),
        "Blast": lambda: ([installer.built("blast")], []),
        "three-pinata": lambda: (["node", installer.npm() / "pinata.mjs"], []),
        "Blender Cell Fracture": lambda: blender(installer),
        "fracture-modes": lambda: (
            [installer.python("fracture-modes"), TOOLS / "modes.py"], [installer.source("fracture-modes")]
        ),
    }


def run_peer(command, folder, target, runs, seconds):
    """The result of one peer on the mesh in `folder`: times and the file of fragments, or the reason why there are none."""
    target.mkdir(parents=True, exist_ok=True)
    for old in target.iterdir():
        old.unlink()
    before, after = command
    words = list(map(str, [*before, folder, target, runs, *after]))
    with open(target / "log", "w") as log:
        try:
            done = subprocess.run(words, stdout=log, stderr=log, stdin=subprocess.DEVNULL, timeout=seconds)
        except subprocess.TimeoutExpired:
            return {"rejected": f"no result after {seconds} s"}
    try:
        result = json.loads((target / "result.json").read_text())
    except (OSError, ValueError):
        lines = [line.strip() for line in (target / "log").read_text(errors="replace").splitlines() if line.strip()]
        ended = f"ended by signal {-done.returncode}" if done.returncode < 0 else f"exit code {done.returncode}"
        return {"rejected": f"{ended}: {lines[-1][:120]}" if lines and done.returncode > 0 else ended}
    if "rejected" not in result:
        result["fragments"] = target / "fragments.bin"
    return result


def judged(python, folder, result):
    """The result with the checker's figures in place of the file."""
    if "fragments" not in result:
        return result
    done = subprocess.run([python, TOOLS / "judge.py", "fragments", folder, result["fragments"]], capture_output=True, text=True)
    if done.returncode:
        return {"rejected": f"no usable fragments: {done.stderr.strip().splitlines()[-1][:120]}"}
    return {**result, **json.loads(done.stdout)}


def compare(path, options, installer, python, peers):
    """Results by tool, and the checker's description of the mesh."""
    name = Path(path).stem
    folder = Path(options.work) / "meshes" / name
    folder.mkdir(parents=True, exist_ok=True)
    subprocess.run([python, TOOLS / "judge.py", "prepare", path, folder, str(options.sites)], check=True)
    mesh, results, kept = json.loads((folder / "input.json").read_text()), {}, folder / f"results-{options.sites}-{options.runs}.json"
    old = json.loads(kept.read_text()) if options.resume and kept.exists() else {}
    if "Shatter" in options.tools and SHATTER in old:
        results = {tool: old[tool] for tool in (SHATTER, SKIN)}
    elif "Shatter" in options.tools:
        print(f"{name}: Shatter", file=sys.stderr, flush=True)
        try:
            programs, rays = daemon.programs(options.shatter), mesh["rays"]
            struck = daemon.fractured(programs, path, rays, options.sites, options.runs, folder, options.examples)
            results[SHATTER], results[SKIN] = (judged(python, folder, struck[kind]) for kind in ("closed", "skin"))
        except (Unavailable, ValueError) as reason:
            missing = "unavailable" if isinstance(reason, Unavailable) else "rejected"
            results[SHATTER] = results[SKIN] = {missing: str(reason)}
    for tool, command in peers.items():
        if tool in old:
            results[tool] = old[tool]
        elif isinstance(command, Unavailable):
            results[tool] = {"unavailable": str(command)}
        else:
            print(f"{name}: {tool}", file=sys.stderr, flush=True)
            result = run_peer(command, folder, folder / tool.replace(" ", "-"), options.runs, options.timeout)
            results[tool] = judged(python, folder, result)
        had = {**old, **{tool: result for tool, result in results.items() if "unavailable" not in result}}
        kept.write_text(json.dumps(had, default=str))
    return {"mesh": {"name": name, **{key: value for key, value in mesh.items() if key != "rays"}}, "results": results}


def percent(share):
    return "0" if share < 1e-7 else f"{100 * share:.2g} %" if share < 0.995 else f"{100 * share:.0f} %"


def row(tool, result):
    if "fragments" not in result:
        reason = f"not available: {result['unavailable']}" if "unavailable" in result else f"rejected: {result['rejected']}"
        return [tool, reason.replace("|", "/"), *["–"] * (len(COLUMNS) - 2)]
    once = result["prepare_ms"] / 1e3
    times = (statistics.median(result[key]) for key in TIMES)
    return [
        tool, *(f"{time:.1f}" if time < 100 else f"{time:,.0f}" for time in times), "–" if once < 0.05 else f"{once:.1f}" if once < 10 else f"{once:.0f}", str(result["fragments"]),
        str(result["closed"]), percent(result["volume_error"]), percent(result["surface_mean"]), percent(result["surface_max"]),
        str(result["several"]), str(result["slivers"]),
    ]


def table(rows):
    lines = ["| " + " | ".join(cells) + " |" for cells in rows]
    return [lines[0], "|" + "---|" * len(rows[0]), *lines[1:]]


def of_fragments(result):
    if "fragments" not in result:
        return "not available" if "unavailable" in result else "rejected"
    whole = result["closed"] == result["fragments"]
    return "all closed" if whole else f"{result['closed']} of {result['fragments']}"


def markdown(document):
    lines = [document["machine"] + ".", "", "`" + document["command"] + "`", ""]
    lines += [f"- {tool}: {version}" for tool, version in document["versions"].items()]
    tools = list(document["meshes"][0]["results"])
    lines += ["", "Closed fragments of returned fragments:", ""]
    lines += table([["mesh", *tools], *([own["mesh"]["name"], *map(of_fragments, own["results"].values())] for own in document["meshes"])])
    for own in document["meshes"]:
        mesh = own["mesh"]
        kind, volume = "closed" if mesh["closed"] else "open", "exact" if mesh["volume_is_exact"] else "by winding numbers"
        lines += ["", f"### {mesh['name']}", "", f"{mesh['triangles']:,} triangles, {kind}; volume {volume}.", ""]
        lines += table([COLUMNS, *(row(tool, result) for tool, result in own["results"].items())])
        notes = {tool: result["note"] for tool, result in own["results"].items() if result.get("note") and tool != SKIN}
        lines += ["", *(f"- {tool}: {note}" for tool, note in notes.items())] if notes else []
    return "\n".join(lines) + "\n"


def machine():
    model = next((line.partition(":")[2].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), platform.machine())
    cores, system = len(os.sched_getaffinity(0)), platform.freedesktop_os_release().get("PRETTY_NAME", platform.system())
    return f"{model}, {cores} {'core' if cores == 1 else 'cores'}, {system}, Python {platform.python_version()}"


def head():
    done = subprocess.run(["git", "-C", daemon.ROOT, "rev-parse", "--short", "HEAD"], capture_output=True, text=True)
    return done.stdout.strip() or "unknown"


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("meshes", nargs="+", metavar="MESH", help="mesh file, .obj or .ply")
    parser.add_argument("--sites", type=int, default=50, help="number of sites [50]")
    parser.add_argument("--runs", type=int, default=5, help="timed runs of each tool; the median counts [5]")
    parser.add_argument("--examples", type=int, default=100, help="examples of Shatter's bake [100]")
    parser.add_argument("--work", default="peers-work", help="folder of installations and fragments [peers-work]")
    parser.add_argument("--out", action="append", default=[], metavar="FILE", help="file to write, .md or .json; repeat for both")
    parser.add_argument("--resume", action="store_true", help="take results that an interrupted run left in --work")
    parser.add_argument("--source", action="append", default=[], metavar="NAME=PATH", help=f"local checkout of {', '.join(SOURCES)}")
    parser.add_argument("--shatter", metavar="DIR", help="folder of shatterd and shatter [target/release, or PATH]")
    parser.add_argument("--commit", default=head(), help="commit of Shatter's programs, for the report [of this checkout]")
    parser.add_argument("--tools", type=lambda text: text.split(","), help="tools to run, separated by commas [all]")
    parser.add_argument("--timeout", type=int, default=900, help="longest time of one tool on one mesh, s [900]")
    return parser.parse_args()


def main():
    options = arguments()
    work = Path(options.work).resolve()
    work.mkdir(parents=True, exist_ok=True)
    options.work = work
    installer = Installer(work, dict(given.split("=", 1) for given in options.source))
    python, peers = installer.python("judge"), commands(installer)
    options.tools = options.tools or [SHATTER, *peers]
    ready = {}
    for tool in (tool for tool in peers if tool in options.tools):
        print(f"install: {tool}", file=sys.stderr, flush=True)
        try:
            ready[tool] = peers[tool]()
        except Unavailable as reason:
            ready[tool] = reason
    document = {
        "machine": machine(), "command": "python3 tests/peers/compare.py " + shlex.join(sys.argv[1:]),
        "versions": {SHATTER: f"commit {options.commit}", **versions()}, "sites": options.sites, "runs": options.runs,
        "meshes": [compare(path, options, installer, python, ready) for path in options.meshes],
    }
    plain = json.dumps(document, indent=1, default=str)
    for file in options.out:
        Path(file).write_text(markdown(document) if file.endswith(".md") else plain + "\n")
    print(plain if not options.out else markdown(document), end="\n" if not options.out else "")


main()
