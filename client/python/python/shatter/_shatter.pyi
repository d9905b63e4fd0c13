"""What the module offers. Lengths are in the unit of the connection's convention, meters by default, whatever their names end with."""

import os
from collections.abc import Iterator, Sequence
from types import TracebackType
from typing import Literal, final

import numpy as np
from numpy.typing import NDArray

_Convention = Literal["gltf", "godot", "unity", "unreal", "blender", "mujoco"]
_Source = Literal["closed_form", "inferred", "verified", "optimised"]
_Quality = Literal["draft", "game", "film", "reference"]
_Vector = tuple[float, float, float] | Sequence[float] | NDArray[np.float64]
_Body = tuple[float, float, float, float]

__all__ = [
    "ArgumentError",
    "Bond",
    "Broken",
    "Contact",
    "Debris",
    "Facts",
    "Fragment",
    "Hertz",
    "Hit",
    "Hull",
    "Object",
    "Refusal",
    "Run",
    "Service",
    "ShatterError",
    "Skin",
    "Status",
    "Summary",
    "Ticket",
    "__version__",
    "connect",
    "hertz",
    "wait_for",
]
__version__: str

class ShatterError(Exception):
    """Base class of the exceptions of this module."""

class ArgumentError(ShatterError, ValueError):
    """An argument cannot be used."""

class Refusal(ShatterError):
    """Why something was not done. The message is one sentence for people."""

    kind: str
    """The rule, as in JSON and logs: ``unknown_object``, ``busy``, ``lost``, …"""
    at: str
    """The offender: an argument, index, key or path; may be empty."""
    fault: Literal["caller", "service", "environment"]
    retry: bool
    """Whether the same call may succeed a little later."""
    retry_after_s: float | None

def connect(name: str | None = None, *, timeout_s: float = 1.0, convention: _Convention = "gltf") -> Service:
    """Connects to the service of that name, or without one to that of ``SHATTER_SERVICE``, or to ``default``.

    Its answers come in the coordinates of ``convention``.

    The connection outlives the daemon: what was under way when it went away ends as ``lost``, what comes next goes to its successor.
    """

def wait_for(name: str | None = None, *, timeout_s: float = 60.0, convention: _Convention = "gltf") -> Service:
    """Connects as :func:`connect` does, but waits for a daemon to appear."""

def hertz(one: _Body, other: _Body, speed_m_s: float, *, impulse_ns: float | None = None) -> Hertz:
    """How long and how wide two elastic bodies touch that meet in a point (Johnson, *Contact Mechanics*, 1985, 11.4).

    A body is its mass (kg, ``inf`` for a floor), radius where it is touched (m, ``inf`` for a plane), Young's modulus (Pa) and Poisson's
    ratio; :class:`Facts` has the moduli of objects. With ``impulse_ns`` the mass is at most that which the impulse stops.
    """

@final
class Hertz:
    @property
    def approach_m(self) -> float: ...
    @property
    def radius_m(self) -> float: ...
    @property
    def force_n(self) -> float: ...
    @property
    def duration_s(self) -> float: ...

@final
class Contact:
    """Where an object is hit, and the impulse (N·s) that is handed to it; duration and radius are the object's where not given.

    With ``ray``, a direction of any length, the point is where a ray begins: the object is struck where the ray first meets it, which
    :attr:`Broken.hit` tells. For strikes of one contact.
    """

    def __new__(
        cls,
        point: _Vector,
        impulse: _Vector,
        *,
        duration_s: float | None = None,
        radius: float | None = None,
        ray: _Vector | None = None,
    ) -> Contact: ...
    @property
    def ray(self) -> list[float] | None: ...
    @property
    def point(self) -> list[float]: ...
    @property
    def impulse(self) -> list[float]: ...
    @property
    def duration_s(self) -> float | None: ...
    @property
    def radius(self) -> float | None: ...

