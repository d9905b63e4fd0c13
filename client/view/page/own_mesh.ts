// The panel's part for a mesh of the user: drop, defects, bake.

import * as THREE from "three";
import type { App } from "./app";
import { ServiceError } from "./connection";
import { type Defect, findDefects, NAMES } from "./defects";
import { element, onClick, onInput, textElement } from "./dom";
import { length } from "./format";
import { readMesh } from "./mesh_file";
import * as panel from "./panel";

/** Materials of the service (`materials.toml`). */
export const MATERIALS = ["ceramic", "glass", "stone", "marble", "concrete", "plaster", "terracotta", "ice"];

/** Most defects that are listed; the picture marks all. */
const LISTED_MAX = 40;

/** Largest file, bytes: the server refuses a longer message. */
const BYTES_MAX = 60 << 20;

const COLORS = { hole: "#e0332f", edge: "#d9a400", winding: "#8a4fd3", flat: "#2f7fe0" };

/** Units of files, m. */
const UNITS: Record<string, number> = { m: 1, cm: 0.01, mm: 0.001, in: 0.0254 };

interface OwnFile {
  name: string;
  contents: ArrayBuffer;
  /** Lengths along the axes, in the unit of the file; `undefined` of a file that the page does not read. */
  extent: THREE.Vector3 | undefined;
}

/** Binds drop, choice and bake of a mesh file. `loadObjects` shows an object of the service. */
export function bindOwnMesh(app: App, loadObjects: (name: string) => Promise<void>): void {
  let file: OwnFile | undefined;
  const select = element<HTMLSelectElement>("mesh-material");
  select.replaceChildren(...MATERIALS.map((name) => new Option(name)));
  const input = element<HTMLInputElement>("file");
  onClick("open", () => input.click());
  const take = (chosen: File | undefined) => {
    if (!chosen) return;
    void app.guarded(async () => {
      file = await open(app, chosen);
      showSize(file.extent);
    });
  };
  input.addEventListener("change", () => {
    take(input.files?.[0]);
    input.value = "";
  });
  bindDrop(take);
  onClick("bake", () => {
    if (file) void bake(app, file, loadObjects);
  });
  onInput("mesh-unit", () => showSize(file?.extent));
  onClick("cancel", () => void app.connection.ask({ op: "cancel_bake" }));
}

function bindDrop(take: (file: File | undefined) => void): void {
  const cover = element("drop");
  let depth = 0;
  const over = (by: number) => {
    depth = Math.max(0, depth + by);
    cover.hidden = depth === 0;
  };
  window.addEventListener("dragenter", (event) => {
    event.preventDefault();
    over(1);
  });
  window.addEventListener("dragleave", () => over(-1));
  window.addEventListener("dragover", (event) => event.preventDefault());
  window.addEventListener("drop", (event) => {
    event.preventDefault();
    over(-depth);
    take(event.dataTransfer?.files[0]);
  });
}

/** Shows a mesh file and its defects. */
async function open(app: App, chosen: File): Promise<OwnFile> {
  if (chosen.size > BYTES_MAX) throw new Error(`${chosen.name} is larger than 60 MB: bake it with shatterd bake instead`);
  const contents = await chosen.arrayBuffer();
  const preview = await readMesh(chosen.name, contents).catch((error: unknown) => {
    throw new Error(`${chosen.name} cannot be read: ${error instanceof Error ? error.message : String(error)}`);
  });
  const details = element<HTMLDetailsElement>("mesh");
  details.hidden = false;
  details.open = true;
  document.body.classList.remove("folded");
  element("mesh-name").textContent = preview
    ? `${chosen.name}, ${(preview.mesh.indices.length / 3).toLocaleString("en-US")} triangles`
    : `${chosen.name}: shown after the bake`;
  const defects = preview ? findDefects(preview.mesh) : [];
  if (preview) {
    app.preview(preview.shown, preview.textures);
    mark(app, defects);
    list(app, defects);
    choosePreview(chosen.name);
  }
  details.scrollIntoView({ block: "nearest" });
  panel.hint(defects.length > 0 ? "Its defects are marked; the bake repairs them" : "Bake it to strike it");
  return { name: chosen.name, contents, extent: preview && new THREE.Box3().setFromObject(preview.shown).getSize(new THREE.Vector3()) };
}

/** Tells how large the mesh is in the chosen unit. */
function showSize(extent: THREE.Vector3 | undefined): void {
  const unitM = UNITS[element<HTMLSelectElement>("mesh-unit").value] ?? 1;
  element("mesh-size").textContent = extent ? `Size: ${extent.toArray().map((value) => length(unitM * value)).join(" × ")}` : "";
}

