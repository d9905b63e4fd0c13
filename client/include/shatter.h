/*
 * C interface of Shatter: run-time brittle fracture as a service. C11 and C++17 read it.
 *
 *     ShatterService *service; ShatterObject *mug; ShatterTicket *ticket; ShatterBroken *broken; ShatterRefusal refusal;
 *     if (shatter_connect("default", SHATTER_UP_TO_ZERO, 50, &service, &refusal)) ...      // 0 is done, else refusal tells
 *     if (shatter_service_object(service, "mug", SHATTER_UP_TO_ZERO, 50, &mug, &refusal)) ...
 *     ShatterContact contact = {{0.0, 0.05, 0.04}, {0.0, 0.0, -2.0}, 0.0, 0.0, {0}};       // where, m; impulse, N s
 *     ShatterImpact impact = {0};                                                          // zero is the default
 *     impact.contacts = &contact, impact.contact_count = 1;
 *     if (shatter_object_strike(mug, &impact, &ticket, &refusal)) ...                      // never blocks
 *     if (shatter_ticket_poll(ticket, &broken, &refusal)) ...                              // nor does this, once a frame
 *     if (broken) for (uint32_t id = 0; !shatter_broken_fragment(broken, id, &fragment, NULL); id++) ...
 *     shatter_broken_free(broken);                                                         // now its pointers are gone
 *
 * Meters, kilograms, seconds; right-handed, +Y up, counter-clockwise seen from outside.
 *
 * Nothing blocks without a bound: shatter_ticket_poll, shatter_ticket_progress and shatter_object_strike never do, what takes a
 * timeout ends with it. There is no global state and no callback. Connections and objects may be used by any number of threads at a
 * time, tickets and answers by one; any of them may be freed in any order, on any thread.
 *
 * Results go through pointers and are written if the code is SHATTER_CODE_OK; handles are NULL otherwise, and freeing NULL is fine.
 * Null pointers, lengths and numbers that cannot be are refused with SHATTER_CODE_ARGUMENT or the code of the rule. What cannot be
 * checked must hold: pointers that are not NULL lead to what they say, aligned; handles have not
 * been freed; every bool is 0 or 1.
 *
 * Made by cbindgen of client/c/src: change it there.
 */

#ifndef SHATTER_H
#define SHATTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
/* For lengths of texts: up to the zero at their end. */
#define SHATTER_UP_TO_ZERO SIZE_MAX

/// Version of this interface; what a struct or function means changes only with it.
#define SHATTER_VERSION 3

/// For `iterations_max`: none at all.
#define SHATTER_NO_ITERATIONS UINT32_MAX

/// Neighbor of a run that faces no fragment of the answer; second fragment of a bond with the world; material of a triangle that has
/// none of the input's.
#define SHATTER_NONE UINT32_MAX

/// What became of a call. Zero: done. Else why not, one code per rule; `ShatterRefusal` tells whose fault it is, whether to try
/// again, and which argument, field or path offends.
enum ShatterCode
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Done.
    SHATTER_CODE_OK = 0,
    /// The bytes are not a request of ours.
    SHATTER_CODE_BAD_MAGIC = 1,
    /// The daemon speaks another version than this library.
    SHATTER_CODE_VERSION_MISMATCH = 2,
    /// No such kind of request.
    SHATTER_CODE_UNKNOWN_REQUEST = 3,
    /// A field that this version keeps free is not zero.
    SHATTER_CODE_RESERVED_FIELD = 4,
    /// The object's name is empty, too long or not UTF-8.
    SHATTER_CODE_OBJECT_NAME = 5,
    /// The service has no object of this name.
    SHATTER_CODE_UNKNOWN_OBJECT = 6,
    /// The object's database could not be loaded.
    SHATTER_CODE_CORRUPT_OBJECT = 7,
    /// No contact, or more than there is room for.
    SHATTER_CODE_CONTACT_COUNT = 8,
    /// A contact point is not finite.
    SHATTER_CODE_CONTACT_POINT = 9,
    /// A contact point is farther from the body than its radius.
    SHATTER_CODE_CONTACT_TOO_FAR = 10,
    /// An impulse is zero or not finite.
    SHATTER_CODE_IMPULSE = 11,
    /// A contact duration is negative or not finite.
    SHATTER_CODE_CONTACT_DURATION = 12,
    /// A contact radius is negative or not finite.
    SHATTER_CODE_CONTACT_RADIUS = 13,
    /// γ is not above zero, or not finite.
    SHATTER_CODE_GAMMA = 14,
    /// A degree of zero, beyond the object's cap, or from an unknown source.
    SHATTER_CODE_DEGREE = 15,
    /// A lift that is unknown or that the object was not baked for.
    SHATTER_CODE_LIFT = 16,
    /// An effect that this version does not have.
    SHATTER_CODE_UNKNOWN_EFFECT = 17,
    /// A budget that this version does not have, or that is not finite.
    SHATTER_CODE_BUDGET = 18,
    /// There is no such convention, or a unit of length that cannot be.
    SHATTER_CODE_CONVENTION = 19,
    /// No answer with this handle is kept: there never was one, it was given back, or its time is over.
    SHATTER_CODE_UNKNOWN_HANDLE = 20,
    /// The answer would exceed the caller's cap on fragments or bytes.
    SHATTER_CODE_CAP_EXCEEDED = 21,
    /// A name of a service that is not 1 to 32 letters, digits, `-` or `_`.
    SHATTER_CODE_SERVICE_NAME = 22,
    /// A configuration key or value that cannot be used.
    SHATTER_CODE_CONFIGURATION = 23,
    /// An output file could not be written.
    SHATTER_CODE_OUTPUT = 24,
    /// The elastic solve cannot follow this load.
    SHATTER_CODE_UNSOLVABLE = 25,
    /// Displacements from nowhere that is known.
    SHATTER_CODE_ELASTIC = 26,
    /// An effect that is both on and off, or without what it needs.
    SHATTER_CODE_EFFECT = 27,
    /// The answer has no such fragment.
    SHATTER_CODE_UNKNOWN_FRAGMENT = 28,
    /// A fragment too small to be struck again, or too large to be deformed.
    SHATTER_CODE_FRAGMENT_SIZE = 29,
    /// A ray without a direction, beside other contacts, or missing where one is needed.
    SHATTER_CODE_RAY = 30,
    /// A ray that does not meet the object.
    SHATTER_CODE_RAY_MISSED = 31,
    /// The queue is full, or no answer can be lent.
    SHATTER_CODE_BUSY = 40,
    /// The deadline passed first.
    SHATTER_CODE_LATE = 41,
    /// The daemon is ending.
    SHATTER_CODE_STOPPING = 42,
    /// The strike was cancelled, or its ticket is spent.
    SHATTER_CODE_CANCELLED = 43,
    /// The strike failed inside the service.
    SHATTER_CODE_FAILED = 44,
    /// The answer is larger than the buckets of the daemon.
    SHATTER_CODE_ANSWER_TOO_LARGE = 45,
    /// The answer did not pass the client's checks.
    SHATTER_CODE_BAD_ANSWER = 46,
    /// A call of the transport failed.
    SHATTER_CODE_TRANSPORT = 47,
    /// The object's database has been found and is being loaded: send the impact again later.
    SHATTER_CODE_LOADING = 48,
    /// No daemon of this name runs.
    SHATTER_CODE_NO_DAEMON = 60,
    /// The daemon went away while a request was with it.
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
    /// An argument cannot be used: a pointer that must not be null is, text is not UTF-8, a number names nothing.
    SHATTER_CODE_ARGUMENT = 200,
    /// A fault of this library, caught at its border; free the handles that took part, and use them for nothing else.
    SHATTER_CODE_PANICKED = 201,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterCode ShatterCode;
