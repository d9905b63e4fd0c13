/*
 * C interface of Shatter, a brittle-fracture service. For C11 and C++17.
 *
 *     ShatterService *service; ShatterObject *mug; ShatterTicket *ticket; ShatterResult *result; ShatterError error;
 *     if (shatter_connect("default", SHATTER_UP_TO_ZERO, 50, &service, &error)) ...        // 0 is success, else see error
 *     if (shatter_service_object(service, "mug", SHATTER_UP_TO_ZERO, 50, &mug, &error)) ...
 *     ShatterContact contact = {.point_m = {0.0, 0.05, 0.04}, .impulse_ns = {0.0, 0.0, -2.0}}; // m, N s
 *     ShatterImpact impact = {0};                                                          // zero is the default
 *     impact.contacts = &contact, impact.contact_count = 1;
 *     if (shatter_object_strike(mug, &impact, &ticket, &error)) ...                        // never blocks
 *     if (shatter_ticket_poll(ticket, &result, &error)) ...                                // never blocks; once a frame
 *     if (result) for (uint32_t id = 0; !shatter_result_fragment(result, id, &fragment, NULL); id++) ...
 *     shatter_result_free(result);                                                         // its pointers are invalid now
 *
 * Units are meters, kilograms and seconds. Axes are right-handed, +Y up; triangles are counter-clockwise seen from outside.
 *
 * Every wait has a bound. shatter_ticket_poll, shatter_ticket_progress and shatter_object_strike never block. A call with a timeout
 * returns when that has passed. There is no global state and no callback. Any number of threads may use a connection or an object at
 * the same time. Only one thread at a time may use a ticket or a result. All of them may be freed in any order, on any thread.
 *
 * If a function returns SHATTER_CODE_OK, its results are written through the pointers; otherwise handles are NULL. Freeing NULL is
 * allowed. Null pointers, invalid lengths and invalid numbers are refused, with SHATTER_CODE_ARGUMENT or the code of the rule.
 * The caller must ensure the rest. Pointers that are not NULL point to values of their type and are aligned. Handles have not been
 * freed. Every bool is 0 or 1.
 *
 * cbindgen generates this file from client/c/src: change it there.
 */

#ifndef SHATTER_H
#define SHATTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
/* Length of a text that ends with a zero. */
#define SHATTER_UP_TO_ZERO SIZE_MAX

/// Version of this interface. The meaning of a struct or function changes only with this number.
#define SHATTER_VERSION 3

/// Value of `iterations_max` for no iterations.
#define SHATTER_NO_ITERATIONS UINT32_MAX

/// No fragment or no material. Neighbor of a run that faces no fragment of the result; second fragment of a bond with the world; material
/// of a triangle without one.
#define SHATTER_NONE UINT32_MAX

/// Result code of a call. Zero: success. Any other value names the rule that was violated. `ShatterError` adds who is at fault, whether
/// to try again, and the argument, field or path in question.
enum ShatterCode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Success.
    SHATTER_CODE_OK = 0,
    /// The bytes are not a request of this protocol.
    SHATTER_CODE_BAD_MAGIC = 1,
    /// The daemon speaks another version of the protocol than this library.
    SHATTER_CODE_VERSION_MISMATCH = 2,
    /// The kind of request does not exist.
    SHATTER_CODE_UNKNOWN_REQUEST = 3,
    /// A reserved field is not zero.
    SHATTER_CODE_RESERVED_FIELD = 4,
    /// The object's name is empty, too long or not UTF-8.
    SHATTER_CODE_OBJECT_NAME = 5,
    /// The service has no object of this name.
    SHATTER_CODE_UNKNOWN_OBJECT = 6,
    /// The object's database could not be loaded.
    SHATTER_CODE_CORRUPT_OBJECT = 7,
    /// No contact, or more than a request can hold.
    SHATTER_CODE_CONTACT_COUNT = 8,
    /// A contact point is not finite.
    SHATTER_CODE_CONTACT_POINT = 9,
    /// A contact point is farther from the body than its radius and a lattice spacing.
    SHATTER_CODE_CONTACT_TOO_FAR = 10,
    /// An impulse is zero or not finite, or the contacts cancel or press on anchors only.
    SHATTER_CODE_IMPULSE = 11,
    /// A contact duration is negative or not finite.
    SHATTER_CODE_CONTACT_DURATION = 12,
    /// A contact radius is not positive, not finite, or larger than the object.
    SHATTER_CODE_CONTACT_RADIUS = 13,
    /// γ is not above zero, or not finite.
    SHATTER_CODE_GAMMA = 14,
    /// The degree is zero, above the object's limit, or from an unknown rule.
    SHATTER_CODE_DEGREE = 15,
    /// The lift is unknown, or the object was not baked for it.
    SHATTER_CODE_LIFT = 16,
    /// The effect does not exist in this version.
    SHATTER_CODE_UNKNOWN_EFFECT = 17,
    /// The preset is unknown, or a limit of time, error or iterations is out of range.
    SHATTER_CODE_BUDGET = 18,
    /// An invalid coordinate convention: an unknown number or name, or a unit of length out of range.
    SHATTER_CODE_CONVENTION = 19,
    /// The service retains no result under this handle: it expired, was released or evicted, or never existed.
    SHATTER_CODE_UNKNOWN_HANDLE = 20,
    /// The result would exceed the limit of fragments or bytes.
    SHATTER_CODE_CAP_EXCEEDED = 21,
    /// The name of the service is not 1 to 32 letters, digits, `-` or `_`.
    SHATTER_CODE_SERVICE_NAME = 22,
    /// A key or value of the configuration or scene is invalid.
    SHATTER_CODE_CONFIGURATION = 23,
    /// An output file could not be written.
    SHATTER_CODE_OUTPUT = 24,
    /// The displacement under this load cannot be computed.
    SHATTER_CODE_UNSOLVABLE = 25,
    /// The source of displacements is unknown.
    SHATTER_CODE_ELASTIC = 26,
    /// An effect is both enabled and disabled, or an effect or table that it needs is missing.
    SHATTER_CODE_EFFECT = 27,
    /// The result has no such fragment.
    SHATTER_CODE_UNKNOWN_FRAGMENT = 28,
    /// The fragment is too small to be struck again, or too thin for the elastic lattice.
    SHATTER_CODE_FRAGMENT_SIZE = 29,
    /// A ray has no direction, is combined with other contacts, or is missing.
    SHATTER_CODE_RAY = 30,
    /// The ray misses the object.
    SHATTER_CODE_RAY_MISSED = 31,
    /// The ticket has already handed out its result or its error.
    SHATTER_CODE_TICKET_SPENT = 32,
    /// The partner of a contact is invalid, missing at one of several contacts, or does not limit the energy.
    SHATTER_CODE_CONTACT_PARTNER = 33,
    /// The queue, the pool of results or the number of clients has reached its limit.
    SHATTER_CODE_BUSY = 40,
    /// The deadline passed before the result was ready.
    SHATTER_CODE_LATE = 41,
    /// The daemon is stopping.
    SHATTER_CODE_STOPPING = 42,
    /// The request was canceled.
    SHATTER_CODE_CANCELED = 43,
    /// The request failed inside the service.
    SHATTER_CODE_FAILED = 44,
    /// The result is larger than the buckets of the daemon.
    SHATTER_CODE_RESULT_TOO_LARGE = 45,
    /// The result did not pass the client's checks.
    SHATTER_CODE_BAD_RESULT = 46,
    /// A call of the transport failed.
    SHATTER_CODE_TRANSPORT = 47,
    /// The object's database has been found and is being loaded: send the request again later.
    SHATTER_CODE_LOADING = 48,
    /// No daemon of this name runs.
    SHATTER_CODE_NO_DAEMON = 60,
    /// The daemon ended during the request.
    SHATTER_CODE_LOST = 61,
    /// Another daemon of this name runs.
    SHATTER_CODE_SECOND_DAEMON = 62,
    /// The runtime folder cannot be used.
    SHATTER_CODE_RUNTIME_FOLDER = 63,
    /// The shared memory of the machine is full.
    SHATTER_CODE_SHARED_MEMORY = 64,
    /// The folder of databases cannot be read.
    SHATTER_CODE_DATABASE_FOLDER = 65,
    /// The loopback port for health and metrics cannot be opened.
    SHATTER_CODE_PORT = 66,
    /// An argument cannot be used: it is NULL but must not be, its text is not UTF-8, or its number has no meaning.
    SHATTER_CODE_ARGUMENT = 200,
    /// A panic inside this library, caught at the C boundary. Free the handles of the call, and do not use them otherwise.
    SHATTER_CODE_PANICKED = 201,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterCode ShatterCode;
