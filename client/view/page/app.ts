// The page: states of the object, requests, and what is shown of them.

import * as THREE from "three";
import { type Connection, ServiceError } from "./connection";
import { paintLayers, type Scale } from "./colors";
import { element } from "./dom";
import { type Answer, countShown, History, type Layer, layersAfter, multipleOf, type State } from "./history";
import { type ColorMode, lookOf, type PieceLook } from "./material";
import * as panel from "./panel";
import { Pieces } from "./pieces";
import type { ResultMessage, Vector } from "./result";
import { Stage } from "./stage";
import * as strength from "./strength";
import { EFFECTS, impactOf, TEXTURE_EFFECT, type ImpactRequest, type Settings } from "./impact_request";
import type { Aim, ObjectFacts } from "./object_facts";

/** Explode factor after the first request: wide enough to see between the pieces. */
export const EXPLODE_FIRST = 0.22;

/** Time in which pieces move apart, ms. */
const APART_MS = 480;

/** The page. */
export class App {
  readonly history = new History();
  readonly stage: Stage;
  object: ObjectFacts | undefined;
  /** What the pointer is at; away from the object: what was struck last. */
  aim: Aim | undefined;
  /** Name of the service. */
  service: string | undefined;
  private look: PieceLook | undefined;
  private center: Vector = [0, 0, 0];
  /** Effects that the service does not allow, each after its object and a slash. */
  private readonly refused = new Set<string>();
  private handles = new WeakMap<ImpactRequest, string>();
  private readonly hulls = new WeakMap<ImpactRequest, ResultMessage>();
  /** Whether a repetition is under way, whether another one follows, and whether that is the last one of a step. */
  private live = { isBusy: false, wants: false, isLast: false };
  private marked: Pieces | undefined;
  /** Called after pieces were moved apart by a share. */
  onMove: (share: number) => void = () => undefined;
  /** Called after the shown state has changed. */
  onState: () => void = () => undefined;

  constructor(
    canvas: HTMLCanvasElement,
    readonly connection: Connection,
  ) {
    this.stage = new Stage(canvas, (isLost) => {
      if (isLost) panel.message("The browser lost the graphics context; it comes back by itself.");
      else panel.message(undefined);
    });
  }

  /** Shows a mesh that is not an object of the service yet. */
  preview(shown: THREE.Object3D, keepsView = false): void {
    this.leaveFor(undefined);
    this.stage.group.clear();
    this.stage.group.add(shown);
    this.stage.framePart(shown, keepsView);
    this.point(undefined);
    this.onState();
  }

  /** Forgets the results of the shown object: another one, or a mesh, takes its place. */
  private leaveFor(object: ObjectFacts | undefined): void {
    const old = this.history.pieces();
    if (this.object && this.history.count > 1) this.forgotten.add(this.object.name);
    this.history.clear();
    this.dispose(old);
    this.object = object;
    this.forgetStruck();
  }

  /** Keeps the textures of a mesh for the object that was baked from it. */
  keepTextures(object: string, textures: THREE.DataArrayTexture | undefined): void {
    this.textures.get(object)?.dispose();
    if (textures) this.textures.set(object, textures);
    else this.textures.delete(object);
  }

  /** Base colors by material, of the objects that have some. */
  private readonly textures = new Map<string, THREE.DataArrayTexture>();

  /** Shows an object of the service, whole. */
  async show(object: ObjectFacts, keepsView = false): Promise<void> {
    const result = await this.withEffects(object.name, (effects) =>
      this.connection.askResult({ op: "intact", object: object.name, enable: effects }),
    );
    this.showIntact(object, result, keepsView);
  }