@final
class Hit:
    """Where a ray first meets an object: on the boundary of its crack lattice, which contact points are projected on."""

    @property
    def point(self) -> list[float]: ...
    @property
    def normal(self) -> list[float]:
        """Outward, of length one."""

    @property
    def distance(self) -> float:
        """From the origin of the ray to the point."""

    @property
    def body(self) -> int: ...

@final
class Service:
    """A connection to a service."""

    def object(self, name: str, *, timeout_s: float = 1.0) -> Object:
        """The object of that name, ready to be struck."""

    def objects(self, *, timeout_s: float = 1.0) -> list[Facts]:
        """All objects, ready or not, by name."""

    def status(self, *, timeout_s: float = 1.0) -> Status: ...
    def release(self, handle: int, *, timeout_s: float = 1.0) -> None:
        """Gives a kept answer back."""

@final
class Status:
    @property
    def pid(self) -> int: ...
    @property
    def threads(self) -> int: ...
    @property
    def clients(self) -> int: ...
    @property
    def queued(self) -> int: ...
    @property
    def running(self) -> int: ...
    @property
    def answered(self) -> int: ...
    @property
    def refused(self) -> int: ...
    @property
    def uptime_s(self) -> float: ...

@final
class Facts:
    """What a service says of an object: always meters and +Y up. Of one that is not ready all but name, state and refusal is zero."""

    @property
    def name(self) -> str: ...
    @property
    def ready(self) -> bool: ...
    @property
    def state(self) -> Literal["failed", "ready", "loading"]: ...
    @property
    def refusal(self) -> str | None: ...
    @property
    def material(self) -> str: ...
    @property
    def bodies(self) -> int: ...
    @property
    def degree_max(self) -> int: ...
    @property
    def elastic_nodes(self) -> int: ...
    @property
    def crack_nodes(self) -> int: ...
    @property
    def gamma_j_m2(self) -> float: ...
    @property
    def young_pa(self) -> float: ...
    @property
    def poisson(self) -> float: ...
    @property
    def density_kg_m3(self) -> float: ...
    @property
    def volume_m3(self) -> float: ...
    @property
    def diagonal_m(self) -> float: ...
    @property
    def center_m(self) -> list[float]: ...
    @property
    def bounds_m(self) -> list[list[float]]:
        """Lowest and highest corner of the mesh. Rays hit the lattice's surface, which can lie outside by part of its spacing."""

    @property
    def radius_m(self) -> float: ...
    @property
    def duration_s(self) -> float: ...

@final
class Object:
    """An object that can be struck."""

    @property
    def name(self) -> str: ...
    @property
    def facts(self) -> Facts: ...
    def strike(
        self,
        *contacts: Contact,
        degree: int | _Source | None = None,
        quality: _Quality | None = None,
        error: float | None = None,
        time_ms: float | None = None,
        iterations: int | None = None,
        enable: Sequence[str] | None = None,
        disable: Sequence[str] | None = None,
        gamma_j_m2: float | None = None,
        lift: Literal["euclidean", "interior", "surface_diffusion"] | None = None,
        elastic: Literal["reduced", "solve"] | None = None,
        seed: int = 0,
        keep: bool = False,
        origin: tuple[int, int] | None = None,
        deadline_s: float | None = None,
        fragments_max: int | None = None,
        bytes_max: int | None = None,
    ) -> Ticket:
        """Sends a strike of one to eight contacts; never blocks. Keywords are the flags of ``shatter impact``.

        ``degree``: a number of pieces, which breaks the object whatever γ says, or where the number comes from. ``enable`` and
        ``disable``: names of effects, such as ``normals``, ``hulls``, ``bonds``. ``origin``: handle of a kept answer and the id of its
        fragment, which is struck instead of the object.
        """

    def aim(
        self, origin: _Vector, direction: _Vector, *, fragment: tuple[int, int] | None = None, timeout_s: float = 5.0
    ) -> Hit:
        """Where the ray from ``origin`` along ``direction`` first meets the object, or ``fragment``: the handle of a kept answer
        and the id of its fragment. Waits for it."""

    def even(self, pieces: int, *, seed: int = 0, timeout_s: float = 60.0) -> Ticket:
        """Divides the whole object into even pieces without an impact; asks where bodies are first, if there are several."""

    def threshold_factor(self, *contacts: Contact, timeout_s: float = 60.0) -> float:
        """The factor on these impulses at which the object just breaks; waits for it."""

