// Art direction: anchors, protected regions, sites and paint on the object; the scene as TOML.

import * as THREE from "three";
import type { App } from "./app";
import { chosen, element, onClick, onInput, save, textElement } from "./dom";
import { millimeters, place } from "./format";
import type { Aim, ObjectFacts } from "./object_facts";
import { MATERIALS } from "./own_mesh";
import * as panel from "./panel";
import type { Vector } from "./result";
import { type DatabaseFolder, type OtherDatabase, sceneCommands } from "./scene_commands";

/** What a tool has placed. */
interface Mark {
  tool: "anchor" | "protect" | "site" | "paint";
  centerM: Vector;
  radiusM: number;
  shown: THREE.Object3D;
  /** Place in the object at rest, relative to its center, and by how much it moves with its piece. */
  rest: THREE.Vector3;
  carried: THREE.Vector3;
}

/** What is directed of one object. */
interface Direction {
  marks: Mark[];
  material: string;
  size: string;
  /** The bounds of the object, as text: marks of another mesh of its name do not fit. */
  bounds: string;
}

/** What each tool is for. */
const PURPOSE = {
  strike: "A click strikes the object. Choose another tool to mark places.",
  anchor: "Holds what is in the ball: a foot, a bolt in a wall.",
  protect: "No crack enters the ball: a face, a logo.",
  site: "One piece forms around the point.",
  paint: "More and smaller pieces in the balls, fewer elsewhere. Each click adds a ball.",
};

/** What a click does with each tool. */
const HINTS = { anchor: "Click to anchor a place", protect: "Click to protect a place", site: "Click to place a piece", paint: "Click to paint" };

const COLORS = { anchor: "#2f9e6b", protect: "#3d6fd1", site: "#e0562d", paint: "#c0359a" };

/** Radius of the mark of a site, as a share of the diagonal of the object. */
const SITE_SHARE = 0.012;

/** Depth of a site below the surface, as a share of the diagonal of the object. */
const SITE_DEPTH_SHARE = 0.01;

/** Effects of an object without a scene. */
const USUAL = ["elastic", "interior", "examples", "slivers"];

/** Factors of the fragment density where nothing is painted, and where paint is full. */
const PAINT = { least: 0.5, most: 4 };

/** Art direction of the object that is shown. */
export class ArtDirection {
  private marks: Mark[] = [];
  /** What was directed of the objects that were shown before, by their names. */
  private readonly kept = new Map<string, Direction>();
  private object: ObjectFacts | undefined;

  constructor(private readonly app: App) {
    const select = element<HTMLSelectElement>("material");
    select.replaceChildren(new Option("as baked", ""), ...MATERIALS.map((name) => new Option(name)));
    for (const tool of document.querySelectorAll<HTMLInputElement>("#tools input")) {
      const label = tool.nextElementSibling as HTMLElement;
      if (tool.value !== "strike") label.style.borderBottomColor = COLORS[tool.value as Mark["tool"]];
    }
    onInput("tools", () => {
      this.showTool();
      panel.hint(this.hint());
    });
    onInput("tool-radius", () => this.showTool());
    element("art").addEventListener("toggle", () => this.showTool());
    onInput("size", () => this.showSize());
    onClick("undo", () => this.remove(this.marks.at(-1)));
    onClick("save-scene", () => void this.save());
    onClick("copy-commands", () => void this.copy());
  }

  /** Follows the object that is shown: keeps what was directed of the one before, and shows what was directed of this one. */
  follow(): void {
    const { object } = this.app;
    if (object === this.object) {
      this.hold();
      return;
    }
    const [material, size] = [element<HTMLSelectElement>("material"), element<HTMLInputElement>("size")];
    const bounds = (of: ObjectFacts) => JSON.stringify(of.bounds_m);
    if (this.object) {
      this.kept.set(this.object.name, { marks: this.marks, material: material.value, size: size.value, bounds: bounds(this.object) });
    }
    this.object = object;
    const known = object && this.kept.get(object.name);
    this.marks = known && known.bounds === bounds(object) ? known.marks : [];
    [material.value, size.value] = [known?.material ?? "", known?.size ?? ""];
    for (const { shown } of this.marks) this.app.stage.marks.add(shown);
    this.hold();
    this.list();
    this.showTool();
    this.showSize();
    this.tell("");
    const hint = this.hint();
    if (object && hint) panel.hint(hint);
  }

  private hint(): string | undefined {
    const tool = this.tool();
    return tool === "strike" ? undefined : HINTS[tool];
  }

  /** The tool that is chosen; `strike` while the section is closed. */
  tool(): Mark["tool"] | "strike" {
    return element<HTMLDetailsElement>("art").open ? (chosen("tool") as Mark["tool"] | "strike") : "strike";
  }

  /** Radius of what the tool places, m; `undefined` of the tool that strikes. */
  toolRadiusM(): number | undefined {
    const [tool, diagonal] = [this.tool(), this.app.object?.diagonal_m ?? 0];
    if (tool === "strike") return undefined;
    return tool === "site" ? SITE_SHARE * diagonal : (Number(element<HTMLInputElement>("tool-radius").value) / 100) * diagonal;
  }