#else
typedef uint32_t ShatterCode;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Whose fault it is.
enum ShatterFault
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Nobody's: nothing was refused.
    SHATTER_FAULT_NOBODY = 0,
    /// The call is wrong; repeating it changes nothing.
    SHATTER_FAULT_CALLER = 1,
    /// The service or this library could not do what it should, or not now.
    SHATTER_FAULT_SERVICE = 2,
    /// Something around both: no daemon, no memory, no rights.
    SHATTER_FAULT_ENVIRONMENT = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterFault ShatterFault;
#else
typedef uint32_t ShatterFault;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What a strike does.
enum ShatterState
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// It is on its way to the daemon, or among those that wait.
    SHATTER_STATE_WAITING = 0,
    /// It is being computed.
    SHATTER_STATE_COMPUTING = 1,
    /// It was answered, refused or given up: `shatter_ticket_poll` tells.
    SHATTER_STATE_ENDED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterState ShatterState;
#else
typedef uint32_t ShatterState;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What a strike is for.
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

/// Where the number of sites comes from.
enum ShatterDegree
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// From where the preset says.
    SHATTER_DEGREE_PRESET = 0,
    /// The calibrated closed form.
    SHATTER_DEGREE_CLOSED_FORM = 1,
    /// The full optimisation.
    SHATTER_DEGREE_OPTIMISED = 2,
    /// `degree_sites`; breaks the object whatever γ says.
    SHATTER_DEGREE_SITES = 3,
    /// The inferred number, made to hold.
    SHATTER_DEGREE_VERIFIED = 4,
    /// What the object has learned from its examples; the closed form where they do not reach.
    SHATTER_DEGREE_INFERRED = 5,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterDegree ShatterDegree;
#else
typedef uint32_t ShatterDegree;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// In which space the cells are straight.
enum ShatterLift
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The object's default.
    SHATTER_LIFT_OBJECT = 0,
    /// Space itself.
    SHATTER_LIFT_EUCLIDEAN = 1,
    /// That of interior distances.
    SHATTER_LIFT_INTERIOR = 2,
    /// That of diffusion on the surface, carried inside.
    SHATTER_LIFT_SURFACE_DIFFUSION = 3,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterLift ShatterLift;
#else
typedef uint32_t ShatterLift;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// Where displacements come from.
enum ShatterElastic
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// From where the preset says.
    SHATTER_ELASTIC_PRESET = 0,
    /// The solve.
    SHATTER_ELASTIC_SOLVE = 1,
    /// The object's reduced basis, where it has one that is exact enough for the impact; else the solve.
    SHATTER_ELASTIC_REDUCED = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterElastic ShatterElastic;
#else
typedef uint32_t ShatterElastic;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// A preset: a bundle of numbers.
enum ShatterQuality
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The object's.
    SHATTER_QUALITY_OBJECT = 0,
    /// To try things out.
    SHATTER_QUALITY_DRAFT = 1,
    /// A strike within a frame.
    SHATTER_QUALITY_GAME = 2,
    /// As fine as cracks are seen close up.
    SHATTER_QUALITY_FILM = 3,
    /// What the others are measured by.
    SHATTER_QUALITY_REFERENCE = 4,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterQuality ShatterQuality;
