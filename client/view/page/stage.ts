// The stage: camera, light, ground, contact marker. It draws only when something changed.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { RoomEnvironment } from "three/examples/jsm/environments/RoomEnvironment.js";
import type { StageLight } from "./fast_material";
import { Ground } from "./ground";
import { DETAILED, FAST } from "./layers";
import { isSoftwareRenderer, Pace } from "./pace";

/** Pixels per pixel of the page at rest, with a software renderer: smooth edges for less time than multisampling takes there. */
const SOFTWARE_RATIO = 1.5;

/** Direction to the key light. */
const KEY = new THREE.Vector3(0.75, 1.5, 0.65);

/** Radius around the center that the picture shows, as a share of the diagonal of the object. */
const FRAMED = 0.62;

/** Everything that is drawn, in meters relative to the center of the object. */
export class Stage {
  readonly scene = new THREE.Scene();
  readonly camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
  /** Pieces. */
  readonly group = new THREE.Group();
  /** Marks of defects, anchors and sites. */
  readonly marks = new THREE.Group();
  private readonly renderer: THREE.WebGLRenderer;
  private readonly controls: OrbitControls;
  private readonly key = new THREE.DirectionalLight("#fff4e6", 2.3);
  private readonly fill = new THREE.DirectionalLight("#cfe0ff", 0.5);
  /** The same light for the fast look of pieces. */
  readonly light: StageLight;
  private readonly ground = new Ground(this.key);
  private readonly ring: THREE.Mesh;
  private readonly dot: THREE.Mesh;
  /** By how much a previewed mesh is moved, in its unit. */
  readonly previewOffset = new THREE.Vector3();
  private diagonal = 1;
  /** Distance of the camera, as a multiple of that for the object in one piece. */
  private spread = 1;
  private readonly isSoftware = isSoftwareRenderer();
  private readonly pace = new Pace(this.isSoftware);
  /** Height of the lowest point of the object, m. */
  private low = 0;
  private isShadowStale = true;
  /** Whether no frame with all details was drawn in this context yet: fast frames use its shadow. */
  private isFirst = true;
  private pending = false;
  private isMoving = false;
  private restTimer: number | undefined;
  private isHeld = false;
  private tick: ((now: number) => boolean) | undefined;
  /** Frames drawn. */
  frames = 0;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    onLost: (isLost: boolean) => void,
  ) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !this.isSoftware, alpha: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false;
    this.renderer.toneMapping = THREE.NeutralToneMapping;
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      onLost(true);
    });
    canvas.addEventListener("webglcontextrestored", () => {
      this.setEnvironment();
      this.isFirst = true;
      onLost(false);
      this.changed();
    });
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enablePan = true;
    this.controls.rotateSpeed = 0.8;
    this.controls.addEventListener("change", () => this.moved());
    const accent = new THREE.MeshBasicMaterial({ color: "#e0562d", transparent: true, opacity: 0.95, depthTest: false });
    this.ring = new THREE.Mesh(new THREE.RingGeometry(0.93, 1, 64), accent);
    this.dot = new THREE.Mesh(new THREE.CircleGeometry(0.07, 24), accent);
    this.ring.add(this.dot);
    this.ring.renderOrder = 10;
    this.dot.renderOrder = 10;
    this.ring.visible = false;
    this.setLights();
    this.light = this.lightOf();
    this.scene.add(this.group, this.marks, this.ground.group, this.ring);
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  private setLights(): void {
    this.key.position.copy(KEY);
    this.key.castShadow = true;
    this.key.shadow.mapSize.setScalar(this.isSoftware ? 1024 : 2048);
    this.key.shadow.radius = 5;
    this.key.shadow.bias = -0.0004;
    this.fill.position.set(-2, 0.6, -1.2);
    this.scene.add(this.key, this.key.target, this.fill);
    this.scene.environmentIntensity = 0.55;
    this.setEnvironment();
  }

  private lightOf(): StageLight {
    const direction = (light: THREE.Light) => ({ value: light.position.clone().normalize() });
    const color = (light: THREE.Light) => ({ value: light.color.clone().multiplyScalar(light.intensity / Math.PI) });
    return {
      uKeyDirection: direction(this.key),
      uKeyColor: color(this.key),
      uFillDirection: direction(this.fill),
      uFillColor: color(this.fill),
      uAmbient: { value: this.scene.environmentIntensity },
    };
  }

  private setEnvironment(): void {
    const maker = new THREE.PMREMGenerator(this.renderer);
    this.scene.environment?.dispose();
    this.scene.environment = maker.fromScene(new RoomEnvironment(), 0.04).texture;
    maker.dispose();
  }

  /** Removes all marks; new ones are placed relative to the center of the object. */
  clearMarks(): void {
    this.marks.clear();
    this.marks.position.set(0, 0, 0);
    this.marks.quaternion.identity();
  }

  /** Places camera, light and ground for an object with these bounds, relative to its center; `keepsView`: seen from where the user looks. */
  frame(low: THREE.Vector3, high: THREE.Vector3, keepsView = false): void {
    const diagonal = low.distanceTo(high);
    const view = this.camera.position.clone().sub(this.controls.target).divideScalar(this.diagonal * this.spread);
    const target = this.controls.target.clone().divideScalar(this.diagonal);
    [this.diagonal, this.spread] = [diagonal, 1];
    const distance = (FRAMED * diagonal) / Math.sin(THREE.MathUtils.degToRad(this.camera.fov / 2));
    this.camera.near = diagonal / 100;
    this.camera.far = diagonal * 60;
    this.camera.position.set(0.42, 0.38, 0.82).normalize().multiplyScalar(distance * this.margin());
    this.controls.target.set(0, 0, 0);
    this.controls.minDistance = 0.3 * diagonal;
    this.controls.maxDistance = 12 * diagonal;
    if (keepsView) {
      this.controls.target.copy(target.multiplyScalar(diagonal));
      this.camera.position.copy(view.multiplyScalar(diagonal)).add(this.controls.target);
    }
    this.controls.update();
    this.camera.updateProjectionMatrix();
    this.low = low.y - 0.001 * diagonal;
    this.lowerGround(0);
    this.ground.group.scale.setScalar(4 * diagonal);
    this.key.position.copy(KEY).multiplyScalar(2.2 * diagonal);
    const box = this.key.shadow.camera;
    [box.left, box.right, box.bottom, box.top] = [-1.5, 1.5, -1.5, 1.5].map((x) => x * diagonal) as [number, number, number, number];
    box.near = 0.1 * diagonal;
    box.far = 9 * diagonal;
    box.updateProjectionMatrix();
    this.key.shadow.normalBias = 0.002 * diagonal;
    this.changed();
  }

  /** Moves the ground below where the object stands, by a length in m: pieces move apart. */
  lowerGround(byM: number): void {
    this.ground.group.position.y = this.low - byM;
  }

  /** Moves the camera so far away that what reaches so far from the center is in the picture, m; the user's turn and zoom stay. */
  fit(reachM: number): void {
    const spread = Math.max(1, reachM / (FRAMED * this.diagonal));
    if (Math.abs(spread / this.spread - 1) < 1e-3) return;
    const offset = this.camera.position.clone().sub(this.controls.target).multiplyScalar(spread / this.spread);
    this.spread = spread;
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
  }

  /** Length of the diagonal of what is shown, m. */
  size(): number {
    return this.diagonal;
  }

  /** Frames a part that is not an object of the service: moves it to the center. */
  framePart(part: THREE.Object3D, keepsView = false): void {
    part.position.set(0, 0, 0);
    const box = new THREE.Box3().setFromObject(part);
    const center = box.getCenter(new THREE.Vector3());
    this.previewOffset.copy(center).negate();
    part.position.copy(this.previewOffset);
    this.frame(box.min.sub(center), box.max.sub(center), keepsView);
  }

  /** Looks at a place from outside. */
  lookFrom(place: THREE.Vector3): void {
    const distance = this.camera.position.distanceTo(this.controls.target);
    const direction = place.lengthSq() > 0 ? place.clone().normalize() : new THREE.Vector3(0, 0, 1);
    direction.y += 0.25;
    this.camera.position.copy(direction.normalize().multiplyScalar(distance));
    this.controls.update();
    this.moved();
  }

  /** Turns the camera about the object, by angles in radians, and moves it closer by a factor. */
  orbit(azimuth: number, elevation: number, zoom = 1): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const place = new THREE.Spherical().setFromVector3(offset);
    place.theta += azimuth;
    place.phi = THREE.MathUtils.clamp(place.phi + elevation, 0.05, Math.PI - 0.05);
    place.radius = THREE.MathUtils.clamp(place.radius * zoom, this.controls.minDistance, this.controls.maxDistance);
    this.camera.position.setFromSpherical(place).add(this.controls.target);
    this.controls.update();
    this.moved();
  }

  /** The ray through a point of the canvas, in pixels of the page. */
  ray(x: number, y: number): THREE.Ray {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(((x - box.left) / box.width) * 2 - 1, 1 - ((y - box.top) / box.height) * 2);
    this.camera.updateMatrixWorld();
    const caster = new THREE.Raycaster();
    caster.setFromCamera(at, this.camera);
    return caster.ray;
  }

  /** Shows the contact: its point, normal and radius; `undefined` hides it. */
  showContact(contact: { point: THREE.Vector3; normal: THREE.Vector3; radiusM: number } | undefined): void {
    this.ring.visible = contact !== undefined;
    if (contact) {
      const facing = this.camera.position.clone().sub(contact.point);
      const normal = contact.normal.dot(facing) < 0 ? contact.normal.clone().negate() : contact.normal;
      this.ring.position.copy(contact.point).addScaledVector(normal, 0.002 * this.diagonal);
      this.ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), normal);
      this.ring.scale.setScalar(contact.radiusM);
    }
    this.update();
  }

  /** Calls `step` before each frame until it returns false. */
  animate(step: (now: number) => boolean): void {
    this.tick = step;
    this.changed();
  }

  /** Draws again, with new shadows. */
  changed(): void {
    this.isShadowStale = true;
    this.update();
  }

  /** Draws again: a fast frame first if others take long. */
  private update(): void {
    if (this.pace.isFast) this.moved();
    else this.redraw();
  }

  private redraw(): void {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame((now) => this.draw(now));
  }

  /** A picture of the stage without marks and contact, as a data address. */
  picture(width: number, height: number): string {
    this.isShadowStale = true;
    const isMarked = this.ring.visible;
    this.marks.visible = this.ring.visible = false;
    this.render(false);
    [this.marks.visible, this.ring.visible] = [true, isMarked];
    const copy = document.createElement("canvas");
    const source = this.canvas;
    [copy.width, copy.height] = [width, height];
    const share = Math.min(source.width / width, source.height / height);
    const [w, h] = [width * share, height * share];
    copy.getContext("2d")?.drawImage(source, (source.width - w) / 2, (source.height - h) / 2, w, h, 0, 0, width, height);
    return copy.toDataURL("image/png");
  }

  /** Loses the WebGL context on purpose, and restores it after a while: for tests. */
  loseContext(restoreMs: number): void {
    const extension = this.renderer.getContext().getExtension("WEBGL_lose_context");
    extension?.loseContext();
    setTimeout(() => extension?.restoreContext(), restoreMs);
  }

  /** Memory of the GPU in use: geometries and textures. */
  memory(): { geometries: number; textures: number } {
    const { geometries, textures } = this.renderer.info.memory;
    return { geometries, textures };
  }

  private moved(): void {
    this.isMoving = true;
    clearTimeout(this.restTimer);
    this.restLater();
    this.redraw();
  }

  private restLater(): void {
    this.restTimer = window.setTimeout(() => {
      if (this.isHeld) {
        this.restLater();
        return;
      }
      this.isMoving = false;
      this.redraw();
    }, this.pace.restMs());
  }

  /** Runs `work`, and draws no frame at rest meanwhile: on a slow renderer it would take the processor from the service. */
  async hold(work: () => Promise<void>): Promise<void> {
    this.isHeld = true;
    try {
      await work();
    } finally {
      this.isHeld = false;
    }
  }

  private draw(now: number): void {
    this.pending = false;
    const goesOn = this.tick?.(now) ?? false;
    if (!goesOn) this.tick = undefined;
    const isBusy = this.isMoving || goesOn;
    if (isBusy) this.pace.frame(now);
    else this.pace.rest();
    if (goesOn) this.isShadowStale = true;
    this.setScale(isBusy ? this.pace.scale : this.restScale());
    this.render(isBusy && this.pace.isFast && !this.isFirst);
    this.frames++;
    if (goesOn) this.redraw();
  }

  /** Draws a frame. Fast ones keep the shadow of the last one with all details. */
  private render(isFast: boolean): void {
    if (!isFast) {
      this.renderer.shadowMap.needsUpdate = this.isShadowStale;
      this.isShadowStale = this.isFirst = false;
    }
    this.camera.layers.set(0);
    this.camera.layers.enable(isFast ? FAST : DETAILED);
    this.renderer.render(this.scene, this.camera);
  }

  private restScale(): number {
    return this.isSoftware && window.devicePixelRatio < SOFTWARE_RATIO ? SOFTWARE_RATIO / window.devicePixelRatio : 1;
  }

  private setScale(scale: number): void {
    const ratio = Math.min(window.devicePixelRatio, 2) * scale;
    if (Math.abs(this.renderer.getPixelRatio() - ratio) > 0.02) this.renderer.setPixelRatio(ratio);
  }

  /** Distance of the camera that an upright picture needs, as a multiple of that of a square one. */
  private margin(): number {
    return Math.max(1, 1 / this.camera.aspect);
  }

  private resize(): void {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    const before = this.margin();
    this.camera.aspect = width / height;
    // What filled the picture fills it again.
    const offset = this.camera.position.clone().sub(this.controls.target).multiplyScalar(this.margin() / before);
    this.camera.position.copy(this.controls.target).add(offset);
    this.camera.updateProjectionMatrix();
    this.redraw();
  }
}