#else
typedef uint32_t ShatterCode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Party at fault for an error.
enum ShatterFault
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// No error.
    SHATTER_FAULT_NONE = 0,
    /// The call is wrong; repeating it changes nothing.
    SHATTER_FAULT_CALLER = 1,
    /// The service or this library failed, or cannot do it now.
    SHATTER_FAULT_SERVICE = 2,
    /// The environment: no daemon, no memory, no permission.
    SHATTER_FAULT_ENVIRONMENT = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterFault ShatterFault;
#else
typedef uint32_t ShatterFault;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// State of a request.
enum ShatterState
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// On its way to the daemon, or in its queue.
    SHATTER_STATE_WAITING = 0,
    /// Being computed.
    SHATTER_STATE_COMPUTING = 1,
    /// Complete, refused or canceled: `shatter_ticket_poll` returns which.
    SHATTER_STATE_ENDED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterState ShatterState;
#else
typedef uint32_t ShatterState;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Purpose of a request.
enum ShatterPurpose
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Fragments.
    SHATTER_PURPOSE_FRAGMENTS = 0,
    /// The load that just breaks the object (`ShatterSummary.threshold_impulse_factor`), without fragments.
    SHATTER_PURPOSE_THRESHOLD = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterPurpose ShatterPurpose;
#else
typedef uint32_t ShatterPurpose;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Source of the number of sites.
enum ShatterDegree
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The source that the preset names.
    SHATTER_DEGREE_PRESET = 0,
    /// The calibrated closed form.
    SHATTER_DEGREE_CLOSED_FORM = 1,
    /// The full optimization.
    SHATTER_DEGREE_OPTIMIZED = 2,
    /// `degree_sites`; breaks the object whatever γ is.
    SHATTER_DEGREE_SITES = 3,
    /// The inferred number, corrected until the criterion holds.
    SHATTER_DEGREE_VERIFIED = 4,
    /// The number learned from the object's examples; the closed form where the examples do not reach.
    SHATTER_DEGREE_INFERRED = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterDegree ShatterDegree;
#else
typedef uint32_t ShatterDegree;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Space in which the cells are straight.
enum ShatterLift
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The object's default.
    SHATTER_LIFT_OBJECT = 0,
    /// Euclidean space.
    SHATTER_LIFT_EUCLIDEAN = 1,
    /// Space of interior distances.
    SHATTER_LIFT_INTERIOR = 2,
    /// Space of diffusion on the surface, extended to the interior.
    SHATTER_LIFT_SURFACE_DIFFUSION = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterLift ShatterLift;
#else
typedef uint32_t ShatterLift;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Source of the displacements.
enum ShatterElastic
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The source that the preset names.
    SHATTER_ELASTIC_PRESET = 0,
    /// An elastic solve.
    SHATTER_ELASTIC_SOLVE = 1,
    /// The object's reduced basis, if it has one that is accurate enough for the impact; else the solve.
    SHATTER_ELASTIC_REDUCED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterElastic ShatterElastic;
#else
typedef uint32_t ShatterElastic;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Outer surface of the fragments.
enum ShatterSurface
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The input surface itself, if the object has a mesh of it; else the lattice's.
    SHATTER_SURFACE_EXACT = 0,
    /// The lattice's, with fewer triangles.
    SHATTER_SURFACE_LATTICE = 1,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterSurface ShatterSurface;
#else
typedef uint32_t ShatterSurface;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// A preset of the settings that an impact does not set.
enum ShatterQuality
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The object's preset.
    SHATTER_QUALITY_OBJECT = 0,
    /// Coarse, for trying things out.
    SHATTER_QUALITY_DRAFT = 1,
    /// For a request within a frame.
    SHATTER_QUALITY_GAME = 2,
    /// As fine as close-up views of cracks need.
    SHATTER_QUALITY_FILM = 3,
    /// The reference that the other presets are measured against.
    SHATTER_QUALITY_REFERENCE = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterQuality ShatterQuality;