  /** Tells what the chosen tool is for, and its radius. */
  showTool(): void {
    const [tool, radius] = [this.tool(), this.toolRadiusM()];
    element("tool-note").textContent = PURPOSE[tool];
    element("tool-radius-row").hidden = tool === "strike" || tool === "site";
    element("tool-radius-value").textContent = radius === undefined ? "" : millimeters(radius);
  }

  /** Tells what is wrong with the fragment size, beside its field; returns whether it can be used. */
  private showSize(): boolean {
    const size = element<HTMLInputElement>("size");
    const isUsable = !size.validity.badInput && (size.value === "" || Number(size.value) > 0);
    size.setAttribute("aria-invalid", String(!isUsable));
    const given = size.value === "" ? "The fragment size" : `A fragment size of ${size.value} mm`;
    element("size-note").textContent = isUsable ? "" : `${given} is no length above 0. Correct it, or leave it empty for the object's own.`;
    return isUsable;
  }

  /** Finds the pieces that hold the marks: others are shown. */
  private hold(): void {
    for (const mark of this.marks) mark.carried = this.app.carriedBy(mark.rest);
  }

  /** Moves the marks with their pieces. */
  move(share: number): void {
    for (const { shown, rest, carried } of this.marks) shown.position.copy(rest).addScaledVector(carried, share);
  }

  /** Uses the tool at a place of the object. */
  place(aim: Aim, tool: Mark["tool"]): void {
    const { object } = this.app;
    if (!object) return;
    const radiusM = this.toolRadiusM() ?? 0;
    const at = aim.pick.shown.clone().sub(aim.pick.offset);
    const center = object.bounds_m[0].map((low, axis) => (low + object.bounds_m[1][axis]!) / 2);
    if (tool === "site") at.addScaledVector(new THREE.Vector3(...aim.ray.direction), SITE_DEPTH_SHARE * object.diagonal_m);
    const centerM = at.toArray().map((x, axis) => Number((x + center[axis]!).toPrecision(5))) as Vector;
    const ball = new THREE.Mesh(
      new THREE.SphereGeometry(radiusM, 32, 20),
      new THREE.MeshLambertMaterial({ color: COLORS[tool], transparent: true, opacity: tool === "site" ? 1 : 0.38, depthWrite: tool === "site", depthTest: tool !== "site" }),
    );
    ball.position.copy(at).add(aim.pick.offset);
    this.app.stage.marks.add(ball);
    this.marks.push({ tool, centerM, radiusM: Number(radiusM.toPrecision(4)), shown: ball, rest: at, carried: this.app.carriedBy(at) });
    this.list();
    element("undo").scrollIntoView({ block: "nearest" });
  }

  /** Where a site is placed that the user points at, m: a little below the surface. */
  siteOf(aim: Aim, object: ObjectFacts): Vector {
    const place = new THREE.Vector3(...this.app.placeOf(aim));
    return place.addScaledVector(new THREE.Vector3(...aim.ray.direction), SITE_DEPTH_SHARE * object.diagonal_m).toArray();
  }

  /** Removes a mark. */
  private remove(mark: Mark | undefined): void {
    if (!mark) return;
    this.marks = this.marks.filter((own) => own !== mark);
    this.app.stage.marks.remove(mark.shown);
    this.list();
  }

  private list(): void {
    const diagonalM = this.app.object?.diagonal_m ?? 1;
    const rows = this.marks.map((mark) => {
      const radius = mark.tool === "site" ? "" : `, radius ${millimeters(mark.radiusM)}`;
      const text = `${mark.tool} at ${place(mark.centerM, diagonalM)} mm${radius}`;
      const button = textElement("button", "×");
      button.setAttribute("aria-label", `Remove ${text}`);
      button.addEventListener("click", () => this.remove(mark));
      const row = document.createElement("li");
      row.append(swatch(COLORS[mark.tool]), textElement("span", text), button);
      return row;
    });
    element("art-list").replaceChildren(...rows);
    element<HTMLButtonElement>("undo").disabled = rows.length === 0;
    this.app.stage.changed();
  }

  private of(tool: Mark["tool"]): Mark[] {
    return this.marks.filter((mark) => mark.tool === tool);
  }