#else
typedef uint32_t ShatterQuality;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What a strike simulates and sends beyond the bare pieces, one bit each.
enum ShatterEffect
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// Strain energy from the deformation of the body; on by itself.
    SHATTER_EFFECT_ELASTIC = 1,
    /// Tension alone drives cracks.
    SHATTER_EFFECT_TENSILE = 2,
    /// Interior distances; on by itself.
    SHATTER_EFFECT_INTERIOR = 4,
    /// The degree from the object's examples; on by itself.
    SHATTER_EFFECT_EXAMPLES = 8,
    /// Slivers become part of a neighbor.
    SHATTER_EFFECT_SLIVERS = 16,
    /// Velocities of the fragments from the strain energy that is set free.
    SHATTER_EFFECT_RELEASE = 32,
    /// Normals, one per vertex.
    SHATTER_EFFECT_NORMALS = 64,
    /// Texture coordinates of crack faces, one per vertex.
    SHATTER_EFFECT_UV = 128,
    /// Which fragments touch, and how.
    SHATTER_EFFECT_BONDS = 256,
    /// Points on crack faces from which dust and chips come.
    SHATTER_EFFECT_DEBRIS = 512,
    /// Convex proxies of the fragments for collisions.
    SHATTER_EFFECT_HULLS = 1024,
    /// Cells follow what an artist says.
    SHATTER_EFFECT_WARP = 2048,
    /// What lies in the scene's anchors does not move.
    SHATTER_EFFECT_ANCHORED = 4096,
    /// An anchored body has weight.
    SHATTER_EFFECT_GRAVITY = 8192,
    /// Outer faces look as the input does there.
    SHATTER_EFFECT_ATTRIBUTES = 16384,
    /// The input's own triangles, cut as the object is.
    SHATTER_EFFECT_SKIN = 32768,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterEffect ShatterEffect;
#else
typedef uint32_t ShatterEffect;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// What of an answer is written to a file.
enum ShatterContent
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : uint32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /// The fragments.
    SHATTER_CONTENT_FRAGMENTS = 0,
    /// Their hulls.
    SHATTER_CONTENT_HULLS = 1,
    /// What is seen of them: skins and crack faces.
    SHATTER_CONTENT_SKINS = 2,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum ShatterContent ShatterContent;
#else
typedef uint32_t ShatterContent;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/// The answer to a strike. It holds one bucket of the daemon's pool until it is freed: do so once the fragments are copied to where
/// they are needed. One thread at a time; what its pointers lead to, any number may read.
typedef struct ShatterBroken ShatterBroken;

/// An object that can be struck. Any number of threads may use it at a time.
typedef struct ShatterObject ShatterObject;

/// A connection to a service. It outlives the daemon: what was under way when a daemon went away ends with `SHATTER_CODE_LOST`, what
/// comes next goes to the daemon that then serves. Any number of threads may use it at a time.
typedef struct ShatterService ShatterService;

/// A strike under way. One thread at a time.
typedef struct ShatterTicket ShatterTicket;

/// Why something was not done. Every function that takes one writes it, `SHATTER_CODE_OK` and empty texts where all went well;
/// NULL if you do not care. Texts are UTF-8, end with a zero, and are cut where they are longer.
typedef struct ShatterRefusal {
    /// What the function returned.
    ShatterCode code;
    /// Whose fault it is.
    ShatterFault fault;
    /// Whether the same call may succeed a little later.
    bool retry;
    /// Zero.
    uint32_t reserved;
    /// When it is likely to find room, ms from now; 0: not known.
    double retry_after_ms;
    /// The code as a noun, as in JSON and logs.
    char name[32];
    /// The offender: an argument, index, key or path; may be empty.
    char at[128];
    /// One sentence for people.
    char message[512];
} ShatterRefusal;

/// How a service goes; counters since the daemon started.
typedef struct ShatterStatus {
    /// Process id of the daemon.
    uint32_t pid;
    /// Whether the daemon is ending.
    bool ending;
    /// Objects ready.
    uint32_t objects_ready;
    /// Objects that could not be loaded.
    uint32_t objects_failed;
    /// Threads that compute.
    uint32_t threads;
    /// Strikes computing now.
    uint32_t running;
    /// Strikes waiting now.
    uint32_t queued;
    /// Strikes that may wait.
    uint32_t queue_max;
    /// Clients connected now.
    uint32_t clients;
    /// Clients that may be connected.
    uint32_t clients_max;
    /// Buckets of answers.
    uint32_t buckets;
    /// Zero.
    uint32_t reserved;
    /// Bytes per bucket.
    uint64_t bucket_bytes;
    /// Answers that their clients have not read yet.
    uint64_t unread;
    /// Answers that are kept so that their fragments can be struck.
    uint64_t kept;
    /// Daemons that this service has had before this one.
    uint64_t restarts;
    /// Of these, those that were killed or crashed.
    uint64_t crashes;
    /// Time since the daemon started, ns.
    uint64_t uptime_ns;
    /// Strikes answered.
    uint64_t answered;
    /// Strikes refused as wrong.
    uint64_t refused;
    /// Strikes refused because the service was full.
    uint64_t busy;
    /// Strikes whose deadline passed, or would have.
    uint64_t late;
    /// Strikes that failed inside the service.
    uint64_t failed;
    /// Strikes whose client gave up or vanished.
    uint64_t cancelled;
    /// Bytes of memory that the objects hold.
    uint64_t memory_bytes;
    /// From the arrival of a strike to its answer, ns: median.
    uint64_t strike_p50_ns;
    /// 99th percentile.
    uint64_t strike_p99_ns;
    /// Longest.
    uint64_t strike_max_ns;
} ShatterStatus;

