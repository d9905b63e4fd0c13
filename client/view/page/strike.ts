// Strikes: what is asked of the service, and how it is written in other languages.

import type { Vector } from "./result";

/** A contact by a ray: the first hit is the point. */
export interface RayContact {
  originM: Vector;
  direction: Vector;
}

/** Settings that every strike uses. */
export interface Settings {
  quality: string;
  lift: string;
  seed: number;
}

/** One strike, complete: it can be repeated exactly. */
export interface Strike {
  object: string;
  ray: RayContact;
  impulseNs: number;
  settings: Settings;
  /** The strike whose fragment is struck; `undefined`: the object itself. */
  parent?: { strike: Strike; fragment: number };
}

/** Effects that the page needs to draw, beyond those of the object. They change no fragment. */
export const EFFECTS = ["normals", "bonds"];

/** Effect that a texture needs. It divides vertices at seams of the input, and takes longer than the others together. */
export const TEXTURE_EFFECT = "attributes";

/** The impact of a strike, as the server of the page reads it. */
export function impactOf(strike: Strike, effects: string[], handle: string | undefined): Record<string, unknown> {
  const { settings } = strike;
  return {
    contacts: [{ point_m: strike.ray.originM, ray: strike.ray.direction, impulse_along_ray_ns: strike.impulseNs }],
    ...(settings.quality ? { quality: settings.quality } : {}),
    ...(settings.lift ? { lift: settings.lift } : {}),
    seed: settings.seed,
    enable: effects,
    keep: true,
    ...(strike.parent && handle ? { from: [handle, strike.parent.fragment] } : {}),
  };
}

/** The strikes from the first to this one. */
export function chain(strike: Strike): Strike[] {
  return strike.parent ? [...chain(strike.parent.strike), strike] : [strike];
}

/** Languages of [`codeOf`]. */
export type Language = "shell" | "rust" | "python" | "c";

/** The service that programs connect to if they name none. */
const DEFAULT_SERVICE = "default";

/** A program that repeats a strike exactly, at the same service and with the same effects. */
export function codeOf(strike: Strike, language: Language, effects: string[] = EFFECTS, service = DEFAULT_SERVICE): string {
  const strikes = chain(strike);
  switch (language) {
    case "shell":
      return shell(strikes, effects, service);
    case "rust":
      return rust(strikes, effects, service);
    case "python":
      return python(strikes, effects, service);
    case "c":
      return c(strikes, effects, service);
  }
}

const list = (vector: Vector) => vector.join(",");

/** A number with a decimal point, as Rust and C want it. */
const real = (value: number) => (/[.e]/.test(String(value)) ? String(value) : `${value}.0`);

const reals = (vector: Vector) => vector.map(real).join(", ");

/** The impulse of a strike, N·s: along its ray. */
function impulse(strike: Strike): Vector {
  const [x, y, z] = strike.ray.direction;
  // As the client computes it: `Math.hypot` may differ in the last bit.
  const length = Math.sqrt(x * x + y * y + z * z);
  return strike.ray.direction.map((x) => (strike.impulseNs * x) / length) as Vector;
}

