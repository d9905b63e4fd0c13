// Colors of pieces.

import * as THREE from "three";
import { area, withUnit } from "./format";
import type { Layer } from "./history";
import type { ColorMode } from "./material";
import type { ResultMessage } from "./result";

/** Stops of the ramp for values, from least to most. */
const RAMP = ["#2d3a6e", "#3f7f93", "#8fb98a", "#f0d06c", "#e0562d"].map((stop) => new THREE.Color(stop));

/** Hues of pieces: soft, and far apart for neighbors in the table. */
const HUES = ["#d98f6c", "#7aa6b8", "#e3c27a", "#8f9bbf", "#a9b98c", "#c987a0", "#6fae9f", "#d7a58a", "#9f8bb3", "#b5b56a"].map(
  (hue) => new THREE.Color(hue),
);

/** Color of pieces without a value. */
const NEUTRAL = new THREE.Color("#b9b4aa");

/** What the ramp of colors means. */
export interface Scale {
  label: string;
  low: string;
  high: string;
  /** What the values say about the result. */
  note: string;
}

/** Distance-weighted energy of the cell of each piece, J·m², or area of the cracks around it, m²; `undefined` in a mode without values. */
function valuesOf(result: ResultMessage, mode: ColorMode): number[] | undefined {
  if (mode === "energy") return result.fragments.map((fragment) => fragment.energyJM2);
  if (mode !== "bonds") return undefined;
  const sums = result.fragments.map(() => 0);
  for (const bond of result.bonds()) {
    for (const id of bond.fragments) if (id >= 0) sums[id]! += bond.areaM2;
  }
  return sums;
}

/** What the values are called: each piece has those of the request that made it. */
function labelOf(mode: ColorMode, requests: number, isLog: boolean): string {
  const what =
    mode === "energy"
      ? "Strain energy in the piece's cell, times the squared distance from its site"
      : "Area of the cracks around the piece";
  return `${what}${requests > 1 ? ", in the request that made it" : ""} (${isLog ? "logarithmic" : "linear"} colors)`;
}

/** Threshold γ of the last request, J·m². */
function gammaOf(made: Layer[]): number {
  return made.at(-1)?.pieces.result.head.gamma_j_m2 ?? 0;
}

/** Color of a share from 0 to 1. */
function ramp(share: number): THREE.Color {
  const at = THREE.MathUtils.clamp(share, 0, 1) * (RAMP.length - 1);
  const low = Math.min(Math.floor(at), RAMP.length - 2);
  return RAMP[low]!.clone().lerp(RAMP[low + 1]!, at - low);
}

/** Color of a fragment without values. */
function hue(fragment: number): THREE.Color {
  const color = HUES[(fragment * 7) % HUES.length]!.clone();
  return color.offsetHSL(0, 0, 0.05 * ((fragment * 3) % 5) - 0.1);
}

/** Colors the pieces of all layers on one scale, which is logarithmic where the values span a decade or more. Pieces that no request made have none. */
export function paintLayers(layers: Layer[], mode: ColorMode): Scale | undefined {
  const made = layers.filter((layer) => layer.request);
  const values = new Map(made.map((layer) => [layer, valuesOf(layer.pieces.result, mode)]));
  const shown = made.flatMap((layer) => values.get(layer)?.filter((_, id) => !layer.replaced.has(id)) ?? []);
  const [low, high] = [Math.min(...shown), Math.max(...shown)];
  const isLog = low > 0 && high / low > 10;
  const share = (value: number) => {
    if (high <= low) return 0.5;
    return isLog ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  };
  const hasValues = mode === "energy" || mode === "bonds";
  for (const layer of layers) {
    const own = values.get(layer);
    layer.pieces.paint((fragment) => (own ? ramp(share(own[fragment]!)) : hasValues ? NEUTRAL.clone() : hue(fragment)));
  }
  if (!hasValues || shown.length === 0) return undefined;
  const text = (value: number) => (mode === "energy" ? withUnit(value, "J·m²", high) : area(value));
  const note = mode === "energy" ? `The object breaks if this energy of the whole exceeds γ = ${text(gammaOf(made))}, into cells of about γ or less.` : "";
  return { label: labelOf(mode, made.length, isLog), low: text(low), high: text(high), note };
}

/** The ramp as a style for the legend. */
export function rampStyle(): string {
  return `linear-gradient(90deg, ${RAMP.map((stop) => `#${stop.getHexString()}`).join(", ")})`;
}
