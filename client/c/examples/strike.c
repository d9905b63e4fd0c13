/*
 * Breaks an object of a running shatterd and prints its fragments. C11; the guide explains how to build it ("Getting started").
 *
 *     strike SERVICE OBJECT X,Y,Z JX,JY,JZ DEGREE [OUT.glb]
 */
#include "shatter.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Timeout of a request, ms. */
#define PATIENCE_MS 120000

/* Prints the error; returns 4 without a daemon, as `shatter` does. */
static int refused(const char *what, const ShatterRefusal *refusal)
{
    fprintf(stderr, "%s: %s (%s, at `%s`%s)\n", what, refusal->message, refusal->name, refusal->at,
            refusal->retry ? ", may be tried again" : "");
    return refusal->code == SHATTER_CODE_NO_DAEMON || refusal->code == SHATTER_CODE_LOST ? 4 : 3;
}

static int vector(const char *text, double v[3])
{
    return sscanf(text, "%lf,%lf,%lf", &v[0], &v[1], &v[2]) == 3;
}

/* Volume inside a closed mesh, from its triangles alone. */
static double mesh_volume_m3(const ShatterFragment *fragment)
{
    double six = 0.0;
    for (size_t i = 0; i + 2 < fragment->index_count; i += 3) {
        const float *a = fragment->positions + 3 * (size_t)fragment->indices[i];
        const float *b = fragment->positions + 3 * (size_t)fragment->indices[i + 1];
        const float *c = fragment->positions + 3 * (size_t)fragment->indices[i + 2];
        six += (double)a[0] * ((double)b[1] * c[2] - (double)b[2] * c[1])
             + (double)a[1] * ((double)b[2] * c[0] - (double)b[0] * c[2])
             + (double)a[2] * ((double)b[0] * c[1] - (double)b[1] * c[0]);
    }
    return six / 6.0;
}

/* Reads the fragments in place, in shared memory. */
static int show(const ShatterBroken *broken, ShatterRefusal *refusal)
{
    ShatterSummary summary;
    ShatterHash hash;
    if (shatter_broken_summary(broken, &summary, refusal) || shatter_broken_hash(broken, &hash, refusal)) {
        return refused("summary", refusal);
    }
    double volume_m3 = 0.0, meshes_m3 = 0.0, mass_kg = 0.0;
    uint32_t all_closed = 0;
    size_t cracks = 0;
    for (uint32_t id = 0; id < summary.fragment_count; id++) {
        ShatterFragment fragment;
        bool closed;
        if (shatter_broken_fragment(broken, id, &fragment, refusal)
            || shatter_broken_is_closed(broken, id, &closed, refusal)) {
            return refused("fragment", refusal);
        }
        for (size_t number = 0; number < fragment.run_count; number++) {
            ShatterRun run;
            if (shatter_broken_run(broken, id, number, &run, refusal)) {
                return refused("run", refusal);
            }
            cracks += run.crack ? 1 : 0;
        }
        volume_m3 += fragment.volume_m3;
        meshes_m3 += mesh_volume_m3(&fragment);
        mass_kg += fragment.mass_kg;
        all_closed += closed ? 1 : 0;
    }
    printf("fragments %u\nclosed %u\ncrack_faces %zu\n", summary.fragment_count, all_closed, cracks);
    printf("volume_m3 %.17g\nmeshes_m3 %.17g\nmass_kg %.17g\n", volume_m3, meshes_m3, mass_kg);
    printf("e1_over_gamma %.17g\nhash %s\nround_trip_ms %.1f\n", summary.e1_over_gamma, hash.text,
           1e-6 * (double)summary.round_trip_ns);
    return 0;
}

/* Sends the request, polls as a game does between frames, and prints the result. */
static int strike(const ShatterObject *object, const ShatterImpact *impact, const char *out)
{
    ShatterRefusal refusal;
    ShatterTicket *ticket;
    ShatterBroken *broken = NULL;
    if (shatter_object_strike(object, impact, &ticket, &refusal)) {
        return refused("strike", &refusal);
    }
    ShatterCode code = shatter_ticket_poll(ticket, &broken, &refusal);
    if (code == SHATTER_CODE_OK && broken == NULL) {
        /* A game draws a frame here, and polls again after it; this program has nothing else to do. */
        code = shatter_ticket_wait(ticket, PATIENCE_MS, &broken, &refusal);
    }
    int status = code == SHATTER_CODE_OK ? show(broken, &refusal) : refused("result", &refusal);
    if (status == 0 && out != NULL
        && shatter_broken_write_glb(broken, SHATTER_CONTENT_FRAGMENTS, out, strlen(out), &refusal)) {
        status = refused("file", &refusal);
    }
    shatter_broken_free(broken);
    shatter_ticket_free(ticket);
    return status;
}

int main(int count, char **words)
{
    ShatterContact contact = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}, 0.0, 0.0, {0.0, 0.0, 0.0}};
    ShatterImpact impact = {0};
    if (count < 6 || !vector(words[3], contact.point_m) || !vector(words[4], contact.impulse_ns)) {
        fprintf(stderr, "usage: %s SERVICE OBJECT X,Y,Z JX,JY,JZ DEGREE [OUT.glb]\n", words[0]);
        return 2;
    }
    impact.contacts = &contact;
    impact.contact_count = 1;
    impact.degree_sites = (uint32_t)strtoul(words[5], NULL, 10);
    impact.degree = impact.degree_sites > 0 ? SHATTER_DEGREE_SITES : SHATTER_DEGREE_PRESET;

    ShatterRefusal refusal;
    ShatterService *service;
    ShatterObject *object;
    if (shatter_version() != SHATTER_VERSION) {
        fprintf(stderr, "the library has version %u, the header version %u; use both of one release\n", shatter_version(), SHATTER_VERSION);
        return 6;
    }
    if (shatter_connect(words[1], strlen(words[1]), 1000, &service, &refusal)) {
        return refused("connect", &refusal);
    }
    int status = 0;
    if (shatter_service_object(service, words[2], strlen(words[2]), 1000, &object, &refusal)) {
        status = refused("object", &refusal);
    } else {
        status = strike(object, &impact, count > 6 ? words[6] : NULL);
    }
    shatter_object_free(object);
    shatter_service_free(service);
    return status;
}
