"""Names of the module. Lengths are in the unit of the connection's convention, meters by default, whatever their names end with."""

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
    "FractureResult",
    "Contact",
    "ContactPartner",
    "Debris",
    "Facts",
    "Fragment",
    "Hertz",
    "Hit",
    "Hull",
    "Object",
    "ServiceError",
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
    """An argument that cannot be used."""

class ServiceError(ShatterError):
    """An error of the client or the service. The message is one sentence for people."""

    kind: str
    """Name of the error, as in JSON and logs: ``unknown_object``, ``busy``, ``lost``, …"""
    at: str
    """Argument, index, key or path that caused the error; may be empty."""
    fault: Literal["caller", "service", "environment"]
    retry: bool
    """Whether the same call may succeed a little later."""
    retry_after_s: float | None

def connect(name: str | None = None, *, timeout_s: float = 1.0, convention: _Convention = "gltf") -> Service:
    """Connects to a service by name; without a name to that of ``SHATTER_SERVICE``, or to ``default``.

    Its results come in the coordinates of ``convention``.

    The connection outlives the daemon: requests under way when a daemon goes away end as ``lost``; later ones go to its successor.
    """

def wait_for(name: str | None = None, *, timeout_s: float = 60.0, convention: _Convention = "gltf") -> Service:
    """Connects as :func:`connect` does, but waits for a daemon to appear."""

