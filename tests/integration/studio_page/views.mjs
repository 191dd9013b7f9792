// node views.mjs TERRAZZO FOLDER CHROMIUM: uses the views of a graph with solids like a user. Prints the observed states as one JSON object.
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { drawn, launch, report, result, sooner, start, watch } from './session.mjs';

const [, , program, folder, executablePath] = process.argv;
const graph = join(folder, 'solids.yaml');
writeFileSync(join(folder, 'part.yaml'), 'terrazzo: 1\nnodes:\n  inner: {type: Pattern, params: {kind: marble, axis: z, width: 32, height: 24}}\noutputs: {image: inner.image}\n');
writeFileSync(graph, `# kept
terrazzo: 1
name: Solids
nodes:
  marble: {type: Pattern, params: {kind: marble, axis: z, width: 64, height: 48}}
  part: {graph: part.yaml}
  shape: {type: Shape, params: {kind: dodecahedron}}
  kmatrix: {type: KMatrix, inputs: {shapes: shape.shapes}, params: {classes: 6, orientations: 200}}
  sizes: {type: Distribution, inputs: {shapes: shape.shapes}, params: {kind: lognormal, mean: 1, sd: 0.3, volume_fraction: 0.2}}
  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: shape.shapes}, params: {size: 6}}
  section: {type: Section, inputs: {particles: pack.particles, shapes: shape.shapes}}
  voxels: {type: Voxelize, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {resolution: 32}}
  sheet: {type: ContactSheet, inputs: {images: [marble.image, section.image, part.image]}}
`);
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache')], { cwd: folder });
await report(server, async () => {
  const browser = await launch(executablePath, '--enable-unsafe-swiftshader');
  const context = await browser.newContext({ viewport: { width: 1360, height: 860 }, colorScheme: 'dark' });
  const page = await context.newPage();
  page.setDefaultTimeout(60000);
  const { card, state, until, idle, check } = watch(page);
  await page.goto(address);
  const shot = async (name, p = page) => process.env.SHOTS && p.screenshot({ path: join(process.env.SHOTS, `${name}.png`) });
  // Colors of a screenshot of the drawing: how many differ, coarsely.
  const colors = (where, p = page, least = 12) => sooner(() => colorsNow(where, p), n => n > least);
  const colorsNow = async (where, p) => {
    const png = (await p.locator(where).screenshot()).toString('base64');
    return p.evaluate(async data => {
      const image = new Image();
      image.src = 'data:image/png;base64,' + data;
      await image.decode();
      const c = document.createElement('canvas');
      c.width = image.width, c.height = image.height;
      const d = c.getContext('2d');
      d.drawImage(image, 0, 0);
      const all = d.getImageData(0, 0, c.width, c.height).data, seen = new Set();
      for (let k = 0; k < all.length; k += 4) seen.add((all[k] >> 4) * 256 + (all[k + 1] >> 4) * 16 + (all[k + 2] >> 4));
      return seen.size;
    }, png);
  };
  await page.waitForSelector('.card');
  await idle();

  // Particles: drawn, turned with keys, picked, cut.
  await card('pack').click();
  await page.waitForFunction(() => /\d particles/.test(document.querySelector('.options')?.textContent ?? ''));
  result.particle_colors = await colors('.stage3d');
  await shot('particles');
  const before = await page.locator('.stage3d').screenshot();
  await page.locator('.stage3d').focus();
  await page.keyboard.press('ArrowRight');
  const turned = (p, where, before) => sooner(async () => !before.equals(await p.locator(where).screenshot()), now => now);
  result.turned = await turned(page, '.stage3d', before);
  const dark = await page.locator('.stage3d').screenshot();
  await page.keyboard.press('Shift+ArrowRight');
  result.lit = await turned(page, '.stage3d', dark);

  // A surrounding, and a smoother surface, which the browser remembers.
  const frame = await page.locator('.stage3d').boundingBox();
  const solids = () => page.screenshot({ clip: { ...frame, y: frame.y + 40, height: frame.height - 40 } }); // without the fields above them
  const relit = before => sooner(async () => !before.equals(await solids()), now => now);
  let former = await solids();
  await page.selectOption('.look select', 'Studio');
  await page.locator('.stage3d').focus();
  result.surrounded = await relit(former);
  await drawn(page);
  former = await solids();
  await page.locator('.look input').fill('0.1');
  await page.locator('.stage3d').focus();
  result.smooth = await relit(former);
  result.light = await page.evaluate(() => localStorage.getItem('terrazzo.light'));
  const place = await page.locator('.stage3d').boundingBox();
  for (const [dx, dy] of [[0, 0], [12, 9], [-14, 6], [20, -16]]) {
    await page.mouse.click(place.x + place.width / 2 + dx, place.y + place.height / 2 + dy);
    if (await page.locator('.picked').count()) break;
  }
  result.picked = await page.textContent('.picked').catch(() => '');
  await shot('picked');
  await check('particles');

  // Volume: block and slices.
  await card('voxels').click();
  await page.waitForFunction(() => /voxels/.test(document.querySelector('.options')?.textContent ?? ''));
  result.block_colors = await colors('.stage3d');
  await shot('block');
  await page.click('label:has-text("Binder") input');
  await shot('block_without_binder');
  await page.click('button:has-text("Slices")');
  await page.waitForFunction(() => document.querySelectorAll('.slice canvas').length === 3);
  await shot('slices');
  await check('slices');
  await page.selectOption('.options select', 'density');
  result.scale = await page.textContent('.scale');
  await page.waitForFunction(() => [...document.querySelectorAll('.slice canvas')].every(c => { const [r, g, b] = c.getContext('2d').getImageData(0, 0, 1, 1).data; return r !== g || g !== b; }));
  await page.hover('.slice .panzoom');
  await page.waitForFunction(() => / density \d/.test(document.querySelector('.slice .readout').textContent));
  await page.click('button:has-text("Slices")');
  await page.waitForFunction(() => /^\d/.test(document.querySelector('.options > span:last-child').textContent));
  result.quantity_colors = await colors('.stage3d');
  await shot('quantity');
  await check('quantity');

  // The K matrix, the table and its plot.
  await card('kmatrix').click();
  await page.waitForSelector('.matrix canvas');
  await shot('matrix');
  await check('matrix');
  await card('section').click();
  await page.click('.ports button:has-text("table")');
  await page.click('.sheet tbody tr >> nth=2');
  result.row = await page.textContent('.options');
  await page.click('button:has-text("Plot")');
  await page.waitForSelector('svg.plot circle, svg.plot polyline');
  await shot('plot');

  // Linked views: a bar chooses particles and profiles.
  await page.click('.ports button:has-text("Linked")');
  await page.waitForSelector('.linked .stage3d canvas');
  await page.waitForSelector('.linked .plot .pick');
  await page.locator('.linked .plot .pick').nth(3).click({ force: true });
  result.linked = await page.textContent('.viewer .options >> nth=0');
  result.brushed = await page.locator('.linked polygon.brushed').count();
  await shot('linked');
  await check('linked');

  // The plane is dragged at its handle's slider; the section follows.
  await page.click('.ports button:has-text("Plane in 3D")');
  await page.waitForSelector('.cutting .stage3d canvas');
  const cut = (await state()).nodes.section.outputs.image.hash;
  await page.locator('.plane input[type=range]').first().focus();
  for (let k = 0; k < 12; ++k) await page.keyboard.press('ArrowRight');
  let s = await until('the section follows', s => /offsets/.test(s.document.text) && s.nodes.section.state === 'computed' && s.nodes.section.outputs.image.hash !== cut);
  result.plane_colors = await colors('.cutting .stage3d');
  await shot('plane');
  await page.selectOption('.plane select', 'free');
  await page.locator('.plane input[type=range]').nth(1).focus();
  await page.keyboard.press('ArrowRight');
  s = await until('the plane is free', s => /normal: /.test(s.document.text) && s.nodes.section.state === 'computed');
  await shot('plane_free');
  await check('plane in 3D');
  result.free = s.nodes.section.error?.message ?? 'computed';
  await idle();

  // The price of a value that is typed; it is not sent.
  const text = (await state()).document.text;
  await card('pack').click();
  await page.fill('#field-seed', '7');
  await page.waitForSelector('.card.priced');
  result.price = await page.textContent('.price');
  result.priced = await page.$$eval('.card.priced', all => all.length);
  await shot('price');
  await page.keyboard.press('Escape');
  await page.waitForFunction(() => !document.querySelector('.card.priced'));
  result.not_sent = (await state()).document.text === text;

  // A held picture and a later one, with the line between them; the history.
  await card('marble').click();
  await page.waitForSelector('.panzoom canvas');
  await page.click('button:has-text("Hold")');
  await page.fill('#field-seed', '9');
  await page.press('#field-seed', 'Enter');
  await page.waitForSelector('.wipe');
  await page.locator('.wipe').focus();
  for (let k = 0; k < 5; ++k) await page.keyboard.press('ArrowLeft');
  result.wipe = await page.getAttribute('.wipe', 'aria-valuenow');
  await shot('wipe');
  await page.click('button:has-text("Comparing")');
  await idle();
  await page.click('button:has-text("History")');
  await page.waitForSelector('.states li button');
  result.states = await page.locator('.states li').count();
  await page.locator('.states li').last().locator('button:has-text("Compare")').click();
  await page.waitForSelector('.differ table, .differ p');
  result.pictures = await sooner(() => page.locator('.states .thumb canvas').count(), n => n > 3);
  await shot('history');
  await check('history');
  await page.locator('.states li').last().locator('button:has-text("Restore")').click();
  await until('the first state is back', s => !/offsets|normal: |seed/.test(s.document.text));
  await page.click('button:has-text("Comparing")');
  await page.click('button:has-text("History")');
  await idle();

  // The inside of a subgraph.
  await card('part').dblclick();
  await card('part/inner').waitFor();
  await card('part/inner').click();
  result.inside = await page.inputValue('.inspector input.name');
  await page.waitForSelector('.panzoom canvas');
  await shot('subgraph');
  await check('subgraph');
  await page.click('.tools nav button >> nth=0');
  await card('marble').waitFor();

  // Notes are beside the graph. A node that is dropped on a wire is put into it.
  await page.click('.tools button:has-text("Note")');
  await page.fill('.note textarea', 'Why marble?');
  await page.click('.react-flow__pane', { position: { x: 30, y: 500 } });
  const arrangement = join(folder, 'solids.yaml.studio.json');
  result.note = await sooner(() => existsSync(arrangement) && JSON.parse(readFileSync(arrangement, 'utf8')).notes?.[0]?.text, text => text);
  await page.mouse.move(300, 300);
  await page.keyboard.press('Tab');
  await page.keyboard.type('TextureNib');
  result.tab = await page.locator('.search').count();
  await page.keyboard.press('Escape');
  await page.click('button:has-text("Pictures")');
  await page.waitForSelector('.card .thumb canvas');
  await shot('pictures');
  await page.click('button:has-text("Pictures")');
  await page.locator('.react-flow__node[data-id="marble"] .socket.out').hover();
  await page.waitForSelector('.peek');
  result.peek = await page.textContent('.peek');
  await page.mouse.move(5, 300);

  // A wire that is dropped backwards offers what makes its type, and an input can be chosen in the inspector.
  await card('section').click();
  await page.selectOption('#input-like', 'marble.image');
  await until('it is connected', s => /like: marble.image/.test(s.document.text));
  await page.selectOption('#input-like', '');
  await until('it is not', s => !/like/.test(s.document.text));

  // The nib paints into a picture.
  await card('marble').click();
  await page.waitForSelector('.panzoom canvas');
  await page.click('.options button:has-text("Nib")');
  const picture = await page.locator('.panzoom .content').boundingBox();
  await page.mouse.move(picture.x + picture.width * 0.3, picture.y + picture.height * 0.5);
  await page.mouse.down();
  await page.mouse.move(picture.x + picture.width * 0.7, picture.y + picture.height * 0.5, { steps: 6 });
  await page.mouse.up();
  s = await until('the nib has painted', s => s.nodes.nib?.state === 'computed');
  result.nib = /images: \[nib.image, section.image, part.image\]/.test(s.document.text) && /radius|strokes:/.test(s.document.text);
  await shot('nib');
  await page.click('.pens button:has-text("Done")');
  await page.click('button:has-text("Undo")');
  await until('the nib is gone', s => !/nib/.test(s.document.text));

  // Pages beyond the six connections that a browser opens to a host.
  const pages = [];
  for (let k = 0; k < 8; ++k) pages.push(await context.newPage());
  await Promise.all(pages.map(p => p.goto(address).then(() => p.waitForSelector('.card'))));
  await page.evaluate(() => fetch('/api/edit', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ edits: [{ op: 'rename', node: 'marble', to: 'granite' }] }) }));
  await Promise.all(pages.map(p => p.waitForSelector('.react-flow__node[data-id="granite"]')));
  result.pages = pages.length;
  await browser.close();

  // Without WebGL, the page says so and shows pictures that the server renders.
  const plain = await (await launch(executablePath, '--disable-gpu', '--disable-3d-apis')).newPage({ viewport: { width: 1360, height: 860 } });
  plain.setDefaultTimeout(60000);
  const without = watch(plain);
  await plain.goto(address);
  const rendered = async where => {
    await plain.waitForSelector(`${where}.rendered canvas`);
    return { says: await plain.textContent(`${where}.rendered figcaption`), colors: await colors(`${where}.rendered canvas`, plain, 6) };
  };
  const open = async (node, tab) => {
    await plain.locator(`.react-flow__node[data-id="${node}"]`).click();
    if (tab) await plain.click(`.ports button:has-text("${tab}")`);
    await plain.waitForFunction(name => document.querySelector('.tabs b')?.textContent === name, node);
  };
  await open('pack');
  result.without = { particles: await rendered('.both ') };
  const seen = await plain.locator('.rendered canvas').screenshot();
  await plain.focus('.rendered input[type=range]');
  await plain.keyboard.press('End');
  result.turned_without = await turned(plain, '.rendered canvas', seen);
  await without.check('without WebGL');
  await shot('without_webgl', plain);
  await open('shape');
  result.without.shapes = await rendered('.both ');
  await open('pack', 'Linked');
  result.without.linked = await rendered('.linked ');
  await plain.waitForSelector('.linked .plot');
  await open('section', 'Plane in 3D');
  result.without.plane = await rendered('.cutting ');
  await shot('without_webgl_plane', plain);
  await open('voxels');
  result.without.block = await rendered('');
  await plain.click('button:has-text("Slices")');
  await plain.waitForFunction(() => document.querySelectorAll('.slice canvas').length === 3);
});