#else
typedef uint32_t ShatterQuality;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Effects that a request simulates or adds to the result, one bit each.
enum ShatterEffect
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Strain energy from the deformation of the body; on by default.
    SHATTER_EFFECT_ELASTIC = 1,
    /// Only tension drives cracks.
    SHATTER_EFFECT_TENSILE = 2,
    /// Interior distances; on by default.
    SHATTER_EFFECT_INTERIOR = 4,
    /// The degree from the object's examples; on by default.
    SHATTER_EFFECT_EXAMPLES = 8,
    /// Slivers are merged into a neighbor.
    SHATTER_EFFECT_SLIVERS = 16,
    /// Velocities of the fragments from the released strain energy.
    SHATTER_EFFECT_RELEASE = 32,
    /// Normals, one per vertex.
    SHATTER_EFFECT_NORMALS = 64,
    /// Texture coordinates of crack faces, one per vertex.
    SHATTER_EFFECT_UV = 128,
    /// Contact areas between fragments.
    SHATTER_EFFECT_BONDS = 256,
    /// Points on crack faces from which dust and chips come.
    SHATTER_EFFECT_DEBRIS = 512,
    /// Convex proxies of the fragments for collisions.
    SHATTER_EFFECT_HULLS = 1024,
    /// Cells follow an artist's controls.
    SHATTER_EFFECT_WARP = 2048,
    /// Nodes in the scene's anchors do not move.
    SHATTER_EFFECT_ANCHORED = 4096,
    /// An anchored body has weight.
    SHATTER_EFFECT_GRAVITY = 8192,
    /// Normals, texture coordinates and materials of the input on outer faces.
    SHATTER_EFFECT_ATTRIBUTES = 16384,
    /// The input's own triangles, cut along the cracks.
    SHATTER_EFFECT_SKIN = 32768,
    /// Slow vibrations of the body follow a short contact only in part.
    SHATTER_EFFECT_DYNAMICS = 65536,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterEffect ShatterEffect;
#else
typedef uint32_t ShatterEffect;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Parts of a result that a file can contain.
enum ShatterContent
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The fragments.
    SHATTER_CONTENT_FRAGMENTS = 0,
    /// The hulls of the fragments.
    SHATTER_CONTENT_HULLS = 1,
    /// The visible surfaces of the fragments: skins and crack faces.
    SHATTER_CONTENT_SKINS = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterContent ShatterContent;
#else
typedef uint32_t ShatterContent;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// The result of a request. It holds one bucket of the daemon's pool until it is freed: free it once the fragments are copied. One thread
/// may use it at a time; any number of threads may read through its pointers.
typedef struct ShatterResult ShatterResult;

/// An object that can be struck. Any number of threads may use it at a time.
typedef struct ShatterObject ShatterObject;

/// A connection to a service. It outlives the daemon: calls and requests under way when a daemon goes away end with `SHATTER_CODE_LOST`;
/// later ones go to the daemon that then serves. Any number of threads may use it at a time.
typedef struct ShatterService ShatterService;

/// A request under way. One thread may use it at a time.
typedef struct ShatterTicket ShatterTicket;

/// Error of a call. Every function that takes one writes it: `SHATTER_CODE_OK` and empty texts on success. Pass NULL if you do not need it.
/// Texts are UTF-8 and end with a zero; longer ones are truncated.
typedef struct ShatterError {
    /// Code that the function returned.
    ShatterCode code;
    /// Party at fault.
    ShatterFault fault;
    /// True if the same call may succeed a little later.
    bool retry;
    /// Always zero.
    uint32_t reserved;
    /// Time after which the same call is likely to succeed, ms; 0: not known.
    double retry_after_ms;
    /// Name of the code, as in JSON and logs.
    char name[32];
    /// Argument, index, key or path that caused the error; may be empty.
    char at[128];
    /// One sentence for people.
    char message[512];
} ShatterError;

/// State of a service; counters since the daemon started.
typedef struct ShatterStatus {
    /// Process id of the daemon.
    uint32_t pid;
    /// True if the daemon is ending.
    bool ending;
    /// Objects that are ready.
    uint32_t objects_ready;
    /// Objects that could not be loaded.
    uint32_t objects_failed;
    /// Threads that compute.
    uint32_t threads;
    /// Requests being computed now.
    uint32_t running;
    /// Requests waiting now.
    uint32_t queued;
    /// Requests that may wait.
    uint32_t queue_max;
    /// Clients connected now.
    uint32_t clients;
    /// Clients that may be connected.
    uint32_t clients_max;
    /// Buckets for results.
    uint32_t buckets;
    /// Always zero.
    uint32_t reserved;
    /// Bytes per bucket.
    uint64_t bucket_bytes;
    /// Results that their clients have not read yet.
    uint64_t unread;
    /// Results that are kept so that their fragments can be struck.
    uint64_t kept;
    /// Daemons that served under this name before this one.
    uint64_t restarts;
    /// Of the restarts, those after a daemon that was killed or crashed.
    uint64_t crashes;
    /// Time since the daemon started, ns.
    uint64_t uptime_ns;
    /// Requests that got a result.
    uint64_t completed;
    /// Requests refused as wrong.
    uint64_t refused;
    /// Requests refused because the service was full.
    uint64_t busy;
    /// Requests whose deadline passed, or would have.
    uint64_t late;
    /// Requests that failed inside the service.
    uint64_t failed;
    /// Requests that their client canceled, or whose client died.
    uint64_t canceled;
    /// Memory of the objects, bytes.
    uint64_t memory_bytes;
    /// Time from the arrival of a request to its result, ns: median.
    uint64_t strike_p50_ns;
    /// 99th percentile of that time, ns.
    uint64_t strike_p99_ns;
    /// Longest such time, ns.
    uint64_t strike_max_ns;
} ShatterStatus;