/// An object of a service. Texts are UTF-8 and end with a zero.
typedef struct ShatterFacts {
    /// Its name.
    char name[72];
    /// Name of its material.
    char material[40];
    /// Whether it can be struck. If not, `refusal` says why, and everything else but the name is zero.
    bool ready;
    /// Bodies (components).
    uint32_t bodies;
    /// Cap on the degree.
    uint32_t degree_max;
    /// 1 for the first version of it since the daemon started, one more for each that replaced another.
    uint32_t generation;
    /// Nodes of the elastic lattices.
    uint32_t elastic_nodes;
    /// Nodes of the crack lattices.
    uint32_t crack_nodes;
    /// A strike with more fragments is refused; 0: no limit.
    uint64_t fragments_max;
    /// A strike with a longer answer is refused, bytes; 0: no limit.
    uint64_t bytes_max;
    /// γ, J·m².
    double gamma_j_m2;
    /// Young's modulus, Pa.
    double young_pa;
    /// Poisson's ratio.
    double poisson;
    /// Density, kg/m³.
    double density_kg_m3;
    /// Volume, m³.
    double volume_m3;
    /// Diagonal of the bounding box, m.
    double diagonal_m;
    /// Center of the bounding box, m.
    double center_m[3];
    /// Lowest corner of the mesh, m. The lattice's surface, which rays hit, can lie outside by part of its spacing.
    double low_m[3];
    /// Highest corner of the mesh, m.
    double high_m[3];
    /// Default contact radius, m.
    double radius_m;
    /// Default contact duration, s.
    double duration_s;
    /// Bytes of memory that it holds in the daemon.
    uint64_t memory_bytes;
    /// Bytes of the file that it was loaded from.
    uint64_t file_bytes;
    /// Why it could not be loaded. If it is ready: why what lies in its place now could not, so that the version before is served.
    struct ShatterRefusal refusal;
} ShatterFacts;

/// Coordinates of a host. Zeros are those of glTF: +Y up, right-handed, counter-clockwise, meters.
typedef struct ShatterConvention {
    /// 0: +Y points up. 1: +Z does.
    uint32_t up;
    /// 0: right-handed. 1: left-handed.
    uint32_t hand;
    /// Which way round triangles go, seen from outside. 0: counter-clockwise. 1: clockwise.
    uint32_t winding;
    /// Zero.
    uint32_t reserved;
    /// Length of the host's unit, m, 1e-6 to 1e6; 0: a meter.
    double meters_per_unit;
} ShatterConvention;

/// One of two bodies that meet.
typedef struct ShatterPartner {
    /// Young's modulus, Pa; an object's stands in its `ShatterFacts`.
    double young_pa;
    /// Poisson's ratio.
    double poisson;
    /// Its mass, kg; 0: it does not move.
    double mass_kg;
    /// Radius of its surface where it is touched, m; 0: a plane. Negative: a hollow.
    double radius_m;
} ShatterPartner;

/// What becomes of two bodies that meet in a point, by Hertz theory.
typedef struct ShatterHertz {
    /// How far they approach each other at most, m.
    double approach_m;
    /// Radius of the area of contact then, m: what `ShatterContact.radius_m` asks for, in the host's unit.
    double radius_m;
    /// The force then, N.
    double force_n;
    /// From the first touch to the last, s: what `ShatterContact.duration_s` asks for.
    double duration_s;
} ShatterHertz;

/// Where and how hard an object is hit.
typedef struct ShatterContact {
    /// Where, in the coordinates of the mesh file, m, +Y up. With a ray: where the ray begins.
    double point_m[3];
    /// Impulse handed to the object, N·s; not zero.
    double impulse_ns[3];
    /// Contact duration, s; 0: the object's default.
    double duration_s;
    /// Contact radius, m; 0: the object's default.
    double radius_m;
    /// Direction of a ray, of any length: the object is struck where the ray first meets it. Zero: there is no ray. For
    /// impacts of one contact; `ShatterSummary.hit` tells where it met.
    double ray[3];
} ShatterContact;

/// One impact: contacts, and how the answer shall be computed. Zero is the default of everything but the contacts, so begin with
/// `ShatterImpact impact = {0};` (in C++ `{}`) and set what you need. The service names what it refuses.
typedef struct ShatterImpact {
    /// 1 to 8 contacts; read during the call alone.
    const struct ShatterContact *contacts;
    /// How many.
    size_t contact_count;
    /// What for, a `ShatterPurpose`.
    uint32_t purpose;
    /// Where the number of sites comes from, a `ShatterDegree`.
    uint32_t degree;
    /// That number under `SHATTER_DEGREE_SITES`, else 0.
    uint32_t degree_sites;
    /// Which lift, a `ShatterLift`.
    uint32_t lift;
    /// Where displacements come from, a `ShatterElastic`.
    uint32_t elastic;
    /// Which preset says what nothing else says, a `ShatterQuality`.
    uint32_t quality;
    /// Iterations at most by which the pieces are centered; 0: the preset's. `SHATTER_NO_ITERATIONS`: none.
    uint32_t iterations_max;
    /// Refuse an answer of more fragments; 0: the object's cap.
    uint32_t fragments_max;
    /// Refuse an answer of more bytes; 0: the daemon's bucket.
    uint64_t bytes_max;
    /// γ, J·m²; 0: the object's own.
    double gamma_j_m2;
    /// Largest estimated relative error, of the elastic energy and of how the pieces are centered; 0: the preset's dials decide.
    double error_max;
    /// How long the service may take from when it takes the strike in until it sends the answer, ms: quality falls where that is
    /// short; 0: any time.
    double time_ms_max;
    /// After how long the answer is of no use, ms: strikes with less time left go first, one that cannot be in time is refused; 0: it
    /// always is of use.
    double deadline_ms;
    /// Everything random follows from it.
    uint64_t seed;
    /// Effects to switch on, `ShatterEffect`s joined by `|`.
    uint64_t enable;
    /// Effects to switch off.
    uint64_t disable;
    /// Handle of the kept answer whose fragment is struck (`ShatterSummary.handle`); 0: the object itself is.
    uint64_t from_handle;
    /// That fragment; 0 without a handle.
    uint32_t from_fragment;
    /// Whether the service keeps the answer for a while, so that its fragments can be struck.
    bool keep;
    /// Zero.
    uint64_t reserved[8];
} ShatterImpact;

