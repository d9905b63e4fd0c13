// The stage: camera, light, ground, contact marker. It draws only when something changed.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { RoomEnvironment } from "three/examples/jsm/environments/RoomEnvironment.js";

/** Longest time between two frames for full resolution while the camera moves, ms. */
const FRAME_MS = 45;

/** Least share of the resolution. */
const SCALE_MIN = 0.4;

/** Pause after the last movement before a frame of full resolution, ms; at least two frames, so that slow ones do not end a movement. */
const REST_MS = 180;
const REST_MAX_MS = 1500;

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
  private readonly ground: THREE.Mesh;
  private readonly ring: THREE.Mesh;
  private readonly dot: THREE.Mesh;
  /** By how much a previewed mesh is moved, in its unit. */
  readonly previewOffset = new THREE.Vector3();
  private diagonal = 1;
  private scale = 1;
  private pending = false;
  private isMoving = false;
  private restTimer: number | undefined;
  private tick: ((now: number) => boolean) | undefined;
  /** Time at which the last frame of a movement began, ms; `undefined` at rest. */
  private lastFrame: number | undefined;
  /** Time between the last two frames of a movement, ms. */
  private frameMs = 0;
  /** Frames drawn. */
  frames = 0;

  constructor(
    private readonly canvas: HTMLCanvasElement,
    onLost: (isLost: boolean) => void,
  ) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
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
      onLost(false);
      this.changed();
    });
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.enablePan = true;
    this.controls.rotateSpeed = 0.8;
    this.controls.addEventListener("change", () => this.moved());
    this.ground = new THREE.Mesh(new THREE.CircleGeometry(1, 48), new THREE.ShadowMaterial({ opacity: 0.26, depthWrite: false }));
    this.ground.rotation.x = -Math.PI / 2;
    this.ground.receiveShadow = true;
    const accent = new THREE.MeshBasicMaterial({ color: "#e0562d", transparent: true, opacity: 0.95, depthTest: false });
    this.ring = new THREE.Mesh(new THREE.RingGeometry(0.93, 1, 64), accent);
    this.dot = new THREE.Mesh(new THREE.CircleGeometry(0.07, 24), accent);
    this.ring.add(this.dot);
    this.ring.renderOrder = 10;
    this.dot.renderOrder = 10;
    this.ring.visible = false;
    this.setLights();
    this.scene.add(this.group, this.marks, this.ground, this.ring);
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  private setLights(): void {
    this.key.castShadow = true;
    this.key.shadow.mapSize.set(2048, 2048);
    this.key.shadow.radius = 5;
    this.key.shadow.bias = -0.0004;
    const fill = new THREE.DirectionalLight("#cfe0ff", 0.5);
    fill.position.set(-2, 0.6, -1.2);
    this.scene.add(this.key, this.key.target, fill);
    this.setEnvironment();
  }

  private setEnvironment(): void {
    const maker = new THREE.PMREMGenerator(this.renderer);
    this.scene.environment?.dispose();
    this.scene.environment = maker.fromScene(new RoomEnvironment(), 0.04).texture;
    this.scene.environmentIntensity = 0.55;
    maker.dispose();
  }

  /** Places camera, light and ground for an object with these bounds, relative to its center. */
  frame(low: THREE.Vector3, high: THREE.Vector3): void {
    const diagonal = low.distanceTo(high);
    this.diagonal = diagonal;
    const distance = (0.62 * diagonal) / Math.sin(THREE.MathUtils.degToRad(this.camera.fov / 2));
    this.camera.near = diagonal / 100;
    this.camera.far = diagonal * 60;
    this.camera.position.set(0.42, 0.38, 0.82).normalize().multiplyScalar(distance * Math.max(1, 1 / this.camera.aspect));
    this.controls.target.set(0, 0, 0);
    this.controls.minDistance = 0.3 * diagonal;
    this.controls.maxDistance = 12 * diagonal;
    this.controls.update();
    this.camera.updateProjectionMatrix();
    this.ground.position.y = low.y - 0.001 * diagonal;
    this.ground.scale.setScalar(4 * diagonal);
    this.key.position.set(0.75, 1.5, 0.65).multiplyScalar(2.2 * diagonal);
    const box = this.key.shadow.camera;
    [box.left, box.right, box.bottom, box.top] = [-1.5, 1.5, -1.5, 1.5].map((x) => x * diagonal) as [number, number, number, number];
    box.near = 0.1 * diagonal;
    box.far = 9 * diagonal;
    box.updateProjectionMatrix();
    this.key.shadow.normalBias = 0.002 * diagonal;
    this.changed();
  }

  /** Length of the diagonal of what is shown, m. */
  size(): number {
    return this.diagonal;
  }

  /** Frames a part that is not an object of the service: moves it to the center. */
  framePart(part: THREE.Object3D): void {
    const box = new THREE.Box3().setFromObject(part);
    const center = box.getCenter(new THREE.Vector3());
    this.previewOffset.copy(center).negate();
    part.position.add(this.previewOffset);
    this.frame(box.min.sub(center), box.max.sub(center));
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
    this.redraw();
  }

  /** Calls `step` before each frame until it returns false. */
  animate(step: (now: number) => boolean): void {
    this.tick = step;
    this.changed();
  }

  /** Draws again, with new shadows. */
  changed(): void {
    this.renderer.shadowMap.needsUpdate = true;
    this.redraw();
  }

  /** Draws again. */
  redraw(): void {
    if (this.pending) return;
    this.pending = true;
    requestAnimationFrame((now) => this.draw(now));
  }

  /** A picture of the stage as it is, as a data address. */
  picture(width: number, height: number): string {
    this.renderer.shadowMap.needsUpdate = true;
    this.renderer.render(this.scene, this.camera);
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
    this.restTimer = window.setTimeout(() => {
      this.isMoving = false;
      this.redraw();
    }, THREE.MathUtils.clamp(2 * this.frameMs, REST_MS, REST_MAX_MS));
    this.redraw();
  }

  private draw(now: number): void {
    this.pending = false;
    const goesOn = this.tick?.(now) ?? false;
    if (!goesOn) this.tick = undefined;
    else this.renderer.shadowMap.needsUpdate = true;
    const isBusy = this.isMoving || goesOn;
    if (isBusy) this.adapt(now);
    this.lastFrame = isBusy ? now : undefined;
    this.setScale(isBusy ? this.scale : 1);
    this.renderer.render(this.scene, this.camera);
    this.frames++;
    if (goesOn) this.redraw();
  }

  /** Adapts the resolution to the time between frames: the browser draws after `render` returns, and asks for frames as it gets on. */
  private adapt(now: number): void {
    if (this.lastFrame === undefined) return;
    this.frameMs = now - this.lastFrame;
    this.scale = THREE.MathUtils.clamp(this.scale * (this.frameMs > FRAME_MS ? 0.8 : 1.05), SCALE_MIN, 1);
  }

  private setScale(scale: number): void {
    const ratio = Math.min(window.devicePixelRatio, 2) * scale;
    if (Math.abs(this.renderer.getPixelRatio() - ratio) > 0.02) this.renderer.setPixelRatio(ratio);
  }

  private resize(): void {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.redraw();
  }
}