  /** Shows an object of which the result is known; `keepsView`: from where the user looks. */
  showIntact(object: ObjectFacts, result: ResultMessage, keepsView = false): void {
    this.leaveFor(object);
    const [low, high] = object.bounds_m.map((corner) => new THREE.Vector3(...corner)) as [THREE.Vector3, THREE.Vector3];
    const center = low.clone().add(high).multiplyScalar(0.5);
    this.center = center.toArray();
    const look = lookOf(object, low.y - center.y, Math.max(high.y - low.y, 1e-9), low.distanceTo(high), this.stage.light);
    this.look = look;
    const textures = this.textures.get(object.name);
    [look.uniforms.uTextures.value, look.uniforms.uHasTextures.value] = [textures ?? null, textures ? 1 : 0];
    this.stage.clearMarks();
    this.setExplode(0);
    this.stage.frame(low.sub(center), high.sub(center), keepsView);
    panel.hint(`${this.forgotten.delete(object.name) ? "Its earlier results were not kept. " : ""}Click to break it`, true);
    this.history.push({ layers: [this.layer(result, undefined)], last: undefined });
    this.refresh();
    element("panel").scrollTop = 0;
  }

  /** The layer of a result. */
  layer(result: ResultMessage, request: ImpactRequest | undefined): Layer {
    if (!this.look) throw new Error("no object is shown");
    return { pieces: new Pieces(result, this.center, this.look), request, replaced: new Set() };
  }

  /** What a point of the page shows: the first piece there. */
  pick(x: number, y: number): Aim | undefined {
    const ray = this.stage.ray(x, y);
    let best: Aim | undefined;
    for (const layer of this.history.now?.layers ?? []) {
      const pick = layer.pieces.pick(ray);
      if (pick && (!best || pick.distance < best.pick.distance)) {
        const origin = ray.origin.clone().sub(pick.offset).add(new THREE.Vector3(...this.center));
        best = { layer, pick, ray: { originM: origin.toArray(), direction: ray.direction.toArray() }, x, y };
      }
    }
    return best;
  }

  /** Points at a place of the object, or away from it. */
  point(aim: Aim | undefined, radiusM = this.object?.radius_m ?? 0.01): void {
    this.aim = aim ?? this.struck?.aim;
    this.stage.showContact(aim && { point: aim.pick.shown, normal: aim.pick.normal, radiusM });
    if (this.marked && this.marked !== aim?.layer.pieces) this.marked.mark(undefined);
    const isMany = (this.history.now?.layers.length ?? 0) > 1 || (aim?.layer.pieces.result.fragments.length ?? 0) > 1;
    if (aim) aim.layer.pieces.mark(isMany ? aim.pick.fragment : undefined);
    this.marked = aim?.layer.pieces;
  }

  /** Where the user points at, in the coordinates of the object, m. */
  placeOf({ pick }: Aim): Vector {
    const place = pick.shown.clone().sub(pick.offset).add(new THREE.Vector3(...this.center));
    return place.toArray();
  }

  /** Strikes what the user points at. */
  async strikeAt(aim: Aim, settings: Settings): Promise<void> {
    const before = this.history.now?.layers;
    if (!before || !this.object) return;
    this.aim = aim;
    this.settle();
    const ask = async () => {
      const thresholdNs = await this.threshold(aim, settings);
      const request = this.requestOf(aim, thresholdNs, settings);
      await this.send(request, aim, before, false);
    };
    await this.guarded(() => this.stage.hold(ask));
  }

  /** Repeats the last request with the present settings. Only one request is under way; the latest settings win. */
  async again(settings: () => Settings): Promise<void> {
    if (!this.struck) return;
    if (this.live.isBusy) {
      [this.live.wants, this.live.isLast] = [true, false];
      return;
    }
    this.live = { ...this.live, isBusy: true, wants: false };
    const { aim, before } = this.struck;
    const ask = async () => {
      const thresholdNs = await this.threshold(aim, settings());
      await this.send(this.requestOf(aim, thresholdNs, settings()), aim, before, true);
    };
    await this.guarded(() => this.stage.hold(ask));
    this.live.isBusy = false;
    if (this.live.wants) await this.again(settings);
    else if (this.live.isLast) this.settle();
  }

  /** The control that repeats the request was let go: the shown state stays as a step, and the next change adds another. */
  settle(): void {
    this.live.isLast = this.live.isBusy;
    if (!this.live.isBusy) this.step = undefined;
  }

