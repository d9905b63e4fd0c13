/*
 * Misuses the interface in every way that the library can notice: it refuses each call by name, and writes no memory that it must not. Run
 * by `tests/tests/c_interface.rs`, also under AddressSanitizer.
 *
 *     misuse SERVICE OBJECT X,Y,Z
 */
#define _POSIX_C_SOURCE 200809L /* setenv */
#include "shatter.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int failures = 0;

static void expect(int line, ShatterCode wanted, ShatterCode code)
{
    if (code != wanted) {
        fprintf(stderr, "line %d: code %u, not %u\n", line, (unsigned)code, (unsigned)wanted);
        failures++;
    }
}

static void hold(int line, int holds)
{
    if (!holds) {
        fprintf(stderr, "line %d: does not hold\n", line);
        failures++;
    }
}

#define IS(wanted, call) expect(__LINE__, SHATTER_CODE_##wanted, (call))
#define HOLDS(condition) hold(__LINE__, (condition))
#define Z SHATTER_UP_TO_ZERO

static void connections(void)
{
    ShatterError error;
    ShatterService *service = (ShatterService *)&error;
    IS(ARGUMENT, shatter_connect("\xff", Z, 0, &service, &error));
    HOLDS(service == NULL && error.code == SHATTER_CODE_ARGUMENT && error.fault == SHATTER_FAULT_CALLER);
    HOLDS(strcmp(error.at, "name") == 0 && strcmp(error.name, "argument") == 0 && error.message[0] != 0);
    IS(ARGUMENT, shatter_connect("default", Z, 0, NULL, &error));
    IS(ARGUMENT, shatter_connect("default", Z - 1, 0, &service, NULL));
    IS(ARGUMENT, shatter_connect("\xff", Z, 0, &service, NULL));
    IS(SERVICE_NAME, shatter_connect("a b", Z, 0, &service, NULL));
    IS(SERVICE_NAME, shatter_connect("", Z, 0, &service, NULL));
    IS(SERVICE_NAME, shatter_connect("a\0b", 3, 0, &service, NULL));
    IS(NO_DAEMON, shatter_connect("nobody", Z, 0, &service, &error));
    HOLDS(error.retry && error.fault == SHATTER_FAULT_ENVIRONMENT && service == NULL);
    IS(NO_DAEMON, shatter_wait_for("nobody", Z, 20, &service, NULL));
    /* Without a name the environment names the service. */
    setenv("SHATTER_SERVICE", "a b", 1);
    IS(SERVICE_NAME, shatter_connect(NULL, 0, 0, &service, &error));
    HOLDS(service == NULL && strcmp(error.at, "SHATTER_SERVICE") == 0);
    setenv("SHATTER_SERVICE", "nobody", 1);
    IS(NO_DAEMON, shatter_wait_for(NULL, Z, 20, &service, &error));
    HOLDS(strcmp(error.at, "nobody") == 0);
    unsetenv("SHATTER_SERVICE");
    IS(OK, shatter_connect(NULL, 0, 1000, &service, NULL));
    shatter_service_free(service);
    shatter_service_free(NULL);
    shatter_object_free(NULL);
    shatter_ticket_free(NULL);
    shatter_result_free(NULL);
}

