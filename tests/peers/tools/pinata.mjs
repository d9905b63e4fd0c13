// Fractures the mesh by three-pinata: the files of exchange.py. Called as `node pinata.mjs INPUT OUTPUT RUNS`, beside node_modules.

import { readFileSync, writeFileSync } from "node:fs";
import { DestructibleMesh, FractureOptions } from "@dgreenheck/three-pinata";
import * as THREE from "three";

const LIMIT_MS = 30_000;
const [input, output, runs] = process.argv.slice(2);

function readMesh(path) {
  const data = readFileSync(path);
  const [vertices, triangles] = [data.readUInt32LE(4), data.readUInt32LE(8)];
  const positions = Float32Array.from({ length: 3 * vertices }, (_, at) => data.readDoubleLE(12 + 8 * at));
  const start = 12 + 24 * vertices;
  const indices = Uint32Array.from({ length: 3 * triangles }, (_, at) => data.readUInt32LE(start + 4 * at));
  return [positions, indices];
}

function readSites(path) {
  const data = readFileSync(path);
  const at = (site, axis) => data.readDoubleLE(4 + 24 * site + 8 * axis);
  return Array.from({ length: data.readUInt32LE(0) }, (_, site) => new THREE.Vector3(at(site, 0), at(site, 1), at(site, 2)));
}

function writeMeshes(path, meshes) {
  const header = (...values) => Buffer.from(Uint32Array.from(values).buffer);
  const parts = [header(meshes.length)];
  for (const { geometry, matrixWorld } of meshes) {
    const source = geometry.attributes.position;
    const positions = new Float64Array(3 * source.count);
    for (let at = 0; at < source.count; at++) {
      const point = new THREE.Vector3().fromBufferAttribute(source, at).applyMatrix4(matrixWorld);
      positions.set([point.x, point.y, point.z], 3 * at);
    }
    const indices = Uint32Array.from(geometry.index ? geometry.index.array : positions.keys());
    parts.push(header(source.count, indices.length / 3), Buffer.from(positions.buffer), Buffer.from(indices.buffer));
  }
  writeFileSync(path, Buffer.concat(parts));
}

function fracture(positions, indices, sites) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
  geometry.setAttribute("uv", new THREE.BufferAttribute(new Float32Array((positions.length / 3) * 2), 2));
  geometry.setIndex(new THREE.BufferAttribute(indices, 1));
  geometry.computeVertexNormals();
  const material = new THREE.MeshBasicMaterial();
  const mesh = new DestructibleMesh(geometry, material, material);
  const options = new FractureOptions({
    fractureMethod: "voronoi",
    fragmentCount: sites.length,
    voronoiOptions: { mode: "3D", seedPoints: sites, useApproximation: false },
    seed: 1,
  });
  return mesh.fracture(options);
}

const result = { times_ms: [], cpu_ms: [], prepare_ms: 0, note: "" };
try {
  const [positions, indices] = readMesh(`${input}/mesh.bin`);
  const sites = readSites(`${input}/sites.bin`);
  let fragments = [];
  const started = performance.now();
  for (let run = 0; run < Number(runs) && performance.now() - started < LIMIT_MS; run++) {
    const [begun, used] = [performance.now(), process.cpuUsage()];
    fragments = fracture(positions.slice(), indices.slice(), sites);
    result.times_ms.push(performance.now() - begun);
    const { user, system } = process.cpuUsage(used);
    result.cpu_ms.push((user + system) / 1e3);
  }
  fragments.forEach((fragment) => fragment.updateMatrixWorld(true));
  writeMeshes(`${output}/fragments.bin`, fragments);
} catch (error) {
  delete result.times_ms;
  delete result.cpu_ms;
  result.rejected = `${error.message ?? error}`;
}
writeFileSync(`${output}/result.json`, JSON.stringify(result));