  /** What was struck last, and the layers before it. */
  private struck: { aim: Aim; before: Layer[] } | undefined;
  /** The state that further repetitions of the request replace. */
  private step: State | undefined;
  /** Name of that step in a recording, which keeps its last result alone. */
  private stepName = "";
  /** Objects whose results were forgotten when another object was shown. */
  private readonly forgotten = new Set<string>();

  /** Other settings have other thresholds. */
  forgetThresholds(): void {
    for (const aim of [this.aim, this.struck?.aim]) if (aim) delete aim.thresholdNs;
  }

  /** Whether a change of slider, preset, lift or seed repeats a request. */
  get canRepeat(): boolean {
    return this.struck !== undefined;
  }

  private forgetStruck(): void {
    this.aim = this.struck = this.step = undefined;
  }

  private requestOf(aim: Aim, thresholdNs: number, settings: Settings): ImpactRequest {
    const { request } = aim.layer;
    // Four digits: enough for anyone, and short in the copied code.
    const impulseNs = Number((thresholdNs * strength.factor()).toPrecision(4));
    return {
      object: this.object?.name ?? "",
      ray: aim.ray,
      impulseNs,
      settings,
      ...(request ? { parent: { request, fragment: aim.pick.fragment } } : {}),
    };
  }

  /** Sends a request and shows its result: as a new state, or in place of the step that the slider changes. */
  private async send(request: ImpactRequest, aim: Aim, before: Layer[], isLive: boolean): Promise<void> {
    const begun = performance.now();
    if (isLive && (this.step === undefined || this.step !== this.history.now)) this.stepName = crypto.randomUUID();
    const result = await this.resultOf(request, (effects) => effects, true, isLive ? this.stepName : undefined);
    const made = result.isWhole ? undefined : this.layer(result, request);
    const at = { before, struck: aim.layer, fragment: aim.pick.fragment, aim: { ...aim } };
    const state = { layers: layersAfter(at, made), last: { ...at, request, result, pictureMs: performance.now() - begun } };
    const isFirst = !isLive && made !== undefined && before.length === 1 && !before[0]!.request;
    const old = this.history.pieces();
    if (this.replaces(state, isLive)) this.history.replace(state);
    else this.history.push(state);
    this.step = isLive ? state : undefined;
    this.struck = { aim, before };
    this.dispose(old);
    if (isFirst && this.explode() === 0) this.moveApart(EXPLODE_FIRST);
    if (!isLive) panel.hint(!made ? "It stays whole: strike harder" : isFirst ? "Click a piece to break it again" : undefined);
    this.refresh();
  }

  /** Whether a state takes the place of the shown one: it is the same step, or nothing broke once more. */
  private replaces(state: State, isLive: boolean): boolean {
    const now = this.history.now;
    if (isLive && this.step !== undefined && this.step === now) return true;
    return !isLive && state.last?.result.isWhole === true && now?.last?.result.isWhole === true && now.layers === state.layers;
  }

  /** A picture of what another result of a request leaves. */
  pictureOf(answer: Answer, result: ResultMessage, request: ImpactRequest, width: number, height: number): string {
    const made = result.isWhole ? undefined : this.layer(result, request);
    this.put(layersAfter(answer, made));
    const picture = this.stage.picture(width, height);
    made?.pieces.dispose();
    this.refresh();
    return picture;
  }

  /** The impulse that just breaks what `aim` points at, N·s. */
  async threshold(aim: Aim, settings: Settings): Promise<number> {
    if (aim.thresholdNs !== undefined) return aim.thresholdNs;
    const probe = { ...this.requestOf(aim, 1, settings), impulseNs: 1 };
    const reply = await this.withHandle(probe, (handle) =>
      this.connection.ask({ op: "threshold", object: probe.object, impact: { ...impactOf(probe, [], handle), keep: false } }),
    );
    aim.thresholdNs = Number(reply["factor"]);
    return aim.thresholdNs;
  }

