// The pieces of one result as one mesh, and where rays meet them.

import * as THREE from "three";
import { fastMaterial } from "./fast_material";
import { DETAILED, FAST } from "./layers";
import { type PieceLook, shadowMaterial, solidMaterial, xrayMaterial } from "./material";
import { setLayers } from "./piece_layers";
import { COLUMNS } from "./piece_shader";
import type { ResultMessage, Vector } from "./result";

/** Numbers per row of the section of outer attributes: normal, texture coordinates. */
const OUTER_FLOATS = 5;

/** Where a ray meets a piece. */
export interface Pick {
  /** Fragment in its result. */
  fragment: number;
  /** From the origin of the ray, m. */
  distance: number;
  /** The point as it is shown, relative to the center of the object, m. */
  shown: THREE.Vector3;
  /** Outward normal of the triangle. */
  normal: THREE.Vector3;
  /** By how much the piece is moved from its place in the object, m. */
  offset: THREE.Vector3;
}

/** Pieces of one result, relative to the center of the object. */
export class Pieces {
  readonly mesh: THREE.Mesh;
  private readonly geometry = new THREE.BufferGeometry();
  private readonly places: THREE.DataTexture;
  private readonly colors: THREE.DataTexture;
  private readonly solid: THREE.Material;
  private readonly xray: THREE.Material;
  private readonly shadow: THREE.Material;
  private readonly fast: THREE.Mesh<THREE.BufferGeometry, THREE.Material>;
  private knownRadii: Float32Array | undefined;
  private hullLines: THREE.LineSegments | undefined;

  constructor(
    readonly result: ResultMessage,
    readonly centerM: Vector,
    private readonly look: PieceLook,
  ) {
    const count = result.fragments.length;
    const rows = Math.max(1, Math.ceil(count / COLUMNS));
    const table = () => {
      const texture = new THREE.DataTexture(new Float32Array(4 * COLUMNS * rows), COLUMNS, rows, THREE.RGBAFormat, THREE.FloatType);
      texture.needsUpdate = true;
      return texture;
    };
    this.places = table();
    this.colors = table();
    this.fill();
    this.solid = solidMaterial(look, this.places, this.colors);
    this.xray = xrayMaterial(look, this.places, this.colors);
    this.shadow = shadowMaterial(look, this.places, this.colors);
    this.mesh = new THREE.Mesh(this.geometry, this.solid);
    this.mesh.customDepthMaterial = this.shadow;
    this.mesh.castShadow = true;
    this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false;
    this.mesh.layers.set(DETAILED);
    this.fast = new THREE.Mesh(this.geometry, fastMaterial(look, this.places, this.colors));
    this.fast.frustumCulled = false;
    this.fast.layers.set(FAST);
    this.mesh.add(this.fast);
  }

  private fill(): void {
    const { result } = this;
    const positions = result.floats("positions");
    const vertexCount = positions.length / 3;
    const piece = new Float32Array(vertexCount);
    const crack = new Float32Array(vertexCount);
    const given = result.integers("indices");
    const indices = new Uint32Array(given.length);
    const places = this.places.image.data as Float32Array;
    result.fragments.forEach((fragment, id) => {
      piece.fill(id, fragment.vertexFirst, fragment.vertexFirst + fragment.vertexCount);
      const end = fragment.indexFirst + fragment.indexCount;
      for (let at = fragment.indexFirst; at < end; at++) indices[at] = given[at]! + fragment.vertexFirst;
      for (let axis = 0; axis < 3; axis++) places[4 * id + axis] = fragment.centerM[axis]! - this.centerM[axis]!;
      places[4 * id + 3] = 1;
    });
    for (const run of result.runs()) if (run.isCrack) crack.fill(1, run.vertexFirst, run.vertexFirst + run.vertexCount);
    this.geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
    this.geometry.setAttribute("piece", new THREE.BufferAttribute(piece, 1));
    this.geometry.setAttribute("crack", new THREE.BufferAttribute(crack, 1));
    this.geometry.setIndex(new THREE.BufferAttribute(indices, 1));
    this.setNormals();
    if (this.look.uniforms.uHasTextures.value > 0) setLayers(this.geometry, result.integers("materials"), this.look.uniforms.uTextures.value?.image.depth ?? 1);
    this.places.needsUpdate = true;
  }

  /** Normals and texture coordinates, as they lie in the result; normals are computed if it has none. */
  private setNormals(): void {
    const cracks = this.result.floats("normals");
    const outer = this.result.floats("outer_attributes");
    if (cracks.length === 0) {
      this.geometry.computeVertexNormals();
      return;
    }
    this.geometry.setAttribute("normal", new THREE.BufferAttribute(cracks, 3));
    if (outer.length === 0) return;
    const rows = new THREE.InterleavedBuffer(outer, OUTER_FLOATS);
    this.geometry.setAttribute("outerNormal", new THREE.InterleavedBufferAttribute(rows, 3, 0));
    this.geometry.setAttribute("skinUv", new THREE.InterleavedBufferAttribute(rows, 2, 3));
  }