/// Where a ray first meets an object. The surface is the boundary of the crack lattice, which contact points are projected on.
typedef struct ShatterHit {
    /// The point, m.
    double point_m[3];
    /// Outward normal of the surface there, of length one.
    double normal[3];
    /// From the origin of the ray to the point, m.
    double distance_m;
    /// Body (component of the object) that it lies on.
    uint32_t body;
    /// Whether there is a hit. If not, the strike had no ray, and everything else is zero.
    bool present;
} ShatterHit;

/// How far a strike is.
typedef struct ShatterProgress {
    /// What it does.
    ShatterState state;
    /// Zero.
    uint32_t reserved;
    /// Time since the daemon took it in, ns; zero unless it is being computed.
    uint64_t age_ns;
    /// The stage that computes, or computed last; empty unless it is being computed.
    char stage[32];
} ShatterProgress;

/// The facts of a strike.
typedef struct ShatterSummary {
    /// Fragments; 0: the object stayed whole, or nothing but the threshold was asked for.
    uint32_t fragment_count;
    /// Sites asked of the diagram.
    uint32_t sites;
    /// n of the criterion; 1: the object stays whole.
    uint32_t fracture_degree;
    /// Which rule produced it. 0: threshold. 1: closed form. 2: inferred. 3: verified. 4: optimised. 5: forced.
    uint32_t degree_source;
    /// Whether the object's cap on the degree was reached.
    bool capped;
    /// What stopped it. 0: no diagram was made. 1: a cap. 2: converged. 3: the error was met. 4: time. 5: iterations.
    uint32_t stop_reason;
    /// Where the energy came from. 0: solve. 1: reduced basis. 2: falloff. 3: a bound, the object stays whole whatever it is.
    uint32_t elastic;
    /// The preset, a `ShatterQuality`.
    uint32_t quality;
    /// Iterations of the diagrams taken: the most of all bodies.
    uint32_t iterations;
    /// Why `overrun_ns` is not 0. 1: the impact waited in the queue. 2: without a reduced basis it was solved for. 3: it was solved for
    /// since the estimated error of reduced displacements was too large. 4: energy and degree took longer. 5: the cells did. 6: the
    /// stages after them did.
    uint32_t overrun;
    /// γ used, J·m².
    double gamma_j_m2;
    /// E_1/γ; where `elastic` is a bound it is at most this.
    double e1_over_gamma;
    /// Factor on the impulses at which the object just breaks.
    double threshold_impulse_factor;
    /// How near the examples are that decided the degree, 0 to 1.
    double confidence;
    /// Largest contact radius in effect, m.
    double radius_m;
    /// Relative error of the elastic energy, estimated.
    double energy_error;
    /// Relative energy of the diagrams above the end of their descents, estimated.
    double cvd_gap;
    /// Seed used.
    uint64_t seed;
    /// Names this answer to later strikes (`ShatterImpact.from_handle`); 0: the service does not keep it.
    uint64_t handle;
    /// From admission until right before the answer was sent, ns.
    uint64_t time_ns;
    /// By how much that exceeds `ShatterImpact.time_ms_max`, ns; 0: it was kept, or none was asked for.
    uint64_t overrun_ns;
    /// From sending the strike to finding the answer, ns.
    uint64_t round_trip_ns;
    /// Bytes of the answer.
    uint64_t bytes;
    /// Where the ray of the strike met the object.
    struct ShatterHit hit;
} ShatterSummary;

/// How a vertex of an outer face looks; zero on crack faces.
typedef struct ShatterLook {
    /// Of length one.
    float normal[3];
    /// Texture coordinates of the input, v upwards (OBJ's; 1 - v of glTF's); zero where it has none.
    float uv[2];
} ShatterLook;

/// One fragment: a closed mesh and what a rigid body needs. Pointers lead into shared memory and hold until
/// `shatter_broken_free`; those to what the answer does not have are NULL. Positions are relative to `center_m`.
typedef struct ShatterFragment {
    /// Its number in the answer.
    uint32_t id;
    /// Body (component of the object) that it comes from.
    uint32_t body;
    /// Volume, m³.
    double volume_m3;
    /// Mass, kg.
    double mass_kg;
    /// Center of mass in the coordinates of the mesh file, m.
    double center_m[3];
    /// Inertia tensor about the center, kg·m²: xx, yy, zz, xy, xz, yz.
    double inertia_kg_m2[6];
    /// Velocity of the center once it is free, on top of how the object moved, m/s; zero unless `release` is on.
    double linear_m_s[3];
    /// The same of its rotation, rad/s.
    double angular_rad_s[3];
    /// Three coordinates per vertex, m.
    const float *positions;
    /// Three per vertex, of length one; NULL unless `normals` is on.
    const float *normals;
    /// Two per vertex, m; NULL unless `uv` is on.
    const float *uvs;
    /// One per vertex; NULL unless `attributes` is on.
    const struct ShatterLook *looks;
    /// Number of vertices.
    size_t vertex_count;
    /// Three vertices per triangle, counter-clockwise from outside.
    const uint32_t *indices;
    /// Number of indices.
    size_t index_count;
    /// The input's materials, one per triangle, `SHATTER_NONE` on cracks; NULL unless `attributes` is on and the input has any.
    const uint32_t *materials;
    /// Pairs (from, to) of vertices that are the same point: with them every edge has exactly one opposite.
    const uint32_t *merges;
    /// Number of pairs.
    size_t merge_count;
    /// Number of runs, see `shatter_broken_run`.
    size_t run_count;
} ShatterFragment;

