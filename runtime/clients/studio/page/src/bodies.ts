// Contents of a Stage: particles, shapes, and blocks of voxels.
import {
  BackSide, BoxGeometry, BufferAttribute, BufferGeometry, Color, Data3DTexture, DoubleSide, DynamicDrawUsage, Group, InstancedMesh, LinearFilter, Matrix4, Mesh,
  MeshLambertMaterial, Plane, Points, Quaternion, RGBAFormat, ShaderMaterial, SphereGeometry, SRGBColorSpace, GLSL3, UnsignedByteType, Vector3, Vector4,
} from 'three';

import { rampShader } from './ramp';
import { disposeMesh, sun, type Content } from './stage';
import { lightShader, lightUniforms } from './studio_light';

export interface ParticleTable {
  count: number; box: Vector3;
  position(i: number): Vector3; size(i: number): number; shape(i: number): number; color(i: number): [number, number, number]; isVoid(i: number): boolean;
  scale(i: number): number; orientation(i: number): Quaternion;
}

export function readParticles(data: ArrayBuffer): ParticleTable {
  const words = new Uint32Array(data), floats = new Float32Array(data), count = words[0], stride = words[1] / 4, at = (i: number) => 5 + i * stride;
  const bytes = new Uint8Array(data);
  return {
    count, box: new Vector3(floats[2], floats[3], floats[4]),
    position: i => new Vector3().fromArray(floats, at(i)),
    orientation: i => new Quaternion().fromArray(floats, at(i) + 3),
    scale: i => floats[at(i) + 7], size: i => floats[at(i) + 8], shape: i => words[at(i) + 9],
    color: i => [bytes[4 * (at(i) + 10)], bytes[4 * (at(i) + 10) + 1], bytes[4 * (at(i) + 10) + 2]],
    isVoid: i => bytes[4 * (at(i) + 10) + 3] === 0,
  };
}

export interface ShapeMesh { geometry: BufferGeometry; triangles: number; full: number; colored: boolean }

export function readShapes(data: ArrayBuffer): ShapeMesh[] {
  const words = new Uint32Array(data), floats = new Float32Array(data), out: ShapeMesh[] = [];
  let at = 1;
  const take = (n: number) => (at += n) - n;
  for (let k = 0; k < words[0]; ++k) {
    const [vertices, indices, full, colored] = [words[at], words[at + 1], words[at + 2], words[at + 3]];
    at += 4;
    const geometry = new BufferGeometry();
    for (const name of ['position', 'normal']) {
      const from = take(3 * vertices);
      geometry.setAttribute(name, new BufferAttribute(floats.slice(from, at), 3));
    }
    const from = take(indices);
    geometry.setIndex(new BufferAttribute(words.slice(from, at), 1));
    if (colored) {
      const begin = take(vertices), bytes = new Uint8Array(data, 4 * begin, 4 * vertices), color = new Float32Array(3 * vertices), c = new Color();
      for (let v = 0; v < vertices; ++v) c.setRGB(bytes[4 * v] / 255, bytes[4 * v + 1] / 255, bytes[4 * v + 2] / 255, SRGBColorSpace).toArray(color, 3 * v);
      geometry.setAttribute('color', new BufferAttribute(color, 3));
    }
    out.push({ geometry, triangles: indices / 3, full, colored: !!colored });
  }
  return out;
}

// Where a plane cuts a closed body, the far side shows through. Drawn without light, it looks like the cut.
function cuttable(vertexColors = false): MeshLambertMaterial {
  const material = new MeshLambertMaterial({ side: DoubleSide, vertexColors });
  material.onBeforeCompile = shader => {
    Object.assign(shader.uniforms, lightUniforms(sun));
    shader.fragmentShader = `${lightShader}\n${shader.fragmentShader}`.replace('#include <dithering_fragment>', `#include <dithering_fragment>
      if (surrounding > 0.5) gl_FragColor = linearToOutputTexel(vec4(reflected(diffuseColor.rgb, inverseTransformDirection(normal, viewMatrix), inverseTransformDirection(normalize(vViewPosition), viewMatrix)), 1.0));
      if (!gl_FrontFacing) gl_FragColor = linearToOutputTexel(vec4(diffuseColor.rgb, 1.0));`);
  };
  return material;
}

