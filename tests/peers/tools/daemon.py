"""Requests to Shatter: an object baked from the mesh, a daemon, and the client's own times."""

import json
import os
import shutil
import subprocess
import time
from pathlib import Path

from install import Unavailable

# Impulse over the one that just breaks the object.
OVER = 10.0
READY_SECONDS = 120
ROOT = Path(__file__).resolve().parents[3]


def programs(given):
    """The folder of `shatterd` and `shatter`: the one given, the build of this checkout, or one of PATH."""
    found = shutil.which("shatterd")
    folders = [Path(given)] if given else [ROOT / "target/release", *([Path(found).parent] if found else [])]
    for folder in folders:
        if (folder / "shatterd").exists() and (folder / "shatter").exists():
            return folder.resolve()
    raise Unavailable("no programs shatterd and shatter: build them with `cargo build --release`, or name their folder with --shatter")


def document(command):
    """The document that a command prints. Raises `ValueError` with its message where it rejects its input, else `Unavailable`."""
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, stdin=subprocess.DEVNULL)
    try:
        made = json.loads(done.stdout)
    except ValueError:
        made = {"error": {"fault": "environment", "message": done.stderr.strip() or f"exit code {done.returncode}"}}
    if "error" in made:
        raise (ValueError if made["error"]["fault"] == "caller" else Unavailable)(made["error"]["message"])
    return made


class Daemon:
    """A daemon of its own service that serves the mesh as object `mesh`."""

    def __init__(self, folder, mesh, work, examples):
        self.folder, self.databases = folder, work / "databases"
        self.service = f"peers-{os.getpid()}"
        bake = [folder / "shatterd", "bake", mesh, "--name", "mesh", "--unit", "m", "--quality", "game", "--examples", examples,
                "--restart", "--out", self.databases, "--json"]
        self.baked = document(bake)
        self.log = open(work / "daemon.log", "w")
        serve = [folder / "shatterd", "serve", "--service", self.service, "--databases", self.databases]
        self.process = subprocess.Popen(list(map(str, serve)), stdout=subprocess.PIPE, stderr=self.log, text=True)
        if self.process.stdout.readline().strip() != "ready":
            self.stop()
            raise Unavailable("the daemon did not start: see daemon.log")
        document([folder / "shatter", "status", "--service", self.service, "--wait", READY_SECONDS, "--json"])

    def stop(self):
        self.process.terminate()
        self.process.wait()
        self.log.close()
        shutil.rmtree(self.databases, ignore_errors=True)

    def client(self, command, ray, *options):
        where = ",".join(f"{value:.9g}" for value in ray)
        return document([self.folder / "shatter", command, "mesh", "--service", self.service, f"--ray={where}", *options, "--json"])

    def cpu_ns(self):
        """Processor time of all threads of the daemon."""
        threads = Path(f"/proc/{self.process.pid}/task").iterdir()
        return sum(int((thread / "schedstat").read_text().split()[0]) for thread in threads)

    def strike(self, ray, sites, *options):
        """The client's document, with the processor time that the daemon spent meanwhile."""
        impulse = OVER * self.client("threshold", ray)["impulse_ns"]
        before = self.cpu_ns()
        made = self.client("impact", ray, "--impulse-ns", f"{impulse:.9g}", "--degree", sites, "--quality", "game", *options)
        return {**made, "cpu_ns": self.cpu_ns() - before}


def fractured(folder, mesh, rays, sites, runs, work, examples):
    """Results of the closed meshes and of the skin: times of `runs` requests with different impacts, and the fragments of the first.

    Each program call sends one request; its time is the round trip that the client measures.
    """
    begun = time.perf_counter()
    daemon = Daemon(folder, mesh, work, examples)
    prepare_ms = 1e3 * (time.perf_counter() - begun)
    try:
        baked, results = daemon.baked, {}
        bodies = f"; {baked['bodies']} bodies" if baked["bodies"] > 1 else ""
        note = f"{examples} examples, {baked['crack_nodes']} crack nodes{bodies}"
        for name, options in {"closed": ["--disable", "skin"], "skin": ["--enable", "skin"]}.items():
            daemon.strike(rays[0], sites, *options)
            made = [daemon.strike(ray, sites, *options) for ray in rays[:runs]]
            times, cpu = ([own[key] / 1e6 for own in made] for key in ("round_trip_ns", "cpu_ns"))
            file = work / f"{name}.glb"
            struck = daemon.strike(rays[0], sites, *options, "--out", file)
            own = {"times_ms": times, "cpu_ms": cpu, "prepare_ms": prepare_ms, "note": note}
            results[name] = {**own, "fragments": file, "sites": struck["sites"]}
        return results
    finally:
        daemon.stop()
