/*
 * Example of a host: its coordinates, its contact, bodies in place of the object, fragments made ahead of time. C11.
 *
 *     host SERVICE OBJECT gltf|godot|unity|unreal|blender|mujoco X,Y,Z JX,JY,JZ SPEED
 *
 * Point, impulse and speed are in the host's coordinates and unit: the point where a steel ball of 0.2 kg met the object, the impulse that
 * it transferred, and the approach speed before the step.
 */
#include "shatter.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PATIENCE_MS 120000

/* Motion of the body that breaks at the time of the result; its frame is that of the mesh file, not rotated. */
typedef struct Body {
    double center[3], linear[3], angular[3];
} Body;

static int refused(const char *what, const ShatterError *error)
{
    fprintf(stderr, "%s: %s (%s, at `%s`)\n", what, error->message, error->name, error->at);
    return error->code == SHATTER_CODE_NO_DAEMON ? 4 : 3;
}

/* Duration and radius of the contact by Hertz theory, which is in SI units whatever the host's unit is. */
static ShatterCode describe(const ShatterFacts *facts, double unit_m, double speed, ShatterContact *contact,
                            ShatterError *error)
{
    const double *j = contact->impulse_ns;
    const double impulse = sqrt(j[0] * j[0] + j[1] * j[1] + j[2] * j[2]);
    const ShatterPartner ball = {210e9, 0.3, 0.2, 0.018};
    const ShatterPartner own = {facts->young_pa, facts->poisson, facts->density_kg_m3 * facts->volume_m3,
                                0.5 * facts->diagonal_m};
    ShatterHertz hertz;
    const ShatterCode code = shatter_hertz(&own, &ball, speed * unit_m, impulse * unit_m, &hertz, error);
    if (code == SHATTER_CODE_OK) {
        contact->duration_s = hertz.duration_s;
        contact->radius_m = hertz.radius_m / unit_m;
        printf("contact_m %.17g\nduration_s %.17g\n", hertz.radius_m, hertz.duration_s);
    }
    return code;
}

/* A rigid body in place of a fragment: mass, center, inertia and velocities, the hull for collisions, the visible triangles. */
static int spawn(const ShatterResult *result, uint32_t id, const Body *parent, double momentum[3], double *mass_kg,
                 ShatterError *error)
{
    ShatterFragment piece;
    ShatterHull hull;
    if (shatter_result_fragment(result, id, &piece, error) || shatter_result_hull(result, id, &hull, error)) {
        return refused("fragment", error);
    }
    double r[3];
    for (int k = 0; k < 3; k++) {
        r[k] = piece.center_m[k] - parent->center[k];
    }
    for (int k = 0; k < 3; k++) {
        const int a = (k + 1) % 3, b = (k + 2) % 3;
        const double linear = parent->linear[k] + parent->angular[a] * r[b] - parent->angular[b] * r[a] + piece.linear_m_s[k];
        momentum[k] += piece.mass_kg * linear;
    }
    *mass_kg += piece.mass_kg;
    for (size_t number = 0; number < piece.run_count; number++) {
        ShatterRun run;
        if (shatter_result_run(result, id, number, &run, error)) {
            return refused("run", error);
        }
        /* Triangles with the material of cracks, or of the outside: indices[run.index_first ..], one draw call each. */
    }
    /* A hull without corners: the fragment is too flat for one; use a box. */
    return hull.vertex_count == 0 || hull.index_count > 0 ? 0 : 6;
}

/* Polls as a frame does; returns the result, or NULL after an error. */
static ShatterResult *completed(ShatterTicket *ticket, ShatterError *error)
{
    ShatterResult *result = NULL;
    if (shatter_ticket_poll(ticket, &result, error) == SHATTER_CODE_OK && result == NULL) {
        /* A host continues with its next step here, and polls again after it; this program has nothing else to do. */
        shatter_ticket_wait(ticket, PATIENCE_MS, &result, error);
    }
    shatter_ticket_free(ticket);
    return result;
}

static int replace(ShatterResult *result, const char *name, ShatterError *error)
{
    const Body parent = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    double momentum[3] = {0.0, 0.0, 0.0}, mass_kg = 0.0;
    ShatterSummary summary;
    int status = result == NULL || shatter_result_summary(result, &summary, error) ? refused(name, error) : 0;
    for (uint32_t id = 0; status == 0 && id < summary.fragment_count; id++) {
        status = spawn(result, id, &parent, momentum, &mass_kg, error);
    }
    if (status == 0) {
        printf("%s_fragments %u\n%s_mass_kg %.17g\n", name, summary.fragment_count, name, mass_kg);
        printf("%s_momentum %.3g\n", name, sqrt(momentum[0] * momentum[0] + momentum[1] * momentum[1] + momentum[2] * momentum[2]));
    }
    shatter_result_free(result);
    return status;
}

static int run(const ShatterObject *object, const ShatterConvention *own, ShatterContact contact, double speed)
{
    ShatterError error;
    ShatterFacts facts;
    ShatterTicket *ticket;
    ShatterImpact impact = {0};
    if (shatter_object_facts(object, &facts, &error) || describe(&facts, own->meters_per_unit, speed, &contact, &error)) {
        return refused("contact", &error);
    }
    impact.enable = SHATTER_EFFECT_HULLS | SHATTER_EFFECT_RELEASE;
    impact.contacts = &contact;
    impact.contact_count = 1;
    if (shatter_object_strike(object, &impact, &ticket, &error)) {
        return refused("strike", &error);
    }
    int status = replace(completed(ticket, &error), "struck", &error);
    /* The same without an impact: twelve fragments of equal size, for a pool that is filled in advance. */
    impact.contacts = NULL;
    impact.contact_count = 0;
    impact.enable = SHATTER_EFFECT_HULLS;
    if (status == 0 && shatter_object_even(object, 12, &impact, PATIENCE_MS, &ticket, &error)) {
        return refused("even", &error);
    }
    return status == 0 ? replace(completed(ticket, &error), "even", &error) : status;
}

static int vector(const char *text, double v[3])
{
    return sscanf(text, "%lf,%lf,%lf", &v[0], &v[1], &v[2]) == 3;
}

int main(int count, char **words)
{
    ShatterContact contact = {0};
    if (count != 7 || !vector(words[4], contact.point_m) || !vector(words[5], contact.impulse_ns)) {
        fprintf(stderr, "usage: %s SERVICE OBJECT CONVENTION X,Y,Z JX,JY,JZ SPEED\n", words[0]);
        return 2;
    }
    ShatterError error;
    ShatterConvention own;
    ShatterService *service = NULL, *hosted = NULL;
    ShatterObject *object = NULL;
    int status;
    if (shatter_convention_named(words[3], SHATTER_UP_TO_ZERO, &own, &error)
        || shatter_connect(words[1], SHATTER_UP_TO_ZERO, 1000, &service, &error)
        || shatter_service_with_convention(service, &own, &hosted, &error)
        || shatter_service_object(hosted, words[2], SHATTER_UP_TO_ZERO, 1000, &object, &error)) {
        status = refused("connect", &error);
    } else {
        status = run(object, &own, contact, strtod(words[6], NULL));
    }
    shatter_object_free(object);
    shatter_service_free(hosted);
    shatter_service_free(service);
    return status;
}
