// node check.mjs FILE.usda: prints one JSON object with the layer that tinyusdz parses, written again as text. Its renderer is not
// used: it accepts only textures as the source of a color.
import { readFile } from 'node:fs/promises';

// tinyusdz is built for browsers and refuses to start in Node.
Object.defineProperty(process, 'type', { value: 'renderer' });
globalThis.window = globalThis;
const { default: start } = await import('tinyusdz/tinyusdz.js');
const code = await readFile(new URL('node_modules/tinyusdz/tinyusdz.wasm', import.meta.url));
const messages = [];
const tinyusdz = await start({
  print: (text) => messages.push(text),
  printErr: (text) => messages.push(text),
  instantiateWasm(imports, done) {
    WebAssembly.instantiate(code, imports).then((result) => done(result.instance, result.module));
    return {};
  },
});
console.log = (text) => messages.push(text);

const bytes = new Uint8Array(await readFile(process.argv[2]));
const layer = new tinyusdz.TinyUSDZLoaderNative();
const parsed = layer.loadAsLayerFromBinary(bytes, process.argv[2]);
process.stdout.write(JSON.stringify({ parsed, error: layer.error(), text: parsed ? layer.layerToString() : '', messages }));