def hertz(one: _Body, other: _Body, speed_m_s: float, *, impulse_ns: float | None = None) -> Hertz:
    """Computes duration and radius of an elastic contact by Hertz theory (Johnson, *Contact Mechanics*, 1985, 11.4).

    A body is its mass (kg, ``inf`` for a floor), radius at the contact (m, ``inf`` for a plane), Young's modulus (Pa) and Poisson's
    ratio; :class:`Facts` has the moduli of objects. With ``impulse_ns`` the effective mass is at most the one that the impulse stops.
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
    """One contact of an impact: point, impulse (N·s), duration and radius; the last two are the object's if not given.

    With ``ray``, a direction of any length, ``point`` is the origin of a ray, and the contact point is its first hit on the object:
    :attr:`FractureResult.hit`. Only for impacts of one contact.

    With ``partner``, the body that strikes, the object stores no more energy than the impact has. Give one for all contacts or for none.
    """

    def __new__(
        cls,
        point: _Vector,
        impulse: _Vector,
        *,
        duration_s: float | None = None,
        radius: float | None = None,
        ray: _Vector | None = None,
        partner: ContactPartner | None = None,
    ) -> Contact: ...
    @property
    def partner(self) -> ContactPartner | None: ...
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
class ContactPartner:
    """Body that strikes an object at a contact: its mass (``math.inf`` if it does not move), and the closing speed along the impulse.

    Contacts whose partners have the same ``id`` have the same partner, whose energy counts once. With ``inertia``, its tensor about
    ``center`` (kg·m²: xx, yy, zz, xy, xz, yz), it may rotate. Lengths are in the unit of the connection's convention.
    """

    def __new__(
        cls,
        mass_kg: float,
        speed: float,
        *,
        id: int = 0,
        center: _Vector | None = None,
        inertia: Sequence[float] | None = None,
    ) -> ContactPartner: ...
    @property
    def mass_kg(self) -> float: ...
    @property
    def speed(self) -> float: ...
    @property
    def id(self) -> int: ...
    @property
    def center(self) -> list[float]: ...
    @property
    def inertia(self) -> list[float]: ...

@final
class Hit:
    """First hit of a ray on an object: on the surface that fragments end on (with ``surface="lattice"``, the boundary of the crack lattice), onto which contact points are projected."""
    @property
    def point(self) -> list[float]: ...
    @property
    def normal(self) -> list[float]:
        """Outward normal of the surface at the point, of length one."""
    @property
    def distance(self) -> float:
        """Distance from the origin of the ray to the point."""
    @property
    def body(self) -> int: ...

@final
class Service:
    """A connection to a service."""

    def object(self, name: str, *, timeout_s: float = 1.0) -> Object:
        """Finds an object by name, ready to be struck."""

    def objects(self, *, timeout_s: float = 1.0) -> list[Facts]:
        """All objects, ready or not, by name."""

    def status(self, *, timeout_s: float = 1.0) -> Status: ...
    def release(self, handle: int, *, timeout_s: float = 1.0) -> None:
        """Releases a kept result: its fragments cannot be struck any more."""

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
    def completed(self) -> int: ...
    @property
    def refused(self) -> int: ...
    @property
    def uptime_s(self) -> float: ...

@final
class Facts:
    """Facts of an object, always in meters and +Y up. If it is not ready, all but name, state and error is zero."""
    @property
    def name(self) -> str: ...
    @property
    def ready(self) -> bool: ...
    @property
    def state(self) -> Literal["failed", "ready", "loading"]: ...
    @property
    def error(self) -> str | None: ...
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
        """Lowest and highest corner of the mesh, or of the lattice without its skin, whose surface can lie outside by part of its spacing."""
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
        enable: Sequence[str] | str | None = None,
        disable: Sequence[str] | str | None = None,
        gamma_j_m2: float | None = None,
        lift: Literal["euclidean", "interior", "surface_diffusion"] | None = None,
        elastic: Literal["reduced", "solve"] | None = None,
        surface: Literal["exact", "lattice"] | None = None,
        criterion: Literal["paper", "strength"] | None = None,
        seed: int = 0,
        keep: bool = False,
        origin: tuple[int, int] | None = None,
        deadline_s: float | None = None,
        fragments_max: int | None = None,
        bytes_max: int | None = None,
    ) -> Ticket:
        """Sends a request of one to eight contacts; never blocks. Keywords are the options of ``shatter impact``.

        ``degree``: a number of sites, which breaks the object whatever γ is, or the rule that sets the number. ``enable`` and
        ``disable``: names of effects, such as ``["normals", "hulls"]``, or one name. ``origin``: handle of a kept result and id of
        its fragment, which is struck instead of the object.
        """

    def aim(
        self, origin: _Vector, direction: _Vector, *, fragment: tuple[int, int] | None = None, timeout_s: float = 5.0
    ) -> Hit:
        """Finds the first hit of the ray from ``origin`` along ``direction`` on the object, or on ``fragment``: the handle of a
        kept result and the id of its fragment. Waits for the service."""

    def even(self, pieces: int, *, seed: int = 0, timeout_s: float = 60.0) -> Ticket:
        """Divides the whole object evenly without an impact; asks the service where the bodies are first, if there are several."""

    def threshold_factor(self, *contacts: Contact, timeout_s: float = 60.0) -> float:
        """Factor on these impulses at which the object just breaks; waits for the service."""

@final
class Ticket:
    """A request under way. It is canceled when the last reference to it goes before its result."""

    def wait(self, *, timeout_s: float = 60.0) -> FractureResult:
        """Waits for the result; Ctrl-C ends it. After ``late`` the ticket is still valid."""

    def poll(self) -> FractureResult | None:
        """The result if there is one; never blocks. Once a frame is often enough."""
    @property
    def state(self) -> Literal["waiting", "computing", "ended"]:
        """State when last heard of: a call asks for the next one. After ``cancel`` it raises ``ServiceError``."""
    def cancel(self) -> None: ...

@final
class FractureResult:
    """The result of a request: a sequence of fragments, empty if the object stays whole.

    It holds memory of the service until it, its fragments and all arrays that refer to it are gone; ``del`` or ``with`` release it.
    Copy arrays that you keep for long (``array.copy()``).
    """
    @property
    def summary(self) -> Summary: ...
    @property
    def is_whole(self) -> bool: ...
    @property
    def handle(self) -> int | None:
        """Handle of this result for later requests (``origin``); ``None`` if the service does not keep it."""
    @property
    def hit(self) -> Hit | None:
        """First hit of the request's ray on the object; ``None`` if it had no ray."""
    @property
    def output_hash(self) -> str:
        """Content hash: equal for identical results."""
    @property
    def positions(self) -> NDArray[np.float32]:
        """(all vertices, 3): the vertices of all fragments one after another, each relative to the center of its fragment."""
    @property
    def bonds(self) -> list[Bond]:
        """Contact areas between fragments; empty unless ``bonds`` is on."""
    @property
    def debris(self) -> list[Debris]:
        """Points on cracks from which dust and chips come; empty unless ``debris`` is on."""

    def write_glb(self, path: str | os.PathLike[str], materials: str | os.PathLike[str] | None = None) -> None:
        """Writes a binary glTF file (.glb), whole or not at all; with the materials and textures of the mesh file ``materials`` (.glb,
        .gltf) that the object was baked from. They need the effect ``attributes``."""

    def write_obj(self, folder: str | os.PathLike[str]) -> None:
        """Writes a folder of OBJ files with a table."""

    def write_mjcf(self, path: str | os.PathLike[str]) -> None:
        """Writes a MuJoCo model, with its meshes in a folder beside it; ``bonds`` and ``hulls`` make it hold together and collide."""

    def release(self) -> None:
        """Releases the memory now; ``BufferError`` while fragments or arrays refer to it."""

    def __len__(self) -> int: ...
    def __getitem__(self, index: int, /) -> Fragment: ...
    def __iter__(self) -> Iterator[Fragment]: ...
    def __enter__(self) -> FractureResult: ...
    def __exit__(self, *_error: type[BaseException] | BaseException | TracebackType | None) -> None: ...

