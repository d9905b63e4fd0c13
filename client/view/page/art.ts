// Art direction: anchors, protected regions, sites and paint on the object; the scene as TOML.

import * as THREE from "three";
import type { Aim, App } from "./app";
import { chosen, element, onClick, save, textElement } from "./dom";
import { MATERIALS } from "./own_mesh";
import type { Vector } from "./result";

/** What a tool has placed. */
interface Mark {
  tool: "anchor" | "protect" | "site" | "paint";
  centerM: Vector;
  radiusM: number;
  shown: THREE.Object3D;
}

const COLORS = { anchor: "#2f9e6b", protect: "#3d6fd1", site: "#e0562d", paint: "#c0359a" };

/** Effects of an object without a scene. */
const USUAL = ["elastic", "interior", "examples", "slivers"];

/** Factors of the fragment density where nothing is painted, and where paint is full. */
const PAINT = { least: 0.5, most: 4 };

/** Art direction of the object that is shown. */
export class ArtDirection {
  private marks: Mark[] = [];

  constructor(private readonly app: App) {
    const select = element<HTMLSelectElement>("material");
    select.replaceChildren(new Option("the database's", ""), ...MATERIALS.map((name) => new Option(name)));
    onClick("undo", () => this.undo());
    onClick("save-scene", () => void this.save());
  }

  /** The tool that is chosen; `strike` while the section is closed. */
  tool(): Mark["tool"] | "strike" {
    return element<HTMLDetailsElement>("art").open ? (chosen("tool") as Mark["tool"] | "strike") : "strike";
  }

  /** Uses the tool at a place of the object. */
  place(aim: Aim, tool: Mark["tool"]): void {
    const { object } = this.app;
    if (!object) return;
    const radiusM = (Number(element<HTMLInputElement>("tool-radius").value) / 100) * object.diagonal_m;
    const at = aim.pick.shown.clone().sub(aim.pick.offset);
    const center = object.bounds_m[0].map((low, axis) => (low + object.bounds_m[1][axis]!) / 2);
    // A site belongs inside the object: a little below the surface.
    if (tool === "site") at.addScaledVector(new THREE.Vector3(...aim.ray.direction), 0.01 * object.diagonal_m);
    const centerM = at.toArray().map((x, axis) => Number((x + center[axis]!).toPrecision(5))) as Vector;
    const radius = tool === "site" ? 0.012 * object.diagonal_m : radiusM;
    const ball = new THREE.Mesh(
      new THREE.SphereGeometry(radius, 32, 20),
      new THREE.MeshLambertMaterial({ color: COLORS[tool], transparent: true, opacity: tool === "site" ? 1 : 0.38, depthWrite: tool === "site", depthTest: tool !== "site" }),
    );
    ball.position.copy(at);
    this.app.stage.marks.position.set(0, 0, 0);
    this.app.stage.marks.add(ball);
    this.marks.push({ tool, centerM, radiusM: Number(radiusM.toPrecision(4)), shown: ball });
    this.list();
  }

  /** Forgets everything: another object is shown. */
  clear(): void {
    this.marks = [];
    this.list();
  }

  private undo(): void {
    const last = this.marks.pop();
    if (last) this.app.stage.marks.remove(last.shown);
    this.list();
  }

  private list(): void {
    const rows = this.marks.map((mark) => {
      const radius = mark.tool === "site" ? "" : `, radius ${(1000 * mark.radiusM).toFixed(0)} mm`;
      return textElement("li", `${mark.tool} at ${mark.centerM.map((x) => (1000 * x).toFixed(0)).join(", ")} mm${radius}`);
    });
    element("art-list").replaceChildren(...rows);
    element<HTMLButtonElement>("undo").disabled = this.marks.length === 0;
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
    if (database) text += `database = ${JSON.stringify(database)}\n`;
    if (sizeMm > 0) text += `fragment_size_m = ${sizeMm / 1000}\n`;
    if (anchors) text += `anchors = [\n${anchors}]\n`;
    if (isWarped) text += `\n[objects.${quoted}.warp]\n`;
    if (protect) text += `protect = [\n${protect}]\n`;
    if (sites.length > 0) text += `sites = [${sites.map((mark) => list(mark.centerM)).join(", ")}]\n`;
    if (paint.length > 0) text += `paint = { file = "paint.ply", attribute = "red", least = ${PAINT.least.toFixed(1)}, most = ${PAINT.most.toFixed(1)} }\n`;
    return text;
  }

  /** Name of the database for a material that the present one was not baked with; `undefined` if it fits. */
  private otherDatabase(): string | undefined {
    const material = element<HTMLSelectElement>("material").value;
    const { object } = this.app;
    return object && material && material !== object.material ? `${object.name}-${material}` : undefined;
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
    const note = element("scene-note");
    const [scene, paint] = [this.scene(), this.paint()];
    try {
      const reply = await this.app.connection.ask({ op: "check_scene", scene, ...(paint ? { paint } : {}) });
      if (reply["accepted"] !== true) {
        const document = reply["document"] as { error?: { message?: string } } | null;
        note.textContent = `shatterd check refuses it: ${document?.error?.message ?? "unknown reason"}`;
        return;
      }
      save("scene.toml", scene, "application/toml");
      if (paint) save("paint.ply", paint, "application/octet-stream");
      const database = this.otherDatabase();
      const bake = database
        ? ` Bake its database first: shatterd bake MESH --name ${database} --material ${element<HTMLSelectElement>("material").value}.`
        : "";
      note.textContent = `Accepted by shatterd check.${bake} Serve it: shatterd serve --scene scene.toml${paint ? " (keep paint.ply beside it)" : ""}`;
    } catch (error) {
      note.textContent = error instanceof Error ? error.message : String(error);
    }
  }
}