  /** Distance of the farthest vertex of each piece from its center, m: computed when it is first needed. */
  private radii(): Float32Array {
    this.knownRadii ??= Float32Array.from(this.result.fragments, (fragment) => {
      const positions = this.result.floats("positions");
      let square = 0;
      for (let at = 3 * fragment.vertexFirst; at < 3 * (fragment.vertexFirst + fragment.vertexCount); at += 3) {
        const [x, y, z] = [positions[at]!, positions[at + 1]!, positions[at + 2]!];
        square = Math.max(square, x * x + y * y + z * z);
      }
      return Math.sqrt(square);
    });
    return this.knownRadii;
  }

  /** Height of the lowest center of a piece, relative to the center of the object, m. */
  lowestCenter(): number {
    return this.result.fragments.reduce((least, { centerM }) => Math.min(least, centerM[1] - this.centerM[1]), 0);
  }

  /** Distance from the center of the object to the farthest visible point when pieces are moved apart by a share, m. */
  reach(share: number): number {
    const [radii, place] = [this.radii(), new THREE.Vector3()];
    return radii.reduce((most, radius, id) => (this.isVisible(id) ? Math.max(most, this.placeOf(id, place).length() * (1 + share) + radius) : most), 0);
  }

  /** The visible piece with the nearest vertex to a point of the object at rest: its place, and the square of the distance. */
  nearest(point: THREE.Vector3): { place: THREE.Vector3; square: number } | undefined {
    const positions = this.result.floats("positions");
    let best: { place: THREE.Vector3; square: number } | undefined;
    this.result.fragments.forEach((fragment, id) => {
      if (!this.isVisible(id)) return;
      const place = this.placeOf(id, new THREE.Vector3());
      const own = point.clone().sub(place);
      const gap = own.length() - this.radii()[id]!;
      if (best && gap > 0 && gap * gap > best.square) return;
      for (let at = 3 * fragment.vertexFirst; at < 3 * (fragment.vertexFirst + fragment.vertexCount); at += 3) {
        const [x, y, z] = [positions[at]! - own.x, positions[at + 1]! - own.y, positions[at + 2]! - own.z];
        const square = x * x + y * y + z * z;
        if (!best || square < best.square) best = { place, square };
      }
    });
    return best;
  }

  /** Shows or hides a piece. */
  setVisible(fragment: number, isVisible: boolean): void {
    (this.places.image.data as Float32Array)[4 * fragment + 3] = isVisible ? 1 : 0;
    this.places.needsUpdate = true;
  }

  /** Whether a piece is shown. */
  isVisible(fragment: number): boolean {
    return (this.places.image.data as Float32Array)[4 * fragment + 3]! > 0.5;
  }

  /** Colors the pieces. */
  paint(color: (fragment: number) => THREE.Color): void {
    const data = this.colors.image.data as Float32Array;
    this.result.fragments.forEach((_, id) => color(id).toArray(data, 4 * id));
    this.colors.needsUpdate = true;
  }

  /** Marks one piece, or none. */
  mark(fragment: number | undefined): void {
    const data = this.colors.image.data as Float32Array;
    for (let id = 0; id < this.result.fragments.length; id++) data[4 * id + 3] = id === fragment ? 1 : 0;
    this.colors.needsUpdate = true;
  }

  /** Switches between the solid look and the one that shows the inside. */
  setXray(isOn: boolean): void {
    this.mesh.material = isOn ? this.xray : this.solid;
    this.mesh.castShadow = !isOn;
    this.fast.visible = !isOn;
    if (isOn) this.mesh.layers.enable(FAST);
    else this.mesh.layers.disable(FAST);
  }

  /** Whether crack faces alone are drawn: then both sides of them are seen. */
  setCracksOnly(isOn: boolean): void {
    const side = isOn ? THREE.DoubleSide : THREE.FrontSide;
    for (const material of [this.solid, this.fast.material]) {
      if (material.side === side) continue;
      material.side = side;
      material.needsUpdate = true;
    }
  }