@final
class Ticket:
    """A strike under way. It is cancelled when nobody has it any more."""

    def wait(self, *, timeout_s: float = 60.0) -> Broken:
        """Waits for the answer; Ctrl-C ends it. On ``late`` the ticket is still good."""

    def poll(self) -> Broken | None:
        """The answer if it is there; never blocks. Once a frame is often enough."""

    @property
    def state(self) -> Literal["waiting", "computing", "ended"]: ...
    def cancel(self) -> None: ...

@final
class Broken:
    """The answer to a strike: a sequence of fragments, empty where the object stays whole.

    It holds memory of the service until it, its fragments and the arrays that look into it are gone; ``del`` or ``with`` let go of it.
    Copy what is kept for long (``array.copy()``).
    """

    @property
    def summary(self) -> Summary: ...
    @property
    def is_whole(self) -> bool: ...
    @property
    def handle(self) -> int | None:
        """Names this answer to later strikes (``origin``), where it was to be kept."""

    @property
    def hit(self) -> Hit | None:
        """Where the ray of the strike met the object; ``None`` if it had no ray."""

    @property
    def output_hash(self) -> str:
        """Equal answers have equal ones."""

    @property
    def positions(self) -> NDArray[np.float32]:
        """(all vertices, 3): of all fragments one after the other, each relative to its own center."""

    @property
    def bonds(self) -> list[Bond]:
        """Which fragments touch; empty unless ``bonds`` is on."""

    @property
    def debris(self) -> list[Debris]:
        """Where dust and chips come from; empty unless ``debris`` is on."""

    def write_glb(self, path: str | os.PathLike[str]) -> None:
        """Writes a binary glTF file, whole or not at all."""

    def write_obj(self, folder: str | os.PathLike[str]) -> None:
        """Writes a folder of OBJ files with a table."""

    def write_mjcf(self, path: str | os.PathLike[str]) -> None:
        """Writes a MuJoCo model, with its meshes in a folder beside it; ``bonds`` and ``hulls`` make it collide and hold."""

    def release(self) -> None:
        """Gives the memory back now; ``BufferError`` while fragments or arrays look into it."""

    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> Fragment: ...
    def __iter__(self) -> Iterator[Fragment]: ...
    def __enter__(self) -> Broken: ...
    def __exit__(self, *_error: type[BaseException] | BaseException | TracebackType | None) -> None: ...

@final
class Summary:
    """The facts of a strike."""

    @property
    def object(self) -> str: ...
    @property
    def sites(self) -> int: ...
    @property
    def fracture_degree(self) -> int: ...
    @property
    def degree_source(self) -> str: ...
    @property
    def capped(self) -> bool: ...
    @property
    def stop_reason(self) -> str: ...
    @property
    def elastic(self) -> str: ...
    @property
    def quality(self) -> str: ...
    @property
    def iterations(self) -> int: ...
    @property
    def gamma_j_m2(self) -> float: ...
    @property
    def e1_over_gamma(self) -> float: ...
    @property
    def threshold_impulse_factor(self) -> float: ...
    @property
    def confidence(self) -> float: ...
    @property
    def radius_m(self) -> float: ...
    @property
    def energy_error(self) -> float: ...
    @property
    def cvd_gap(self) -> float: ...
    @property
    def seed(self) -> int: ...
    @property
    def time_s(self) -> float: ...
    @property
    def overrun_s(self) -> float: ...
    @property
    def overrun_reason(self) -> str | None: ...
    @property
    def round_trip_s(self) -> float: ...
    @property
    def bytes(self) -> int: ...

