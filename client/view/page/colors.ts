// Colors of pieces.

import * as THREE from "three";
import type { ColorMode } from "./material";
import type { ResultMessage } from "./result";

/** Stops of the ramp for values, from least to most. */
const RAMP = ["#2d3a6e", "#3f7f93", "#8fb98a", "#f0d06c", "#e0562d"].map((stop) => new THREE.Color(stop));

/** Hues of pieces: soft, and far apart for neighbors in the table. */
const HUES = ["#d98f6c", "#7aa6b8", "#e3c27a", "#8f9bbf", "#a9b98c", "#c987a0", "#6fae9f", "#d7a58a", "#9f8bb3", "#b5b56a"].map(
  (hue) => new THREE.Color(hue),
);

/** Values of pieces that a ramp shows. */
export interface Values {
  label: string;
  unit: string;
  of: number[];
}

/** The values behind a color mode; `undefined` if the mode shows none. */
export function valuesOf(result: ResultMessage, mode: ColorMode): Values | undefined {
  if (mode === "energy") {
    return { label: "strain energy of the cell", unit: "J·m²", of: result.fragments.map((fragment) => fragment.energyJM2) };
  }
  if (mode === "bonds") {
    const sums = result.fragments.map(() => 0);
    for (const bond of result.bonds()) {
      for (const id of bond.fragments) if (id >= 0) sums[id]! += bond.areaM2;
    }
    return { label: "area of cracks around", unit: "m²", of: sums };
  }
  return undefined;
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

/** Colors of the pieces of a result. Ramps are logarithmic where the values span a decade or more. */
export function painter(values: Values | undefined, range: [number, number]): (fragment: number) => THREE.Color {
  if (!values) return hue;
  const [low, high] = range;
  const isLog = low > 0 && high / low > 10;
  const share = (value: number) => {
    if (high <= low) return 0.5;
    return isLog ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  };
  return (fragment) => ramp(share(values.of[fragment]!));
}

/** The ramp as a style for the legend. */
export function rampStyle(): string {
  return `linear-gradient(90deg, ${RAMP.map((stop) => `#${stop.getHexString()}`).join(", ")})`;
}