/// Facts of an object. Texts are UTF-8 and end with a zero.
typedef struct ShatterFacts {
    /// Name.
    char name[72];
    /// Name of its material.
    char material[40];
    /// True if the object can be struck. If not, `error` has the reason, and all other fields but the name are zero.
    bool ready;
    /// Bodies (components).
    uint32_t bodies;
    /// Cap on the degree.
    uint32_t degree_max;
    /// Version of the object: 1 for the first since the daemon started, one more for each replacement.
    uint32_t generation;
    /// Nodes of the elastic lattices.
    uint32_t elastic_nodes;
    /// Nodes of the crack lattices.
    uint32_t crack_nodes;
    /// Largest number of fragments of a result, beyond which the service refuses; 0: no limit.
    uint64_t fragments_max;
    /// Largest size of a result, bytes, beyond which the service refuses; 0: no limit.
    uint64_t bytes_max;
    /// γ, J·m².
    double gamma_j_m2;
    /// Young's modulus, Pa.
    double young_pa;
    /// Poisson's ratio.
    double poisson;
    /// Density, kg/m³.
    double density_kg_m3;
    /// Volume, m³: the sum of the fragments' volumes.
    double volume_m3;
    /// Diagonal of the bounding box, m.
    double diagonal_m;
    /// Center of the bounding box, m.
    double center_m[3];
    /// Lowest corner of the mesh, m, or of the lattice if it is loaded without its skin. Without an exact surface, rays hit the lattice's,
    /// which can lie outside by part of its spacing.
    double low_m[3];
    /// Highest corner of the mesh, m.
    double high_m[3];
    /// Default contact radius, m.
    double radius_m;
    /// Default contact duration, s.
    double duration_s;
    /// Memory of the object in the daemon, bytes.
    uint64_t memory_bytes;
    /// Size of the file that the object was loaded from, bytes.
    uint64_t file_bytes;
    /// Reason why the object could not be loaded. If it is ready: reason why its changed file could not be loaded; the version before is
    /// served.
    struct ShatterError error;
} ShatterFacts;

/// Coordinates of a host. Zeros are the convention of glTF: +Y up, right-handed, counter-clockwise, meters.
typedef struct ShatterConvention {
    /// Up axis. 0: +Y. 1: +Z.
    uint32_t up;
    /// Handedness. 0: right-handed. 1: left-handed.
    uint32_t hand;
    /// Winding of triangles, seen from outside. 0: counter-clockwise. 1: clockwise.
    uint32_t winding;
    /// Always zero.
    uint32_t reserved;
    /// Length of the host's unit, m, 1e-6 to 1e6; 0: a meter.
    double meters_per_unit;
} ShatterConvention;

/// One of two bodies in contact.
typedef struct ShatterPartner {
    /// Young's modulus, Pa; for an object, see its `ShatterFacts`.
    double young_pa;
    /// Poisson's ratio.
    double poisson;
    /// Mass, kg; 0: it does not move.
    double mass_kg;
    /// Radius of its surface at the contact, m; 0: a plane. Negative: concave.
    double radius_m;
} ShatterPartner;

/// Contact of two bodies in a point, by Hertz theory.
typedef struct ShatterHertz {
    /// Largest approach, m.
    double approach_m;
    /// Radius of the contact area at the largest approach, m: the value for `ShatterContact.radius_m`, which is in the host's unit.
    double radius_m;
    /// Force at the largest approach, N.
    double force_n;
    /// Duration from the first touch to the last, s: the value for `ShatterContact.duration_s`.
    double duration_s;
} ShatterHertz;

/// One contact of an impact: point, impulse, duration, radius, and the body that strikes, if it is known.
typedef struct ShatterContact {
    /// Contact point in the coordinates of the object, m, +Y up. With a ray: its origin.
    double point_m[3];
    /// Impulse on the object, N·s; not zero.
    double impulse_ns[3];
    /// Contact duration, s; 0: the object's default.
    double duration_s;
    /// Contact radius, m; 0: the object's default.
    double radius_m;
    /// Direction of a ray, of any length: the contact point is its first hit on the object. Zero: no ray. Only for impacts of one contact;
    /// `ShatterSummary.hit` has the hit.
    double ray[3];
    /// Number of the body that strikes the object here: contacts with the same number have the same partner, whose energy counts once.
    uint64_t partner;
    /// Mass of the partner, kg; `INFINITY`: it does not move. 0: there is no partner, and the energy of the impact has no limit; the next
    /// three fields are then 0. Set it for all contacts or for none.
    double partner_mass_kg;
    /// Closing speed of partner and object along the impulse, m/s; negative where they separate.
    double speed_m_s;
    /// Center of mass of the partner, m; of no effect without inertia.
    double partner_center_m[3];
    /// Inertia tensor of the partner about its center, kg·m²: xx, yy, zz, xy, xz, yz. Zero: it does not rotate.
    double partner_inertia_kg_m2[6];
} ShatterContact;

/// An impact: contacts, and options of the request. Zero is the default of everything except the contacts. Begin with `ShatterImpact impact
/// = {0};` (in C++ `{}`) and set the fields that you need. An error names the field that the service refuses.
typedef struct ShatterImpact {
    /// 1 to 8 contacts, read only during the call.
    const struct ShatterContact *contacts;
    /// Number of contacts.
    size_t contact_count;
    /// Purpose, a `ShatterPurpose`.
    uint32_t purpose;
    /// Source of the number of sites, a `ShatterDegree`.
    uint32_t degree;
    /// Number of sites with `SHATTER_DEGREE_SITES`, else 0.
    uint32_t degree_sites;
    /// Lift, a `ShatterLift`.
    uint32_t lift;
    /// Source of the displacements, a `ShatterElastic`.
    uint32_t elastic;
    /// Preset of all settings that are not set here, a `ShatterQuality`.
    uint32_t quality;
    /// Largest number of iterations of the diagram; 0: the preset's. `SHATTER_NO_ITERATIONS`: none.
    uint32_t iterations_max;
    /// Largest number of fragments, beyond which the service refuses; 0: the object's cap.
    uint32_t fragments_max;
    /// Largest size of the result, bytes, beyond which the service refuses; 0: the size of the daemon's buckets.
    uint64_t bytes_max;
    /// γ, J·m²; 0: the object's own.
    double gamma_j_m2;
    /// Largest estimated relative error of the elastic energy and of the diagram; 0: the preset decides.
    double error_max;
    /// Time from the admission of the request until the service sends the result, ms. The service lowers the quality where that is too
    /// short. 0: no limit.
    double time_ms_max;
    /// Time after which the result is of no use, ms. The service serves requests with less time left first, and refuses one that cannot be
    /// in time. 0: no limit.
    double deadline_ms;
    /// Seed of all random numbers.
    uint64_t seed;
    /// Effects to switch on, `ShatterEffect`s joined by `|`.
    uint64_t enable;
    /// Effects to switch off.
    uint64_t disable;
    /// Handle of the kept result whose fragment is struck (`ShatterSummary.handle`); 0: the object itself is struck.
    uint64_t from_handle;
    /// Fragment of that result; 0 without a handle.
    uint32_t from_fragment;
    /// Outer surface of the fragments, a `ShatterSurface`. The fragments of a fragment keep its surface.
    uint32_t surface;
    /// True if the service keeps the result for a while, so that its fragments can be struck.
    bool keep;
    /// Rule that decides whether the object breaks, a `ShatterCriterion`.
    uint32_t criterion;
    /// Always zero.
    uint64_t reserved[8];
} ShatterImpact;