function shell(strikes: Strike[], effects: string[], service: string): string {
  const quoted = (name: string) => (/^[\w-]+$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`);
  const named = service === DEFAULT_SERVICE ? "" : ` --service ${quoted(service)}`;
  return strikes
    .map((strike, at) => {
      const { settings } = strike;
      const options = [
        `--ray ${list(strike.ray.originM)},${list(strike.ray.direction)}`,
        `--impulse-ns ${strike.impulseNs}`,
        ...(settings.quality ? [`--quality ${settings.quality}`] : []),
        ...(settings.lift ? [`--lift ${settings.lift}`] : []),
        `--seed ${settings.seed}`,
        ...(effects.length > 0 ? [`--enable ${effects.join(",")}`] : []),
        ...(strike.parent ? [`--from "$handle/${strike.parent.fragment}"`] : []),
        ...(at + 1 < strikes.length ? ["--keep"] : ["--out broken.glb"]),
        "--json",
      ];
      const command = `shatter${named} impact ${quoted(strike.object)} ${options.join(" ")}`;
      const read = "python3 -c 'import json, sys; print(json.load(sys.stdin)[\"handle\"])'";
      return at + 1 < strikes.length ? `handle=$(${command} | ${read})` : command;
    })
    .join("\n");
}

function rust(strikes: Strike[], effects: string[], service: string): string {
  const name = JSON.stringify(strikes[0]!.object);
  const body = strikes.map((strike, at) => {
    const { settings } = strike;
    const quality = settings.quality ? `.quality(Quality::${capital(settings.quality)})` : "";
    const lift = settings.lift ? `.lift(Lift::${settings.lift.split("_").map(capital).join("")})` : "";
    const from = strike.parent ? `.from(handle, ${strike.parent.fragment})` : "";
    const keep = at + 1 < strikes.length ? ".keep()" : "";
    const enabled = effects.map((effect) => `.enable(Effect::${capital(effect)})`).join("");
    return [
      `let contact = Contact::new([${reals(strike.ray.originM)}])`,
      `    .ray([${reals(strike.ray.direction)}])`,
      `    .impulse_along_ray(${real(strike.impulseNs)});`,
      `let impact = Impact::new([contact]).seed(${settings.seed})${quality}${lift}${enabled}${from}${keep};`,
      "let result = object.strike(&impact)?.wait(Deadline::ms(10_000))?;",
      ...(keep ? ['let handle = result.handle().expect("the service keeps results");'] : []),
    ].join("\n");
  });
  const used = [
    ...["Client", "Contact", "Deadline"],
    ...(effects.length > 0 ? ["Effect"] : []),
    "Impact",
    ...(strikes.some((strike) => strike.settings.lift) ? ["Lift"] : []),
    ...(strikes.some((strike) => strike.settings.quality) ? ["Quality"] : []),
  ];
  return `use shatter_client::{${used.join(", ")}};

let service = Client::connect(${JSON.stringify(service)}, Deadline::ms(1000))?;
let object = service.object(${name}, Deadline::ms(1000))?;
${body.join("\n")}
result.write_glb("broken.glb".as_ref())?;`;
}

function capital(name: string): string {
  return name.charAt(0).toUpperCase() + name.slice(1);
}

function python(strikes: Strike[], effects: string[], service: string): string {
  const body = strikes.map((strike, at) => {
    const { settings } = strike;
    const options = [
      `seed=${settings.seed}`,
      ...(effects.length > 0 ? [`enable=${JSON.stringify(effects)}`] : []),
      ...(settings.quality ? [`quality="${settings.quality}"`] : []),
      ...(settings.lift ? [`lift="${settings.lift}"`] : []),
      ...(strike.parent ? [`origin=(result.handle, ${strike.parent.fragment})`] : []),
      ...(at + 1 < strikes.length ? ["keep=True"] : []),
    ];
    return [
      `contact = shatter.Contact((${list(strike.ray.originM)}), (${list(impulse(strike))}), ray=(${list(strike.ray.direction)}))`,
      `result = thing.strike(contact, ${options.join(", ")}).wait()`,
    ].join("\n");
  });
  return `import shatter

thing = shatter.connect(${service === DEFAULT_SERVICE ? "" : JSON.stringify(service)}).object(${JSON.stringify(strikes[0]!.object)})
${body.join("\n")}
result.write_glb("broken.glb")`;
}

function c(strikes: Strike[], effects: string[], service: string): string {
  const quality = (name: string) => (name ? `.quality = SHATTER_QUALITY_${name.toUpperCase()}, ` : "");
  const lift = (name: string) => (name ? `.lift = SHATTER_LIFT_${name.toUpperCase()}, ` : "");
  const names = effects.map((effect) => `SHATTER_EFFECT_${effect.toUpperCase()}`);
  const enabled = names.length > 0 ? `.enable = ${names.join(" | ")}, ` : "";
  const body = strikes.map((strike, at) => {
    const { settings } = strike;
    const from = strike.parent ? `.from_handle = summary.handle, .from_fragment = ${strike.parent.fragment}, ` : "";
    const keep = at + 1 < strikes.length;
    return [
      `contact = (ShatterContact){{${reals(strike.ray.originM)}}, {${reals(impulse(strike))}}, 0.0, 0.0, {${reals(strike.ray.direction)}}};`,
      `impact = (ShatterImpact){.contacts = &contact, .contact_count = 1, ${quality(settings.quality)}${lift(settings.lift)}${from}${keep ? ".keep = true, " : ""}${enabled}.seed = ${settings.seed}};`,
      "if (shatter_object_strike(object, &impact, &ticket, NULL)) return 3;",
      "if (shatter_ticket_wait(ticket, 10000, &result, NULL)) return 5;",
      ...(keep ? ["if (shatter_result_summary(result, &summary, NULL)) return 3;"] : []),
    ].join("\n");
  });
  return `#include <shatter.h>

ShatterService *service; ShatterObject *object; ShatterTicket *ticket; ShatterResult *result;
ShatterContact contact; ShatterImpact impact; ShatterSummary summary;
if (shatter_connect(${JSON.stringify(service)}, SHATTER_UP_TO_ZERO, 1000, &service, NULL)) return 4;
if (shatter_service_object(service, ${JSON.stringify(strikes[0]!.object)}, SHATTER_UP_TO_ZERO, 1000, &object, NULL)) return 3;
${body.join("\n")}
shatter_result_free(result);`;
}
