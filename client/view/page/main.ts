// Wires the page: pointer, keys, panel.

import { App } from "./app";
import { Connection } from "./connection";
import { choose, chosen, element, onClick, onInput, save } from "./dom";
import { millimeters, place } from "./format";
import { ArtDirection } from "./art";
import { bindCompare } from "./compare";
import { bindKeys } from "./keys";
import type { Aim, ObjectFacts } from "./object_facts";
import { OwnMesh } from "./own_mesh";
import * as panel from "./panel";
import { recordingOf, replay } from "./replay";
import * as strength from "./strength";
import { codeOf, impactOf, TEXTURE_EFFECT, type Language, type Settings } from "./impact_request";

/** Farthest that a pointer moves in a click, pixels. */
const CLICK_PX = 6;

/** Time for which the pointer rests before the threshold is asked for, ms. */
const REST_MS = 140;

const canvas = element<HTMLCanvasElement>("canvas");
const connection = new Connection();
const app = new App(canvas, connection);
const art = new ArtDirection(app);
/** What is replayed, without a service. */
const recording = recordingOf(document);
const ownMesh = recording ? undefined : new OwnMesh(app, (name) => loadObjects(name, true));
let objects: ObjectFacts[] = [];

/** Settings of the panel. */
export function settings(): Settings {
  const text = (id: string) => element<HTMLSelectElement>(id).value;
  return { quality: text("quality"), lift: text("lift"), seed: Math.max(0, Math.floor(Number(text("seed")) || 0)) };
}

function showStrength(): void {
  strength.show(app.aim?.thresholdNs);
}

/** Asks for the threshold where the pointer rests. */
async function showThreshold(aim: Aim): Promise<void> {
  try {
    await app.threshold(aim, settings());
  } catch {
    // The request itself reports the error.
    return;
  }
  if (app.aim === aim) {
    showStrength();
    showTooltip(aim);
    placeTooltip(aim.x, aim.y);
  }
}

function showTooltip(aim: Aim | undefined): void {
  const box = element("tooltip");
  box.hidden = aim === undefined;
  if (!aim || !app.object) return;
  const [tool, radiusM] = [art.tool(), art.toolRadiusM()];
  const point = place(tool === "site" ? art.siteOf(aim, app.object) : app.placeOf(aim), app.object.diagonal_m);
  const breaks = aim.thresholdNs === undefined ? "" : ` · breaks at ${strength.quantity(aim.thresholdNs)}`;
  const radius = millimeters(radiusM ?? app.object.radius_m);
  if (tool === "strike") box.textContent = `${point} mm · radius ${radius}${breaks}`;
  else box.textContent = `${point} mm · ${tool}${tool === "site" ? "" : `, radius ${radius}`}`;
}

/** Places the tooltip beside the pointer, inside the picture. */
function placeTooltip(x: number, y: number): void {
  const [box, { right, bottom }] = [element("tooltip"), canvas.getBoundingClientRect()];
  const left = Math.max(4, Math.min(x + 16, right - box.offsetWidth - 4));
  const top = y + 14 + box.offsetHeight > bottom ? y - 14 - box.offsetHeight : y + 14;
  Object.assign(box.style, { left: `${left}px`, top: `${top}px` });
}

/** Shows what the pointer is at. Returns it. */
function pointAt(x: number, y: number): Aim | undefined {
  const aim = app.pick(x, y);
  app.point(aim, art.toolRadiusM());
  if (!aim) showStrength();
  showTooltip(aim);
  placeTooltip(x, y);
  return aim;
}

function bindPointer(): void {
  let [down, rest] = [undefined as { x: number; y: number } | undefined, undefined as number | undefined];
  const isClick = (event: PointerEvent) => down && Math.hypot(event.clientX - down.x, event.clientY - down.y) < CLICK_PX;
  canvas.addEventListener("pointerdown", (event) => (down = event.isPrimary ? { x: event.clientX, y: event.clientY } : undefined));
  canvas.addEventListener("pointermove", (event) => {
    clearTimeout(rest);
    if (recording || event.buttons !== 0 || event.pointerType === "touch") return;
    const aim = pointAt(event.clientX, event.clientY);
    if (aim && art.tool() === "strike") rest = window.setTimeout(() => void showThreshold(aim), REST_MS);
  });
  // The camera has moved: another place is below the pointer.
  canvas.addEventListener("wheel", (event) => {
    clearTimeout(rest);
    if (!recording) pointAt(event.clientX, event.clientY);
  });
  canvas.addEventListener("pointerleave", () => {
    clearTimeout(rest);
    app.point(undefined);
    showStrength();
    showTooltip(undefined);
  });
  canvas.addEventListener("pointerup", (event) => {
    if (isClick(event) && event.button === 0) void strikeAt(event.clientX, event.clientY);
    down = undefined;
  });
}

