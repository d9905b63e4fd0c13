// The look of pieces while something moves and the renderer is slow: light per vertex, and no shadow on pieces.

import * as THREE from "three";
import type { PieceLook } from "./material";
import { FRAGMENT_COLOR, FRAGMENT_HEAD, VERTEX_HEAD, VERTEX_NORMAL, VERTEX_PLACE } from "./piece_shader";

/** Light of the stage that reaches a vertex, divided by π. */
export interface StageLight {
  uKeyDirection: { value: THREE.Vector3 };
  uKeyColor: { value: THREE.Color };
  uFillDirection: { value: THREE.Vector3 };
  uFillColor: { value: THREE.Color };
  uAmbient: { value: number };
}

/**
 * Light per vertex: two directional lights (Lambert), and the environment as spherical harmonics of degree two (Ramamoorthi and Hanrahan
 * 2001). Its coefficients are those of three.js's RoomEnvironment by LightProbeGenerator, a cube of 128 pixels. The highlight is Blinn's.
 */
const VERTEX_LIGHT = /* glsl */ `
uniform vec3 uKeyDirection;
uniform vec3 uKeyColor;
uniform vec3 uFillDirection;
uniform vec3 uFillColor;
uniform float uAmbient;
uniform float uHighlight;
varying vec3 vLight;
varying float vHighlight;
void lightAt(vec3 n, vec3 place) {
  // Of crack faces alone, both sides are seen.
  if (uCracksOnly > 0.5 && dot(n, cameraPosition - place) < 0.0) n = -n;
  float ambient = 0.9598 + dot(vec3(0.0896, 0.5717, 0.5335), n) + 0.0587 * n.x * n.y + 0.2975 * n.y * n.z - 0.0952 * n.x * n.z
    + 0.2894 * n.z * n.z - 0.0834 * (n.x * n.x - n.y * n.y);
  vLight = uAmbient * ambient + uKeyColor * max(0.0, dot(n, uKeyDirection)) + uFillColor * max(0.0, dot(n, uFillDirection));
  float facing = max(0.0, dot(n, normalize(uKeyDirection + normalize(cameraPosition - place))));
  vHighlight = uHighlight * (0.02 + pow(facing, 40.0));
}
`;

const VERTEX = /* glsl */ `
${VERTEX_HEAD}
${VERTEX_LIGHT}
void main() {
  ${VERTEX_NORMAL}
  ${VERTEX_PLACE}
  lightAt(normalize(objectNormal), transformed);
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(transformed, 1.0));
}
`;

const FRAGMENT = /* glsl */ `
${FRAGMENT_HEAD}
varying vec3 vLight;
varying float vHighlight;
void main() {
  vec4 diffuseColor = vec4(1.0);
  ${FRAGMENT_COLOR}
  gl_FragColor = vec4(diffuseColor.rgb * vLight + vHighlight, 1.0);
  #include <tonemapping_fragment>
  #include <colorspace_fragment>
}
`;

/** The fast look of pieces. */
export function fastMaterial(look: PieceLook, places: THREE.DataTexture, colors: THREE.DataTexture): THREE.Material {
  const own = { uPlaces: { value: places }, uColors: { value: colors }, uHighlight: { value: 1 - look.roughness } };
  const uniforms = { ...look.uniforms, ...look.light, ...own };
  return new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, uniforms });
}
