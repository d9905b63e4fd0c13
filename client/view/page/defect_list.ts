// Defects of a previewed mesh: marked in the picture, listed in the panel.

import * as THREE from "three";
import type { App } from "./app";
import { type Defect, NAMES } from "./defects";
import { element, textElement } from "./dom";
import { counted } from "./format";

/** Most defects that are listed; the picture marks all. */
const LISTED_MAX = 40;

const COLORS = { hole: "#e0332f", open: "#e0332f", edge: "#d9a400", winding: "#8a4fd3", flat: "#2f7fe0" };

/** Defects that the page does not look for. */
const BAKE_FINDS = "The bake looks for more: shells turned inside out, parts that intersect, thin walls.";

/** Marks all defects in the picture. `turn` is that of the previewed mesh. */
export function markDefects(app: App, defects: Defect[], turn: THREE.Quaternion): void {
  const { marks } = app.stage;
  app.stage.clearMarks();
  for (const kind of Object.keys(COLORS) as (keyof typeof COLORS)[]) {
    const lines = defects.filter((defect) => defect.kind === kind).flatMap((defect) => defect.lines);
    if (lines.length === 0) continue;
    const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(lines, 3));
    const material = new THREE.LineBasicMaterial({ color: COLORS[kind], depthTest: false });
    const shown = new THREE.LineSegments(geometry, material);
    shown.renderOrder = 8;
    marks.add(shown);
  }
  const size = app.stage.size() * 0.018;
  for (const defect of defects.slice(0, LISTED_MAX)) {
    const ball = new THREE.Mesh(
      new THREE.SphereGeometry(size, 16, 12),
      new THREE.MeshBasicMaterial({ color: COLORS[defect.kind], transparent: true, opacity: 0.75, depthTest: false }),
    );
    ball.position.set(...defect.center);
    ball.renderOrder = 9;
    marks.add(ball);
  }
  marks.quaternion.copy(turn);
  marks.position.copy(app.stage.previewOffset);
  app.stage.changed();
}

/** Lists the defects, with places in the axes and the unit of the file; a click turns to one. */
export function listDefects(app: App, defects: Defect[], unit: string, turn: THREE.Quaternion): void {
  const described = new Map<string, Defect[]>();
  for (const defect of defects) {
    const text = textOf(defect, app.stage.size(), unit);
    const equal = described.get(text);
    if (equal) equal.push(defect);
    else described.set(text, [defect]);
  }
  const listed = [...described].slice(0, LISTED_MAX);
  const rows = listed.map(([text, equal]) => {
    const defect = equal[0]!;
    const row = document.createElement("li");
    const button = document.createElement("button");
    button.textContent = equal.length > 1 ? `${text} (${equal.length} times)` : text;
    button.style.borderLeft = `4px solid ${COLORS[defect.kind]}`;
    const place = new THREE.Vector3(...defect.center).applyQuaternion(turn).add(app.stage.previewOffset);
    button.addEventListener("click", () => app.stage.lookFrom(place));
    row.append(button);
    return row as HTMLElement;
  });
  const more = defects.length - listed.reduce((sum, [, equal]) => sum + equal.length, 0);
  if (defects.length > 0) rows.unshift(textElement("li", counted(defects.length, "defect")));
  if (more > 0) rows.push(textElement("li", `and ${more} more, all marked`));
  rows.push(textElement("li", defects.length === 0 ? `No defects found here. ${BAKE_FINDS}` : BAKE_FINDS));
  element("defects").replaceChildren(...rows);
}

/** A defect in words, with its place. */
function textOf({ kind, count, center }: Defect, size: number, unit: string): string {
  const [one, several] = NAMES[kind];
  const what = kind === "hole" ? `${one} of ${count} edges` : count > 1 ? `${count} ${several}` : one;
  return `${what} at ${center.map((value) => rounded(value, size)).join(", ")} ${unit}`;
}

/** A coordinate of a mesh of this size, with three digits of the size. */
function rounded(value: number, size: number): number {
  const step = 10 ** (Math.floor(Math.log10(size)) - 2);
  return Number((Math.round(value / step) * step).toPrecision(6)) + 0;
}
