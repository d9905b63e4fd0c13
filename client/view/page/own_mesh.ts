// The panel's part for a mesh of the user: drop, defects, bake.

import * as THREE from "three";
import type { App } from "./app";
import { type BakeReport, reportRows, warningText } from "./bake_report";
import { ServiceError } from "./connection";
import { listDefects, markDefects } from "./defect_list";
import { type Defect, findDefects } from "./defects";
import { element, onClick, onInput, textElement } from "./dom";
import { length } from "./format";
import { ENDING_LIST, ENDINGS, endingOf } from "./mesh_check";
import { readMesh } from "./mesh_file";
import type { ObjectFacts } from "./object_facts";
import * as panel from "./panel";

/** Materials of the service (`materials.toml`). */
export const MATERIALS = ["ceramic", "glass", "stone", "marble", "concrete", "plaster", "terracotta", "ice"];

/** Largest file, bytes: the server refuses a longer message. */
const BYTES_MAX = 60 << 20;

/** Units of files, m. */
const UNITS: Record<string, number> = { m: 1, cm: 0.01, mm: 0.001, in: 0.0254 };

/** A file as it is shown before the bake. */
interface ShownFile {
  /** Holds the mesh, turned by the chosen axis. */
  shown: THREE.Group;
  textures: THREE.DataArrayTexture | undefined;
  defects: Defect[];
}

interface OwnFile {
  name: string;
  contents: ArrayBuffer;
  /** `undefined` of a file that the page does not read. */
  preview: ShownFile | undefined;
  /** The object that the page showed when the file was opened. */
  openedOver: ObjectFacts | undefined;
  /** Name of the object that was baked from it. */
  bakedAs: string | undefined;
}

/** The mesh file of the user, of which the last one is kept. */
export class OwnMesh {
  private file: OwnFile | undefined;

  /** Binds drop, choice and bake. `loadObjects` shows an object of the service, seen from where the user looks. */
  constructor(
    private readonly app: App,
    private readonly loadObjects: (name: string) => Promise<void>,
  ) {
    const select = element<HTMLSelectElement>("mesh-material");
    select.replaceChildren(...MATERIALS.map((name) => new Option(name)));
    const input = element<HTMLInputElement>("file");
    input.accept = ENDING_LIST;
    element("drop").textContent = `Drop a mesh: ${ENDING_LIST}`;
    onClick("open", () => input.click());
    const take = (chosen: File | undefined) => {
      if (chosen) void app.guarded(() => this.open(chosen));
    };
    input.addEventListener("change", () => {
      take(input.files?.[0]);
      input.value = "";
    });
    bindDrop(take);
    onClick("bake", () => {
      if (this.file) void this.bake(this.file);
    });
    onInput("mesh-unit", () => this.describe());
    // An object that is baked already stands as it was baked.
    onInput("mesh-up", () => (app.object ? this.describe() : this.show(true)));
    onClick("cancel", () => void app.connection.ask({ op: "cancel_bake" }));
  }

  /** Shows the part of the panel for the file, or for the object baked from it, alone. */
  follow(): void {
    const { file, app } = this;
    const isShown = file && (!app.object || file.bakedAs === app.object.name);
    const isOpened = file && !file.preview && file.openedOver === app.object;
    // A bake goes on, and can be canceled, while another object is shown.
    element("mesh").hidden = !isShown && !isOpened && !element<HTMLButtonElement>("bake").disabled;
    element("defects").hidden = !isShown;
  }

  /** Lists the file before the objects until it is baked: each of them can be chosen. */
  offer(): void {
    const select = element<HTMLSelectElement>("object");
    for (const option of [...select.options]) if (option.value === "") option.remove();
    if (!this.file?.preview || this.file.bakedAs !== undefined) return;
    const chosen = select.value;
    select.add(new Option(`${this.file.name} (not baked)`, ""), 0);
    select.value = this.app.object ? chosen : "";
    select.title = select.selectedOptions[0]?.text ?? "";
  }

  /** Shows the file again, which is not baked yet. */
  show(keepsView = false): void {
    const { file, app } = this;
    if (!file?.preview) return;
    const { shown, defects } = file.preview;
    this.turn(file.preview);
    app.preview(shown, keepsView);
    markDefects(app, defects, shown.quaternion);
    this.describe();
    this.offer();
    this.hint(file);
  }

  /** Tells what to do with a file, unless it is being baked. */
  private hint(file: OwnFile): void {
    if (element<HTMLButtonElement>("bake").disabled) panel.hint(undefined);
    else panel.hint(file.preview?.defects.length ? "Bake it to strike it: that repairs its defects" : "Bake it to strike it", true);
  }

  /** Turns the mesh as the chosen axis says. */
  private turn({ shown }: ShownFile): void {
    shown.rotation.x = element<HTMLSelectElement>("mesh-up").value === "z" ? -Math.PI / 2 : 0;
  }

