// node subgraph.mjs TERRAZZO FOLDER CHROMIUM: edits a subgraph in place, copies it into the graph, makes one of nodes, and undoes. Prints the
// observed states as one JSON object.
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
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

  // The subgraph is edited in place: its file has the change, and what reads it follows. Undo belongs to the file.
  const file = join(folder, 'library', 'veins.yaml'), original = readFileSync(file, 'utf8'), hash = s => s.nodes.sheet.outputs.image?.hash;
  await card('veins').dblclick();
  await card('veins/phases').waitFor();
  await card('veins/photo').click();
  await page.fill('#field-width', '48');
  await page.press('#field-width', 'Enter');
  await until('the parent follows', s => s.nodes.sheet.state === 'computed' && hash(s) !== hash(before));
  result.edited = readFileSync(file, 'utf8') === original.replace('width: 96', 'width: 48');
  result.says = (await page.textContent('.tools nav em')).trim();
  await shot('subgraph_inside');
  await check('inside');

  // Its value comes from the node in the parent, which a change in here changes.
  result.label = (await page.textContent('label[for=field-seed]')).trim();
  result.value = await page.inputValue('#field-seed');
  await page.fill('#field-seed', '6');
  await page.press('#field-seed', 'Enter');
  await until('the node has another seed', s => /params: \{seed: 6\}/.test(s.document.text));

  // A node is added and renamed; a note; and all is taken back.
  await page.click('.react-flow__pane', { position: { x: 20, y: 60 } });
  await page.keyboard.press('a');
  await page.keyboard.type('Palette');
  await page.keyboard.press('Enter');
  await card('veins/palette').waitFor();
  await page.waitForFunction(() => document.querySelector('.inspector input.name')?.value === 'palette');
  await page.fill('.inspector input.name', 'colors');
  await page.press('.inspector input.name', 'Enter');
  await card('veins/colors').waitFor();
  await page.click('.tools button:text-is("Note")');
  await page.locator('.note').waitFor();
  result.beside = await page.waitForFunction(async () => (await (await fetch('/api/subgraph?path=veins')).json()).arrangement.notes?.length === 1).then(() => existsSync(`${file}.studio.json`));
  for (let k = 0; k < 4; ++k) {
    const was = await page.evaluate(async () => { const d = await (await fetch('/api/subgraph?path=veins')).json(); return d.text + JSON.stringify(d.arrangement); });
    await page.click('button:text-is("Undo")');
    await page.waitForFunction(async was => { const d = await (await fetch('/api/subgraph?path=veins')).json(); return d.text + JSON.stringify(d.arrangement) !== was; }, was);
  }
  await page.waitForFunction(() => [...document.querySelectorAll('.group button')].find(b => b.textContent === 'Undo').disabled);
  result.restored = readFileSync(file, 'utf8') === original;
  await idle();

  // What an edit in here would run, variants of a value in here, and the state before one was kept.
  await card('veins/photo').click();
  await page.fill('#field-width', '52');
  await page.waitForSelector('.card.priced');
  result.price = await page.textContent('.price');
  await page.keyboard.press('Escape');
  await page.click('[aria-label="More for height"]');
  await page.click('[role=menuitem]:has-text("Show variants")');
  await page.fill('.variants form input:not([type])', '40, 64');
  result.vary = await page.inputValue('.variants select');
  await page.click('.variants button:text-is("Show variants")');
  const varied = await until('the variants are done', s => s.variants && !s.variants.running);
  result.tiles = varied.variants.tiles.map(t => t.state);
  await page.locator('.tiles button').first().click();
  await until('one is kept', s => s.nodes['veins/photo'].outputs.image?.hash === varied.variants.tiles[0].output.hash);
  result.kept = readFileSync(file, 'utf8') === original.replace('height: 64', 'height: 40');
  await page.waitForFunction(() => document.querySelector('.tiles [aria-pressed=true] b')?.textContent === '40');
  await shot('subgraph_variants');
  await idle();
  await page.click('button:text-is("History")');
  await page.locator('.states li', { hasText: 'height: 40' }).waitFor();
  await page.locator('.states li').nth(1).locator('button:has-text("Restore")').click();
  await until('the state before is back', s => s.nodes['veins/photo'].outputs.image?.hash === varied.variants.tiles[1].output.hash);
  result.past = readFileSync(file, 'utf8') === original;
  await page.click('button:text-is("History")');
  await page.click('.tools nav button >> nth=0');
  await card('sheet').waitFor();
  await page.click('button:text-is("Undo")');
  await until('the seed is back', s => /params: \{seed: 4\}/.test(s.document.text));
  await idle();

  await card('veins').dblclick();
  await page.waitForSelector('.react-flow__node[data-id="veins/phases"]');
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

  // Nodes become a subgraph, in one step, and compute nothing again.
  await card('photo').click();
  await page.keyboard.down('Control');
  await card('veins').click();
  await page.keyboard.up('Control');
  await page.waitForFunction(() => document.querySelectorAll('.react-flow__node.selected').length === 2);
  await page.keyboard.press('Control+g');
  await page.fill('form[aria-label="Make a subgraph"] input', 'sources');
  await shot('subgraph_make');
  await check('make');
  await page.keyboard.press('Enter');
  await card('sources').waitFor();
  s = await idle();
  result.grouped = s.document.text;
  result.group = readFileSync(join(folder, 'sources.yaml'), 'utf8');
  result.computed = Object.values(s.nodes).filter(n => n.state === 'computed').length;
  result.equal = hash(s) === hash(before);
  await page.waitForFunction(() => document.querySelector('.inspector input.name')?.value === 'sources');
  await shot('subgraph_made');
  await page.click('button:text-is("Undo")');
  s = await until('the nodes are back', s => s.document.nodes.length === 3);
  result.ungrouped = !s.document.can_undo;
});
