"""Pinned versions of the peers: environments of Python, packages of npm, and sources that are built here."""

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

TOOLS = Path(__file__).parent
PACKAGES = {
    "judge": ["numpy==2.4.6", "scipy==1.17.1", "libigl==2.6.3"],
    "voro++": ["numpy==2.4.6", "multivoro==0.1.3", "manifold3d==3.5.4"],
    "fracture-modes": ["numpy==1.26.4", "scipy==1.15.3", "libigl==2.4.1", "gpytoolbox==0.3.8", "tetgen==0.8.4", "clarabel==0.11.1"],
    "cell-fracture": ["bpy==5.0.1"],
    "geogram": ["cmake==3.31.6", "ninja==1.13.2", "tbb-devel==2023.2.0"],
}
NPM = ["@dgreenheck/three-pinata@2.0.1", "three@0.187.0"]


@dataclass
class Source:
    address: str
    commit: str
    folder: str = "."
    submodules: list = field(default_factory=list)


THIRD_PARTY = "src/lib/geogram/third_party"
SOURCES = {
    "geogram": Source(
        "https://github.com/BrunoLevy/geogram.git", "3511fb0b7f1d2afe4d3cf916c98fb4e5bfedbd5d",
        submodules=[f"{THIRD_PARTY}/{name}" for name in ("amgcl", "libMeshb", "rply", "OpenNL")],
    ),
    "fracture-modes": Source("https://github.com/sgsellan/fracture-modes.git", "bdf5051fb0d78d787f49fabbf75b54bbc6698b17"),
    "cell-fracture": Source(
        "https://github.com/blender/blender-addons.git", "b42d68627734cb18af0e6f41537063984313a284", "object_fracture_cell"
    ),
    "blast": Source("https://github.com/NVIDIA-Omniverse/PhysX.git", "a3d8a641de4c3014fd56704af0f50b8be7e9778b", "blast"),
}
GEOGRAM_OPTIONS = ["LIB_ONLY=ON", *(f"WITH_{part}=OFF" for part in ("GRAPHICS", "LUA", "HLBFGS", "LEGACY_NUMERICS", "TRIANGLE"))]
BLAST_INCLUDES = [
    "include/lowlevel", "include/globals", "include/shared/NvFoundation", "include/extensions/assetutils",
    "include/extensions/authoring", "include/extensions/authoringCommon", "source/sdk/common", "source/sdk/globals",
    "source/sdk/lowlevel", "source/sdk/extensions/authoring", "source/sdk/extensions/authoringCommon",
    "source/sdk/extensions/authoring/VHACD/inc", "source/sdk/extensions/authoring/VHACD/public",
    "source/shared/NsFoundation/include", "source/shared/NvTask/include",
]
BLAST_FOLDERS = ["common", "globals", "lowlevel", "extensions/assetutils", "extensions/authoring", "extensions/authoring/VHACD/src",
                 "extensions/authoringCommon"]
BLAST_FLAGS = ["-O2", "-DNDEBUG", "-DCARB_DEBUG=0", "-std=c++17", "-w", "-include", "cstdio", "-include", "cstdint", "-include", "cstring"]


class Unavailable(Exception):
    """A tool that cannot be installed, built or run here; the text is the reason."""


def call(command, log, reason, **options):
    """Runs a command of an installation; its output goes to `log`, and its last line into the reason of a failure."""
    with open(log, "a") as file:
        file.write(f"$ {' '.join(map(str, command))}\n")
        file.flush()
        try:
            done = subprocess.run(list(map(str, command)), stdout=file, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL, **options)
        except FileNotFoundError:
            raise Unavailable(f"{reason}: no program {command[0]}") from None
    if done.returncode:
        lines = [line for line in Path(log).read_text(errors="replace").splitlines() if line.strip()]
        raise Unavailable(f"{reason}: {lines[-1][:160]}")