  /** Tells how large the mesh is, and where its defects are, in the chosen unit. */
  private describe(): void {
    const preview = this.file?.preview;
    if (preview) this.turn(preview);
    const unit = element<HTMLSelectElement>("mesh-unit").value;
    const extent = preview && new THREE.Box3().setFromObject(preview.shown).getSize(new THREE.Vector3());
    const lengths = extent?.toArray().map((value) => length((UNITS[unit] ?? 1) * value));
    element("mesh-size").textContent = lengths ? `Size: ${lengths.join(" × ")}` : "";
    // Of an object that is baked, the list is the report.
    if (preview && !this.app.object) listDefects(this.app, preview.defects, unit, preview.shown.quaternion);
    else if (!preview) element("defects").replaceChildren();
  }

  /** Reads a mesh file, and shows it with its defects. */
  private async open(chosen: File): Promise<void> {
    if (!ENDINGS.includes(endingOf(chosen.name))) {
      throw new Error(`${chosen.name} is no mesh file that is read here: the name of one ends with ${ENDING_LIST}`);
    }
    if (chosen.size > BYTES_MAX) throw new Error(`${chosen.name} is larger than 60 MB: bake it with shatterd bake instead`);
    const contents = await chosen.arrayBuffer();
    const read = await readMesh(chosen.name, contents).catch((error: unknown) => {
      throw new Error(`${chosen.name} cannot be read: ${error instanceof Error ? error.message : String(error)}`);
    });
    const preview = read && { shown: new THREE.Group().add(read.shown), textures: read.textures, defects: findDefects(read.mesh) };
    this.file = { name: chosen.name, contents, preview, openedOver: this.app.object, bakedAs: undefined };
    // The defaults of a bake: unit and axis of the file before do not say anything about this one.
    for (const [id, value] of [["mesh-unit", "m"], ["mesh-up", "y"]] as const) element<HTMLSelectElement>(id).value = value;
    const details = element<HTMLDetailsElement>("mesh");
    details.open = true;
    document.body.classList.remove("folded");
    element("progress-line").textContent = "";
    element("mesh-name").textContent = read
      ? `${chosen.name}, ${(read.mesh.indices.length / 3).toLocaleString("en-US")} triangles`
      : `${chosen.name}: shown after the bake`;
    if (preview) this.show();
    else {
      this.describe();
      this.follow();
      this.offer();
      this.hint(this.file);
    }
    details.scrollIntoView({ block: "nearest" });
  }

  /** Bakes the file, with progress, and shows the object. */
  private async bake(file: OwnFile): Promise<void> {
    const value = (id: string) => element<HTMLSelectElement>(id).value;
    const name = objectName(file.name);
    const head = { op: "bake", file: file.name, name, material: value("mesh-material"), unit: value("mesh-unit"), up: value("mesh-up") };
    const [progress, line] = [element<HTMLProgressElement>("progress"), element("progress-line")];
    progress.hidden = element("cancel").hidden = false;
    progress.removeAttribute("value");
    element<HTMLButtonElement>("bake").disabled = true;
    panel.hint(undefined);
    await this.app.guarded(async () => {
      try {
        const reply = await this.app.connection.sendFile(head, file.contents, (text) => (line.textContent = text.replace(/^[^:]*: /, "")));
        element("cancel").hidden = true;
        line.textContent = "Loading the object …";
        await this.showBaked(file, name, reply["report"] as BakeReport);
      } catch (error) {
        const isCanceled = error instanceof ServiceError && error.kind === "canceled";
        line.textContent = isCanceled ? "Canceled." : "";
        // Nothing is shown of a file that the page does not read: the message is all that is left of it.
        if (!isCanceled && !file.preview && this.file === file) this.file = undefined;
        if (!isCanceled) throw error;
      } finally {
        progress.hidden = element("cancel").hidden = true;
        element<HTMLButtonElement>("bake").disabled = false;
        this.follow();
        if (this.file && !this.app.object) this.hint(this.file);
      }
    });
  }

  /** Shows the object that was baked from the file, with the report. */
  private async showBaked(file: OwnFile, name: string, report: BakeReport): Promise<void> {
    panel.setReason(report.object, report.surface.reason);
    await untilServed(this.app, name);
    element("progress-line").textContent = "";
    if (this.file !== file) return;
    if (file.preview) this.app.keepTextures(name, file.preview.textures);
    file.bakedAs = name;
    const rows = reportRows(report);
    element("defects").replaceChildren(...rows.map((row) => textElement("li", row)));
    await this.loadObjects(name);
    element("progress-line").textContent = [`Baked in ${report.seconds.toFixed(1)} s.`, ...report.warnings.map(warningText)].join(" ");
    element<HTMLDetailsElement>("mesh").open = rows.length + report.warnings.length > 0;
  }
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

/** The name of the object: that of the file, with plain letters. */
function objectName(file: string): string {
  const stem = file.replace(/\.[^.]*$/, "").replace(/[^\w-]+/g, "-");
  return stem.slice(0, 60) || "mesh";
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
