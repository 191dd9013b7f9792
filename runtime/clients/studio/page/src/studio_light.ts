// What lights solids in three dimensions: a lamp, or a surrounding that is computed, which surfaces reflect as their roughness lets them.
import type { Vector3 } from 'three';

import { keep, kept } from './kept';

const last = kept('light');
export const surroundings = ['Lamp', 'Studio', 'Sky'];
// Uniforms that all materials share.
export const look = { surrounding: { value: surroundings[last.surrounding] ? last.surrounding : 0 }, roughness: { value: Math.min(last.roughness ?? 0.5, 1) } };

export function setLook(surrounding: number, roughness: number) {
  look.surrounding.value = surrounding, look.roughness.value = roughness;
  keep('light', { surrounding, roughness });
}

export const lightUniforms = (sun: Vector3) => ({ ...look, sun: { value: sun } });

// reflected(): a surface of a linear color, with its normal and the direction to the eye, in a surrounding other than the lamp.
export const lightShader = `
uniform float surrounding, roughness;
uniform vec3 sun;
vec3 around(vec3 d, float rough) { // what comes from a direction, blurred
  float blur = 0.03 + rough, up = smoothstep(-blur, blur, d.z), sharp = 2.0 / (rough * rough * rough + 0.002), lamp = pow(max(dot(d, sun), 0.0), sharp);
  if (surrounding > 1.5) return mix(vec3(0.22, 0.19, 0.15), mix(vec3(0.75, 0.82, 0.9), vec3(0.25, 0.45, 0.85), max(d.z, 0.0)), up) + (0.5 + 0.06 * sharp) * vec3(1.0, 0.93, 0.8) * lamp;
  vec3 side = normalize(vec3(-sun.x, -sun.y, 0.4));
  float panel = smoothstep(0.55 - blur, 0.55 + blur, dot(d, sun)), fill = smoothstep(0.75 - blur, 0.75 + blur, dot(d, side));
  return mix(vec3(0.14), vec3(0.42), up) + 2.2 * panel + 0.7 * fill;
}
vec3 reflected(vec3 color, vec3 n, vec3 eye) {
  float fresnel = 0.04 + 0.9 * (1.0 - 0.8 * roughness) * pow(1.0 - clamp(dot(n, eye), 0.0, 1.0), 5.0);
  vec3 diffuse = color * (0.35 * around(n, 1.0) + 0.7 * max(dot(n, sun), 0.0) + 0.08);
  return mix(diffuse, around(reflect(-eye, n), roughness), fresnel);
}`;