/** Strikes what a point of the page shows; with a tool of art direction, uses that instead. */
async function strikeAt(x: number, y: number): Promise<void> {
  const aim = app.pick(x, y);
  if (!aim) return;
  if (recording) {
    panel.hint("A recording: nothing can be struck here. The button → shows the next result");
    return;
  }
  const tool = art.tool();
  if (tool !== "strike") {
    art.place(aim, tool);
    return;
  }
  showTooltip(undefined);
  await app.strikeAt(aim, settings());
  showStrength();
}

function bindStrike(): void {
  const again = () => {
    showStrength();
    void app.again(settings).then(showStrength);
  };
  onInput("impulse", again);
  for (const id of ["impulse", "quality", "lift", "seed"]) element(id).addEventListener("change", () => app.settle());
  for (const id of ["by", "ball"]) onInput(id, showStrength);
  for (const id of ["quality", "lift", "seed"]) {
    onInput(id, () => {
      app.forgetThresholds();
      again();
    });
  }
  onClick("reseed", () => {
    element<HTMLInputElement>("seed").value = String(Math.floor(Math.random() * 1e6));
    again();
    app.settle();
  });
}

/** What the controls of the section do. */
const REPEATS = "The slider, preset, lift and seed repeat the last request at once.";

function bindView(): void {
  const holdCompared = bindCompare(app);
  onInput("explode", () => app.setExplode(2 * (Number(element<HTMLInputElement>("explode").value) / 100) ** 2));
  for (const id of ["colors", "xray", "hulls", "cracks"]) onInput(id, () => app.recolor());
  onClick("back", () => app.go(-1));
  onClick("forward", () => app.go(1));
  onClick("reset", () => app.go(-Infinity));
  onClick("help", () => element<HTMLDialogElement>("keys").showModal());
  onClick("fold", fold);
  element("message").querySelector("button")!.addEventListener("click", () => panel.message(undefined));
  app.onMove = (share) => art.move(share);
  app.onState = () => {
    art.follow();
    ownMesh?.follow();
    holdCompared();
    element<HTMLButtonElement>("back").disabled = element<HTMLButtonElement>("reset").disabled = !app.history.canGoBack;
    element<HTMLButtonElement>("forward").disabled = !app.history.canGoForward;
    document.body.classList.toggle("preview", !app.object);
    showTooltip(undefined);
    element("repeats").textContent = app.canRepeat ? REPEATS : `Strike the object first. ${REPEATS}`;
    showStrength();
  };
}

function fold(): void {
  const isFolded = document.body.classList.toggle("folded");
  element("fold").textContent = isFolded ? "‹" : "›";
  element("fold").setAttribute("aria-expanded", String(!isFolded));
}

function bindAway(): void {
  for (const button of document.querySelectorAll<HTMLButtonElement>("[data-format]")) {
    button.addEventListener("click", () => void download(button.dataset["format"]!));
  }
  for (const button of document.querySelectorAll<HTMLButtonElement>("[data-language]")) {
    button.addEventListener("click", () => void copy(button));
  }
}

/** Lets the browser save all pieces that are shown. */
async function download(format: string): Promise<void> {
  await app.guarded(async () => {
    // The attributes of the mesh file are its texture coordinates.
    const file = await app.shownAs(format, format === "mjcf" ? ["hulls", "bonds"] : ["normals", TEXTURE_EFFECT]);
    save(file.head.name ?? "broken", file.raw("file"), format === "glb" ? "model/gltf-binary" : "application/zip");
    element("away-note").textContent =
      format === "mjcf" ? "The model welds touching pieces of one result: it stays whole until the simulation switches the welds (bond_…) off." : "";
  });
}

