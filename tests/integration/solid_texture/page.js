import * as THREE from 'three';
import { KTX2Loader } from 'three/addons/loaders/KTX2Loader.js';

const renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
document.body.style.margin = 0;
document.body.append(renderer.domElement);
const library = await (await fetch('/shader.glsl')).text();
const { size, origin, right, up, columns, rows } = await (await fetch('/points.json')).json();

const slices = await new THREE.TextureLoader().loadAsync('/solid.png');
slices.flipY = false;
slices.generateMipmaps = false;
slices.minFilter = slices.magFilter = THREE.NearestFilter;
slices.colorSpace = THREE.SRGBColorSpace;
const solid = await new KTX2Loader().detectSupport(renderer).loadAsync('/solid.ktx2');
solid.wrapS = solid.wrapT = solid.wrapR = THREE.RepeatWrapping;
solid.minFilter = solid.magFilter = THREE.LinearFilter;

const uniforms = {
  slices: { value: slices }, solid: { value: solid }, size: { value: size },
  origin: { value: new THREE.Vector3(...origin) }, right: { value: new THREE.Vector3(...right) }, up: { value: new THREE.Vector3(...up) },
};

// One value for each pixel of a picture of columns × rows, as floats.
function values(expression) {
  const material = new THREE.RawShaderMaterial({  // declares nothing, so the library must compile alone
    glslVersion: THREE.GLSL3,
    uniforms,
    vertexShader: 'in vec3 position; in vec2 uv; out vec2 at; void main() { at = uv; gl_Position = vec4(position.xy, 0, 1); }',
    fragmentShader: `${library}
      uniform sampler2D slices; uniform sampler3D solid; uniform ivec3 size; uniform vec3 origin, right, up; in vec2 at; out vec4 color;
      void main() { vec3 p = origin + at.x * right + at.y * up; color = ${expression}; }`,
  });
  const scene = new THREE.Scene().add(new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material));
  const target = new THREE.WebGLRenderTarget(columns, rows, { type: THREE.FloatType, colorSpace: THREE.LinearSRGBColorSpace });
  renderer.setRenderTarget(target);
  renderer.render(scene, new THREE.Camera());
  const out = new Float32Array(4 * columns * rows);
  renderer.readRenderTargetPixels(target, 0, 0, columns, rows, out);
  renderer.setRenderTarget(null);
  return Array.from(out);
}

window.sample = () => ({
  slices: values('terrazzo_solid(slices, size, p)'),
  solid: values('terrazzo_solid(solid, p)'),
  is_3d: Boolean(solid.isData3DTexture),
  depth: solid.image.depth,
  color_space: solid.colorSpace,
});

// A block under a lamp, as a picture.
window.show = () => {
  const material = new THREE.ShaderMaterial({
    glslVersion: THREE.GLSL3,
    uniforms,
    vertexShader: `out vec3 at, normal_at; void main() { at = position; normal_at = normal;
      gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1); }`,
    fragmentShader: `uniform sampler2D slices; uniform sampler3D solid; uniform ivec3 size; in vec3 at, normal_at; out vec4 color;
      ${library}
      void main() {
        float light = 0.25 + 0.75 * max(0.0, dot(normalize(normal_at), normalize(vec3(0.4, -0.5, 0.9))));
        color = linearToOutputTexel(vec4(terrazzo_solid(slices, size, at - 1e-4 * normal_at).rgb * light, 1));
      }`,
  });
  const scene = new THREE.Scene();
  scene.background = new THREE.Color(0.8, 0.8, 0.8);
  const box = new THREE.BoxGeometry(1, 1, 1);
  box.translate(0.5, 0.5, 0.5);
  scene.add(new THREE.Mesh(box, material));
  const camera = new THREE.PerspectiveCamera(24, 1, 0.1, 100);  // as RenderSolid looks at a block
  const azimuth = -41 * Math.PI / 180, elevation = 30 * Math.PI / 180;
  camera.up.set(0, 0, 1);
  camera.position.set(0.5 + 4.4 * Math.cos(elevation) * Math.cos(azimuth), 0.5 + 4.4 * Math.cos(elevation) * Math.sin(azimuth),
    0.5 + 4.4 * Math.sin(elevation));
  camera.lookAt(0.5, 0.5, 0.5);
  renderer.setPixelRatio(1);
  renderer.setSize(640, 640);
  renderer.render(scene, camera);
};