  /** The scene as TOML. */
  scene(): string {
    const name = this.app.object?.name ?? "object";
    const quoted = JSON.stringify(name);
    const list = (vector: Vector) => `[${vector.map((x) => (Number.isInteger(x) ? x.toFixed(1) : String(x))).join(", ")}]`;
    const balls = (tool: Mark["tool"]) =>
      this.of(tool).map((mark) => `    { center = ${list(mark.centerM)}, radius_m = ${mark.radiusM} },\n`).join("");
    const [anchors, protect, sites, paint] = [balls("anchor"), balls("protect"), this.of("site"), this.of("paint")];
    const isWarped = protect !== "" || sites.length > 0 || paint.length > 0;
    const effects = [...USUAL, ...(isWarped ? ["warp"] : []), ...(anchors ? ["anchored"] : [])];
    const material = element<HTMLSelectElement>("material").value;
    const sizeMm = Number(element<HTMLInputElement>("size").value);
    let text = `title = ${JSON.stringify(`Art direction of ${name}`)}\n\n[objects.${quoted}]\n`;
    text += `effects = ${JSON.stringify(effects)}\nallow = ["normals", "uv", "bonds", "hulls", "attributes", "skin", "release", "debris"]\n`;
    if (material) text += `material = ${JSON.stringify(material)}\n`;
    const database = this.otherDatabase();
    if (database) text += `database = ${JSON.stringify(database.name)}\n`;
    if (sizeMm > 0) text += `fragment_size_m = ${sizeMm / 1000}\n`;
    if (anchors) text += `anchors = [\n${anchors}]\n`;
    if (isWarped) text += `\n[objects.${quoted}.warp]\n`;
    if (protect) text += `protect = [\n${protect}]\n`;
    if (sites.length > 0) text += `sites = [${sites.map((mark) => list(mark.centerM)).join(", ")}]\n`;
    if (paint.length > 0) text += `paint = { file = "paint.ply", attribute = "red", least = ${PAINT.least.toFixed(1)}, most = ${PAINT.most.toFixed(1)} }\n`;
    return text;
  }

  /** The database for a material that the present one was not baked with; `undefined` if it fits. */
  private otherDatabase(): OtherDatabase | undefined {
    const material = element<HTMLSelectElement>("material").value;
    const { object } = this.app;
    return object && material && material !== object.material ? { name: `${object.name}-${material}`, material } : undefined;
  }

  /** The painted vertices as a PLY file: red is 255 at the middle of a stroke, and 0 beyond its radius. */
  paint(): string | undefined {
    const strokes = this.of("paint");
    const whole = this.app.history.intact;
    if (strokes.length === 0 || !whole) return undefined;
    const rows: string[] = [];
    const positions = whole.floats("positions");
    for (const fragment of whole.fragments) {
      for (let at = 3 * fragment.vertexFirst; at < 3 * (fragment.vertexFirst + fragment.vertexCount); at += 3) {
        const point = [0, 1, 2].map((axis) => positions[at + axis]! + fragment.centerM[axis]!);
        const share = Math.max(
          ...strokes.map((stroke) => {
            const distance = Math.hypot(...point.map((x, axis) => x - stroke.centerM[axis]!));
            return Math.max(0, 1 - distance / stroke.radiusM);
          }),
        );
        rows.push(`${point.map((x) => x.toPrecision(6)).join(" ")} ${Math.round(255 * Math.min(1, 2 * share))}`);
      }
    }
    const properties = [..."xyz"].map((axis) => `property float ${axis}\n`).join("");
    return `ply\nformat ascii 1.0\nelement vertex ${rows.length}\n${properties}property uchar red\nend_header\n${rows.join("\n")}\n`;
  }

  /** Saves the scene, after `shatterd check` has accepted it. */
  private async save(): Promise<void> {
    if (!this.showSize()) {
      this.tell("Not saved: correct the fragment size.");
      return;
    }
    const [scene, paint] = [this.scene(), this.paint()];
    const object = this.app.object?.name ?? "object";
    try {
      const reply = await this.app.connection.ask({ op: "check_scene", object, scene, ...(paint ? { paint } : {}) });
      if (reply["accepted"] !== true) {
        const document = reply["document"] as { error?: { message?: string } } | null;
        this.tell(`shatterd check refuses it: ${document?.error?.message ?? "unknown reason"}`);
        return;
      }
      save("scene.toml", scene, "application/toml");
      if (paint) save("paint.ply", paint, "application/octet-stream");
      const given = reply["databases"] as { path: string; is_temporary: boolean } | null;
      const folder: DatabaseFolder = { path: given?.path, isTemporary: given?.is_temporary ?? false };
      const marks = this.marks.length > 0 ? "" : ", without marks";
      const saved = paint ? "scene.toml and paint.ply; keep them in one folder" : `scene.toml${marks}`;
      this.tell(`Accepted by shatterd check, and saved as ${saved}. To serve it, run there:`, sceneCommands(object, folder, this.otherDatabase()));
    } catch (error) {
      this.tell(error instanceof Error ? error.message : String(error));
    }
  }

  /** Shows what came of the scene, and commands if there are some. */
  private tell(text: string, commands = ""): void {
    element("scene-note").textContent = text;
    element("scene-commands").textContent = commands;
    element("scene-serve").hidden = commands === "";
    if (text) element(commands ? "scene-serve" : "scene-note").scrollIntoView({ block: "nearest" });
  }

  private async copy(): Promise<void> {
    await this.app.guarded(async () => {
      await navigator.clipboard.writeText(element("scene-commands").textContent ?? "");
      panel.hint("Copied the commands");
    });
  }
}

/** A sample of the color of a tool's marks. */
function swatch(color: string): HTMLElement {
  const made = document.createElement("i");
  made.className = "swatch";
  made.style.background = color;
  return made;
}