/// Triangles of one fragment that face one neighbor, or the outside, or what was there before an earlier crack. The outer run comes
/// first, if there is one. Each has vertices of its own.
typedef struct ShatterRun {
    /// The fragment on the other side of the crack; `SHATTER_NONE`: the outside, or a fragment of an earlier answer.
    uint32_t neighbor;
    /// Whether it is a side of a crack, be it one of an earlier answer; else it is the outside.
    bool crack;
    /// First of the fragment's indices.
    uint32_t index_first;
    /// Number of indices.
    uint32_t index_count;
    /// First of the fragment's vertices.
    uint32_t vertex_first;
    /// Number of vertices.
    uint32_t vertex_count;
} ShatterRun;

/// The convex proxy of a fragment, for collisions: at most 64 triangles. Pointers as in `ShatterFragment`.
typedef struct ShatterHull {
    /// Three coordinates per corner, m, relative to the fragment's center.
    const float *positions;
    /// Number of corners; 0: `hulls` is off, or the fragment is too flat for one.
    size_t vertex_count;
    /// Three corners per triangle, counter-clockwise from outside.
    const uint32_t *indices;
    /// Number of indices.
    size_t index_count;
    /// Volume of the part of the fragment inside the hull over that of the fragment.
    double coverage;
    /// The deepest that the surface of any other fragment lies below the hull's surface, m.
    double margin_m;
} ShatterHull;

/// A vertex of a skin.
typedef struct ShatterSkinVertex {
    /// Relative to the fragment's center, m.
    float position_m[3];
    /// Of length one.
    float normal[3];
    /// Texture coordinates of the input, v upwards (OBJ's; 1 - v of glTF's); zero where it has none.
    float uv[2];
} ShatterSkinVertex;

/// The input's own triangles as far as they are a fragment's, for rendering: with the crack faces of its runs they are what is seen of
/// it. Pointers as in `ShatterFragment`.
typedef struct ShatterSkin {
    /// Vertices.
    const struct ShatterSkinVertex *vertices;
    /// How many; 0: `skin` is off, or no part of the input's surface is the fragment's.
    size_t vertex_count;
    /// Three vertices per triangle, counter-clockwise from outside.
    const uint32_t *indices;
    /// Number of indices.
    size_t index_count;
    /// One per triangle: the place of a material in the mesh file, or `SHATTER_NONE`; NULL if the file has none.
    const uint32_t *materials;
} ShatterSkin;

/// Two fragments that touch; or one that an anchor of the scene holds, and the world.
typedef struct ShatterBond {
    /// The fragments, the lower id first; the second is `SHATTER_NONE` in a bond with the world.
    uint32_t fragments[2];
    /// Area of the crack between them, m²; of a bond with the world: of the outer triangles that the anchors hold.
    double area_m2;
    /// Mean normal of that area, of length one, from the first to the second; zero where there is none.
    double normal[3];
    /// Centroid of that area in the coordinates of the mesh file, m.
    double centroid_m[3];
} ShatterBond;

/// A point of a crack from which dust and chips come.
typedef struct ShatterDebris {
    /// The fragment on whose crack face it lies: of two neighbors the one with the lower id.
    uint32_t fragment;
    /// The other one.
    uint32_t neighbor;
    /// Where, m, relative to the fragment's center.
    float position_m[3];
    /// Normal of the crack there, out of the fragment.
    float normal[3];
    /// Diameter, m.
    float size_m;
    /// Zero.
    uint32_t reserved;
} ShatterDebris;

/// What one stage or effect of a strike did.
typedef struct ShatterCounter {
    /// Stages. 0: load. 1: elasticity. 2: threshold. 3: degree. 4: centroidal. 5: labels. 6: tessellation. 7: fragments. Effects: the
    /// place of their bit in `ShatterEffect`.
    uint32_t number;
    /// Whether it ran.
    bool ran;
    /// Time it took, ns.
    uint64_t ns;
    /// Bytes of results it produced, or of tables it used.
    uint64_t bytes;
} ShatterCounter;

/// 16 hexadecimal digits that equal answers share, whatever the times and the number of threads; and a zero.
typedef struct ShatterHash {
    /// The digits.
    char text[24];
} ShatterHash;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/// Version of the interface of this library; compare it with `SHATTER_VERSION` of the header that you compiled with.
uint32_t shatter_version(void);

/// Connects to the service of that name; where `name` is NULL to that which the environment variable `SHATTER_SERVICE` names, or to
/// `default`. Without a daemon the refusal comes at
/// once, one that is starting is waited for. `service` is NULL afterwards where it failed. Free it with `shatter_service_free`.
///
/// Codes: `no_daemon`, `version_mismatch`, `busy` (no place for another client), `runtime_folder`, `service_name`, `transport`.
///
/// # Safety
/// `name` is NULL, or points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
ShatterCode shatter_connect(const char *name,
                            size_t length,
                            uint64_t timeout_ms,
                            struct ShatterService **service,
                            struct ShatterRefusal *refusal);

