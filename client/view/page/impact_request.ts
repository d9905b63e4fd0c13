// Requests: what is asked of the service, and how it is written in other languages.

import type { Vector } from "./result";

/** A contact by a ray: the first hit is the point. */
export interface RayContact {
  originM: Vector;
  direction: Vector;
}

/** Settings that every request uses. */
export interface Settings {
  quality: string;
  lift: string;
  seed: number;
}

/** One request, complete: it can be repeated exactly. */
export interface ImpactRequest {
  object: string;
  ray: RayContact;
  impulseNs: number;
  settings: Settings;
  /** The request whose fragment is struck; `undefined`: the object itself. */
  parent?: { request: ImpactRequest; fragment: number };
}

/** Effects that the page needs to draw, beyond those of the object. They change no fragment. */
export const EFFECTS = ["normals", "bonds"];

/** Effect that a texture needs. It divides vertices at seams of the input, and takes longer than the others together. */
export const TEXTURE_EFFECT = "attributes";

/** The impact of a request, as the server of the page reads it. */
export function impactOf(request: ImpactRequest, effects: string[], handle: string | undefined): Record<string, unknown> {
  const { settings } = request;
  return {
    contacts: [{ point_m: request.ray.originM, ray: request.ray.direction, impulse_along_ray_ns: request.impulseNs }],
    ...(settings.quality ? { quality: settings.quality } : {}),
    ...(settings.lift ? { lift: settings.lift } : {}),
    seed: settings.seed,
    enable: effects,
    keep: true,
    ...(request.parent && handle ? { from: [handle, request.parent.fragment] } : {}),
  };
}

/** The requests from the first to this one. */
export function chain(request: ImpactRequest): ImpactRequest[] {
  return request.parent ? [...chain(request.parent.request), request] : [request];
}

/** Languages of [`codeOf`]. */
export type Language = "shell" | "rust" | "python" | "c";

/** The service that programs connect to if they name none. */
const DEFAULT_SERVICE = "default";

/** A program that repeats a request exactly, at the same service and with the same effects. */
export function codeOf(request: ImpactRequest, language: Language, effects: string[] = EFFECTS, service = DEFAULT_SERVICE): string {
  const requests = chain(request);
  switch (language) {
    case "shell":
      return shell(requests, effects, service);
    case "rust":
      return rust(requests, effects, service);
    case "python":
      return python(requests, effects, service);
    case "c":
      return c(requests, effects, service);
  }
}

const list = (vector: Vector) => vector.join(",");

/** A number with a decimal point, as Rust and C want it. */
const real = (value: number) => (/[.e]/.test(String(value)) ? String(value) : `${value}.0`);

const reals = (vector: Vector) => vector.map(real).join(", ");

/** The impulse of a request, N·s: along its ray. */
function impulse(request: ImpactRequest): Vector {
  const [x, y, z] = request.ray.direction;
  // As the client computes it: `Math.hypot` may differ in the last bit.
  const length = Math.sqrt(x * x + y * y + z * z);
  return request.ray.direction.map((x) => (request.impulseNs * x) / length) as Vector;
}

/** A comment for code of several requests: its file has fewer pieces than the page. */
function comment(requests: ImpactRequest[], sign: string): string {
  if (requests.length === 1) return "";
  return `${sign} The file has the pieces of the last request alone. Download the file of the page for all pieces that it shows.\n`;
}

