// node check.mjs FILE.glb: prints one JSON object with the validator's counts and messages and the scene that three.js loads.
import { readFile } from 'node:fs/promises';
import validator from 'gltf-validator';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

// Pictures are not decoded: Node has no decoder.
globalThis.self = globalThis;
globalThis.createImageBitmap = async () => ({ width: 1, height: 1, close() {} });

const bytes = new Uint8Array(await readFile(process.argv[2]));
const report = await validator.validateBytes(bytes, { maxIssues: 50 });

const gltf = await new GLTFLoader().parseAsync(bytes.buffer, '');
const instanced = [], meshes = [], nodes = [];
gltf.scene.traverse((object) => {
  if (object.isInstancedMesh) {
    const matrix = Array.from(object.instanceMatrix.array.slice(0, 16));
    instanced.push({
      name: object.name,
      count: object.count,
      colors: object.instanceColor ? object.instanceColor.count : 0,
      components: object.instanceColor ? object.instanceColor.itemSize : 0,
      firstColor: object.instanceColor ? Array.from(object.instanceColor.array.slice(0, 3)) : [],
      firstPosition: matrix.slice(12, 15),
      firstScale: Math.cbrt(object.matrixWorld.clone().fromArray(matrix).determinant()),
    });
  } else if (object.isMesh) {
    meshes.push(object.name);
    nodes.push({
      name: object.name,
      extras: object.userData,
      position: object.getWorldPosition(object.position.clone()).toArray(),
      color: object.material.color.toArray(),
    });
  }
});
console.log(JSON.stringify({
  errors: report.issues.numErrors,
  warnings: report.issues.numWarnings,
  messages: report.issues.messages.map((m) => `${m.code} ${m.pointer ?? ''} ${m.message}`),
  generator: gltf.asset.generator,
  extras: gltf.asset.extras ?? null,
  instanced,
  meshes,
  nodes,
}));
