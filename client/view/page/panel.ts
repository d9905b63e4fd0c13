// The panel: facts of the result, choices of the view.

import { histogram, stageBars } from "./charts";
import { countClosed } from "./closed";
import { rampStyle, type Scale } from "./colors";
import { chosen, element, textElement } from "./dom";
import { counted, digits, percent, time, withUnit } from "./format";
import { countShown, multipleOf, type State } from "./history";
import type { ColorMode } from "./material";
import type { ObjectFacts } from "./object_facts";
import type { ResultHead, ResultMessage } from "./result";

/** Time for which a hint stays, ms. */
const HINT_MS = 6000;

let hintTimer: number | undefined;

/** Shows a hint over the object, for a while or until another one. Fingers tap. */
export function hint(text: string | undefined, stays = false): void {
  clearTimeout(hintTimer);
  const shown = matchMedia("(pointer: coarse)").matches ? text?.replace(/^Click/, "Tap") : text;
  element("hint").replaceChildren(...(shown ? [textElement("span", shown)] : []));
  if (text && !stays) hintTimer = window.setTimeout(() => hint(undefined), HINT_MS);
}

/** Shows an error; `undefined` removes it. */
export function message(text: string | undefined): void {
  const box = element("message");
  box.hidden = text === undefined;
  box.querySelector("span")!.textContent = text ?? "";
}

/** Whether a check box is on. */
export function isOn(id: string): boolean {
  return element<HTMLInputElement>(id).checked;
}

/** What the pieces are colored by. */
export function colorMode(): ColorMode {
  return chosen("color") as ColorMode;
}

/** Shows the meaning of the colors. */
export function legend(values: Scale | undefined): void {
  const box = element("legend");
  box.hidden = values === undefined;
  const isColored = ["surface", "pieces"].includes(colorMode());
  const absent = isColored ? "" : "The whole object has no such values: strike it to see those of the pieces.";
  element("color-note").textContent = values?.note ?? absent;
  if (!values) return;
  const [label, low, bar, high] = box.children as unknown as [HTMLElement, HTMLElement, HTMLElement, HTMLElement];
  const mark = bar.firstElementChild as HTMLElement;
  label.textContent = values.label;
  low.textContent = values.low;
  high.textContent = values.high;
  bar.style.background = rampStyle();
  mark.hidden = values.gammaShare === undefined;
  mark.style.left = `${100 * (values.gammaShare ?? 0)}%`;
}

/** Surface of the fragments, in words; the reason is known of meshes that this page baked. */
const reasons = new Map<string, string>();

/** Remembers why the fragments of an object have the lattice's surface. */
export function setReason(object: string, reason: string | null): void {
  if (reason) reasons.set(object, reason);
  else reasons.delete(object);
}

function surface(head: ResultHead): string {
  if (head.surface === "exact") return "the input's own (exact)";
  return `the lattice's: ${reasons.get(head.object) ?? "the object has no mesh of its own surface; shatterd inspect says why"}`;
}

/** Estimated error of the elastic energy, in words. */
function energyError(head: ResultHead): string {
  if (head.energy_error === null) return "not estimated";
  return head.energy_error === 0 ? "none: solved" : `${percent(head.energy_error)} (est.)`;
}

/** Shows the facts of a state. */
export function facts(state: State, object: ObjectFacts | undefined): void {
  const last = state.last;
  element("result").hidden = element("away").hidden = last === undefined;
  if (!last) return;
  const { head } = last.result;
  const { fragments } = last.result;
  const count = countShown(state.layers);
  element("pieces").textContent = last.result.isWhole ? "stays whole" : counted(count, "piece");
  const isPart = !last.result.isWhole && count > fragments.length;
  element("took").textContent = `${isPart ? `${fragments.length.toLocaleString("en-US")} new, ` : ""}in ${time(head.time_ns)}`;
  const rows: [string, string][] = [
    ["Impulse", `${withUnit(last.request.impulseNs, "N·s")}, ${digits(multipleOf(last), 2)} × the threshold`],
    ["Round trip", time(head.round_trip_ns)],
    // A recording has no such time.
    ...(last.pictureMs > 0 ? ([["Picture ready after", `${digits(last.pictureMs)} ms`]] as [string, string][]) : []),
    ["E₁/γ (breaks above 1)", digits(head.e1_over_gamma)],
    ["Threshold γ", withUnit(head.gamma_j_m2, "J·m²")],
    ["Displacements", head.elastic],
    ...ledger(head),
    ["Error of the energy", energyError(head)],
  ];
  if (!last.result.isWhole) {
    const massKg = fragments.reduce((sum, fragment) => sum + fragment.massKg, 0);
    rows.unshift([isPart ? "Closed, of the new ones" : "Closed", "…"]);
    rows.push(
      ["Gap of the cells", head.cvd_gap === null ? "none" : `${percent(head.cvd_gap)} (est.)`],
      ["Sites", `${head.sites} (${head.degree_source.replace("_", " ")}${head.capped ? ", capped" : ""})`],
      ["Stopped", head.stop_reason.replace("_", " ")],
      [isPart ? "Mass of the new ones" : "Mass", `${digits(massKg)} kg`],
      ["Surface", surface(head)],
      ["Size", `${digits(head.response_bytes / 1e6)} MB`],
    );
  }
  if (object) rows.push(["Material", object.material]);
  element("facts").replaceChildren(...rows.flatMap(([name, value]) => [textElement("dt", name), textElement("dd", value)]));
  const shown = state.layers.flatMap((layer) =>
    layer.pieces.result.fragments.filter((fragment) => !layer.replaced.has(fragment.id)).map((fragment) => fragment.volumeM3),
  );
  element("volumes-part").hidden = shown.length < 2;
  histogram(element("volumes"), shown);
  stageBars(element("stages"), head);
  const row = element("facts").querySelector("dd");
  if (!last.result.isWhole && row) void showClosed(last.result, row);
}

/** The known ones of the energies of a result, and its stress. Recordings of older versions have none. */
function ledger(head: ResultHead): [string, string][] {
  const rows: [string, number | null | undefined, string][] = [
    ["Stress over strength (breaks from 1)", head.stress_over_strength, ""],
    ["Energy of the impactor", head.impactor_j, "J"],
    ["Strain energy", head.strain_j, "J"],
    ["Energy of the cracks", head.surface_j, "J"],
    ["Energy of the release", head.released_j, "J"],
  ];
  return rows.flatMap(([name, value, unit]): [string, string][] => (value ? [[name, unit ? withUnit(value, unit) : digits(value)]] : []));
}

/** Counts closed pieces once the picture is drawn, and writes them into a row. Another state has rows of its own. */
async function showClosed(result: ResultMessage, row: HTMLElement): Promise<void> {
  await new Promise((resolve) => setTimeout(resolve, 60));
  const closed = await countClosed(result, () => row.isConnected);
  row.textContent = `${closed} of ${result.fragments.length}`;
}