/* Coordinates and contacts of a host. */
static void hosts(const ShatterService *service)
{
    ShatterConvention own = {0};
    ShatterService *hosted = (ShatterService *)&own;
    ShatterError error;
    const ShatterPartner ball = {210e9, 0.3, 0.2, 0.018}, ground = {33e9, 0.2, 0.0, 0.0};
    ShatterHertz hertz;
    IS(CONVENTION, shatter_convention_named("maya", Z, &own, NULL));
    IS(ARGUMENT, shatter_convention_named("unreal", Z, NULL, NULL));
    IS(OK, shatter_convention_named("unreal?", 6, &own, NULL));
    HOLDS(own.up == 1 && own.hand == 1 && own.winding == 0 && own.meters_per_unit == 0.01);
    IS(ARGUMENT, shatter_service_with_convention(NULL, &own, &hosted, NULL));
    HOLDS(hosted == NULL);
    IS(ARGUMENT, shatter_service_with_convention(service, NULL, &hosted, NULL));
    IS(ARGUMENT, shatter_service_with_convention(service, &own, NULL, NULL));
    own.hand = 2;
    IS(CONVENTION, shatter_service_with_convention(service, &own, &hosted, &error));
    HOLDS(strcmp(error.at, "convention.hand") == 0 && hosted == NULL);
    own.hand = 0, own.meters_per_unit = -1.0;
    IS(CONVENTION, shatter_service_with_convention(service, &own, &hosted, NULL));
    own.meters_per_unit = 0.0, own.reserved = 1;
    IS(ARGUMENT, shatter_service_with_convention(service, &own, &hosted, NULL));
    own.reserved = 0;
    IS(OK, shatter_service_with_convention(service, &own, &hosted, NULL));
    shatter_service_free(hosted);
    IS(OK, shatter_hertz(&ball, &ground, 1.0, 0.0, &hertz, NULL));
    HOLDS(hertz.duration_s > 0.0 && hertz.radius_m > 0.0 && hertz.force_n > 0.0 && hertz.approach_m > 0.0);
    IS(ARGUMENT, shatter_hertz(&ground, &ground, 1.0, 0.0, &hertz, &error));
    HOLDS(strcmp(error.at, "mass_kg") == 0);
    IS(ARGUMENT, shatter_hertz(&ball, &ground, NAN, 0.0, &hertz, &error));
    HOLDS(strcmp(error.at, "speed_m_s") == 0);
    IS(ARGUMENT, shatter_hertz(&ball, &ground, 1.0, -1.0, &hertz, &error));
    HOLDS(strcmp(error.at, "impulse_ns") == 0);
    IS(ARGUMENT, shatter_hertz(NULL, &ground, 1.0, 0.0, &hertz, NULL));
    IS(ARGUMENT, shatter_hertz(&ball, NULL, 1.0, 0.0, &hertz, NULL));
    IS(ARGUMENT, shatter_hertz(&ball, &ground, 1.0, 0.0, NULL, NULL));
}

/* Even divisions refuse the fields that only impacts have. */
static void even(const ShatterObject *object, const ShatterContact *contact)
{
    ShatterImpact impact = {0};
    ShatterTicket *ticket;
    IS(ARGUMENT, shatter_object_even(NULL, 4, NULL, 0, &ticket, NULL));
    IS(ARGUMENT, shatter_object_even(object, 4, NULL, 0, NULL, NULL));
    impact.contacts = contact, impact.contact_count = 1;
    IS(ARGUMENT, shatter_object_even(object, 4, &impact, 1000, &ticket, NULL));
    HOLDS(ticket == NULL);
    impact.contact_count = 0, impact.degree = SHATTER_DEGREE_VERIFIED;
    IS(ARGUMENT, shatter_object_even(object, 4, &impact, 1000, &ticket, NULL));
    impact.degree = 0, impact.from_handle = 1;
    IS(ARGUMENT, shatter_object_even(object, 4, &impact, 1000, &ticket, NULL));
    impact.from_handle = 0, impact.reserved[3] = 1;
    IS(RESERVED_FIELD, shatter_object_even(object, 4, &impact, 1000, &ticket, NULL));
    IS(DEGREE, shatter_object_even(object, 0, NULL, 1000, &ticket, NULL));
    IS(OK, shatter_object_even(object, 4, NULL, 1000, &ticket, NULL));
    shatter_ticket_free(ticket);
}

