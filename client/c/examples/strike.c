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
static int refused(const char *what, const ShatterError *error)
{
    fprintf(stderr, "%s: %s (%s, at `%s`%s)\n", what, error->message, error->name, error->at,
            error->retry ? ", may be tried again" : "");
    return error->code == SHATTER_CODE_NO_DAEMON || error->code == SHATTER_CODE_LOST ? 4 : 3;
}

static int vector(const char *text, double v[3])
{
    return sscanf(text, "%lf,%lf,%lf", &v[0], &v[1], &v[2]) == 3;
}

/* Reads a number of sites. */
static int sites(const char *text, uint32_t *value)
{
    char *end;
    unsigned long number = strtoul(text, &end, 10);
    if (text[0] < '0' || text[0] > '9' || *end != '\0' || number > UINT32_MAX) {
        return 0;
    }
    *value = (uint32_t)number;
    return 1;
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
static int show(const ShatterResult *result, ShatterError *error)
{
    ShatterSummary summary;
    ShatterHash hash;
    if (shatter_result_summary(result, &summary, error) || shatter_result_hash(result, &hash, error)) {
        return refused("summary", error);
    }
    double volume_m3 = 0.0, meshes_m3 = 0.0, mass_kg = 0.0;
    uint32_t all_closed = 0;
    size_t cracks = 0;
    for (uint32_t id = 0; id < summary.fragment_count; id++) {
        ShatterFragment fragment;
        bool closed;
        if (shatter_result_fragment(result, id, &fragment, error)
            || shatter_result_is_closed(result, id, &closed, error)) {
            return refused("fragment", error);
        }
        for (size_t number = 0; number < fragment.run_count; number++) {
            ShatterRun run;
            if (shatter_result_run(result, id, number, &run, error)) {
                return refused("run", error);
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
    ShatterError error;
    ShatterTicket *ticket;
    ShatterResult *result = NULL;
    if (shatter_object_strike(object, impact, &ticket, &error)) {
        return refused("strike", &error);
    }
    ShatterCode code = shatter_ticket_poll(ticket, &result, &error);
    if (code == SHATTER_CODE_OK && result == NULL) {
        /* A game draws a frame here, and polls again after it; this program has nothing else to do. */
        code = shatter_ticket_wait(ticket, PATIENCE_MS, &result, &error);
    }
    int status = code == SHATTER_CODE_OK ? show(result, &error) : refused("result", &error);
    if (status == 0 && out != NULL
        && shatter_result_write_glb(result, SHATTER_CONTENT_FRAGMENTS, out, strlen(out), &error)) {
        status = refused("file", &error);
    }
    shatter_result_free(result);
    shatter_ticket_free(ticket);
    return status;
}

int main(int count, char **words)
{
    ShatterContact contact = {0};
    ShatterImpact impact = {0};
    if (count < 6 || !vector(words[3], contact.point_m) || !vector(words[4], contact.impulse_ns)
        || !sites(words[5], &impact.degree_sites)) {
        fprintf(stderr, "usage: %s SERVICE OBJECT X,Y,Z JX,JY,JZ DEGREE [OUT.glb]\n", words[0]);
        return 2;
    }
    impact.contacts = &contact;
    impact.contact_count = 1;
    impact.degree = impact.degree_sites > 0 ? SHATTER_DEGREE_SITES : SHATTER_DEGREE_PRESET;

    ShatterError error;
    ShatterService *service;
    ShatterObject *object;
    if (shatter_version() != SHATTER_VERSION) {
        fprintf(stderr, "the library has version %u, the header version %u; use both of one release\n", shatter_version(), SHATTER_VERSION);
        return 6;
    }
    if (shatter_connect(words[1], strlen(words[1]), 1000, &service, &error)) {
        return refused("connect", &error);
    }
    int status = 0;
    if (shatter_service_object(service, words[2], strlen(words[2]), 1000, &object, &error)) {
        status = refused("object", &error);
    } else {
        status = strike(object, &impact, count > 6 ? words[6] : NULL);
    }
    shatter_object_free(object);
    shatter_service_free(service);
    return status;
}