  /** Asks for the result of a request. A recording keeps it, unless it only shows more of what is known; of a `step` it keeps the last. */
  async resultOf(request: ImpactRequest, choose: (effects: string[]) => string[], isRecorded = true, step?: string): Promise<ResultMessage> {
    const result = await this.withEffects(request.object, (effects) =>
      this.withHandle(request, (handle) =>
        this.connection.askResult({
          op: "strike",
          object: request.object,
          impact: impactOf(request, choose(effects), handle),
          is_recorded: isRecorded,
          step,
        }),
      ),
    );
    // A recording finds the requests by the handles that it knows.
    if (result.head.handle && isRecorded) this.handles.set(request, result.head.handle);
    return result;
  }

  /** Effects of the requests for an object: those that the page needs and the service allows. */
  effectsOf(object: string): string[] {
    return this.allowed(object, this.textures.has(object) ? [...EFFECTS, TEXTURE_EFFECT] : EFFECTS);
  }

  private allowed(object: string, effects: string[]): string[] {
    return effects.filter((effect) => !this.refused.has(`${object}/${effect}`));
  }

  /** Calls `ask` with those of the effects that the service allows for an object. */
  private async withEffects<T>(object: string, ask: (effects: string[]) => Promise<T>, needed = this.effectsOf(object)): Promise<T> {
    const effects = this.allowed(object, needed);
    try {
      return await ask(effects);
    } catch (error) {
      const at = error instanceof ServiceError && error.kind === "effect" ? error.at : "";
      if (!effects.includes(at)) throw error;
      this.refused.add(`${object}/${at}`);
      return this.withEffects(object, ask, needed);
    }
  }

  /** Calls `ask` with the handle of the struck fragment's result. Repeats that request if the service has forgotten it. */
  async withHandle<T>(request: ImpactRequest, ask: (handle: string | undefined) => Promise<T>): Promise<T> {
    const parent = request.parent?.request;
    if (!parent) return ask(undefined);
    try {
      const handle = this.handles.get(parent);
      if (handle) return await ask(handle);
    } catch (error) {
      if (!(error instanceof ServiceError && error.kind === "unknown_handle")) throw error;
    }
    await this.resultOf(parent, (effects) => effects);
    return ask(this.handles.get(parent));
  }

  /** A file with all pieces that are shown. The service repeats the requests that it has forgotten. */
  async shownAs(format: string, needed: string[]): Promise<ResultMessage> {
    const askWith = async (enable: string[]) => {
      const layers = [];
      for (const { pieces, request, replaced } of this.history.now?.layers ?? []) {
        const ids = pieces.result.fragments.map(({ id }) => id).filter((id) => !replaced.has(id));
        const impact = request && (await this.withHandle(request, async (handle) => ({ ...impactOf(request, enable, handle), keep: false })));
        layers.push({ pieces: ids, ...(impact ? { impact } : {}) });
      }
      return this.connection.askResult({ op: "download", format, object: this.object?.name, layers, enable });
    };
    const ask = () => this.withEffects(this.object?.name ?? "", askWith, needed);
    try {
      return await ask();
    } catch (error) {
      if (!(error instanceof ServiceError && error.kind === "unknown_handle")) throw error;
      this.handles = new WeakMap();
      return ask();
    }
  }

  /** Runs `work`, and shows its error. */
  async guarded(work: () => Promise<void>): Promise<void> {
    try {
      await work();
      panel.message(undefined);
    } catch (error) {
      panel.message(error instanceof Error ? error.message : String(error));
    }
  }

  private dispose(old: Set<Pieces>): void {
    const kept = this.history.pieces();
    for (const pieces of old) if (!kept.has(pieces)) pieces.dispose();
  }

  /** Moves in the history. */
  go(by: number): void {
    if (!(by === -Infinity ? this.history.first() : this.history.move(by))) return;
    this.forgetStruck();
    panel.hint(undefined);
    const last = this.history.now?.last;
    if (last) strength.showRequest(last.request, multipleOf(last));
    // The slider repeats the request whose result is shown.
    if (last?.aim) this.struck = { aim: { ...last.aim }, before: last.before };
    this.refresh();
  }

