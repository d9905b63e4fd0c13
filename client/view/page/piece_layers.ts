// Which layer of the textures each vertex of the pieces shows.

import * as THREE from "three";

/**
 * Sets the attribute `layer`: the material of the triangles of a vertex. A vertex of triangles of several materials is divided. Triangles
 * without a material have the last of `layerCount` layers.
 */
export function setLayers(geometry: THREE.BufferGeometry, materials: Uint32Array, layerCount: number): void {
  const indices = geometry.index!.array as Uint32Array;
  const count = geometry.getAttribute("position").count;
  const layers = new Float32Array(count).fill(-1);
  const copies: { of: number; layer: number }[] = [];
  const copyOf = new Map<string, number>();
  const withLayer = (vertex: number, layer: number) => {
    if (layers[vertex] === -1) layers[vertex] = layer;
    if (layers[vertex] === layer) return vertex;
    const key = `${vertex}/${layer}`;
    const known = copyOf.get(key);
    if (known !== undefined) return known;
    copies.push({ of: vertex, layer });
    copyOf.set(key, count + copies.length - 1);
    return count + copies.length - 1;
  };
  for (let at = 0; at < indices.length; at++) {
    const layer = Math.min(materials[Math.floor(at / 3)] ?? 0, layerCount - 1);
    indices[at] = withLayer(indices[at]!, layer);
  }
  const all = new Float32Array(count + copies.length);
  all.set(layers);
  copies.forEach(({ layer }, at) => (all[count + at] = layer));
  if (copies.length > 0) for (const name of Object.keys(geometry.attributes)) extend(geometry, name, copies);
  geometry.setAttribute("layer", new THREE.BufferAttribute(all, 1));
}

/** Appends copies of vertices to an attribute. */
function extend(geometry: THREE.BufferGeometry, name: string, copies: { of: number }[]): void {
  const given = geometry.getAttribute(name);
  const size = given.itemSize;
  const values = new Float32Array((given.count + copies.length) * size);
  for (let vertex = 0; vertex < given.count + copies.length; vertex++) {
    const source = copies[vertex - given.count]?.of ?? vertex;
    for (let axis = 0; axis < size; axis++) values[size * vertex + axis] = given.getComponent(source, axis);
  }
  geometry.setAttribute(name, new THREE.BufferAttribute(values, size));
}