/// First hit of a ray on an object. The surface is the one onto which contact points are projected: that of the fragments that the request asks for.
typedef struct ShatterHit {
    /// Point of the hit, m.
    double point_m[3];
    /// Outward normal of the surface at the point, of length one.
    double normal[3];
    /// Distance from the origin of the ray to the point, m.
    double distance_m;
    /// Body (component of the object) that was hit.
    uint32_t body;
    /// True if there is a hit. If not, the request had no ray, and all other fields are zero.
    bool present;
} ShatterHit;

/// Progress of a request.
typedef struct ShatterProgress {
    /// State of the request.
    ShatterState state;
    /// Always zero.
    uint32_t reserved;
    /// Time since the daemon admitted the request, ns; zero unless it is being computed.
    uint64_t age_ns;
    /// Stage that computes, or that computed last; empty unless the request is being computed.
    char stage[32];
} ShatterProgress;

/// Summary of a result.
typedef struct ShatterSummary {
    /// Number of fragments; 0: the object stayed whole, or the request asked only for the threshold.
    uint32_t fragment_count;
    /// Sites asked of the diagram.
    uint32_t sites;
    /// Degree n of the criterion; 1: the object stays whole.
    uint32_t fracture_degree;
    /// Source of the degree. 0: threshold. 1: closed form. 2: inferred. 3: verified. 4: optimized. 5: forced.
    uint32_t degree_source;
    /// True if the object's cap on the degree was reached.
    bool capped;
    /// Reason to stop. 0: no diagram was made. 1: a cap. 2: converged. 3: the error was met. 4: time. 5: iterations.
    uint32_t stop_reason;
    /// Source of the energy. 0: solve. 1: reduced basis. 2: falloff. 3: a bound: the object stays whole whatever the displacements are.
    uint32_t elastic;
    /// Preset, a `ShatterQuality`.
    uint32_t quality;
    /// Iterations of the diagrams: the most of all bodies.
    uint32_t iterations;
    /// Cause of `overrun_ns`. 1: the request waited in the queue. 2: without a reduced basis, the displacements were solved for. 3: they
    /// were solved for because the estimated error of reduced ones was too large. 4: energy and degree took most of the
    /// time. 5: the cells did. 6: the stages after them did.
    uint32_t overrun;
    /// Outer surface of the fragments. 0: that of the lattice. 1: the input surface itself.
    uint32_t surface;
    /// γ used, J·m².
    double gamma_j_m2;
    /// E_1/γ; an upper bound of it if `elastic` is 3.
    double e1_over_gamma;
    /// Factor on the impulses at which the object just breaks, sqrt(γ/E_1); a lower bound of it if `elastic` is 3. With the effect
    /// `gravity`: of a request for the threshold, the factor on the impulses alone; otherwise the factor on all loads, weight among them.
    /// Without meaning for an even division.
    double threshold_impulse_factor;
    /// Strain energy of the struck bodies at peak load, J: of all contacts, and of the weight with the effect `gravity`; with the effect
    /// `dynamics`, its largest over time. 0 if `elastic` is 2 or 3.
    double strain_j;
    /// Largest averaged equivalent stress over the tensile strength. This and the next three are 0 with the paper's criterion.
    double stress_over_strength;
    /// Energy of the new surface, J: toughness times the area of all cracks.
    double surface_j;
    /// Kinetic energy of the release velocities, J; 0 without the effect `release`.
    double released_j;
    /// Energy that a given number of sites lacks, J.
    double deficit_j;
    /// Kinetic energy that the contacts can take from the motion of object and partners, J; 0 without partners.
    double impactor_j;
    /// Energy of these that the object does not store, J; 0 without partners, and if `elastic` is 3.
    double remainder_j;
    /// Factor on all loads, 0 to 1, so that the object stores no more than `impactor_j`; 1 if nothing was lowered.
    double load_factor;
    /// Nearness of the examples that decided the degree, 0 to 1.
    double confidence;
    /// Largest contact radius in effect, m.
    double radius_m;
    /// Estimated relative error of the elastic energy.
    double energy_error;
    /// Estimated relative energy of the diagrams above the end of their descents.
    double cvd_gap;
    /// Seed used.
    uint64_t seed;
    /// Handle of this result for later requests (`ShatterImpact.from_handle`); 0: the service does not keep it.
    uint64_t handle;
    /// Time from admission until right before the result was sent, ns.
    uint64_t time_ns;
    /// Time by which `time_ns` exceeds `ShatterImpact.time_ms_max`, ns; 0: it was kept, or there was no limit.
    uint64_t overrun_ns;
    /// Time from sending the request to finding the result, ns.
    uint64_t round_trip_ns;
    /// Size of the result, bytes.
    uint64_t bytes;
    /// Hit of the request's ray.
    struct ShatterHit hit;
} ShatterSummary;

/// Attributes of a vertex on an outer face; zero on crack faces.
typedef struct ShatterVertexAttributes {
    /// Normal, of length one.
    float normal[3];
    /// Texture coordinates of the input, v upwards (OBJ's; 1 - v of glTF's); zero where it has none.
    float uv[2];
} ShatterVertexAttributes;