/* Calls every function with NULL for a handle or for the place of a result. */
static void nothing(void)
{
    ShatterFacts facts;
    ShatterStatus status;
    ShatterProgress progress;
    ShatterSummary summary;
    ShatterFragment fragment;
    ShatterRun run;
    ShatterHull hull;
    ShatterSkin skin;
    ShatterHash hash;
    ShatterObject *object;
    ShatterTicket *ticket;
    ShatterResult *result = (ShatterResult *)&facts;
    const ShatterBond *bonds;
    const ShatterDebris *debris;
    const ShatterCounter *counters;
    ShatterImpact impact = {0};
    bool closed;
    size_t count;
    IS(ARGUMENT, shatter_service_status(NULL, 0, &status, NULL));
    IS(ARGUMENT, shatter_service_objects(NULL, 0, &facts, 1, &count, NULL));
    IS(ARGUMENT, shatter_service_object(NULL, "vase", Z, 0, &object, NULL));
    IS(ARGUMENT, shatter_service_wait(NULL, 0, NULL));
    IS(ARGUMENT, shatter_service_release(NULL, 1, 0, NULL));
    IS(ARGUMENT, shatter_object_facts(NULL, &facts, NULL));
    IS(ARGUMENT, shatter_object_strike(NULL, &impact, &ticket, NULL));
    IS(ARGUMENT, shatter_ticket_poll(NULL, &result, NULL));
    HOLDS(result == NULL);
    IS(ARGUMENT, shatter_ticket_wait(NULL, 0, &result, NULL));
    IS(ARGUMENT, shatter_ticket_progress(NULL, &progress, NULL));
    IS(ARGUMENT, shatter_result_summary(NULL, &summary, NULL));
    IS(ARGUMENT, shatter_result_fragment(NULL, 0, &fragment, NULL));
    IS(ARGUMENT, shatter_result_run(NULL, 0, 0, &run, NULL));
    IS(ARGUMENT, shatter_result_hull(NULL, 0, &hull, NULL));
    IS(ARGUMENT, shatter_result_skin(NULL, 0, &skin, NULL));
    IS(ARGUMENT, shatter_result_is_closed(NULL, 0, &closed, NULL));
    IS(ARGUMENT, shatter_result_bonds(NULL, &bonds, &count, NULL));
    HOLDS(bonds == NULL && count == 0);
    IS(ARGUMENT, shatter_result_debris(NULL, &debris, &count, NULL));
    IS(ARGUMENT, shatter_result_stages(NULL, &counters, &count, NULL));
    IS(ARGUMENT, shatter_result_effects(NULL, &counters, &count, NULL));
    IS(ARGUMENT, shatter_result_hash(NULL, &hash, NULL));
    IS(ARGUMENT, shatter_result_write_glb(NULL, 0, "x.glb", Z, NULL));
}

static void services(const ShatterService *service, const char *name)
{
    ShatterError error;
    ShatterFacts facts[2];
    ShatterStatus status;
    ShatterObject *object;
    size_t count = 7;
    IS(ARGUMENT, shatter_service_status(service, 1000, NULL, NULL));
    IS(OK, shatter_service_status(service, 1000, &status, &error));
    HOLDS(status.objects_ready == 1 && status.pid > 0 && error.code == SHATTER_CODE_OK && error.message[0] == 0);
    IS(ARGUMENT, shatter_service_objects(service, 1000, NULL, 1, &count, NULL));
    HOLDS(count == 0);
    IS(ARGUMENT, shatter_service_objects(service, 1000, NULL, 0, NULL, NULL));
    IS(OK, shatter_service_objects(service, 1000, NULL, 0, &count, NULL));
    HOLDS(count == 1);
    IS(OK, shatter_service_objects(service, 1000, facts, 2, &count, NULL));
    HOLDS(count == 1 && strcmp(facts[0].name, name) == 0 && facts[0].ready && facts[0].young_pa > 0.0);
    HOLDS(facts[0].error.code == SHATTER_CODE_OK);
    IS(UNKNOWN_OBJECT, shatter_service_object(service, "nothing", Z, 1000, &object, &error));
    HOLDS(object == NULL && strcmp(error.at, "nothing") == 0);
    IS(ARGUMENT, shatter_service_object(service, NULL, 3, 1000, &object, NULL));
    IS(ARGUMENT, shatter_service_object(service, name, Z, 1000, NULL, NULL));
    IS(UNKNOWN_HANDLE, shatter_service_release(service, 99, 1000, NULL));
    IS(OK, shatter_service_wait(service, 1, NULL));
}

static void strikes(const ShatterObject *object, const ShatterContact *contact)
{
    ShatterContact many[9] = {0};
    ShatterImpact good = {0}, bad;
    ShatterTicket *ticket;
    ShatterFacts facts;
    good.contacts = contact;
    good.contact_count = 1;
    IS(ARGUMENT, shatter_object_facts(object, NULL, NULL));
    IS(OK, shatter_object_facts(object, &facts, NULL));
    HOLDS(facts.volume_m3 > 0.0);
    IS(ARGUMENT, shatter_object_strike(object, NULL, &ticket, NULL));
    IS(ARGUMENT, shatter_object_strike(object, &good, NULL, NULL));
#define BAD(wanted, field, value)                                       \
    bad = good, bad.field = (value);                                    \
    IS(wanted, shatter_object_strike(object, &bad, &ticket, NULL));     \
    HOLDS(ticket == NULL)
    BAD(ARGUMENT, contacts, NULL);
    BAD(ARGUMENT, contacts, (const ShatterContact *)((const char *)contact + 1));
    BAD(CONTACT_COUNT, contact_count, 0);
    BAD(CONTACT_COUNT, contact_count, SIZE_MAX);
    BAD(UNKNOWN_REQUEST, purpose, 2);
    BAD(DEGREE, degree, 99);
    BAD(DEGREE, degree, SHATTER_DEGREE_SITES);
    BAD(DEGREE, degree_sites, 3);
    BAD(LIFT, lift, 4);
    BAD(ELASTIC, elastic, 3);
    BAD(BUDGET, quality, 5);
    BAD(BUDGET, error_max, 2.0);
    BAD(BUDGET, time_ms_max, NAN);
    BAD(BUDGET, iterations_max, 20000);
    BAD(GAMMA, gamma_j_m2, -1.0);
    BAD(ARGUMENT, deadline_ms, -1.0);
    BAD(UNKNOWN_EFFECT, enable, UINT64_C(1) << 40);
    BAD(UNKNOWN_FRAGMENT, from_fragment, 3);
    BAD(RESERVED_FIELD, reserved[7], 1);
    many[0] = *contact;
    BAD(IMPULSE, contacts, &many[1]);
    many[0].point_m[1] = NAN;
    BAD(CONTACT_POINT, contacts, many);
}