@final
class Summary:
    """Summary of a result."""
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
    def threshold_impulse_factor(self) -> float:
        """Factor on the impulses at which the object just breaks; a lower bound of it if ``elastic`` is ``bounded``. With ``gravity``, on
        all loads, weight among them, except in a request for the threshold. Without meaning for an even division."""
    @property
    def strain_j(self) -> float | None:
        """Strain energy of the struck bodies at peak load, J: of all contacts, and of the weight with ``gravity``; with
        ``dynamics``, its largest over time. None if ``elastic`` is ``bounded`` or ``falloff``."""
    @property
    def criterion(self) -> str:
        """Rule that decided whether the object breaks: ``paper`` or ``strength``. The next four are None with ``paper``."""
    @property
    def stress_over_strength(self) -> float | None:
        """Largest averaged equivalent stress over the tensile strength."""
    @property
    def surface_j(self) -> float | None:
        """Energy of the new surface, J: toughness times the area of all cracks. None without fragments."""
    @property
    def released_j(self) -> float | None:
        """Kinetic energy of the release velocities, J. None without ``release``."""
    @property
    def deficit_j(self) -> float | None:
        """Energy that a given number of sites lacks, J. None if nothing lacks."""
    @property
    def impactor_j(self) -> float | None:
        """Kinetic energy that the contacts can take from the motion of object and partners, J. None without partners."""
    @property
    def remainder_j(self) -> float | None:
        """Energy of these that the object does not store, J. None without partners, and where ``strain_j`` is None."""
    @property
    def load_factor(self) -> float | None:
        """Factor on all loads, 0 to 1, so that the object stores no more than ``impactor_j``: 1 if nothing was lowered. None without
        partners, and if ``elastic`` is ``bounded``."""
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
    def surface(self) -> str: ...
    @property
    def round_trip_s(self) -> float: ...
    @property
    def bytes(self) -> int: ...

@final
class Fragment:
    """One fragment: a closed mesh, and the data of a rigid body. Arrays refer to shared memory and are read-only."""
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
        """(3, 3): inertia tensor about the center of mass."""
    @property
    def linear_m_s(self) -> NDArray[np.float64] | None:
        """(3,): velocity in addition to the object's; None unless ``release`` is on."""
    @property
    def angular_rad_s(self) -> NDArray[np.float64] | None: ...
    @property
    def positions(self) -> NDArray[np.float32]:
        """(vertices, 3): positions relative to the center of mass."""
    @property
    def triangles(self) -> NDArray[np.uint32]:
        """(triangles, 3): rows of ``positions``, counter-clockwise from outside unless the convention is clockwise."""
    @property
    def merges(self) -> NDArray[np.uint32]:
        """(pairs, 2): vertices that are the same point; with them every edge has exactly one opposite."""
    @property
    def normals(self) -> NDArray[np.float32] | None:
        """(vertices, 3): normals, of length one; None unless ``normals`` is on."""
    @property
    def uvs(self) -> NDArray[np.float32] | None:
        """(vertices, 2): texture coordinates, m; None unless ``uv`` is on."""
    @property
    def outer_attributes(self) -> NDArray[np.float32] | None:
        """(vertices, 5): normal and texture coordinates of the input, zero on cracks; None unless ``attributes`` is on."""
    @property
    def outer_uvs2(self) -> NDArray[np.float32] | None:
        """(vertices, 2): second texture coordinates of the input, zero on cracks; None unless ``attributes`` is on and it has them."""
    @property
    def outer_colors(self) -> NDArray[np.uint8] | None:
        """(vertices, 4): colors of the input, RGBA, white on cracks; None unless ``attributes`` is on and it has any."""
    @property
    def materials(self) -> NDArray[np.uint32] | None:
        """(triangles,): the input's materials, 2³²−1 on cracks; None unless ``attributes`` is on and the input has any."""
    @property
    def runs(self) -> list[Run]: ...
    @property
    def hull(self) -> Hull | None:
        """Convex proxy for collisions; None unless ``hulls`` is on."""
    @property
    def skin(self) -> Skin | None:
        """The fragment's part of the input's own triangles; None unless ``skin`` is on."""

    def is_closed(self) -> bool: ...

@final
class Run:
    """Triangles of one fragment that face one neighbor; None: the outside, or a fragment of an earlier result."""
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
        """Volume of the part of the fragment inside the hull, divided by the fragment's volume."""
    @property
    def margin_m(self) -> float:
        """Largest depth of any other fragment below the hull's surface."""

@final
class Skin:
    @property
    def vertices(self) -> NDArray[np.float32]:
        """(vertices, 8): position, normal, texture coordinates."""
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def materials(self) -> NDArray[np.uint32]: ...
    @property
    def uvs2(self) -> NDArray[np.float32] | None:
        """(vertices, 2): second texture coordinates; None if the input has none."""
    @property
    def colors(self) -> NDArray[np.uint8] | None:
        """(vertices, 4): colors, RGBA; None if the input has none."""

@final
class Bond:
    @property
    def fragments(self) -> tuple[int, int | None]:
        """Ids of the fragments, the lower first; None: the world."""
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
