"""Client of ``shatterd``, the brittle-fracture daemon.

    import shatter

    mug = shatter.connect().object("mug")
    ticket = mug.strike(shatter.Contact((0.0, 0.05, 0.04), (0.0, 0.0, -2.0)), degree=24)    # never blocks
    result = ticket.wait()                                  # or ticket.poll(), once a frame
    for fragment in result:
        fragment.positions, fragment.triangles              # numpy arrays over shared memory, without a copy
        fragment.mass_kg, fragment.center_m, fragment.inertia_kg_m2
    result.write_glb("broken.glb")

Meters, kilograms, seconds; right-handed, +Y up, counter-clockwise seen from outside, unless the connection has another
``convention``. The exceptions of this module derive from :class:`ShatterError`: :class:`ServiceError` is an error of the client or the
service, :class:`ArgumentError` an argument that cannot be used. Any number of threads may use the module and its objects at a time.
After a fork, the child connects again by itself; tickets of the parent fail there with `lost`.
"""

try:
    import numpy as _numpy  # noqa: F401
except ModuleNotFoundError as error:
    raise ModuleNotFoundError("shatter returns numpy arrays: `pip install numpy`", name=error.name) from None

from . import _messages, _shatter  # noqa: E402

# Before the names are imported: functions are replaced.
_messages.explain(_shatter)

from ._shatter import (  # noqa: E402
    ArgumentError,
    Bond,
    FractureResult,
    Contact,
    ContactPartner,
    Debris,
    Facts,
    Fragment,
    Hertz,
    Hit,
    Hull,
    Object,
    ServiceError,
    Run,
    Service,
    ShatterError,
    Skin,
    Status,
    Summary,
    Ticket,
    __version__,
    connect,
    hertz,
    wait_for,
)

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