static void answers(const ShatterObject *object, const ShatterContact *contact)
{
    ShatterError error;
    ShatterImpact impact = {0};
    ShatterTicket *ticket;
    ShatterResult *result, *again;
    ShatterProgress progress;
    ShatterSummary summary;
    ShatterFragment fragment;
    ShatterRun run;
    ShatterHull hull;
    ShatterSkin skin;
    const ShatterDebris *debris;
    const ShatterCounter *counters;
    size_t count;
    impact.contacts = contact;
    impact.contact_count = 1;
    impact.degree = SHATTER_DEGREE_SITES;
    impact.degree_sites = 5;
    IS(OK, shatter_object_strike(object, &impact, &ticket, NULL));
    IS(ARGUMENT, shatter_ticket_poll(ticket, NULL, NULL));
    IS(ARGUMENT, shatter_ticket_progress(ticket, NULL, NULL));
    IS(OK, shatter_ticket_progress(ticket, &progress, NULL));
    IS(OK, shatter_ticket_wait(ticket, 120000, &result, &error));
    IS(TICKET_SPENT, shatter_ticket_poll(ticket, &again, &error));
    HOLDS(again == NULL && strcmp(error.at, "ticket") == 0);
    IS(OK, shatter_ticket_progress(ticket, &progress, NULL));
    HOLDS(progress.state == SHATTER_STATE_ENDED);
    shatter_ticket_free(ticket);
    IS(OK, shatter_result_summary(result, &summary, NULL));
    IS(ARGUMENT, shatter_result_summary(result, NULL, NULL));
    HOLDS(summary.fragment_count >= 5 && summary.degree_source == 5 && summary.handle == 0);
    IS(UNKNOWN_FRAGMENT, shatter_result_fragment(result, summary.fragment_count, &fragment, &error));
    IS(UNKNOWN_FRAGMENT, shatter_result_fragment(result, UINT32_MAX, &fragment, NULL));
    IS(OK, shatter_result_fragment(result, 0, &fragment, NULL));
    HOLDS(fragment.normals == NULL && fragment.uvs == NULL && fragment.materials == NULL);
    HOLDS(fragment.outer_uvs2 == NULL && fragment.outer_colors == NULL);
    HOLDS(fragment.positions != NULL && fragment.merges != NULL && fragment.linear_m_s[0] == 0.0);
    IS(ARGUMENT, shatter_result_run(result, 0, fragment.run_count, &run, NULL));
    IS(ARGUMENT, shatter_result_run(result, 0, SIZE_MAX, &run, NULL));
    IS(OK, shatter_result_run(result, 0, fragment.run_count - 1, &run, NULL));
    HOLDS(run.index_first + run.index_count == fragment.index_count);
    IS(OK, shatter_result_hull(result, 0, &hull, NULL));
    IS(OK, shatter_result_skin(result, 0, &skin, NULL));
    HOLDS(hull.positions == NULL && hull.vertex_count == 0 && skin.vertices == NULL && skin.index_count == 0);
    IS(OK, shatter_result_debris(result, &debris, &count, NULL));
    HOLDS(debris == NULL && count == 0);
    IS(ARGUMENT, shatter_result_debris(result, &debris, NULL, NULL));
    IS(OK, shatter_result_stages(result, &counters, &count, NULL));
    HOLDS(count == 8 && counters[7].ran && counters[7].bytes > 0);
    IS(OK, shatter_result_effects(result, &counters, &count, NULL));
    HOLDS(count == 17 && counters[0].number == 0);
    IS(ARGUMENT, shatter_result_write_glb(result, 3, "x.glb", Z, NULL));
    IS(ARGUMENT, shatter_result_write_glb(result, SHATTER_CONTENT_FRAGMENTS, NULL, Z, NULL));
    IS(OUTPUT, shatter_result_write_glb(result, SHATTER_CONTENT_FRAGMENTS, "/proc/nowhere/x.glb", Z, NULL));
    IS(OUTPUT, shatter_result_write_glb(result, SHATTER_CONTENT_FRAGMENTS, "", Z, NULL));
    IS(OUTPUT, shatter_result_write_glb(result, SHATTER_CONTENT_HULLS, "/proc/nowhere/x.glb", Z, NULL));
    shatter_result_free(result);
    /* A request whose ticket is freed is canceled. */
    IS(OK, shatter_object_strike(object, &impact, &ticket, NULL));
    shatter_ticket_free(ticket);
}

