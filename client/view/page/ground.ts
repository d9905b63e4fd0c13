// The ground: it shows the shadow alone. Fast frames sample the shadow once per pixel, others as three.js does.

import * as THREE from "three";
import { DETAILED, FAST } from "./layers";

/** Darkness of the shadow. */
const OPACITY = 0.26;

const VERTEX = /* glsl */ `
uniform mat4 uShadowMatrix;
varying vec3 vShadow;
void main() {
  vec4 place = modelMatrix * vec4(position, 1.0);
  vShadow = (uShadowMatrix * place).xyz;
  gl_Position = projectionMatrix * (viewMatrix * place);
}
`;

const FRAGMENT = /* glsl */ `
uniform highp sampler2DShadow uShadow;
varying vec3 vShadow;
void main() {
  bool isInside = all(greaterThan(vShadow, vec3(0.0))) && all(lessThan(vShadow, vec3(1.0)));
  if (!isInside) discard;
  gl_FragColor = vec4(0.0, 0.0, 0.0, ${OPACITY} * (1.0 - texture(uShadow, vShadow)));
}
`;

/** The ground. */
export class Ground {
  /** Both looks, each in its layer. */
  readonly group = new THREE.Group();
  private readonly uniforms: { uShadow: { value: THREE.Texture | null }; uShadowMatrix: { value: THREE.Matrix4 } };

  /** `light` casts the shadow. */
  constructor(private readonly light: THREE.DirectionalLight) {
    this.uniforms = { uShadow: { value: null }, uShadowMatrix: { value: light.shadow.matrix } };
    const circle = new THREE.CircleGeometry(1, 48);
    const detailed = new THREE.Mesh(circle, new THREE.ShadowMaterial({ opacity: OPACITY, depthWrite: false }));
    detailed.receiveShadow = true;
    detailed.layers.set(DETAILED);
    const material = new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, transparent: true, depthWrite: false, uniforms: this.uniforms });
    const fast = new THREE.Mesh(circle, material);
    fast.layers.set(FAST);
    // The shadow map exists once a frame with all details was drawn.
    fast.onBeforeRender = () => (this.uniforms.uShadow.value = this.light.shadow.map?.depthTexture ?? null);
    this.group.add(detailed, fast);
    this.group.rotation.x = -Math.PI / 2;
  }
}
