// node graphs.mjs TERRAZZO FOLDER CHROMIUM SOURCE: reads and wires graphs in windows of several sizes. Prints the observed states as one JSON
// object.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { drawn, fitted, launch, report, result, start, watch } from './session.mjs';

const [, , program, folder, executablePath, source] = process.argv;
const graph = join(folder, 'outputs.yaml');
writeFileSync(graph, `terrazzo: 1
name: Outputs
nodes:
  shape: {type: Shape, params: {kind: dodecahedron}}
  sizes: {type: Distribution, inputs: {shapes: shape.shapes}, params: {kind: lognormal, mean: 1, sd: 0.3, volume_fraction: 0.2}}
  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: shape.shapes}, params: {size: 6}}
  voxels: {type: Voxelize, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {resolution: 32}}
  block: {type: RenderSolid, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {width: 64, height: 64, samples: 4}}
  glb: {type: Export, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {path: a.glb}}
  vdb: {type: Export, inputs: {volume: voxels.volume}, params: {path: a.vdb}}
  png: {type: Export, inputs: {image: block.image}, params: {path: a.png}}
  csv: {type: Export, inputs: {particles: pack.particles}, params: {path: a.csv}}
`);
const sizes = { '1440×900': { width: 1440, height: 900 }, '1024×700': { width: 1024, height: 700 }, '200 %': { width: 720, height: 450, scale: 2 } };
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache'), '--no-live'], { cwd: folder });
await report(server, async () => {
  const browser = await launch(executablePath, '--enable-unsafe-swiftshader');
  const shot = async (page, name) => process.env.SHOTS && page.screenshot({ path: join(process.env.SHOTS, `${name}.png`) });
  const edit = (page, edits) => page.evaluate(async edits => {
    await fetch('/api/edit', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ edits }) });
  }, edits);
  const view = page => page.evaluate(() => document.querySelector('.react-flow__viewport').style.transform);
  const fittedView = async page => { await fitted(page); return view(page); };
  const focused = page => page.evaluate(() => document.activeElement.textContent);
  const fits = page => page.waitForFunction(() => {
    const flow = document.querySelector('.flow').getBoundingClientRect(), cards = [...document.querySelectorAll('.card')].map(c => c.getBoundingClientRect());
    return cards.length && cards.every(c => c.left >= flow.left && c.right <= flow.right && c.top >= flow.top && c.bottom <= flow.bottom);
  });
  // The nodes of the card of checks, one by one, and what has the card's place when they are folded again.
  const openChecks = async page => {
    const ids = () => page.locator('.react-flow__node').evaluateAll(all => all.map(n => n.dataset.id));
    const before = await ids();
    await page.click('.card.folded:has-text("checks") >> text=nodes');
    await page.waitForSelector('.react-flow__node[data-id="observer"]');
    const opened = (await ids()).filter(n => !before.includes(n)).sort();
    await page.click('button:text-is("Fold")');
    await page.locator('.react-flow__node[data-id="observer"]').waitFor({ state: 'detached' });
    // A node that is looked for is shown.
    await page.keyboard.press('Control+k');
    await page.keyboard.type('compare_sizes');
    await page.keyboard.press('Enter');
    await page.waitForSelector('.react-flow__node.selected[data-id="compare_sizes"]');
    return opened;
  };
  const places = page => page.evaluate(() => Object.fromEntries([...document.querySelectorAll('.react-flow__node')].map(n => [n.dataset.id, n.style.transform])));

  // The standard graph, with names that can be read, and nothing over the graph.
  const standard = await start(program, [join(source, 'graphs/materials/terrazzo.yaml'), '--cache', join(folder, 'cache2'), '--no-live'], { cwd: folder });
  result.sizes = {};
  try {
    for (const [name, { width, height, scale }] of Object.entries(sizes)) {
      const page = await browser.newPage({ viewport: { width, height }, deviceScaleFactor: scale ?? 1, colorScheme: name === '1024×700' ? 'light' : 'dark' });
      const { check } = watch(page);
      await page.goto(standard.address);
      await page.waitForSelector('.card.folded');
      await fitted(page);
      result.sizes[name] = await page.evaluate(() => {
        const names = [...document.querySelectorAll('.card header b')], flow = document.querySelector('.flow').getBoundingClientRect();
        return {
          name: Math.min(...names.map(b => parseFloat(getComputedStyle(b).fontSize) * b.getBoundingClientRect().width / b.offsetWidth)),
          cut: names.filter(b => Math.round(b.offsetHeight / parseFloat(getComputedStyle(b).lineHeight)) > b.textContent.split('_').length || b.scrollHeight > b.offsetHeight + 4 || b.scrollWidth > b.offsetWidth + 2).map(b => b.textContent),
          over: [...document.querySelectorAll('.tools, .react-flow__minimap, .react-flow__controls')].filter(e => e.getBoundingClientRect().bottom > flow.top + 1).length,
          seen: [...document.querySelectorAll('.card')].filter(c => { const r = c.getBoundingClientRect(); return r.left >= flow.left && r.right <= flow.right && r.top >= flow.top && r.bottom <= flow.bottom; }).length,
          bars: ['.top', '.tools'].map(bar => document.querySelector(bar).offsetHeight),
          folded: [...document.querySelectorAll('.card.folded b')].map(b => b.textContent).sort().join(', '),
        };
      });
      if (name === '200 %') {
        await check(name);
        await page.click('button:text-is("More") >> nth=0');
        await page.waitForSelector('[role=menuitem]:has-text("New or open")');
        await shot(page, 'menu_720');
        await check('menu, 200 %');
        await page.keyboard.press('Escape');
      }
      await shot(page, `graph_${width}`);
      if (name === '1440×900') result.checks = await openChecks(page);
      await page.close();
    }
  } finally {
    standard.server.kill();
  }

  const page = await browser.newPage({ viewport: { width: 1440, height: 900 }, colorScheme: 'dark' });
  page.setDefaultTimeout(60000);
  const { card, state, until, check } = watch(page);
  await page.goto(address);
  await page.waitForSelector('.card.folded');
  await fits(page);
  await fitted(page);

  // A window of another size shows all, unless the user chose a part.
  await page.setViewportSize({ width: 1100, height: 640 });
  await fits(page);
  result.smaller = await fittedView(page);
  await page.mouse.move(300, 500);
  await page.mouse.wheel(0, -300);
  await page.waitForFunction(before => document.querySelector('.react-flow__viewport').style.transform !== before, result.smaller);
  const chosen = await view(page), width = await page.evaluate(() => document.querySelector('.flow').clientWidth);
  await page.setViewportSize({ width: 1440, height: 900 });
  await page.waitForFunction(before => document.querySelector('.flow').clientWidth > before, width);
  await drawn(page); // the page knows its new size
  result.keeps_part = (await view(page)) === chosen;
  await page.click('button:text-is("Fit")');
  await fits(page);
  await fitted(page);

  // The outputs one by one, and as one card again. Nothing else moves.
  const before = await places(page);
  result.folded = await page.locator('.card').count();
  await shot(page, 'folded');
  await page.click('.card.folded >> text=nodes');
  await card('csv').waitFor();
  await fits(page);
  await fitted(page);
  result.unfolded = await page.locator('.card').count();
  result.focused = [await focused(page)];
  const open = await places(page);
  result.moved_by_unfolding = Object.keys(before).filter(n => open[n] && open[n] !== before[n]);
  await shot(page, 'unfolded');
  await check('unfolded');
  await card('vdb').locator('header b').click();
  const path = await page.locator('#field-path').boundingBox();
  result.path_in_view = path.y + path.height < 900;
  const offered = () => page.locator('[id^=input-]').count();
  result.inputs = [await offered()];
  await page.click('text=more optional inputs');
  result.inputs.push(await offered());
  await page.click('.react-flow__pane', { position: { x: 20, y: 20 } });
  await page.click('button:text-is("Fold")');
  await page.waitForSelector('.card.folded');
  await fits(page);
  await page.waitForFunction(() => document.activeElement !== document.body);
  result.focused.push(await focused(page));
  const again = await places(page);
  result.moved_by_folding = Object.keys(before).filter(n => again[n] !== before[n]);

  // A node that comes in between moves nothing, and covers nothing.
  await edit(page, [
    { op: 'add', node: 'tint', type: 'Colorize' }, { op: 'connect', node: 'tint', name: 'particles', wires: ['pack.particles'] },
    { op: 'connect', node: 'voxels', name: 'particles', wires: ['tint.particles'] },
  ]);
  await card('tint').waitFor();
  const grown = await places(page);
  result.moved_by_adding = Object.keys(before).filter(n => grown[n] !== before[n]);
  result.overlaps = await page.evaluate(() => {
    const all = [...document.querySelectorAll('.card')].map(c => c.getBoundingClientRect());
    return all.filter((a, k) => all.some((b, l) => l > k && a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1)).length;
  });

  // A wire that is drawn to an optional input: no card grows.
  await page.click('button:text-is("Fit")');
  await fits(page);
  await fitted(page);
  const heights = () => page.evaluate(() => [...document.querySelectorAll('.card')].map(c => c.offsetHeight).join(' '));
  const tall = await heights();
  const from = await card('shape').locator('.react-flow__handle.source').boundingBox(), to = await card('sizes').boundingBox();
  await edit(page, [{ op: 'connect', node: 'sizes', name: 'shapes', wires: [] }]);
  await until('sizes has no wire', s => !Object.keys(s.document.nodes.find(n => n.name === 'sizes').inputs.shapes ?? []).length);
  await page.waitForFunction(() => !document.querySelector('.react-flow__edge[data-id="sizes.shapes.0"]'));
  const short = await heights();
  await page.mouse.move(from.x + from.width / 2, from.y + from.height / 2);
  await page.mouse.down();
  await page.mouse.move(to.x + to.width / 2, to.y + 12, { steps: 6 });
  await page.waitForSelector('.more');
  result.grows = (await heights()) !== short;
  const handle = await page.locator('.more .socket', { hasText: 'shapes' }).locator('.react-flow__handle').boundingBox();
  await shot(page, 'wiring');
  await page.mouse.move(handle.x + handle.width / 2 + 3, handle.y + handle.height / 2, { steps: 6 });
  await page.mouse.up();
  await until('sizes has its wire', s => s.document.nodes.find(n => n.name === 'sizes').inputs.shapes?.[0]?.startsWith('shape'));
  await page.waitForFunction(tall => [...document.querySelectorAll('.card')].map(c => c.offsetHeight).join(' ') === tall, tall);

  // A wire is selected and deleted where it can be seen. A card in front of it is selected alone, and is not deleted with the wire.
  const nodesNow = async () => (await state()).document.nodes;
  const half = where => page.evaluate(([id, at]) => {
    const path = document.querySelector(`.react-flow__edge[data-id="${id}"] .react-flow__edge-path`), p = path.getPointAtLength(path.getTotalLength() * at).matrixTransform(path.getScreenCTM());
    return [p.x, p.y];
  }, where);
  const chosenNow = () => page.evaluate(() => [...document.querySelectorAll('.react-flow__node.selected, .react-flow__edge.selected')].map(e => e.dataset.id));
  await card('sizes').locator('header').click();
  await page.waitForSelector('.react-flow__node.selected[data-id="sizes"]');
  await page.mouse.click(...await half(['block.shapes.0', 0.97]));
  await page.waitForSelector('.react-flow__edge.selected');
  result.wire = await chosenNow();
  await edit(page, [{ op: 'set', node: 'shape', name: 'size', value: '2' }]); // what arrives meanwhile selects nothing
  await page.waitForFunction(async () => (await (await fetch('/api/state')).json()).document.text.includes('size: 2'));
  await page.mouse.click(...await half(['block.shapes.0', 0.97]));
  await page.waitForSelector('.react-flow__edge.selected');
  const count = (await nodesNow()).length;
  await page.keyboard.press('Delete');
  await until('the wire is deleted', s => !s.document.nodes.find(n => n.name === 'block').inputs.shapes);
  result.nodes_kept = (await nodesNow()).length === count;
  await page.keyboard.press('Control+z');
  await page.waitForSelector('.react-flow__edge[data-id="block.shapes.0"]', { state: 'attached' });
  const front = await card('sizes').boundingBox();
  await page.mouse.click(front.x + front.width / 2, front.y + front.height * 0.55);
  await page.waitForSelector('.react-flow__node.selected[data-id="sizes"]');
  result.front = await chosenNow();
  await page.keyboard.press('Escape');

  // `Save as` belongs to the page on which it was opened, and a text is no photograph.
  await page.click('[aria-label="More to do with the file"]');
  await page.click('[role=menuitem]:has-text("Save as…")');
  await page.waitForSelector('form.save');
  const files = await page.evaluateHandle(() => {
    const files = new DataTransfer();
    files.items.add(new File(['This is a text.'], 'notes.jpg', { type: 'image/jpeg' }));
    return files;
  });
  for (const type of ['dragover', 'drop']) await page.dispatchEvent('.canvas', type, { dataTransfer: files });
  await page.waitForSelector('.new[role=alert]');
  const expected = result.errors.findIndex(e => /status of 400/.test(e)); // the browser's word for the refusal
  if (expected >= 0) result.errors.splice(expected, 1);
  result.refused = await page.textContent('.new .bad');
  result.can_create = await page.locator('text=Create the material').count();
  result.save_as = await page.locator('form.save').count();
  result.focused.push(await focused(page));
  await shot(page, 'refused');
  await check('refused');
  await page.click('text=Choose another picture');
  await page.waitForSelector('.drop');
  result.focused.push(await focused(page));
});