/// One fragment: a closed mesh, and the data of a rigid body. Pointers point into shared memory and are valid until `shatter_result_free`;
/// NULL where the result does not have the data. Positions are relative to `center_m`.
typedef struct ShatterFragment {
    /// Index of the fragment in the result.
    uint32_t id;
    /// Body (component of the object) that the fragment comes from.
    uint32_t body;
    /// Volume, m³.
    double volume_m3;
    /// Mass, kg.
    double mass_kg;
    /// Center of mass in the coordinates of the object, m.
    double center_m[3];
    /// Inertia tensor about the center, kg·m²: xx, yy, zz, xy, xz, yz.
    double inertia_kg_m2[6];
    /// Velocity of the center once the fragment is free, in addition to the object's, m/s; zero unless `release` is on.
    double linear_m_s[3];
    /// Angular velocity, in addition to the object's, rad/s; zero unless `release` is on.
    double angular_rad_s[3];
    /// Positions, three coordinates per vertex, m.
    const float *positions;
    /// Normals, three coordinates per vertex, of length one; NULL unless `normals` is on.
    const float *normals;
    /// Texture coordinates, two per vertex, m; NULL unless `uv` is on.
    const float *uvs;
    /// Attributes of outer faces, one per vertex; NULL unless `attributes` is on.
    const struct ShatterVertexAttributes *attributes;
    /// Second texture coordinates of the input on outer faces, two per vertex, v upwards, zero on cracks; NULL unless `attributes` is on
    /// and the input has them.
    const float *outer_uvs2;
    /// Colors of the input on outer faces, four bytes per vertex: red, green, blue, alpha; white on cracks; NULL unless `attributes` is
    /// on and the input has any.
    const uint8_t *outer_colors;
    /// Number of vertices.
    size_t vertex_count;
    /// Indices of vertices, three per triangle, counter-clockwise from outside unless the convention is clockwise.
    const uint32_t *indices;
    /// Number of indices.
    size_t index_count;
    /// The input's materials, one per triangle, `SHATTER_NONE` on cracks; NULL unless `attributes` is on and the input has any.
    const uint32_t *materials;
    /// Pairs (from, to) of vertices that are the same point: with them every edge has exactly one opposite.
    const uint32_t *merges;
    /// Number of merge pairs.
    size_t merge_count;
    /// Number of runs; see `shatter_result_run`.
    size_t run_count;
} ShatterFragment;

/// Triangles of one fragment that face one neighbor, the outside, or a fragment of an earlier result. The outer run comes first, if there
/// is one. Each run has vertices of its own.
typedef struct ShatterRun {
    /// The fragment on the other side of the crack; `SHATTER_NONE`: the outside, or a fragment of an earlier result.
    uint32_t neighbor;
    /// True if the run is a side of a crack, also of an earlier result; else it is the outside.
    bool crack;
    /// First index of the run, counted from the fragment's first.
    uint32_t index_first;
    /// Number of indices.
    uint32_t index_count;
    /// First vertex of the run, counted from the fragment's first.
    uint32_t vertex_first;
    /// Number of vertices.
    uint32_t vertex_count;
} ShatterRun;

/// The convex proxy of a fragment, for collisions: at most 64 triangles. Pointers as in `ShatterFragment`.
typedef struct ShatterHull {
    /// Positions, three coordinates per corner, m, relative to the fragment's center.
    const float *positions;
    /// Number of corners; 0: `hulls` is off, or the fragment is too flat for one.
    size_t vertex_count;
    /// Indices of corners, three per triangle, counter-clockwise from outside unless the convention is clockwise.
    const uint32_t *indices;
    /// Number of indices.
    size_t index_count;
    /// Volume of the part of the fragment inside the hull, divided by the fragment's volume.
    double coverage;
    /// Largest depth of the surface of any other fragment below the hull's surface, m.
    double margin_m;
} ShatterHull;

/// A vertex of a skin.
typedef struct ShatterSkinVertex {
    /// Position relative to the fragment's center, m.
    float position_m[3];
    /// Normal, of length one.
    float normal[3];
    /// Texture coordinates of the input, v upwards (OBJ's; 1 - v of glTF's); zero where it has none.
    float uv[2];
} ShatterSkinVertex;

/// The input's own triangles that belong to a fragment, for rendering. With the crack faces of the fragment's runs they are its visible
/// surface. Pointers as in `ShatterFragment`.
typedef struct ShatterSkin {
    /// Vertices.
    const struct ShatterSkinVertex *vertices;
    /// Number of vertices; 0: `skin` is off, or the fragment has no part of the input's surface.
    size_t vertex_count;
    /// Indices of vertices, three per triangle, counter-clockwise from outside unless the convention is clockwise.
    const uint32_t *indices;
    /// Number of indices.
    size_t index_count;
    /// One per triangle: the index of a material in the mesh file, or `SHATTER_NONE`; NULL if the file has none.
    const uint32_t *materials;
    /// Second texture coordinates, two per vertex, v upwards; NULL if the file has none.
    const float *uvs2;
    /// Colors, four bytes per vertex: red, green, blue, alpha; NULL if the file has none.
    const uint8_t *colors;
} ShatterSkin;

/// Two fragments that touch; or one that an anchor of the scene holds, and the world.
typedef struct ShatterBond {
    /// The fragments, the lower id first; the second is `SHATTER_NONE` in a bond with the world.
    uint32_t fragments[2];
    /// Area of the crack between them, m². In a bond with the world: area of the outer triangles that the anchors hold.
    double area_m2;
    /// Mean normal of that area, of length one, from the first to the second; zero if the area has none.
    double normal[3];
    /// Centroid of that area in the coordinates of the object, m.
    double centroid_m[3];
} ShatterBond;

/// A point of a crack from which dust and chips come.
typedef struct ShatterDebris {
    /// Fragment whose crack face has the point: of two neighbors the one with the lower id.
    uint32_t fragment;
    /// The other fragment.
    uint32_t neighbor;
    /// Position relative to the fragment's center, m.
    float position_m[3];
    /// Normal of the crack at the point, out of the fragment.
    float normal[3];
    /// Diameter, m.
    float size_m;
    /// Always zero.
    uint32_t reserved;
} ShatterDebris;

/// Cost of one stage or effect.
typedef struct ShatterCounter {
    /// Number of the stage or effect. Stages. 0: load. 1: elasticity. 2: threshold. 3: degree. 4: centroidal. 5: labels. 6: tessellation.
    /// 7: fragments. Effects: the index of their bit in `ShatterEffect`.
    uint32_t number;
    /// True if it ran.
    bool ran;
    /// Time it took, ns.
    uint64_t ns;
    /// Bytes of results it produced, or of tables it used.
    uint64_t bytes;
} ShatterCounter;

