// Shader text of pieces, shared by all their looks. Each vertex names its piece; two textures hold what differs per piece.

/** Columns of the textures of pieces. */
export const COLUMNS = 256;

/** Declarations of the vertex shader. */
export const VERTEX_HEAD = /* glsl */ `
attribute float piece;
attribute float crack;
attribute vec3 outerNormal;
attribute vec2 skinUv;
attribute float layer;
varying vec3 vSkin;
uniform sampler2D uPlaces;
uniform sampler2D uColors;
uniform float uExplode;
uniform float uCracksOnly;
varying float vCrack;
varying vec3 vPlace;
varying vec4 vPiece;
vec4 placeOf(sampler2D table) {
  int index = int(piece + 0.5);
  return texelFetch(table, ivec2(index % ${COLUMNS}, index / ${COLUMNS}), 0);
}
`;

/** Normals of the input outside, of the result on cracks, where the input has none. */
export const VERTEX_NORMAL = /* glsl */ `
vec3 objectNormal = dot(outerNormal, outerNormal) > 0.0 ? outerNormal : normal;
`;

/** Place of the vertex, and what the fragment shader needs of it. */
export const VERTEX_PLACE = /* glsl */ `
vec4 place = placeOf(uPlaces);
vPiece = placeOf(uColors);
vCrack = crack;
// The v axis of glTF points down, that of sections up.
vSkin = vec3(skinUv.x, 1.0 - skinUv.y, layer);
vPlace = position + place.xyz;
// What is not shown has no area.
bool isShown = place.w > 0.5 && (uCracksOnly < 0.5 || crack > 0.5);
vec3 transformed = isShown ? position + place.xyz * (1.0 + uExplode) : vec3(0.0);
`;

/** Declarations of the fragment shader, and the color of the surface. */
export const FRAGMENT_HEAD = /* glsl */ `
uniform float uMode;
uniform vec3 uBase;
uniform vec3 uDip;
uniform vec3 uCrack;
uniform float uDipHeight;
uniform float uSpeckle;
uniform float uVein;
uniform mediump sampler2DArray uTextures;
uniform float uHasTextures;
varying vec3 vSkin;
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
  if (uHasTextures > 0.5) return texture(uTextures, vSkin).rgb;
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

/** Color of the fragment. */
export const FRAGMENT_COLOR = /* glsl */ `
vec3 ownColor = uMode < 0.5 ? surfaceColor() : vPiece.rgb * (vCrack > 0.5 ? 1.0 : 0.94);
diffuseColor.rgb = mix(ownColor, vec3(1.0, 0.72, 0.3), 0.35 * vPiece.a);
`;
