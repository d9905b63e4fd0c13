// Shading of pieces: one draw call for all pieces of a result. Each vertex names its piece; two textures hold what differs per piece.

import * as THREE from "three";

/** Columns of the textures of pieces. */
export const COLUMNS = 256;

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
  /** Texture of base colors of the input, and whether there is one. */
  uMap: { value: THREE.Texture | null };
  uHasMap: { value: number };
  /** Height of the lowest point and of the object, m, and the length of its diagonal. */
  uBounds: { value: THREE.Vector3 };
}

/** The values of an object: `bounds` are relative to its center. */
export function uniformsOf(material: string, low: number, height: number, diagonal: number): { uniforms: PieceUniforms; roughness: number } {
  const look = LOOKS[material] ?? PLAIN;
  const uniforms = {
    uExplode: { value: 0 },
    uMode: { value: 0 },
    uCracksOnly: { value: 0 },
    uBase: { value: new THREE.Color(look.base) },
    uDip: { value: new THREE.Color(look.dip) },
    uCrack: { value: new THREE.Color(look.crack) },
    uDipHeight: { value: look.dipHeight },
    uSpeckle: { value: look.speckle },
    uVein: { value: look.vein },
    uMap: { value: null },
    uHasMap: { value: 0 },
    uBounds: { value: new THREE.Vector3(low, height, diagonal) },
  };
  return { uniforms, roughness: look.roughness };
}

const VERTEX_HEAD = /* glsl */ `
attribute float piece;
attribute float crack;
attribute vec3 outerNormal;
attribute vec2 skinUv;
varying vec2 vSkinUv;
uniform sampler2D uPlaces;
uniform sampler2D uColors;
uniform float uExplode;
varying float vCrack;
varying vec3 vPlace;
varying vec4 vPiece;
vec4 placeOf(sampler2D table) {
  int index = int(piece + 0.5);
  return texelFetch(table, ivec2(index % ${COLUMNS}, index / ${COLUMNS}), 0);
}
`;

/** Normals of the input outside, of the result on cracks, where the input has none. */
const VERTEX_NORMAL = /* glsl */ `
vec3 objectNormal = dot(outerNormal, outerNormal) > 0.0 ? outerNormal : normal;
`;

const VERTEX_PLACE = /* glsl */ `
vec4 place = placeOf(uPlaces);
vPiece = placeOf(uColors);
vCrack = crack;
vSkinUv = skinUv;
vPlace = position + place.xyz;
vec3 transformed = place.w > 0.5 ? position + place.xyz * (1.0 + uExplode) : vec3(0.0);
`;

const FRAGMENT_HEAD = /* glsl */ `
uniform float uMode;
uniform float uCracksOnly;
uniform vec3 uBase;
uniform vec3 uDip;
uniform vec3 uCrack;
uniform float uDipHeight;
uniform float uSpeckle;
uniform float uVein;
uniform sampler2D uMap;
uniform float uHasMap;
varying vec2 vSkinUv;
uniform vec3 uBounds;
varying float vCrack;
varying vec3 vPlace;
varying vec4 vPiece;
float hash3(vec3 p) {
  p = fract(p * vec3(0.1031, 0.1030, 0.0973));
  p += dot(p, p.yxz + 33.33);
  return fract((p.x + p.y) * p.z);
}
float noise3(vec3 p) {
  vec3 i = floor(p), f = fract(p);
  f = f * f * (3.0 - 2.0 * f);
  vec2 e = vec2(0.0, 1.0);
  return mix(
    mix(mix(hash3(i), hash3(i + e.yxx), f.x), mix(hash3(i + e.xyx), hash3(i + e.yyx), f.x), f.y),
    mix(mix(hash3(i + e.xxy), hash3(i + e.yxy), f.x), mix(hash3(i + e.xyy), hash3(i + e.yyy), f.x), f.y), f.z);
}
vec3 surfaceColor() {
  vec3 p = vPlace / uBounds.z;
  if (vCrack > 0.5) return uCrack * (0.88 + 0.24 * noise3(p * 90.0));
  // The v axis of glTF points down, that of sections up.
  if (uHasMap > 0.5) return texture2D(uMap, vec2(vSkinUv.x, 1.0 - vSkinUv.y)).rgb;
  float grain = noise3(p * 160.0);
  float height = (vPlace.y - uBounds.x) / uBounds.y;
  float edge = uDipHeight + 0.035 * (noise3(p * 9.0) - 0.5) + 0.012 * (noise3(p * 31.0) - 0.5);
  float dipped = uDipHeight > 0.0 ? 1.0 - smoothstep(edge - 0.006, edge + 0.006, height) : 0.0;
  float rim = uDipHeight > 0.0 ? 1.0 - smoothstep(0.0, 0.028, abs(height - edge)) : 0.0;
  vec3 color = mix(uBase, mix(uDip, uDip * 1.55 + 0.02, rim), dipped);
  float dots = smoothstep(0.74, 0.86, grain) * (1.0 - dipped * 0.6);
  color *= 1.0 - uSpeckle * 2.2 * dots;
  color *= 1.0 - uSpeckle * 0.5 * (noise3(p * 40.0) - 0.5);
  float vein = 1.0 - smoothstep(0.0, 0.09, abs(noise3(p * 7.0 + 1.6 * noise3(p * 13.0)) - 0.5));
  return mix(color, color * 0.62, uVein * vein);
}
`;

const FRAGMENT_COLOR = /* glsl */ `
if (uCracksOnly > 0.5 && vCrack < 0.5) discard;
vec3 ownColor = uMode < 0.5 ? surfaceColor() : vPiece.rgb * (vCrack > 0.5 ? 1.0 : 0.94);
diffuseColor.rgb = mix(ownColor, vec3(1.0, 0.72, 0.3), 0.35 * vPiece.a);
`;

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
export function solidMaterial(
  uniforms: PieceUniforms,
  roughness: number,
  places: THREE.DataTexture,
  colors: THREE.DataTexture,
): THREE.MeshStandardMaterial {
  // Pieces are closed: their insides are never seen.
  const material = new THREE.MeshStandardMaterial({ roughness, side: THREE.FrontSide, shadowSide: THREE.DoubleSide });
  patched(material, uniforms, places, colors, true);
  return material;
}

/** A look through which the inner cracks are seen. */
export function xrayMaterial(uniforms: PieceUniforms, places: THREE.DataTexture, colors: THREE.DataTexture): THREE.Material {
  const material = new THREE.MeshLambertMaterial({ transparent: true, depthWrite: false, side: THREE.DoubleSide });
  material.userData["isXray"] = true;
  patched(material, uniforms, places, colors, true);
  return material;
}

/** What casts the shadow of pieces. */
export function shadowMaterial(uniforms: PieceUniforms, places: THREE.DataTexture, colors: THREE.DataTexture): THREE.Material {
  const material = new THREE.MeshDepthMaterial({ depthPacking: THREE.RGBADepthPacking });
  patched(material, uniforms, places, colors, false);
  return material;
}