/** Lists the file as what is shown, before the objects: each of those can be chosen, then. */
function choosePreview(name: string): void {
  const select = element<HTMLSelectElement>("object");
  for (const option of [...select.options]) if (option.value === "") option.remove();
  select.add(new Option(`${name} (not baked)`, ""), 0);
  select.value = "";
}

/** Marks all defects in the picture. */
function mark(app: App, defects: Defect[]): void {
  const { marks } = app.stage;
  marks.clear();
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
  marks.position.copy(app.stage.previewOffset);
  app.stage.changed();
}

/** Lists the defects; a click turns to one. */
function list(app: App, defects: Defect[]): void {
  const rows = defects.slice(0, LISTED_MAX).map((defect) => {
    const row = document.createElement("li");
    const button = document.createElement("button");
    const [x, y, z] = defect.center.map((value) => rounded(value, app.stage.size()));
    const edges = defect.kind === "hole" ? ` of ${defect.count} edges` : defect.count > 1 ? ` (${defect.count})` : "";
    button.textContent = `${NAMES[defect.kind]}${edges} at ${x}, ${y}, ${z}`;
    button.style.borderLeft = `4px solid ${COLORS[defect.kind]}`;
    button.addEventListener("click", () => app.stage.lookFrom(new THREE.Vector3(...defect.center).add(app.stage.previewOffset)));
    row.append(button);
    return row;
  });
  const more = defects.length - rows.length;
  if (more > 0) rows.push(textElement("li", `and ${more} more`) as HTMLLIElement);
  if (defects.length === 0) rows.push(textElement("li", "No defects found.") as HTMLLIElement);
  element("defects").replaceChildren(...rows);
}

/** A coordinate of a mesh of this size, with three digits of the size. */
function rounded(value: number, size: number): number {
  const step = 10 ** (Math.floor(Math.log10(size)) - 2);
  return Number((Math.round(value / step) * step).toPrecision(6)) + 0;
}

/** The name of the object: that of the file, with plain letters. */
function objectName(file: string): string {
  const stem = file.replace(/\.[^.]*$/, "").replace(/[^\w-]+/g, "-");
  return stem.slice(0, 60) || "mesh";
}

interface BakeReport {
  object: string;
  surface: { kind: string; reason: string | null; repairs: { kind: string; count: number; places_m: unknown }[] };
  defects: { counted: string; first: string; action: string }[];
  warnings: string[];
  seconds: number;
}

/** Bakes the file, with progress, and shows the object. */
async function bake(app: App, file: OwnFile, loadObjects: (name: string) => Promise<void>): Promise<void> {
  const value = (id: string) => element<HTMLSelectElement>(id).value;
  const name = objectName(file.name);
  const head = { op: "bake", file: file.name, name, material: value("mesh-material"), unit: value("mesh-unit"), up: value("mesh-up") };
  const [progress, line] = [element<HTMLProgressElement>("progress"), element("progress-line")];
  progress.hidden = element("cancel").hidden = false;
  progress.removeAttribute("value");
  element<HTMLButtonElement>("bake").disabled = true;
  await app.guarded(async () => {
    try {
      const reply = await app.connection.sendFile(head, file.contents, (text) => (line.textContent = text.replace(/^[^:]*: /, "")));
      const report = reply["report"] as BakeReport;
      panel.setReason(report.object, report.surface.reason);
      line.textContent = `Baked in ${report.seconds.toFixed(1)} s. ${report.warnings.join(" ").replaceAll("`", "")}`;
      const repaired = report.defects.map((defect) => textElement("li", `${defect.counted} (first at ${defect.first}): ${defect.action}`));
      if (repaired.length > 0) element("defects").replaceChildren(...repaired);
      await untilServed(app, name);
      app.keepTextures(name);
      await loadObjects(name);
      element<HTMLDetailsElement>("mesh").open = repaired.length + report.warnings.length > 0;
    } catch (error) {
      line.textContent = error instanceof ServiceError && error.kind === "canceled" ? "Canceled." : "";
      if (!(error instanceof ServiceError && error.kind === "canceled")) throw error;
    }
  });
  progress.hidden = element("cancel").hidden = true;
  element<HTMLButtonElement>("bake").disabled = false;
}

/** Waits until the daemon has loaded the object; it looks for new files a few times per second. */
async function untilServed(app: App, name: string): Promise<void> {
  for (let attempt = 0; attempt < 100; attempt++) {
    const reply = await app.connection.ask({ op: "objects" });
    const objects = reply["objects"] as { name: string; state: string; error: string | null }[];
    const own = objects.find((object) => object.name === name);
    if (own?.state === "ready") return;
    if (own?.state === "failed") throw new Error(own.error ?? `${name} could not be loaded`);
    await new Promise((resolve) => setTimeout(resolve, 200));
  }
  throw new Error(`The daemon does not serve ${name}: it serves another folder. End it, and start shatter view again, which starts its own.`);
}