/// Content hash: 16 hexadecimal digits, and a zero. Equal for identical results, whatever the times and the number of threads.
typedef struct ShatterHash {
    /// The digits.
    char text[24];
} ShatterHash;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Version of the interface of this library. Compare it with `SHATTER_VERSION` of the header that you compiled with.
uint32_t shatter_version(void);

/// Connects to a service by name. If `name` is NULL, connects to the service that the environment variable `SHATTER_SERVICE` names, or to
/// `default`. Fails at once without a daemon; waits for a daemon that is starting. `service` is NULL after a failure. Free it with
/// `shatter_service_free`.
///
/// Codes: `no_daemon`, `version_mismatch`, `busy` (the service has as many clients as it may), `runtime_folder`, `service_name`,
/// `transport`.
///
/// # Safety
/// `name` is NULL, or points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
ShatterCode shatter_connect(const char *name,
                            size_t length,
                            uint64_t timeout_ms,
                            struct ShatterService **service,
                            struct ShatterError *error);

/// Connects as `shatter_connect` does, but waits for a daemon to appear.
///
/// # Safety
/// As of `shatter_connect`.
ShatterCode shatter_wait_for(const char *name,
                             size_t length,
                             uint64_t timeout_ms,
                             struct ShatterService **service,
                             struct ShatterError *error);

/// Frees a connection; NULL is allowed. Objects, tickets and results that came from it stay valid.
void shatter_service_free(struct ShatterService *service);

/// State of the service.
ShatterCode shatter_service_status(const struct ShatterService *service,
                                   uint64_t timeout_ms,
                                   struct ShatterStatus *status,
                                   struct ShatterError *error);

/// All objects by name, ready or not. Writes the first `capacity` of them to `facts`, and the number of all to `count`. To learn the number
/// first, pass a capacity of 0 and NULL for `facts`.
///
/// # Safety
/// `facts` points to memory for `capacity` of them.
ShatterCode shatter_service_objects(const struct ShatterService *service,
                                    uint64_t timeout_ms,
                                    struct ShatterFacts *facts,
                                    size_t capacity,
                                    size_t *count,
                                    struct ShatterError *error);

/// Finds an object by name, ready to be struck. `object` is NULL after a failure. Free it with `shatter_object_free`.
///
/// Codes: `unknown_object`, `corrupt_object`, `loading`; `busy`, at once, if the connection has too many requests under way; and those of a
/// lost connection.
///
/// # Safety
/// `name` points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
ShatterCode shatter_service_object(const struct ShatterService *service,
                                   const char *name,
                                   size_t length,
                                   uint64_t timeout_ms,
                                   struct ShatterObject **object,
                                   struct ShatterError *error);

/// Sleeps until the service notifies this connection, a few milliseconds have passed, or the timeout. Use it between two polls of tickets,
/// in a thread that has nothing else to do.
ShatterCode shatter_service_wait(const struct ShatterService *service,
                                 uint64_t timeout_ms,
                                 struct ShatterError *error);

/// Releases the result that the service keeps under `handle` (`ShatterSummary.handle`): its fragments cannot be struck any more.
///
/// Codes: `unknown_handle` if the service keeps no result under it; `busy`, at once, if the connection has too many requests under way; and
/// those of a lost connection.
ShatterCode shatter_service_release(const struct ShatterService *service,
                                    uint64_t handle,
                                    uint64_t timeout_ms,
                                    struct ShatterError *error);

/// Finds a convention by name: `gltf`, `godot`, `unity`, `unreal`, `blender` or `mujoco`.
///
/// Codes: `convention` for an unknown name.
///
/// # Safety
/// `name` points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
ShatterCode shatter_convention_named(const char *name,
                                     size_t length,
                                     struct ShatterConvention *convention,
                                     struct ShatterError *error);

/// Makes a connection for a host with these coordinates. The service reads impacts on objects taken from `hosted`, and writes their
/// results, in its axes, unit and winding; `_m`, `_ns`, `_m2` and `_m3` of contacts, fragments and their parts then stand for that unit.
/// Facts of objects (`ShatterFacts`) stay in meters with +Y up, and files stay in the convention of glTF. `hosted` is
/// NULL after a failure. Free both connections.
///
/// Codes: `convention` if the convention is invalid.
ShatterCode shatter_service_with_convention(const struct ShatterService *service,
                                            const struct ShatterConvention *convention,
                                            struct ShatterService **hosted,
                                            struct ShatterError *error);

/// Computes duration and radius of a contact by Hertz theory. `speed_m_s` is the approach speed along the normal before the step, which
/// `impulse_ns` stopped; an impulse of 0: that of a central collision of both masses. In SI units, whatever the convention.
///
/// Codes: `argument`, which names the number that cannot be used.
ShatterCode shatter_hertz(const struct ShatterPartner *one,
                          const struct ShatterPartner *other,
                          double speed_m_s,
                          double impulse_ns,
                          struct ShatterHertz *hertz,
                          struct ShatterError *error);

/// Facts of the object, as the service reported them when the object was requested.
ShatterCode shatter_object_facts(const struct ShatterObject *object,
                                 struct ShatterFacts *facts,
                                 struct ShatterError *error);

/// Sends a request and returns at once; the ticket fetches the result. `ticket` is NULL after a failure. Free it with
/// `shatter_ticket_free`. The first request after the daemon was lost connects to its successor, which takes some milliseconds.
///
/// Codes: every error that the daemon would find in the impact's own fields; `busy` if the connection has too many requests under way;
/// `lost` if the request reached no daemon, `no_daemon` while no daemon runs.
///
/// # Safety
/// `impact->contacts` points to `impact->contact_count` of them.
ShatterCode shatter_object_strike(const struct ShatterObject *object,
                                  const struct ShatterImpact *impact,
                                  struct ShatterTicket **ticket,
                                  struct ShatterError *error);