  /** Shows the hulls of `source`, a result of the same pieces with hulls; `undefined` hides them. */
  setHulls(source: ResultMessage | undefined): void {
    if (this.hullLines) {
      this.mesh.remove(this.hullLines);
      this.hullLines.geometry.dispose();
      (this.hullLines.material as THREE.Material).dispose();
      this.hullLines = undefined;
    }
    if (!source) return;
    const [positions, indices, lines] = [source.floats("hull_positions"), source.integers("hull_indices"), [] as number[]];
    const factor = 1 + this.look.uniforms.uExplode.value;
    source.hulls().forEach((hull, id) => {
      if (!this.isVisible(id)) return;
      const center = source.fragments[id]!.centerM;
      const corner = (index: number) =>
        [0, 1, 2].map((axis) => positions[3 * (hull.vertexFirst + index) + axis]! + (center[axis]! - this.centerM[axis]!) * factor);
      for (let at = hull.indexFirst; at < hull.indexFirst + hull.indexCount; at += 3) {
        for (let k = 0; k < 3; k++) {
          const [a, b] = [indices[at + k]!, indices[at + ((k + 1) % 3)]!];
          if (a < b) lines.push(...corner(a), ...corner(b));
        }
      }
    });
    const geometry = new THREE.BufferGeometry().setAttribute("position", new THREE.Float32BufferAttribute(lines, 3));
    this.hullLines = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({ color: "#e0562d", transparent: true, opacity: 0.85 }));
    this.mesh.add(this.hullLines);
  }

  /** First piece that a ray meets; origin and direction are relative to the center of the object. */
  pick(ray: THREE.Ray): Pick | undefined {
    const factor = 1 + this.look.uniforms.uExplode.value;
    const [center, sphere] = [new THREE.Vector3(), new THREE.Sphere()];
    const radii = this.radii();
    const candidates: { id: number; distance: number }[] = [];
    this.result.fragments.forEach((_, id) => {
      if (!this.isVisible(id)) return;
      sphere.set(this.placeOf(id, center).multiplyScalar(factor), radii[id]!);
      if (ray.intersectsSphere(sphere)) candidates.push({ id, distance: center.distanceTo(ray.origin) - radii[id]! });
    });
    candidates.sort((a, b) => a.distance - b.distance);
    let best: Pick | undefined;
    for (const { id, distance } of candidates) {
      if (best && distance > best.distance) break;
      best = this.pickPiece(id, ray, factor, best);
    }
    return best;
  }

  private placeOf(id: number, into: THREE.Vector3): THREE.Vector3 {
    return into.fromArray(this.places.image.data as Float32Array, 4 * id);
  }

  private pickPiece(id: number, ray: THREE.Ray, factor: number, best: Pick | undefined): Pick | undefined {
    const fragment = this.result.fragments[id]!;
    const place = this.placeOf(id, new THREE.Vector3());
    const shownCenter = place.clone().multiplyScalar(factor);
    const own = new THREE.Ray(ray.origin.clone().sub(shownCenter), ray.direction);
    const found = firstTriangle(own, this.geometry.getAttribute("position").array as Float32Array, this.geometry.index!.array as Uint32Array, fragment.indexFirst, fragment.indexCount);
    if (!found || (best && found.distance >= best.distance)) return best;
    return {
      fragment: id,
      distance: found.distance,
      shown: ray.at(found.distance, new THREE.Vector3()),
      normal: found.normal,
      offset: shownCenter.sub(place),
    };
  }

  /** Frees the memory of the GPU. */
  dispose(): void {
    this.setHulls(undefined);
    for (const part of [this.geometry, this.places, this.colors, this.solid, this.xray, this.shadow, this.fast.material]) part.dispose();
  }
}

/** First triangle that a ray meets (Möller and Trumbore 1997), from either side. */
function firstTriangle(
  ray: THREE.Ray,
  p: Float32Array,
  indices: Uint32Array,
  first: number,
  count: number,
): { distance: number; normal: THREE.Vector3 } | undefined {
  const { x: ox, y: oy, z: oz } = ray.origin;
  const { x: dx, y: dy, z: dz } = ray.direction;
  let [distance, at] = [Infinity, -1];
  for (let i = first; i < first + count; i += 3) {
    const [a, b, c] = [3 * indices[i]!, 3 * indices[i + 1]!, 3 * indices[i + 2]!];
    const [ax, ay, az] = [p[a]!, p[a + 1]!, p[a + 2]!];
    const [e1x, e1y, e1z] = [p[b]! - ax, p[b + 1]! - ay, p[b + 2]! - az];
    const [e2x, e2y, e2z] = [p[c]! - ax, p[c + 1]! - ay, p[c + 2]! - az];
    const [hx, hy, hz] = [dy * e2z - dz * e2y, dz * e2x - dx * e2z, dx * e2y - dy * e2x];
    const det = e1x * hx + e1y * hy + e1z * hz;
    if (det === 0) continue;
    const f = 1 / det;
    const [sx, sy, sz] = [ox - ax, oy - ay, oz - az];
    const u = f * (sx * hx + sy * hy + sz * hz);
    if (u < 0 || u > 1) continue;
    const [qx, qy, qz] = [sy * e1z - sz * e1y, sz * e1x - sx * e1z, sx * e1y - sy * e1x];
    const v = f * (dx * qx + dy * qy + dz * qz);
    if (v < 0 || u + v > 1) continue;
    const t = f * (e2x * qx + e2y * qy + e2z * qz);
    if (t > 0 && t < distance) [distance, at] = [t, i];
  }
  if (at < 0) return undefined;
  const corner = (k: number) => new THREE.Vector3().fromArray(p, 3 * indices[at + k]!);
  const [a, b, c] = [corner(0), corner(1), corner(2)];
  return { distance, normal: b.sub(a).cross(c.sub(a)).normalize() };
}