function shell(requests: ImpactRequest[], effects: string[], service: string): string {
  const quoted = (name: string) => (/^[\w-]+$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`);
  const named = service === DEFAULT_SERVICE ? "" : ` --service ${quoted(service)}`;
  const commands = requests
    .map((request, at) => {
      const { settings } = request;
      const options = [
        `--ray ${list(request.ray.originM)},${list(request.ray.direction)}`,
        `--impulse-ns ${request.impulseNs}`,
        ...(settings.quality ? [`--quality ${settings.quality}`] : []),
        ...(settings.lift ? [`--lift ${settings.lift}`] : []),
        `--seed ${settings.seed}`,
        ...(effects.length > 0 ? [`--enable ${effects.join(",")}`] : []),
        ...(request.parent ? [`--from "$handle/${request.parent.fragment}"`] : []),
        ...(at + 1 < requests.length ? ["--keep"] : ["--out broken.glb"]),
        "--json",
      ];
      const command = `shatter${named} impact ${quoted(request.object)} ${options.join(" ")}`;
      const read = "python3 -c 'import json, sys; print(json.load(sys.stdin)[\"handle\"])'";
      return at + 1 < requests.length ? `handle=$(${command} | ${read})` : command;
    })
    .join("\n");
  return comment(requests, "#") + commands;
}

function rust(requests: ImpactRequest[], effects: string[], service: string): string {
  const name = JSON.stringify(requests[0]!.object);
  const body = requests.map((request, at) => {
    const { settings } = request;
    const quality = settings.quality ? `.quality(Quality::${capital(settings.quality)})` : "";
    const lift = settings.lift ? `.lift(Lift::${settings.lift.split("_").map(capital).join("")})` : "";
    const from = request.parent ? `.from(handle, ${request.parent.fragment})` : "";
    const keep = at + 1 < requests.length ? ".keep()" : "";
    const enabled = effects.map((effect) => `.enable(Effect::${capital(effect)})`).join("");
    return [
      `let contact = Contact::new([${reals(request.ray.originM)}])`,
      `    .ray([${reals(request.ray.direction)}])`,
      `    .impulse_along_ray(${real(request.impulseNs)});`,
      `let impact = Impact::new([contact]).seed(${settings.seed})${quality}${lift}${enabled}${from}${keep};`,
      "let result = object.strike(&impact)?.wait(Deadline::ms(10_000))?;",
      ...(keep ? ['let handle = result.handle().expect("the service keeps results");'] : []),
    ]
      .map((line) => `    ${line}`)
      .join("\n");
  });
  const used = [
    ...["Client", "Contact", "Deadline"],
    ...(effects.length > 0 ? ["Effect"] : []),
    "Impact",
    ...(requests.some((request) => request.settings.lift) ? ["Lift"] : []),
    ...(requests.some((request) => request.settings.quality) ? ["Quality"] : []),
  ];
  return `${comment(requests, "//")}use shatter_client::{${used.join(", ")}};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let service = Client::connect(${JSON.stringify(service)}, Deadline::ms(1000))?;
    let object = service.object(${name}, Deadline::ms(1000))?;
${body.join("\n")}
    result.write_glb("broken.glb".as_ref())?;
    Ok(())
}`;
}

function capital(name: string): string {
  return name.charAt(0).toUpperCase() + name.slice(1);
}

function python(requests: ImpactRequest[], effects: string[], service: string): string {
  const body = requests.map((request, at) => {
    const { settings } = request;
    const options = [
      `seed=${settings.seed}`,
      ...(effects.length > 0 ? [`enable=${JSON.stringify(effects)}`] : []),
      ...(settings.quality ? [`quality="${settings.quality}"`] : []),
      ...(settings.lift ? [`lift="${settings.lift}"`] : []),
      ...(request.parent ? [`origin=(result.handle, ${request.parent.fragment})`] : []),
      ...(at + 1 < requests.length ? ["keep=True"] : []),
    ];
    return [
      `contact = shatter.Contact((${list(request.ray.originM)}), (${list(impulse(request))}), ray=(${list(request.ray.direction)}))`,
      `result = thing.strike(contact, ${options.join(", ")}).wait()`,
    ].join("\n");
  });
  return `${comment(requests, "#")}import shatter

thing = shatter.connect(${service === DEFAULT_SERVICE ? "" : JSON.stringify(service)}).object(${JSON.stringify(requests[0]!.object)})
${body.join("\n")}
result.write_glb("broken.glb")`;
}

/** A whole program: it frees what it takes, and returns 1 if a call fails. */
function c(requests: ImpactRequest[], effects: string[], service: string): string {
  const quality = (name: string) => (name ? `.quality = SHATTER_QUALITY_${name.toUpperCase()}, ` : "");
  const lift = (name: string) => (name ? `.lift = SHATTER_LIFT_${name.toUpperCase()}, ` : "");
  const names = effects.map((effect) => `SHATTER_EFFECT_${effect.toUpperCase()}`);
  const enabled = names.length > 0 ? `.enable = ${names.join(" | ")}, ` : "";
  const body = requests.map((request, at) => {
    const { settings } = request;
    const from = request.parent ? `.from_handle = summary.handle, .from_fragment = ${request.parent.fragment}, ` : "";
    const keep = at + 1 < requests.length;
    return [
      `    contact = (ShatterContact){`,
      `        .point_m = {${reals(request.ray.originM)}},`,
      `        .impulse_ns = {${reals(impulse(request))}},`,
      `        .ray = {${reals(request.ray.direction)}},`,
      `    };`,
      `    impact = (ShatterImpact){.contacts = &contact, .contact_count = 1, ${quality(settings.quality)}${lift(settings.lift)}${from}${keep ? ".keep = true, " : ""}${enabled}.seed = ${settings.seed}};`,
      "    if (shatter_object_strike(object, &impact, &ticket, &error)) return failed(&error);",
      "    if (shatter_ticket_wait(ticket, 10000, &result, &error)) return failed(&error);",
      "    shatter_ticket_free(ticket);",
      ...(keep ? ["    if (shatter_result_summary(result, &summary, &error)) return failed(&error);", "    shatter_result_free(result);"] : []),
    ].join("\n");
  });
  const summary = requests.length > 1 ? "    ShatterSummary summary;\n" : "";
  return `${comment(requests, "//")}#include <shatter.h>
#include <stdio.h>

static int failed(const ShatterError *error) {
    fprintf(stderr, "%s\\n", error->message);
    return 1;
}

int main(void) {
    ShatterService *service;
    ShatterObject *object;
    ShatterTicket *ticket;
    ShatterResult *result;
    ShatterContact contact;
    ShatterImpact impact;
${summary}    ShatterError error;
    if (shatter_connect(${JSON.stringify(service)}, SHATTER_UP_TO_ZERO, 1000, &service, &error)) return failed(&error);
    if (shatter_service_object(service, ${JSON.stringify(requests[0]!.object)}, SHATTER_UP_TO_ZERO, 1000, &object, &error)) return failed(&error);
${body.join("\n")}
    if (shatter_result_write_glb(result, SHATTER_CONTENT_FRAGMENTS, "broken.glb", SHATTER_UP_TO_ZERO, &error)) return failed(&error);
    shatter_result_free(result);
    shatter_object_free(object);
    shatter_service_free(service);
    return 0;
}`;
}