  /** Shows the present state again. */
  refresh(): void {
    const state = this.history.now;
    if (!state) return;
    this.put(state.layers);
    this.point(undefined);
    this.onState();
    this.moveBy(this.explode());
    this.recolor();
    panel.facts(state, this.object);
    this.stage.changed();
  }

  /** Puts layers on the stage, in the chosen colors. */
  private put(layers: Layer[]): void {
    this.stage.group.clear();
    for (const { pieces, replaced } of layers) {
      pieces.result.fragments.forEach((_, id) => pieces.setVisible(id, !replaced.has(id)));
      this.stage.group.add(pieces.mesh);
    }
    this.paint(layers);
  }

  /** Colors layers as the panel says; returns the scale of the colors. */
  private paint(layers: Layer[]): Scale | undefined {
    const uniforms = this.look?.uniforms;
    if (!uniforms) return undefined;
    const mode = panel.colorMode();
    const modes: ColorMode[] = ["surface", "pieces", "energy", "bonds"];
    uniforms.uMode.value = modes.indexOf(mode);
    uniforms.uCracksOnly.value = panel.isOn("cracks") ? 1 : 0;
    for (const { pieces } of layers) {
      pieces.setXray(panel.isOn("xray"));
      pieces.setCracksOnly(panel.isOn("cracks"));
      pieces.setHulls(undefined);
    }
    return paintLayers(layers, mode);
  }

  /** Colors the pieces as the panel says. */
  recolor(): void {
    const state = this.history.now;
    if (!state) return;
    panel.legend(this.paint(state.layers));
    if (panel.isOn("hulls")) void this.showHulls(state);
    this.stage.changed();
  }

  /** Fetches hulls where they are missing, and shows them. */
  private async showHulls(state: State): Promise<void> {
    await this.guarded(async () => {
      for (const layer of state.layers) {
        if (!layer.request) continue;
        const known = this.hulls.get(layer.request);
        const result = known ?? (await this.resultOf(layer.request, () => ["hulls"], false));
        this.hulls.set(layer.request, result);
        if (this.history.now === state && panel.isOn("hulls")) layer.pieces.setHulls(result);
      }
      this.stage.changed();
    });
  }

  /** Share by which pieces are moved apart. */
  explode(): number {
    return this.share;
  }

  private share = 0;

  /** Moves the pieces apart by a share of their distance from the center. */
  setExplode(share: number): void {
    this.moveBy(share);
    element<HTMLInputElement>("explode").value = String(Math.round(100 * Math.sqrt(share / 2)));
    if (panel.isOn("hulls")) this.recolor();
    this.stage.changed();
  }

  /** Moves the pieces, and the ground below them. */
  private moveBy(share: number): void {
    this.share = share;
    const layers = this.history.now?.layers ?? [];
    // One piece stays where it is.
    const moved = countShown(layers) > 1 ? share : 0;
    if (this.look) this.look.uniforms.uExplode.value = moved;
    const lowest = Math.min(0, ...layers.map((layer) => layer.pieces.lowestCenter()));
    this.stage.lowerGround(-moved * lowest);
    this.stage.fit(moved > 0 ? Math.max(0, ...layers.map((layer) => layer.pieces.reach(moved))) : 0);
    this.onMove(moved);
  }

  /** By how much a place of the object at rest, relative to its center, is moved with its piece when pieces move apart by 1. */
  carriedBy(place: THREE.Vector3): THREE.Vector3 {
    const near = (this.history.now?.layers ?? []).flatMap((layer) => layer.pieces.nearest(place) ?? []);
    near.sort((a, b) => a.square - b.square);
    return near[0]?.place.clone() ?? new THREE.Vector3();
  }

  /** Moves the pieces apart smoothly, unless the user wants less motion. */
  moveApart(share: number): void {
    const from = this.explode();
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) {
      this.setExplode(share);
      return;
    }
    let begun: number | undefined;
    this.stage.animate((now) => {
      begun ??= now;
      const part = Math.min(1, (now - begun) / APART_MS);
      this.moveBy(from + (share - from) * (1 - (1 - part) ** 3));
      if (part === 1) this.setExplode(share);
      return part < 1;
    });
  }
}
