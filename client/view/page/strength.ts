// Strength of an impact: a multiple of the impulse that just breaks the object at the contact, shown as an impulse, a height or a speed.

import { chosen, element, textElement } from "./dom";
import { digits, length, withUnit } from "./format";
import type { ImpactRequest } from "./impact_request";

/** Multiples of the breaking impulse at both ends of the slider. */
const LEAST = 0.2;
const MOST = 100;

/** Multiples that the rule below the slider names. */
const TICKS = [0.5, 1, 2, 5, 10, 20, 100];

/** Multiple at the beginning: some dozen pieces of most objects. */
const BEGIN = 6;

/** How to see a threshold. */
const ADVICE = matchMedia("(pointer: coarse)").matches
  ? "Tap a place to strike it and to see its threshold."
  : "Point at a place to see its threshold.";

/** Standard acceleration of free fall, m/s² (ISO 80000-3). */
const GRAVITY = 9.80665;

const slider = () => element<HTMLInputElement>("impulse");

/** The multiple of the breaking impulse that the slider says. */
export function factor(): number {
  return LEAST * (MOST / LEAST) ** (Number(slider().value) / Number(slider().max));
}

/** Where the slider's middle is at a multiple. */
function leftOf(multiple: number): string {
  const share = Math.log(multiple / LEAST) / Math.log(MOST / LEAST);
  return `calc(8px + ${share} * (100% - 16px))`;
}

/** Moves the slider to a multiple. */
export function setFactor(value: number): void {
  slider().value = String((Number(slider().max) * Math.log(value / LEAST)) / Math.log(MOST / LEAST));
}

/** Places the mark of the threshold, and the slider at its beginning. */
export function begin(): void {
  for (const id of ["threshold", "threshold-name"]) element(id).style.left = leftOf(1);
  element("ticks").replaceChildren(
    ...TICKS.map((multiple) => {
      const tick = textElement("span", `${multiple}×`);
      tick.style.left = leftOf(multiple);
      return tick;
    }),
  );
  setFactor(BEGIN);
}

/** An impulse as the chosen quantity: of a ball that falls, or flies, and stops at the object. */
export function quantity(impulseNs: number): string {
  const massKg = Number(element<HTMLSelectElement>("ball").value);
  const speed = impulseNs / massKg;
  switch (chosen("by")) {
    case "drop":
      return length((speed * speed) / (2 * GRAVITY));
    case "speed":
      return `${digits(speed)} m/s`;
    default:
      return withUnit(impulseNs, "N·s");
  }
}

/** Shows the strength, beside the threshold at the contact if that is known. */
export function show(thresholdNs: number | undefined): void {
  element("ball-row").hidden = chosen("by") === "impulse";
  const value = factor();
  // The slider says multiples of the impulse; the height of a drop grows with its square.
  const isHeight = chosen("by") === "drop";
  const times = `${digits(isHeight ? value * value : value, 2)} × the threshold`;
  element("strength").textContent =
    thresholdNs === undefined ? `${digits(value, 2)} × the threshold` : quantity(thresholdNs * value);
  const ofImpulse = isHeight ? ` (${digits(value, 2)} × the impulse)` : "";
  element("breaks").textContent = thresholdNs === undefined ? ADVICE : `${times} of ${quantity(thresholdNs)}${ofImpulse}`;
}

/** Sets slider, preset, lift and seed to those of a request, whose impulse is `multiple` times the one that just breaks. */
export function showRequest({ settings }: ImpactRequest, multiple: number): void {
  setFactor(multiple);
  element<HTMLSelectElement>("quality").value = settings.quality;
  element<HTMLSelectElement>("lift").value = settings.lift;
  element<HTMLInputElement>("seed").value = String(settings.seed);
}