/// Finds the first hit of the ray from `origin_m` along `direction` on the object; waits for the service. With a `handle`, the target is
/// fragment `fragment` of the result that the service keeps under it; 0: the object.
///
/// Codes: `ray` for a direction that is zero or not finite, `ray_missed` with the closest approach, and those of
/// `shatter_object_strike`.
///
/// # Safety
/// `origin_m` and `direction` point to three numbers each.
ShatterCode shatter_object_aim(const struct ShatterObject *object,
                               const double *origin_m,
                               const double *direction,
                               uint64_t handle,
                               uint32_t fragment,
                               uint64_t timeout_ms,
                               struct ShatterHit *hit,
                               struct ShatterError *error);

/// Sends a request that divides the object into `pieces` fragments of equal size, without an impact: for hosts that want fragments ahead of
/// time. `impact` sets seed, effects, quality, lift and caps, and has no contacts, degree or handle; NULL: all defaults. Waits, at most
/// `timeout_ms`, only if the object has several bodies: the service is then asked where they are. `ticket` is NULL after a failure.
///
/// Codes: those of `shatter_object_strike`; `argument` for contacts, a degree or a handle.
ShatterCode shatter_object_even(const struct ShatterObject *object,
                                uint32_t pieces,
                                const struct ShatterImpact *impact,
                                uint64_t timeout_ms,
                                struct ShatterTicket **ticket,
                                struct ShatterError *error);

/// Frees an object; NULL is allowed. Its tickets and results stay valid.
void shatter_object_free(struct ShatterObject *object);

/// Looks for the result; never blocks. Once a frame is often enough. Returns `SHATTER_CODE_OK` with `result` NULL while there is no result.
/// The result is handed out once: free it with `shatter_result_free`.
///
/// Codes: the error of the service; `lost` if the daemon went away; `bad_result` if the result fails the checks. After a result or an error
/// the ticket is spent (`ticket_spent`), except after `busy` at `results`: free results that you hold, and poll again.
ShatterCode shatter_ticket_poll(struct ShatterTicket *ticket,
                                struct ShatterResult **result,
                                struct ShatterError *error);

/// Waits for the result. After `late` the ticket is still valid: wait again, or free it to cancel the request. Otherwise as
/// `shatter_ticket_poll`; `result` is NULL after a failure.
ShatterCode shatter_ticket_wait(struct ShatterTicket *ticket,
                                uint64_t timeout_ms,
                                struct ShatterResult **result,
                                struct ShatterError *error);

/// Progress of the request, as the daemon reported it last; never blocks. Each call reads the reply to the call before, and asks again.
ShatterCode shatter_ticket_progress(struct ShatterTicket *ticket,
                                    struct ShatterProgress *progress,
                                    struct ShatterError *error);

/// Frees a ticket and cancels its request if that is still under way; NULL is allowed.
void shatter_ticket_free(struct ShatterTicket *ticket);

/// Summary of the result.
ShatterCode shatter_result_summary(const struct ShatterResult *result,
                                   struct ShatterSummary *summary,
                                   struct ShatterError *error);

/// Fragment `id`, below `ShatterSummary.fragment_count`. Only its facts are copied.
///
/// Codes: `unknown_fragment`.
ShatterCode shatter_result_fragment(const struct ShatterResult *result,
                                    uint32_t id,
                                    struct ShatterFragment *fragment,
                                    struct ShatterError *error);

/// Run `number` of fragment `id`, below `ShatterFragment.run_count`.
///
/// Codes: `unknown_fragment`; `SHATTER_CODE_ARGUMENT` if it has no such run.
ShatterCode shatter_result_run(const struct ShatterResult *result,
                               uint32_t id,
                               size_t number,
                               struct ShatterRun *run,
                               struct ShatterError *error);

/// Hull of fragment `id`; all zero if it has none.
///
/// Codes: `unknown_fragment`.
ShatterCode shatter_result_hull(const struct ShatterResult *result,
                                uint32_t id,
                                struct ShatterHull *hull,
                                struct ShatterError *error);

/// Skin of fragment `id`; all zero if it has none.
///
/// Codes: `unknown_fragment`.
ShatterCode shatter_result_skin(const struct ShatterResult *result,
                                uint32_t id,
                                struct ShatterSkin *skin,
                                struct ShatterError *error);

/// True if the surface of fragment `id` is closed and oriented.
///
/// Codes: `unknown_fragment`.
ShatterCode shatter_result_is_closed(const struct ShatterResult *result,
                                     uint32_t id,
                                     bool *closed,
                                     struct ShatterError *error);

/// Contact areas between fragments, and of fragments with the world. `rows` points to `count` of them in shared memory, valid until
/// `shatter_result_free`. Empty unless `bonds` is on.
ShatterCode shatter_result_bonds(const struct ShatterResult *result,
                                 const struct ShatterBond **rows,
                                 size_t *count,
                                 struct ShatterError *error);

/// Points on cracks from which dust and chips come. `rows` as in `shatter_result_bonds`. Empty unless `debris` is on.
ShatterCode shatter_result_debris(const struct ShatterResult *result,
                                  const struct ShatterDebris **rows,
                                  size_t *count,
                                  struct ShatterError *error);

/// Cost of each stage. `rows` as in `shatter_result_bonds`.
ShatterCode shatter_result_stages(const struct ShatterResult *result,
                                  const struct ShatterCounter **rows,
                                  size_t *count,
                                  struct ShatterError *error);

/// Cost of each effect. `rows` as in `shatter_result_bonds`.
ShatterCode shatter_result_effects(const struct ShatterResult *result,
                                   const struct ShatterCounter **rows,
                                   size_t *count,
                                   struct ShatterError *error);

/// Content hash of the result, as `shatter impact --json` prints it (`output_hash`).
ShatterCode shatter_result_hash(const struct ShatterResult *result,
                                struct ShatterHash *hash,
                                struct ShatterError *error);

/// Writes a `.glb` file, whole or not at all; `content` is a `ShatterContent`. The folder must exist.
///
/// Codes: `output` (also if there is nothing to write), `bad_result`.
///
/// # Safety
/// `path` points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
ShatterCode shatter_result_write_glb(const struct ShatterResult *result,
                                     uint32_t content,
                                     const char *path,
                                     size_t length,
                                     struct ShatterError *error);

/// Frees a result and returns its bucket to the daemon; NULL is allowed. Its pointers are invalid afterwards.
void shatter_result_free(struct ShatterResult *result);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SHATTER_H */