async function copy(button: HTMLButtonElement): Promise<void> {
  const last = app.history.now?.last;
  if (!last) return;
  const code = codeOf(last.request, button.dataset["language"] as Language, app.effectsOf(last.request.object), app.service);
  const name = button.dataset["name"] ??= button.textContent ?? "";
  // The row keeps its widths: the sign is wider than a letter.
  button.style.width = `${button.getBoundingClientRect().width}px`;
  try {
    await navigator.clipboard.writeText(code);
    panel.hint(`Copied the code for ${name}`);
  } catch {
    save(`request.${{ shell: "sh", rust: "rs", python: "py", c: "c" }[button.dataset["language"] as Language]}`, code, "text/plain");
    panel.hint(`Saved the code for ${name}`);
  }
  const show = (text: string, isCopied: boolean) => {
    button.textContent = text;
    button.classList.toggle("copied", isCopied);
  };
  show("✓", true);
  setTimeout(() => show(name, false), 1500);
}

/** Time after which objects that are being loaded are listed again, ms. */
const RELIST_MS = 1000;

/** Lists the objects of the service, and chooses the one that is shown. */
async function listObjects(): Promise<void> {
  const reply = await connection.ask({ op: "objects" });
  objects = reply["objects"] as ObjectFacts[];
  app.service = String(reply["service"]);
  const options = objects.map((object) => {
    const option = new Option(object.state === "ready" ? object.name : `${object.name} (${object.state})`, object.name);
    option.disabled = object.state !== "ready";
    option.title = object.error ?? "";
    return option;
  });
  const select = element<HTMLSelectElement>("object");
  select.replaceChildren(...options);
  if (app.object) select.value = app.object.name;
  ownMesh?.offer();
  if (objects.some((object) => object.state === "loading")) setTimeout(() => void relist(), RELIST_MS);
}

/** Lists the objects again, unless a mesh of the user is shown, which the list would lose. */
async function relist(): Promise<void> {
  // A service that went away is reported elsewhere.
  if (app.object) await listObjects().catch(() => undefined);
}

/** The object that the page shows first if none is asked for: the one that `shatter view` bakes by itself. */
const SAMPLE = "mug";

/** Lists the objects of the service and shows one of them; `keepsView`: from where the user looks. */
export async function loadObjects(wanted?: string, keepsView = false): Promise<void> {
  await listObjects();
  const ready = objects.filter((object) => object.state === "ready");
  const named = (name: string | undefined) => ready.find((object) => object.name === name);
  const first = named(wanted) ?? named(SAMPLE) ?? ready[0];
  if (!first) {
    const loading = objects.find((object) => object.state === "loading");
    if (!loading) throw new Error(objects[0]?.error ?? "The service has no objects. Open a mesh, or drop one here.");
    await new Promise((resolve) => setTimeout(resolve, 200));
    return loadObjects(wanted, keepsView);
  }
  await app.show(first, keepsView);
  const select = element<HTMLSelectElement>("object");
  select.value = select.title = first.name;
  showStrength();
}

/** Shows what the list of objects says: an object of the service, or the mesh that is not baked yet. */
async function chooseObject(): Promise<void> {
  const { value } = element<HTMLSelectElement>("object");
  if (value === "") ownMesh?.show();
  else await loadObjects(value);
}

function start(): void {
  // For tests and scripts.
  Object.assign(globalThis, { shatterView: { app, connection, settings, art, impactOf, codeOf, objects: () => objects } });
  strength.begin();
  bindPointer();
  bindStrike();
  bindView();
  bindAway();
  bindKeys(app, {
    strikeCenter: () => {
      const box = canvas.getBoundingClientRect();
      void strikeAt(box.left + box.width / 2, box.top + box.height / 2);
    },
    fold,
    strengthen: (by) => {
      strength.setFactor(strength.factor() * by);
      element("impulse").dispatchEvent(new Event("input"));
    },
    nextColor: () => {
      const names = ["surface", "pieces", "energy", "bonds"];
      choose("color", names[(names.indexOf(chosen("color")) + 1) % names.length]!);
      app.recolor();
    },
  });
  if (recording) {
    void app.guarded(() => replay(app, recording));
    return;
  }
  onInput("object", () => void app.guarded(chooseObject));
  connection.onState = (isOpen) => {
    // What a hint advises needs the service.
    if (!isOpen) panel.hint(undefined);
    panel.message(isOpen ? undefined : "shatter view does not run any more. Start it again, and open the address that it prints.");
  };
  void app.guarded(() => loadObjects());
}

start();
