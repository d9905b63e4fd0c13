// Base colors of a glTF file: one layer of a texture for each of its materials, in their order, and one for triangles without a material.

import * as THREE from "three";

/** Most pixels of all layers together: 64 MiB. */
const PIXELS_MAX = 1 << 24;

/** Longest side of a layer, pixels. */
const SIDE_MAX = 2048;

/** The layers of materials; `undefined` stands for one that no triangle uses. Without any texture of base colors there are none. */
export function texturesOf(materials: (THREE.MeshStandardMaterial | undefined)[]): THREE.DataArrayTexture | undefined {
  const images = materials.map((material) => material?.map?.image as TexImageSource | undefined);
  if (images.every((image) => image === undefined)) return undefined;
  const layers = [...materials, undefined];
  const side = Math.min(SIDE_MAX, 2 ** Math.floor(Math.log2(Math.sqrt(PIXELS_MAX / layers.length))));
  const longest = Math.max(...images.map((image) => (image ? longestSide(image) : 1)));
  const size = Math.min(side, 2 ** Math.ceil(Math.log2(longest)));
  const data = new Uint8Array(4 * size * size * layers.length);
  layers.forEach((material, at) => data.set(pixels(material, size), 4 * size * size * at));
  const texture = new THREE.DataArrayTexture(data, size, size, layers.length);
  texture.colorSpace = THREE.SRGBColorSpace;
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.minFilter = THREE.LinearMipmapLinearFilter;
  texture.magFilter = THREE.LinearFilter;
  texture.generateMipmaps = true;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
}

function longestSide(image: TexImageSource): number {
  const { width, height } = image as { width: number; height: number };
  return Math.max(1, width, height);
}

/** The base colors of a material: its texture times its color. */
function pixels(material: THREE.MeshStandardMaterial | undefined, size: number): Uint8ClampedArray {
  const canvas = Object.assign(document.createElement("canvas"), { width: size, height: size });
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context) throw new Error("the browser cannot read the textures of the file");
  const color = `#${(material?.color ?? new THREE.Color("white")).getHexString()}`;
  context.fillStyle = color;
  context.fillRect(0, 0, size, size);
  if (material?.map) {
    context.globalCompositeOperation = color === "#ffffff" ? "source-over" : "multiply";
    context.drawImage(material.map.image as CanvasImageSource, 0, 0, size, size);
  }
  return context.getImageData(0, 0, size, size).data;
}