/* A ray from beyond the end of the bar. */
static void rays(const ShatterObject *object, const ShatterContact *contact)
{
    const double direction[3] = {-1.0, 0.0, 0.0}, still[3] = {0.0, 0.0, 0.0};
    const double origin[3] = {contact->point_m[0] + 1.0, contact->point_m[1], contact->point_m[2]};
    ShatterHit hit;
    ShatterError error;
    ShatterTicket *ticket;
    ShatterResult *result;
    ShatterSummary summary;
    ShatterContact aimed[2] = {*contact, *contact};
    ShatterImpact impact = {0};
    IS(ARGUMENT, shatter_object_aim(NULL, origin, direction, 0, 0, 1000, &hit, NULL));
    IS(ARGUMENT, shatter_object_aim(object, NULL, direction, 0, 0, 1000, &hit, NULL));
    IS(ARGUMENT, shatter_object_aim(object, origin, NULL, 0, 0, 1000, &hit, NULL));
    IS(ARGUMENT, shatter_object_aim(object, origin, direction, 0, 0, 1000, NULL, NULL));
    IS(RAY, shatter_object_aim(object, origin, still, 0, 0, 1000, &hit, NULL));
    IS(UNKNOWN_HANDLE, shatter_object_aim(object, origin, direction, 7, 0, 10000, &hit, NULL));
    IS(OK, shatter_object_aim(object, origin, direction, 0, 0, 10000, &hit, NULL));
    HOLDS(hit.present && hit.normal[0] > 0.7 && fabs(hit.distance_m - 1.0) < 0.05);
    memcpy(aimed[0].point_m, origin, sizeof origin);
    memcpy(aimed[0].ray, direction, sizeof direction);
    impact.contacts = aimed;
    impact.contact_count = 2;
    IS(RAY, shatter_object_strike(object, &impact, &ticket, &error));
    HOLDS(strcmp(error.at, "contacts[0].ray") == 0);
    impact.contact_count = 1;
    impact.purpose = SHATTER_PURPOSE_THRESHOLD;
    IS(OK, shatter_object_strike(object, &impact, &ticket, NULL));
    IS(OK, shatter_ticket_wait(ticket, 60000, &result, NULL));
    shatter_ticket_free(ticket);
    IS(OK, shatter_result_summary(result, &summary, NULL));
    HOLDS(summary.hit.present && summary.hit.point_m[0] == hit.point_m[0]);
    shatter_result_free(result);
}

int main(int count, char **words)
{
    ShatterContact contact = {.impulse_ns = {-1.0, 0.0, 0.0}};
    ShatterService *service;
    ShatterObject *object;
    if (count != 4 || sscanf(words[3], "%lf,%lf,%lf", &contact.point_m[0], &contact.point_m[1], &contact.point_m[2]) != 3) {
        return 2;
    }
    connections();
    nothing();
    IS(OK, shatter_connect(words[1], Z, 1000, &service, NULL));
    services(service, words[2]);
    hosts(service);
    IS(OK, shatter_service_object(service, words[2], Z, 1000, &object, NULL));
    /* The object outlives its connection. */
    shatter_service_free(service);
    strikes(object, &contact);
    answers(object, &contact);
    even(object, &contact);
    rays(object, &contact);
    shatter_object_free(object);
    printf("failures %d\n", failures);
    return failures > 0;
}
