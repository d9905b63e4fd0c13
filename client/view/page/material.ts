// Looks of pieces: one draw call for all pieces of a result.

import * as THREE from "three";
import type { StageLight } from "./fast_material";
import { FRAGMENT_COLOR, FRAGMENT_HEAD, VERTEX_HEAD, VERTEX_NORMAL, VERTEX_PLACE } from "./piece_shader";

/** What is drawn. */
export type ColorMode = "surface" | "pieces" | "energy" | "bonds";

/** Look of a material of the service. */
interface Look {
  base: string;
  dip: string;
  crack: string;
  /** Share of the height below which the object is dipped in the second color. */
  dipHeight: number;
  speckle: number;
  vein: number;
  roughness: number;
}

const PLAIN: Look = { base: "#dcd9d2", dip: "#dcd9d2", crack: "#a89f94", dipHeight: 0, speckle: 0.05, vein: 0, roughness: 0.75 };

const LOOKS: Record<string, Look> = {
  ceramic: { base: "#efe9dd", dip: "#1d5f74", crack: "#c98d6b", dipHeight: 0.56, speckle: 0.05, vein: 0, roughness: 0.3 },
  terracotta: { base: "#c0673f", dip: "#e9d8bf", crack: "#8f4426", dipHeight: 0.35, speckle: 0.14, vein: 0, roughness: 0.85 },
  glass: { base: "#a9cfd0", dip: "#a9cfd0", crack: "#e3f3f1", dipHeight: 0, speckle: 0, vein: 0, roughness: 0.12 },
  ice: { base: "#cfe6f2", dip: "#cfe6f2", crack: "#f4fbff", dipHeight: 0, speckle: 0.02, vein: 0.25, roughness: 0.2 },
  stone: { base: "#9c978d", dip: "#9c978d", crack: "#77726a", dipHeight: 0, speckle: 0.32, vein: 0, roughness: 0.9 },
  concrete: { base: "#b4b3ae", dip: "#b4b3ae", crack: "#8a8883", dipHeight: 0, speckle: 0.22, vein: 0, roughness: 0.92 },
  marble: { base: "#ecebe8", dip: "#ecebe8", crack: "#d7d3cb", dipHeight: 0, speckle: 0.02, vein: 0.75, roughness: 0.35 },
  plaster: { base: "#f0ede6", dip: "#f0ede6", crack: "#d8cdbb", dipHeight: 0, speckle: 0.04, vein: 0, roughness: 0.95 },
};

/** Values that the shader reads; shared by all results of an object. */
export interface PieceUniforms {
  uExplode: { value: number };
  uMode: { value: number };
  uCracksOnly: { value: number };
  uBase: { value: THREE.Color };
  uDip: { value: THREE.Color };
  uCrack: { value: THREE.Color };
  uDipHeight: { value: number };
  uSpeckle: { value: number };
  uVein: { value: number };
  /** Base colors of the input by material, and whether there are some. */
  uTextures: { value: THREE.DataArrayTexture | null };
  uHasTextures: { value: number };
  /** Height of the lowest point and of the object, m, and the length of its diagonal. */
  uBounds: { value: THREE.Vector3 };
}

/** How the pieces of an object look. */
export interface PieceLook {
  uniforms: PieceUniforms;
  roughness: number;
  light: StageLight;
}

/** Names of the generated vessels, which are dipped in a second color. */
const DIPPED = /^(mug|vase)(-|$)/;

/** The look of an object: `low` is its lowest height relative to its center. */
export function lookOf(object: { name: string; material: string }, low: number, height: number, diagonal: number, light: StageLight): PieceLook {
  const look = LOOKS[object.material] ?? PLAIN;
  const uniforms = {
    uExplode: { value: 0 },
    uMode: { value: 0 },
    uCracksOnly: { value: 0 },
    uBase: { value: new THREE.Color(look.base) },
    uDip: { value: new THREE.Color(look.dip) },
    uCrack: { value: new THREE.Color(look.crack) },
    uDipHeight: { value: DIPPED.test(object.name) ? look.dipHeight : 0 },
    uSpeckle: { value: look.speckle },
    uVein: { value: look.vein },
    uTextures: { value: null },
    uHasTextures: { value: 0 },
    uBounds: { value: new THREE.Vector3(low, height, diagonal) },
  };
  return { uniforms, roughness: look.roughness, light };
}

function patched(
  material: THREE.Material,
  uniforms: PieceUniforms,
  places: THREE.DataTexture,
  colors: THREE.DataTexture,
  hasColors: boolean,
): void {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms, { uPlaces: { value: places }, uColors: { value: colors } });
    shader.vertexShader = shader.vertexShader
      .replace("#include <common>", `#include <common>\n${VERTEX_HEAD}`)
      .replace("#include <beginnormal_vertex>", VERTEX_NORMAL)
      .replace("#include <begin_vertex>", VERTEX_PLACE);
    if (!hasColors) return;
    shader.fragmentShader = shader.fragmentShader
      .replace("#include <common>", `#include <common>\n${FRAGMENT_HEAD}`)
      .replace("#include <color_fragment>", `#include <color_fragment>\n${FRAGMENT_COLOR}`);
    if (material.userData["isXray"]) {
      shader.fragmentShader = shader.fragmentShader.replace(
        "#include <opaque_fragment>",
        `#include <opaque_fragment>
        float facing = abs(dot(normalize(vNormal), normalize(vViewPosition)));
        gl_FragColor.a = vCrack > 0.5 ? 0.34 : 0.06 + 0.5 * pow(1.0 - facing, 2.5);`,
      );
    }
  };
  material.customProgramCacheKey = () => `piece-${hasColors}-${material.userData["isXray"] === true}`;
}

/** The solid look of pieces. */
export function solidMaterial(look: PieceLook, places: THREE.DataTexture, colors: THREE.DataTexture): THREE.Material {
  // Pieces are closed: their insides are never seen.
  const material = new THREE.MeshStandardMaterial({ roughness: look.roughness, side: THREE.FrontSide, shadowSide: THREE.DoubleSide });
  patched(material, look.uniforms, places, colors, true);
  return material;
}

/** A look through which the inner cracks are seen. */
export function xrayMaterial(look: PieceLook, places: THREE.DataTexture, colors: THREE.DataTexture): THREE.Material {
  const material = new THREE.MeshLambertMaterial({ transparent: true, depthWrite: false, side: THREE.DoubleSide });
  material.userData["isXray"] = true;
  patched(material, look.uniforms, places, colors, true);
  return material;
}

/** What casts the shadow of pieces. */
export function shadowMaterial(look: PieceLook, places: THREE.DataTexture, colors: THREE.DataTexture): THREE.Material {
  const material = new THREE.MeshDepthMaterial({ depthPacking: THREE.RGBADepthPacking });
  patched(material, look.uniforms, places, colors, false);
  return material;
}
