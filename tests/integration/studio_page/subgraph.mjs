// node subgraph.mjs TERRAZZO FOLDER CHROMIUM: opens a subgraph, copies it into the graph, edits a copied node, and undoes. Prints the observed
// states as one JSON object.
import { mkdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { openPage, report, result, start } from './session.mjs';

const [, , program, folder, executablePath] = process.argv;
mkdirSync(join(folder, 'library'));
writeFileSync(join(folder, 'library', 'veins.yaml'), `terrazzo: 1
parameters: {seed: {type: int, default: 1}, phases: {type: int, default: 2}}
nodes:
  photo: {type: Pattern, params: {kind: marble, axis: z, width: 96, height: 64, seed: "\${seed}"}}
  phases: {type: Phases, inputs: {image: photo.image}, params: {phases: "\${phases}"}}  # by gray level
  unread: {type: ContactSheet, inputs: {images: photo.image}}
outputs: {image: photo.image, labels: phases.labels, sheet: unread.image}
`);
const graph = join(folder, 'two.yaml');
writeFileSync(graph, `# kept
terrazzo: 1
name: Two
nodes:
  photo: {type: Pattern, params: {kind: wood, axis: z, width: 64, height: 64}}
  veins: {graph: library/veins.yaml, params: {seed: 4}}
  sheet: {type: ContactSheet, inputs: {images: [photo.image, veins.image]}}
outputs: {labels: veins.labels}
`);
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache')], { cwd: folder });
await report(server, async () => {
  const { page, shot, card, until, idle, check } = await openPage(executablePath, { viewport: { width: 1440, height: 900 }, colorScheme: 'light' });
  await page.goto(address);
  const before = await idle();
  await card('veins').dblclick();
  await page.waitForSelector('.react-flow__node[data-id="veins/phases"]');
  await shot('subgraph_inside');
  await check('inside');
  await page.click('text=Copy into this graph');
  await card('veins_photo').waitFor();
  let s = await idle();
  await page.waitForFunction(() => !document.querySelector('.tools nav'));
  result.names = s.document.nodes.map(n => n.name);
  result.text = s.document.text;
  result.ran = Object.entries(s.nodes).filter(([, n]) => n.state === 'computed').map(([path]) => path);
  result.same = s.nodes.sheet.outputs.image.hash === before.nodes.sheet.outputs.image.hash;
  await shot('subgraph_copied');
  await card('phases').click();
  await page.fill('#field-phases', '3');
  await page.press('#field-phases', 'Enter');
  await until('a copied node is edited', s => /phases: 3/.test(s.document.text));
  for (let k = 0; k < 2; ++k) await page.click('button:text-is("Undo")');
  s = await until('the subgraph is back', s => s.document.nodes.some(n => n.name === 'veins'));
  result.undone = !s.document.can_undo;
});
