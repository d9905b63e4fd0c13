// A mesh file of the user: read in the page for the preview, then baked by the service.

import * as THREE from "three";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { OBJLoader } from "three/examples/jsm/loaders/OBJLoader.js";
import { PLYLoader } from "three/examples/jsm/loaders/PLYLoader.js";
import { STLLoader } from "three/examples/jsm/loaders/STLLoader.js";
import type { TriangleMesh } from "./defects";
import { damaged, endingOf, problemOf } from "./mesh_check";
import { texturesOf } from "./textures";

/** A mesh file as it is shown. */
export interface Preview {
  shown: THREE.Object3D;
  mesh: TriangleMesh;
  /** Base colors by material, if the file has textures of them. */
  textures: THREE.DataArrayTexture | undefined;
}

/** Reads a mesh file; `undefined` for formats that only the service reads. */
export async function readMesh(name: string, contents: ArrayBuffer): Promise<Preview | undefined> {
  const ending = endingOf(name);
  const problem = problemOf(ending, contents);
  if (problem) throw new Error(problem);
  // The message of a parser names its own variables.
  const parsed = await parse(ending, contents).catch(() => {
    throw new Error(damaged(ending));
  });
  if (!parsed) return undefined;
  const { shown, materials } = parsed;
  shown.updateMatrixWorld(true);
  const mesh = triangles(shown);
  if (mesh.indices.length === 0) throw new Error("it has no triangles");
  requireNumbers(mesh.positions);
  return { shown, mesh, textures: texturesOf(materials) };
}

/** Refuses coordinates that are infinite or not a number: nothing can be shown of them, and the bake refuses them, too. */
function requireNumbers(positions: Float32Array): void {
  if (positions.every((value) => Number.isFinite(value))) return;
  throw new Error("a vertex has a coordinate that is infinite or not a number; correct it, or export the mesh again");
}

/** A mesh file, and the materials that its triangles use, by their numbers in the file. */
interface ParsedFile {
  shown: THREE.Object3D;
  materials: (THREE.MeshStandardMaterial | undefined)[];
}

async function parse(ending: string, contents: ArrayBuffer): Promise<ParsedFile | undefined> {
  const clay = () => new THREE.MeshStandardMaterial({ color: "#d9d4ca", roughness: 0.8, side: THREE.DoubleSide });
  const plain = (geometry: THREE.BufferGeometry) => {
    if (!geometry.getAttribute("position")) throw new Error("no vertices");
    if (!geometry.getAttribute("normal")) geometry.computeVertexNormals();
    const material = clay();
    material.vertexColors = geometry.hasAttribute("color");
    return { shown: new THREE.Mesh(geometry, material), materials: [] };
  };
  switch (ending) {
    case "stl":
      return plain(new STLLoader().parse(contents));
    case "ply":
      return plain(new PLYLoader().parse(contents));
    case "obj": {
      const group = new OBJLoader().parse(new TextDecoder().decode(contents));
      group.traverse((part) => {
        if (part instanceof THREE.Mesh) part.material = clay();
      });
      return { shown: group, materials: [] };
    }
    case "glb":
    case "gltf":
      return gltf(contents);
    default:
      return undefined;
  }
}

async function gltf(contents: ArrayBuffer): Promise<ParsedFile> {
  const { scene, parser } = await new GLTFLoader().parseAsync(contents, "");
  const listed = (parser.json as { materials?: unknown[] }).materials ?? [];
  const materials = new Array<THREE.MeshStandardMaterial | undefined>(listed.length).fill(undefined);
  for (const part of meshes(scene)) {
    const material = part.material as THREE.MeshStandardMaterial;
    const number = parser.associations.get(material)?.materials;
    if (number !== undefined) materials[number] = material;
  }
  return { shown: scene, materials };
}

function meshes(shown: THREE.Object3D): THREE.Mesh[] {
  const found: THREE.Mesh[] = [];
  shown.traverse((part) => {
    if (part instanceof THREE.Mesh) found.push(part);
  });
  return found;
}

/** All triangles, in the axes of the file. */
function triangles(shown: THREE.Object3D): TriangleMesh {
  const [positions, indices]: [number[], number[]] = [[], []];
  const point = new THREE.Vector3();
  for (const part of meshes(shown)) {
    const geometry = part.geometry as THREE.BufferGeometry;
    const given = geometry.getAttribute("position");
    const first = positions.length / 3;
    for (let at = 0; at < given.count; at++) {
      point.fromBufferAttribute(given, at).applyMatrix4(part.matrixWorld);
      positions.push(point.x, point.y, point.z);
    }
    const order = geometry.getIndex();
    for (let at = 0; at < (order?.count ?? given.count); at++) indices.push(first + (order ? order.getX(at) : at));
  }
  return { positions: new Float32Array(positions), indices: new Uint32Array(indices) };
}
