// A recording: the page replays requests that were made before, without a service.

import { EXPLODE_FIRST, type App } from "./app";
import { element, onInput } from "./dom";
import { type Layer, layersAfter } from "./history";
import type { ObjectFacts } from "./object_facts";
import * as panel from "./panel";
import { decode, type ResultMessage, type Vector } from "./result";
import type { ImpactRequest, Settings } from "./impact_request";

interface RecordedReply {
  request: string;
  message: string;
}

interface RecordedRequest {
  op: string;
  object: string;
  impact?: {
    contacts: { point_m: Vector; ray: Vector; impulse_along_ray_ns: number }[];
    quality?: string;
    lift?: string;
    seed?: number;
    from?: [string, number];
  };
}

/** The recording in the page, if it is one. */
export function recordingOf(page: Document): RecordedReply[] | undefined {
  const text = page.getElementById("recording")?.textContent;
  return text ? (JSON.parse(text) as RecordedReply[]) : undefined;
}

/** A request of a recording with its result. */
interface Step {
  request: ImpactRequest;
  result: ResultMessage;
}

/** What was done to an object from when it was chosen. */
interface Part {
  object: ObjectFacts;
  whole: ResultMessage;
  steps: Step[];
}

/** Shows a recording: every request becomes a state; the list of objects chooses among the parts. */
export async function replay(app: App, recording: RecordedReply[]): Promise<void> {
  document.body.classList.add("replay");
  // Hulls are asked for when they are first shown: a recording has none.
  element<HTMLInputElement>("hulls").disabled = true;
  element("canvas").setAttribute("aria-label", "The recorded object. Drag or use the arrow keys to turn it; N shows the next result.");
  const parts = await partsOf(recording);
  const select = element<HTMLSelectElement>("object");
  const label = ({ object, steps }: Part) => `${object.name} (${steps.length})`;
  select.replaceChildren(...parts.map((part, at) => new Option(label(part), String(at))));
  const show = (part: Part | undefined) => {
    if (!part) return;
    app.showIntact(part.object, part.whole);
    for (const step of part.steps) showRecorded(app, step);
    app.go(-Infinity);
    document.title = `Shatter: recorded results of ${part.object.name}`;
    panel.hint(`A recording: the button → shows the next result${parts.length > 1 ? "; the list at the top, other objects" : ""}`, true);
  };
  onInput("object", () => show(parts[Number(select.value)]));
  show(parts[0]);
}

/** The parts of a recording in which something was struck; without such, the last object. */
async function partsOf(recording: RecordedReply[]): Promise<Part[]> {
  const parts: Part[] = [];
  const byHandle = new Map<string, ImpactRequest>();
  let known = new Map<string, ImpactRequest>();
  for (const { request: text, message } of recording) {
    const asked = JSON.parse(text) as RecordedRequest;
    const result = decode(await bytes(message));
    if (asked.op === "intact") {
      parts.push({ object: factsOf(asked.object, result), whole: result, steps: [] });
      known = new Map();
      continue;
    }
    const part = parts.findLast(({ object }) => object.name === asked.object);
    const request = requestOf(asked, byHandle);
    if (!part || !request || result.isWhole) continue;
    // The page repeats a request that the service has forgotten.
    const key = JSON.stringify(request);
    const first = known.get(key) ?? request;
    if (result.head.handle) byHandle.set(result.head.handle, first);
    if (first === request) part.steps.push({ request, result });
    known.set(key, first);
  }
  const struck = parts.filter(({ steps }) => steps.length > 0);
  return struck.length > 0 ? struck : parts.slice(-1);
}

/** The request that was recorded. */
function requestOf({ object, impact }: RecordedRequest, byHandle: Map<string, ImpactRequest>): ImpactRequest | undefined {
  const contact = impact?.contacts[0];
  if (!impact || !contact) return undefined;
  const settings: Settings = { quality: impact.quality ?? "", lift: impact.lift ?? "", seed: Number(impact.seed ?? 0) };
  const parent = impact.from && byHandle.get(impact.from[0]);
  return {
    object,
    ray: { originM: contact.point_m, direction: contact.ray },
    impulseNs: contact.impulse_along_ray_ns,
    settings,
    ...(parent && impact.from ? { parent: { request: parent, fragment: impact.from[1] } } : {}),
  };
}

/** Adds a step as a state, after the latest one that shows what was struck. */
function showRecorded(app: App, { request, result }: Step): void {
  const { parent } = request;
  const fragment = parent?.fragment ?? 0;
  const struckIn = (layers: Layer[]) => layers.find((layer) => layer.request === parent?.request && !layer.replaced.has(fragment));
  const before = app.history.latest(({ layers }) => struckIn(layers) !== undefined)?.layers;
  const struck = before && struckIn(before);
  if (!struck) return;
  const at = { before, struck, fragment };
  app.history.append({ layers: layersAfter(at, app.layer(result, request)), last: { ...at, request, result, pictureMs: 0 } });
  if (app.explode() === 0) app.setExplode(EXPLODE_FIRST);
}

/** The message of a request: gzip as base64. */
async function bytes(base64: string): Promise<ArrayBuffer> {
  const reply = await fetch(`data:application/octet-stream;base64,${base64}`);
  return new Response(reply.body!.pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}

/** Facts of an object, from its result in one piece: a recording has no others. */
function factsOf(name: string, result: ResultMessage): ObjectFacts {
  const [low, high]: [Vector, Vector] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
  const positions = result.floats("positions");
  for (const fragment of result.fragments) {
    for (let at = 3 * fragment.vertexFirst; at < 3 * (fragment.vertexFirst + fragment.vertexCount); at++) {
      const axis = at % 3;
      const value = positions[at]! + fragment.centerM[axis]!;
      low[axis] = Math.min(low[axis]!, value);
      high[axis] = Math.max(high[axis]!, value);
    }
  }
  const diagonal = Math.hypot(...high.map((x, axis) => x - low[axis]!));
  return {
    name,
    state: "ready",
    error: null,
    material: result.head.material ?? "ceramic",
    bounds_m: [low, high],
    diagonal_m: diagonal,
    radius_m: 0.02 * diagonal,
    volume_m3: 0,
    density_kg_m3: 0,
  };
}