/// Connects as `shatter_connect` does, but waits for a daemon to appear.
///
/// # Safety
/// As of `shatter_connect`.
ShatterCode shatter_wait_for(const char *name,
                             size_t length,
                             uint64_t timeout_ms,
                             struct ShatterService **service,
                             struct ShatterRefusal *refusal);

/// Frees a connection; NULL is fine. Objects, tickets and answers that came from it live on by themselves.
void shatter_service_free(struct ShatterService *service);

/// How the service goes.
ShatterCode shatter_service_status(const struct ShatterService *service,
                                   uint64_t timeout_ms,
                                   struct ShatterStatus *status,
                                   struct ShatterRefusal *refusal);

/// All objects, ready or not, by name: the first `capacity` of them go to `facts`, how many there are to `count`. Ask with a capacity
/// of 0 and no `facts` first to learn how many.
///
/// # Safety
/// `facts` points to room for `capacity` of them.
ShatterCode shatter_service_objects(const struct ShatterService *service,
                                    uint64_t timeout_ms,
                                    struct ShatterFacts *facts,
                                    size_t capacity,
                                    size_t *count,
                                    struct ShatterRefusal *refusal);

/// The object of that name, ready to be struck. `object` is NULL afterwards where it failed. Free it with `shatter_object_free`.
///
/// Codes: `unknown_object`, `corrupt_object`, and those of a lost connection.
///
/// # Safety
/// `name` points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
ShatterCode shatter_service_object(const struct ShatterService *service,
                                   const char *name,
                                   size_t length,
                                   uint64_t timeout_ms,
                                   struct ShatterObject **object,
                                   struct ShatterRefusal *refusal);

/// Sleeps until the service has something for this connection, a few milliseconds have passed, or the timeout: between two looks at
/// tickets, for a thread that has nothing else to do.
ShatterCode shatter_service_doze(const struct ShatterService *service,
                                 uint64_t timeout_ms,
                                 struct ShatterRefusal *refusal);

/// Gives back the answer that the service keeps under `handle` (`ShatterSummary.handle`): its fragments cannot be struck any more.
///
/// Codes: `unknown_handle` if none is kept under it.
ShatterCode shatter_service_release(const struct ShatterService *service,
                                    uint64_t handle,
                                    uint64_t timeout_ms,
                                    struct ShatterRefusal *refusal);

/// The convention of that name: `gltf`, `godot`, `unity`, `unreal`, `blender` or `mujoco`.
///
/// Codes: `convention` if there is none.
///
/// # Safety
/// `name` points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
ShatterCode shatter_convention_named(const char *name,
                                     size_t length,
                                     struct ShatterConvention *convention,
                                     struct ShatterRefusal *refusal);

/// The same connection for a host with these coordinates: impacts of objects taken from `hosted` are read, and their answers written, in its
/// axes, unit and winding; `_m`, `_ns`, `_m2` and `_m3` of contacts, fragments and their parts then stand for that unit. What is said of
/// objects (`ShatterFacts`) stays in meters along our axes, files stay glTF's. `hosted` is NULL afterwards where it failed. Free both.
///
/// Codes: `convention` if it is none.
ShatterCode shatter_service_with_convention(const struct ShatterService *service,
                                            const struct ShatterConvention *convention,
                                            struct ShatterService **hosted,
                                            struct ShatterRefusal *refusal);

/// How long and how wide a contact is that stopped `speed_m_s` (before the step, along the normal) by `impulse_ns`; an impulse of 0: that
/// of a central collision of both masses. SI units, whatever the convention.
///
/// Codes: `argument`, which names the figure of which nothing can be made.
ShatterCode shatter_hertz(const struct ShatterPartner *one,
                          const struct ShatterPartner *other,
                          double speed_m_s,
                          double impulse_ns,
                          struct ShatterHertz *hertz,
                          struct ShatterRefusal *refusal);

/// What the service said of it when it was asked for.
ShatterCode shatter_object_facts(const struct ShatterObject *object,
                                 struct ShatterFacts *facts,
                                 struct ShatterRefusal *refusal);

/// Sends a strike and returns at once: the answer is fetched from the ticket. `ticket` is NULL afterwards where it failed. Free it with
/// `shatter_ticket_free`. The first strike after the daemon was lost connects to its successor, which takes some milliseconds.
///
/// Codes: whatever the daemon would refuse in the impact's own fields; `busy` if the connection has too many strikes under way;
/// `lost` if it reached no daemon, `no_daemon` while there is none.
///
/// # Safety
/// `impact->contacts` points to `impact->contact_count` of them.
ShatterCode shatter_object_strike(const struct ShatterObject *object,
                                  const struct ShatterImpact *impact,
                                  struct ShatterTicket **ticket,
                                  struct ShatterRefusal *refusal);

/// Where the ray from `origin_m` along `direction` first meets the object; waits for the service. With a `handle` it is aimed at
/// fragment `fragment` of the result that the service keeps under it; 0: at the object.
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
                               struct ShatterRefusal *refusal);

/// Sends the strike that divides the object into `pieces` even ones, without an impact: for hosts that want them ahead of time. `impact`
/// tells seed, effects, quality, lift and caps; it has no contacts, degree or handle. NULL: every default. Waits, `timeout_ms` at most,
/// only if the object has several bodies, for where they are. `ticket` is NULL afterwards where it failed.
///
/// Codes: as of `shatter_object_strike`; `argument` for contacts, a degree or a handle.
ShatterCode shatter_object_even(const struct ShatterObject *object,
                                uint32_t pieces,
                                const struct ShatterImpact *impact,
                                uint64_t timeout_ms,
                                struct ShatterTicket **ticket,
                                struct ShatterRefusal *refusal);

