// node check.mjs FILE.mtlx: prints one JSON object with what MaterialX 1.39 says of the file and the types of its nodes.
import { readFile } from 'node:fs/promises';
import { createRequire } from 'node:module';

// The module was built for browsers: it gets its files and what CommonJS provides by hand.
globalThis.require = createRequire(import.meta.url);
globalThis.__dirname = '.';
const bin = new URL('bin/', import.meta.resolve('@needle-tools/materialx/package.json'));
const { default: create } = await import(new URL('JsMaterialXGenShader.js', bin));
const [wasmBinary, data] = await Promise.all(
  ['JsMaterialXGenShader.wasm', 'JsMaterialXGenShader.data.txt'].map((name) => readFile(new URL(name, bin))),
);
const getPreloadedPackage = () => data.buffer.slice(data.byteOffset, data.byteOffset + data.length);
const mx = await create({ wasmBinary, getPreloadedPackage });

const library = mx.loadStandardLibraries(new mx.GenContext(mx.EsslShaderGenerator.create()));
const document = mx.createDocument();
await mx.readFromXmlString(document, await readFile(process.argv[2], 'utf8'));
const nodes = document.getNodes().map((node) => node.getCategory());
document.importLibrary(library);
const report = {};
console.log(JSON.stringify({ valid: document.validate(report), message: report.message ?? '', nodes }));