const dotVertex = `
in float size;
in vec3 color;
uniform float height;
uniform vec4 cut;
out vec3 tint;
void main() {
  vec4 at = modelViewMatrix * vec4(position, 1.0);
  tint = color;
  gl_Position = dot(cut.xyz, position) + cut.w < 0.0 ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * at;
  gl_PointSize = max(0.92 * size * projectionMatrix[1][1] * 0.5 * height / -at.z, 1.0);
}`;
const dotFragment = `
in vec3 tint;
out vec4 shown;
void main() {
  vec2 p = 2.0 * gl_PointCoord - 1.0;
  float r = dot(p, p);
  if (r > 1.0) discard;
  shown = vec4(tint * (0.55 + 0.45 * dot(vec3(p.x, -p.y, sqrt(1.0 - r)), vec3(-0.35, 0.6, 0.72))), 1.0);
}`;
const setCut = (material: ShaderMaterial, plane: Plane | undefined) =>
  (material.uniforms.cut.value as Vector4).set(...(plane ? [plane.normal.x, plane.normal.y, plane.normal.z, plane.constant] : [0, 0, 0, 1]) as [number, number, number, number]);

export interface Bodies extends Content {
  // Which particle an instance of a mesh is.
  particleOf(object: unknown, instance: number): number;
  // Colors particles by a weight from 0 to 1, or as they are.
  weigh(weights: Float32Array | null): void;
}

// All particles, as instances of their shapes, or of spheres of their size.
export function particleBodies(p: ParticleTable, shapes: ShapeMesh[] | null): Bodies {
  const object = new Group(), meshes: { mesh: InstancedMesh; of: number[] }[] = [];
  const material = cuttable(), sphere = shapes ? null : new SphereGeometry(0.5, 14, 10);
  const members = new Map<number, number[]>();
  for (let i = 0; i < p.count; ++i) {
    if (p.isVoid(i)) continue;
    const s = shapes ? p.shape(i) : 0;
    if (!members.has(s)) members.set(s, []);
    members.get(s)!.push(i);
  }
  const matrix = new Matrix4(), color = new Color(), scale = new Vector3();
  for (const [s, of] of members) {
    const geometry = sphere ?? shapes![s]?.geometry;
    if (!geometry) continue;
    const mesh = new InstancedMesh(geometry, material, of.length);
    of.forEach((i, k) => mesh.setMatrixAt(k, matrix.compose(p.position(i), p.orientation(i), scale.setScalar(sphere ? p.size(i) : p.scale(i)))));
    mesh.frustumCulled = false;
    object.add(mesh);
    meshes.push({ mesh, of });
  }
  // Discs, shaded like spheres, which are drawn while the view moves on slow machines.
  const solid = [...members.values()].flat(), places = new Float32Array(3 * solid.length), sizes = new Float32Array(solid.length);
  solid.forEach((i, k) => { p.position(i).toArray(places, 3 * k); sizes[k] = p.size(i); });
  const dots = new BufferGeometry();
  dots.setAttribute('position', new BufferAttribute(places, 3)).setAttribute('size', new BufferAttribute(sizes, 1)).setAttribute('color', new BufferAttribute(new Float32Array(3 * solid.length), 3));
  const dotMaterial = new ShaderMaterial({ glslVersion: GLSL3, vertexShader: dotVertex, fragmentShader: dotFragment, uniforms: { cut: { value: new Vector4(0, 0, 0, 1) }, height: { value: 1 } } });
  const points = new Points(dots, dotMaterial);
  points.visible = false, points.frustumCulled = false;
  points.onBeforeRender = renderer => { dotMaterial.uniforms.height.value = renderer.domElement.height; dotMaterial.uniformsNeedUpdate = true; };
  object.add(points);
  const weigh = (weights: Float32Array | null) => {
    const rgb = dots.getAttribute('color') as BufferAttribute;
    solid.forEach((i, k) => {
      const c = weights ? [64 + 25 * weights[i], 66 + 90 * weights[i], 71 + 178 * weights[i]] : p.color(i);
      rgb.setXYZ(k, c[0] / 255, c[1] / 255, c[2] / 255);
    });
    rgb.needsUpdate = true;
    for (const { mesh, of } of meshes) {
      of.forEach((i, k) => {
        const [r, g, b] = p.color(i);
        if (!weights) color.setRGB(r / 255, g / 255, b / 255, SRGBColorSpace);
        else color.setRGB(0.25 + 0.1 * weights[i], 0.26 + 0.35 * weights[i], 0.28 + 0.7 * weights[i], SRGBColorSpace);
        mesh.setColorAt(k, color);
      });
      mesh.instanceColor!.setUsage(DynamicDrawUsage).needsUpdate = true;
    }
  };
  weigh(null);
  return {
    object, box: p.box, weigh,
    particleOf: (o, k) => meshes.find(m => m.mesh === o)?.of[k] ?? -1,
    cut: planes => { material.clippingPlanes = planes; setCut(dotMaterial, planes[0]); },
    coarse(on) { points.visible = on; meshes.forEach(m => { m.mesh.visible = !on; }); },
    dispose() {
      dots.dispose(), dotMaterial.dispose();
      meshes.forEach(m => { m.mesh.dispose(); if (!shapes) m.mesh.geometry.dispose(); });
      material.dispose();
    },
  };
}

