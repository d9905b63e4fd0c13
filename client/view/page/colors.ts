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
  /** Where γ is on the ramp, from 0 to 1; `undefined` if it is outside, or no such value. */
  gammaShare: number | undefined;
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

/** Ratio of the largest value to the least above which colors are logarithmic: linear ones would not tell the small values apart. */
const LINEAR_RATIO_MAX = 100;

/** What the values are called: each piece has those of the request that made it. */
function labelOf(mode: ColorMode, requests: number, isLog: boolean): string {
  const what =
    mode === "energy"
      ? "Strain energy in the piece's cell, times the squared distance from its site"
      : "Area of the cracks around the piece";
  const colors = isLog ? `logarithmic colors: the values span a factor of more than ${LINEAR_RATIO_MAX}` : "linear colors from 0";
  return `${what}${requests > 1 ? ", in the request that made it" : ""} (${colors})`;
}

/** What the energies mean. The number of pieces is an estimate, so a cell can exceed γ. */
function energyNote(gamma: string): string {
  return (
    `The object breaks if this energy of the whole exceeds γ = ${gamma}. The number of cells is an estimate of the least ` +
    "with which none exceeds γ; some still can."
  );
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

/** Colors the pieces of all layers on one scale: linear from 0, or logarithmic where the values span much. Pieces that no request made have none. */
export function paintLayers(layers: Layer[], mode: ColorMode): Scale | undefined {
  const made = layers.filter((layer) => layer.request);
  const values = new Map(made.map((layer) => [layer, valuesOf(layer.pieces.result, mode)]));
  const shown = made.flatMap((layer) => values.get(layer)?.filter((_, id) => !layer.replaced.has(id)) ?? []);
  const [least, high] = [Math.min(...shown), Math.max(...shown)];
  const isLog = least > 0 && high / least > LINEAR_RATIO_MAX;
  const low = isLog ? least : 0;
  const share = (value: number) => {
    if (high <= 0) return 0;
    return isLog ? Math.log(value / low) / Math.log(high / low) : value / high;
  };
  const hasValues = mode === "energy" || mode === "bonds";
  for (const layer of layers) {
    const own = values.get(layer);
    layer.pieces.paint((fragment) => (own ? ramp(share(own[fragment]!)) : hasValues ? NEUTRAL.clone() : hue(fragment)));
  }
  if (!hasValues || shown.length === 0) return undefined;
  const isEnergy = mode === "energy";
  const text = (value: number) => (isEnergy ? withUnit(value, "J·m²", high) : area(value, high));
  const gamma = gammaOf(made);
  const gammaShare = isEnergy && gamma >= low && gamma <= high ? share(gamma) : undefined;
  return { label: labelOf(mode, made.length, isLog), low: text(low), high: text(high), gammaShare, note: isEnergy ? energyNote(text(gamma)) : "" };
}

/** The ramp as a style for the legend. */
export function rampStyle(): string {
  return `linear-gradient(90deg, ${RAMP.map((stop) => `#${stop.getHexString()}`).join(", ")})`;
}