@final
class Fragment:
    """One fragment: a closed mesh and what a rigid body needs. Arrays look into shared memory and are read-only."""

    @property
    def id(self) -> int: ...
    @property
    def body(self) -> int: ...
    @property
    def volume_m3(self) -> float: ...
    @property
    def mass_kg(self) -> float: ...
    @property
    def center_m(self) -> NDArray[np.float64]:
        """(3,): center of mass."""

    @property
    def inertia_kg_m2(self) -> NDArray[np.float64]:
        """(3, 3): about the center of mass."""

    @property
    def linear_m_s(self) -> NDArray[np.float64] | None:
        """(3,): on top of how the object moved; None unless ``release`` is on."""

    @property
    def angular_rad_s(self) -> NDArray[np.float64] | None: ...
    @property
    def positions(self) -> NDArray[np.float32]:
        """(vertices, 3): relative to the center of mass."""

    @property
    def triangles(self) -> NDArray[np.uint32]:
        """(triangles, 3): rows of ``positions``, counter-clockwise from outside."""

    @property
    def merges(self) -> NDArray[np.uint32]:
        """(pairs, 2): vertices that are the same point; with them every edge has one opposite."""

    @property
    def normals(self) -> NDArray[np.float32] | None:
        """(vertices, 3); None unless ``normals`` is on."""

    @property
    def uvs(self) -> NDArray[np.float32] | None:
        """(vertices, 2), m; None unless ``uv`` is on."""

    @property
    def looks(self) -> NDArray[np.float32] | None:
        """(vertices, 5): normal and texture coordinates of the input, zero on cracks; None unless ``attributes`` is on."""

    @property
    def materials(self) -> NDArray[np.uint32] | None:
        """(triangles,): the input's, 2³²−1 on cracks; None unless ``attributes`` is on and the input has any."""

    @property
    def runs(self) -> list[Run]: ...
    @property
    def hull(self) -> Hull | None:
        """Convex proxy for collisions; None unless ``hulls`` is on."""

    @property
    def skin(self) -> Skin | None:
        """Its part of the input's own triangles; None unless ``skin`` is on."""

    def is_closed(self) -> bool: ...

@final
class Run:
    """Consecutive triangles and vertices of a fragment that face one neighbor; None: the outside, or an older crack."""

    @property
    def neighbor(self) -> int | None: ...
    @property
    def crack(self) -> bool: ...
    @property
    def triangle_first(self) -> int: ...
    @property
    def triangle_count(self) -> int: ...
    @property
    def vertex_first(self) -> int: ...
    @property
    def vertex_count(self) -> int: ...

@final
class Hull:
    @property
    def positions(self) -> NDArray[np.float32]: ...
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def coverage(self) -> float:
        """Volume of the part of the fragment inside the hull over that of the fragment."""

    @property
    def margin_m(self) -> float:
        """The deepest that any other fragment lies below the hull's surface."""

@final
class Skin:
    @property
    def vertices(self) -> NDArray[np.float32]:
        """(vertices, 8): position, normal, texture coordinates."""

    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def materials(self) -> NDArray[np.uint32]: ...

@final
class Bond:
    @property
    def fragments(self) -> tuple[int, int | None]:
        """The lower id first; None: the world."""

    @property
    def area_m2(self) -> float: ...
    @property
    def normal(self) -> list[float]: ...
    @property
    def centroid_m(self) -> list[float]: ...

@final
class Debris:
    @property
    def fragment(self) -> int: ...
    @property
    def neighbor(self) -> int: ...
    @property
    def position_m(self) -> list[float]: ...
    @property
    def normal(self) -> list[float]: ...
    @property
    def size_m(self) -> float: ...