// Shapes beside each other, in rows.
export function shapeBodies(shapes: ShapeMesh[]): Content & { shapeOf(o: unknown): number } {
  const object = new Group(), columns = Math.ceil(Math.sqrt(shapes.length)), meshes: Mesh[] = [];
  const sizes = shapes.map(s => { s.geometry.computeBoundingSphere(); return s.geometry.boundingSphere!.radius; });
  const cell = 2.3 * Math.max(...sizes, 1e-6), rows = Math.ceil(shapes.length / columns);
  const plain = cuttable(), colored = cuttable(true);
  plain.color.set(0xb9a88f);
  shapes.forEach((s, k) => {
    const mesh = new Mesh(s.geometry, s.colored ? colored : plain);
    mesh.position.set((k % columns + 0.5) * cell, (rows - Math.floor(k / columns) - 0.5) * cell, cell / 2);
    object.add(mesh);
    meshes.push(mesh);
  });
  return {
    object, box: new Vector3(columns * cell, rows * cell, cell), shapeOf: o => meshes.indexOf(o as Mesh),
    cut: planes => { plain.clippingPlanes = colored.clippingPlanes = planes; },
    dispose() { meshes.forEach(m => m.geometry.dispose()); plain.dispose(); colored.dispose(); },
  };
}

const blockVertex = `
out vec3 at;
void main() {
  at = position;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;
const blockFragment = `
precision highp sampler3D;${rampShader}${lightShader}
uniform bool quantity; // grays are values
uniform sampler3D voxels;
uniform vec3 edges, texel, eye;
uniform vec4 cut;      // what has dot(cut.xyz, p) + cut.w < 0 is hidden
uniform float level, stride; // level 0: the block is opaque
in vec3 at;
out vec4 color;
vec4 read(vec3 p) { return texture(voxels, p / edges); }
void main() {
  vec3 d = normalize(at - eye), a = -eye / d, b = (edges - eye) / d;
  vec3 near3 = min(a, b), far3 = max(a, b);
  float t0 = max(max(near3.x, near3.y), max(near3.z, 0.0)), t1 = min(far3.x, min(far3.y, far3.z));
  vec3 face = near3.x >= max(near3.y, near3.z) ? vec3(1, 0, 0) : near3.y >= near3.z ? vec3(0, 1, 0) : vec3(0, 0, 1);
  vec3 normal = -sign(d) * face;
  bool plain = false; // the cut, which shows its colors
  float light = dot(face, vec3(0.86, 0.94, 1.0));
  float s = dot(cut.xyz, eye) + cut.w, ds = dot(cut.xyz, d);
  if (ds > 0.0 && -s / ds > t0) { t0 = -s / ds; light = 1.0; plain = true; }
  if (ds < 0.0) t1 = min(t1, -s / ds);
  if (ds == 0.0 && s < 0.0) discard;
  if (t0 >= t1) discard;
  vec3 p = eye + t0 * d;
  vec4 c = read(p);
  if (level > 0.0 && c.a < level) {
    float t = t0;
    bool found = false;
    for (int k = 0; k < 700 && t < t1; ++k, t += stride) if (read(eye + t * d).a >= level) { found = true; break; }
    if (!found) discard;
    float lo = t - stride;
    for (int k = 0; k < 5; ++k) { float m = 0.5 * (lo + t); if (read(eye + m * d).a >= level) t = m; else lo = m; }
    p = eye + t * d;
    c = read(p);
    vec3 n = vec3(read(p - vec3(texel.x, 0, 0)).a - read(p + vec3(texel.x, 0, 0)).a, read(p - vec3(0, texel.y, 0)).a - read(p + vec3(0, texel.y, 0)).a,
      read(p - vec3(0, 0, texel.z)).a - read(p + vec3(0, 0, texel.z)).a);
    float l = length(n);
    plain = false;
    if (l > 0.0) normal = n / l;
    light = l > 0.0 ? 0.42 + 0.62 * max(dot(n / l, sun), 0.0) : 0.8;
  }
  if (surrounding > 0.5 && !quantity && !plain) { color = vec4(pow(min(reflected(pow(c.rgb, vec3(2.2)), normal, -d), 1.0), vec3(1.0 / 2.2)), 1.0); return; }
  color = vec4((quantity ? ramp(c.r) : c.rgb) * light, 1.0);
}`;

// A block of voxels. level: 0 shows all of it; above, what has at least that much alpha. quantity: grays are values.
export function voxelBlock(data: ArrayBuffer, edges: Vector3, quantity = false): Content & { setLevel(level: number): void; factor: number } {
  const [width, height, depth, factor] = new Uint32Array(data, 0, 4);
  const texture = new Data3DTexture(new Uint8Array(data, 16), width, height, depth);
  texture.format = RGBAFormat, texture.type = UnsignedByteType, texture.unpackAlignment = 1;
  texture.minFilter = texture.magFilter = LinearFilter;
  texture.needsUpdate = true;
  const texel = new Vector3(edges.x / width, edges.y / height, edges.z / depth);
  const material = new ShaderMaterial({
    glslVersion: GLSL3, vertexShader: blockVertex, fragmentShader: blockFragment, side: BackSide,
    uniforms: {
      voxels: { value: texture }, edges: { value: edges }, texel: { value: texel }, eye: { value: new Vector3() }, cut: { value: new Vector4(0, 0, 0, 1) },
      ...lightUniforms(sun), quantity: { value: quantity }, level: { value: 0 }, stride: { value: 0.8 * Math.min(texel.x, texel.y, texel.z) },
    },
  });
  const mesh = new Mesh(new BoxGeometry(edges.x, edges.y, edges.z).translate(edges.x / 2, edges.y / 2, edges.z / 2), material);
  mesh.onBeforeRender = (_r, _s, camera) => { material.uniforms.eye.value.setFromMatrixPosition(camera.matrixWorld); material.uniformsNeedUpdate = true; };
  return {
    object: mesh, box: edges, factor,
    setLevel: level => { material.uniforms.level.value = level; },
    cut([plane]: Plane[]) { setCut(material, plane); },
    coarse(on) { material.uniforms.stride.value = (on ? 2.4 : 0.8) * Math.min(texel.x, texel.y, texel.z); },
    dispose() { texture.dispose(); disposeMesh(mesh); },
  };
}
