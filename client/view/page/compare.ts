// Presets and lifts side by side: the last request with each of them, with error and time.

import type { App } from "./app";
import { element, onClick, textElement } from "./dom";
import { counted, percent, time } from "./format";
import type { Answer } from "./history";
import type { ResultMessage } from "./result";
import type { ImpactRequest, Settings } from "./impact_request";

/** Size of a picture, pixels. */
const PICTURE = { width: 260, height: 220 };

/** What is compared. */
const VARIANTS: { name: string; change: Partial<Settings> }[] = [
  { name: "draft", change: { quality: "draft" } },
  { name: "game", change: { quality: "game" } },
  { name: "film", change: { quality: "film" } },
  { name: "reference", change: { quality: "reference" } },
  { name: "interior lift", change: { lift: "interior" } },
  { name: "euclidean lift", change: { lift: "euclidean" } },
  { name: "surface diffusion", change: { lift: "surface_diffusion" } },
];

/** What the pictures are of. */
let compared: Answer | undefined;

/** Binds the comparison. Returns what removes its pictures once another result is shown. */
export function bindCompare(app: App): () => void {
  onClick("run-compare", () => void compare(app));
  return () => {
    if (app.history.now?.last === compared) return;
    compared = undefined;
    element("compared").replaceChildren();
  };
}

async function compare(app: App): Promise<void> {
  const last = app.history.now?.last;
  const into = element("compared");
  if (!last) {
    into.replaceChildren(textElement("span", "Strike the object first."));
    return;
  }
  into.replaceChildren();
  compared = last;
  const button = element<HTMLButtonElement>("run-compare");
  button.disabled = true;
  for (const { name, change } of VARIANTS) {
    const request: ImpactRequest = { ...last.request, settings: { ...last.request.settings, ...change } };
    const figure = document.createElement("figure");
    figure.append(textElement("b", name));
    into.append(figure);
    if (into.children.length === 1) into.scrollIntoView({ block: "nearest" });
    if (request.parent && change.lift === "surface_diffusion") {
      figure.append(textElement("span", "not for pieces: their lifts are interior and euclidean"));
      continue;
    }
    try {
      const result = await app.resultOf(request, (effects) => effects, false);
      // Another result is shown meanwhile.
      if (compared !== last) break;
      describe(figure, result);
      const picture = document.createElement("img");
      [picture.width, picture.height] = [PICTURE.width, PICTURE.height];
      picture.alt = `${name}: ${counted(result.fragments.length, "piece")}`;
      picture.src = app.pictureOf(last, result, request, PICTURE.width, PICTURE.height);
      figure.prepend(picture);
    } catch (error) {
      figure.append(textElement("span", (error instanceof Error ? error.message : String(error)).replaceAll("`", "")));
    }
  }
  button.disabled = false;
}

function describe(figure: HTMLElement, result: ResultMessage): void {
  const { head } = result;
  const energy = head.energy_error === null ? "" : head.energy_error === 0 ? "energy solved" : `error of the energy ${percent(head.energy_error)}`;
  const gap = head.cvd_gap === null ? "" : `gap of the cells ${percent(head.cvd_gap)}`;
  figure.append(
    textElement("span", result.isWhole ? "stays whole" : `${counted(result.fragments.length, "piece")} in ${time(head.time_ns)}`),
    textElement("span", [energy, gap].filter(Boolean).join(", ")),
  );
}