class Installer:
    """Installs into a folder, once."""

    def __init__(self, work, sources):
        self.work, self.given = Path(work), sources
        self.log = self.work / "install.log"

    def python(self, name):
        """The interpreter of the environment `name`."""
        folder = self.work / "environments" / name
        python, done = folder / "bin/python", folder / "installed"
        wanted = "\n".join(PACKAGES[name])
        if not done.exists() or done.read_text() != wanted:
            shutil.rmtree(folder, ignore_errors=True)
            call([sys.executable, "-m", "venv", folder], self.log, "no virtual environment")
            install = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", *PACKAGES[name]]
            call([python, *install], self.log, f"pip cannot install {' '.join(PACKAGES[name])}")
            done.write_text(wanted)
        return python

    def npm(self):
        """The folder that holds `node_modules` of three-pinata and the program that drives it."""
        folder = self.work / "environments/three-pinata"
        folder.mkdir(parents=True, exist_ok=True)
        if not (folder / "node_modules").exists():
            (folder / "package.json").write_text("{}")
            call(["npm", "install", "--no-audit", "--no-fund", *NPM], self.log, "npm cannot install three-pinata", cwd=folder)
        shutil.copy(TOOLS / "pinata.mjs", folder)
        return folder

    def source(self, name):
        """The folder of a source at its pinned commit: the checkout given by the user, or a clone."""
        source = SOURCES[name]
        if name in self.given:
            folder = Path(self.given[name]).resolve()
            if not (folder / source.folder).is_dir():
                raise Unavailable(f"{folder} has no folder {source.folder}")
            head = subprocess.run(["git", "-C", folder, "rev-parse", "HEAD"], capture_output=True, text=True).stdout.strip()
            if head and head != source.commit:
                raise Unavailable(f"the given checkout is at {head[:7]}, not at the pinned {source.commit[:7]}")
            return folder / source.folder
        folder = self.work / "sources" / name
        if not (folder / "fetched").exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir(parents=True)
            reason = f"cannot clone {source.address}"
            git = ["git", "-C", folder]
            call([*git, "init", "--quiet"], self.log, reason)
            if source.folder != ".":
                call([*git, "sparse-checkout", "set", source.folder], self.log, reason)
            call([*git, "remote", "add", "origin", source.address], self.log, reason)
            call([*git, "fetch", "--quiet", "--depth=1", "--filter=blob:none", "origin", source.commit], self.log, reason)
            call([*git, "checkout", "--quiet", "FETCH_HEAD"], self.log, reason)
            for module in source.submodules:
                call([*git, "submodule", "update", "--init", "--depth=1", module], self.log, reason)
            (folder / "fetched").touch()
        return folder / source.folder

    def built(self, name):
        """The program of a peer in C++, built from its source and the driver beside this file."""
        program = self.work / "built" / name / "program"
        if not program.exists():
            source, folder = self.source(name), program.parent
            folder.mkdir(parents=True, exist_ok=True)
            {"geogram": self.build_geogram, "blast": self.build_blast}[name](source, folder)
            call(["ls", program], self.log, f"cannot build {name}")
        return program

    def build_geogram(self, source, folder):
        tools = self.python("geogram").parent
        threads = tools.parent / "lib"  # of oneTBB, which the C++ library's parallel algorithms need
        paths = {**os.environ, "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}", "LIBRARY_PATH": str(threads)}
        linker = f"-Wl,-rpath,{threads}"
        reason, build = "cannot build geogram", folder / "library"
        options = ["-DCMAKE_BUILD_TYPE=Release", "-DVORPALINE_PLATFORM=Linux64-gcc-dynamic", f"-DCMAKE_SHARED_LINKER_FLAGS={linker}"]
        options += [f"-DGEOGRAM_{option}" for option in GEOGRAM_OPTIONS]
        call(["cmake", "-G", "Ninja", "-S", source, "-B", build, *options], self.log, reason, env=paths)
        call(["ninja", "-C", build, f"-j{len(os.sched_getaffinity(0))}"], self.log, reason, env=paths)
        library = next(build.rglob("libgeogram.so")).parent
        flags = ["-O2", "-std=c++17", "-I", source / "src/lib", "-I", build / "src/lib"]
        link = ["-L", library, "-lgeogram", f"-Wl,-rpath,{library}", linker, "-L", threads, "-ltbb", "-lpthread"]
        call(["g++", *flags, TOOLS / "geogram.cpp", *link, "-o", folder / "program"], self.log, reason, env=paths)

    def build_blast(self, source, folder):
        includes = [f"-I{source / include}" for include in BLAST_INCLUDES]
        compile_ = ["g++", *BLAST_FLAGS, *includes]
        objects = []
        for part in BLAST_FOLDERS:
            for file in sorted((source / "source/sdk" / part).glob("*.cpp")):
                objects.append(folder / f"{file.stem}.o")
                call([*compile_, "-c", file, "-o", objects[-1]], self.log, "cannot build Blast (it needs g++ and the headers of Boost)")
        call([*compile_, TOOLS / "blast.cpp", *objects, "-lpthread", "-o", folder / "program"], self.log, "cannot build Blast")