/// Frees an object; NULL is fine. Its tickets and answers live on.
void shatter_object_free(struct ShatterObject *object);

/// Looks for the answer; never blocks. Once a frame is often enough. Returns `SHATTER_CODE_OK` with `broken` NULL while there is none;
/// with an answer, which is handed out once: free it with `shatter_broken_free`.
///
/// Codes: the refusal of the service; `lost` if the daemon went away; `bad_answer` if the answer fails the checks. After an answer or
/// an error the ticket is spent (`cancelled`), except after `busy` at `answers`: free answers that you hold, and poll again.
ShatterCode shatter_ticket_poll(struct ShatterTicket *ticket,
                                struct ShatterBroken **broken,
                                struct ShatterRefusal *refusal);

/// Waits for the answer. On `late` the ticket is still good: wait again, or free it to cancel the strike. Otherwise as
/// `shatter_ticket_poll`; `broken` is NULL where it failed.
ShatterCode shatter_ticket_wait(struct ShatterTicket *ticket,
                                uint64_t timeout_ms,
                                struct ShatterBroken **broken,
                                struct ShatterRefusal *refusal);

/// How far the strike is, as the daemon said last; never blocks: each call takes in the reply to the one before, and asks again.
ShatterCode shatter_ticket_progress(struct ShatterTicket *ticket,
                                    struct ShatterProgress *progress,
                                    struct ShatterRefusal *refusal);

/// Frees a ticket and cancels its strike if that is still under way; NULL is fine.
void shatter_ticket_free(struct ShatterTicket *ticket);

/// The facts of the strike.
ShatterCode shatter_broken_summary(const struct ShatterBroken *broken,
                                   struct ShatterSummary *summary,
                                   struct ShatterRefusal *refusal);

/// Fragment `id`, of `ShatterSummary.fragment_count`; nothing is copied but its facts.
///
/// Codes: `unknown_fragment`.
ShatterCode shatter_broken_fragment(const struct ShatterBroken *broken,
                                    uint32_t id,
                                    struct ShatterFragment *fragment,
                                    struct ShatterRefusal *refusal);

/// Run `number` of fragment `id`, of `ShatterFragment.run_count`.
///
/// Codes: `unknown_fragment`; `SHATTER_CODE_ARGUMENT` if it has no such run.
ShatterCode shatter_broken_run(const struct ShatterBroken *broken,
                               uint32_t id,
                               size_t number,
                               struct ShatterRun *run,
                               struct ShatterRefusal *refusal);

/// The hull of fragment `id`; all zero where there is none.
///
/// Codes: `unknown_fragment`.
ShatterCode shatter_broken_hull(const struct ShatterBroken *broken,
                                uint32_t id,
                                struct ShatterHull *hull,
                                struct ShatterRefusal *refusal);

/// The skin of fragment `id`; all zero where there is none.
///
/// Codes: `unknown_fragment`.
ShatterCode shatter_broken_skin(const struct ShatterBroken *broken,
                                uint32_t id,
                                struct ShatterSkin *skin,
                                struct ShatterRefusal *refusal);

/// Whether the surface of fragment `id` is closed and oriented.
///
/// Codes: `unknown_fragment`.
ShatterCode shatter_broken_is_closed(const struct ShatterBroken *broken,
                                     uint32_t id,
                                     bool *closed,
                                     struct ShatterRefusal *refusal);

/// Which fragments touch, and which the world holds: `rows` leads to `count` of them in shared memory, until
/// `shatter_broken_free`. None unless `bonds` is on.
ShatterCode shatter_broken_bonds(const struct ShatterBroken *broken,
                                 const struct ShatterBond **rows,
                                 size_t *count,
                                 struct ShatterRefusal *refusal);

/// Points on cracks from which dust and chips come, as `shatter_broken_bonds`. None unless `debris` is on.
ShatterCode shatter_broken_debris(const struct ShatterBroken *broken,
                                  const struct ShatterDebris **rows,
                                  size_t *count,
                                  struct ShatterRefusal *refusal);

/// What each stage did, as `shatter_broken_bonds`.
ShatterCode shatter_broken_stages(const struct ShatterBroken *broken,
                                  const struct ShatterCounter **rows,
                                  size_t *count,
                                  struct ShatterRefusal *refusal);

/// What each effect did, as `shatter_broken_bonds`.
ShatterCode shatter_broken_effects(const struct ShatterBroken *broken,
                                   const struct ShatterCounter **rows,
                                   size_t *count,
                                   struct ShatterRefusal *refusal);

/// Hashes the answer, as `shatter impact --json` does (`output_hash`).
ShatterCode shatter_broken_hash(const struct ShatterBroken *broken,
                                struct ShatterHash *hash,
                                struct ShatterRefusal *refusal);

/// Writes a `.glb` file, whole or not at all; `content` is a `ShatterContent`. The folder must be there.
///
/// Codes: `output` (also where there is nothing to write), `bad_answer`.
///
/// # Safety
/// `path` points to `length` bytes, or to text that ends with a zero if `length` is `SHATTER_UP_TO_ZERO`.
ShatterCode shatter_broken_write_glb(const struct ShatterBroken *broken,
                                     uint32_t content,
                                     const char *path,
                                     size_t length,
                                     struct ShatterRefusal *refusal);

/// Frees an answer and gives its bucket back to the daemon; NULL is fine. No pointer into it may be used any more.
void shatter_broken_free(struct ShatterBroken *broken);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SHATTER_H */
