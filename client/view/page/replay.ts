// A recording: the page replays requests that were made before, without a service.

import type { App, ObjectFacts } from "./app";
import { element } from "./dom";
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

/** Shows a recording: every request becomes a state. */
export async function replay(app: App, recording: RecordedReply[]): Promise<void> {
  document.body.classList.add("replay");
  // Hulls are asked for when they are first shown: a recording has none.
  element<HTMLInputElement>("hulls").disabled = true;
  const byHandle = new Map<string, { request: ImpactRequest; result: ResultMessage }>();
  for (const { request: text, message } of recording) {
    const asked = JSON.parse(text) as RecordedRequest;
    const result = decode(await bytes(message));
    if (asked.op === "intact") {
      app.showIntact(factsOf(asked.object, result), result);
      continue;
    }
    const impact = asked.impact;
    const contact = impact?.contacts[0];
    if (!impact || !contact || result.floats("normals").length === 0) continue;
    const settings: Settings = { quality: impact.quality ?? "", lift: impact.lift ?? "", seed: Number(impact.seed ?? 0) };
    const parent = impact.from && byHandle.get(impact.from[0]);
    const request: ImpactRequest = {
      object: asked.object,
      ray: { originM: contact.point_m, direction: contact.ray },
      impulseNs: contact.impulse_along_ray_ns,
      settings,
      ...(parent && impact.from ? { parent: { request: parent.request, fragment: impact.from[1] } } : {}),
    };
    if (result.head.handle) byHandle.set(result.head.handle, { request, result });
    app.showRecorded(request, result);
  }
  app.go(-Infinity);
  panel.hint("A recording: → shows the next result");
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
