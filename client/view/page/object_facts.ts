// What the page knows of an object, and of a place of it.

import type { Layer } from "./history";
import type { RayContact } from "./impact_request";
import type { Pick } from "./pieces";
import type { Vector } from "./result";

/** Facts of an object of the service. */
export interface ObjectFacts {
  name: string;
  state: string;
  error: string | null;
  material: string;
  bounds_m: [Vector, Vector];
  diagonal_m: number;
  radius_m: number;
  volume_m3: number;
  density_kg_m3: number;
}

/** A contact that the user points at. */
export interface Aim {
  layer: Layer;
  pick: Pick;
  ray: RayContact;
  thresholdNs?: number;
  /** The point of the page. */
  x: number;
  y: number;
}
