// node material.mjs TERRAZZO FOLDER CHROMIUM: opens a material, looks, changes its colors, writes and downloads its files, and cancels.
// Prints the observed states as one JSON object.
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { launch, report, result, start, watch } from './session.mjs';

const [, , program, folder, executablePath] = process.argv;
const graph = join(folder, 'stone.yaml');
writeFileSync(graph, `terrazzo: 1
name: Stone
nodes:
  shape: {type: Shape, params: {kind: dodecahedron}}
  sizes: {type: Distribution, inputs: {shapes: shape.shapes}, params: {kind: lognormal, mean: 1, sd: 0.3, volume_fraction: 0.2}}
  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: shape.shapes}, params: {size: 6}}
  palette: {type: Palette, params: {colors: ["#204060", "#806040", "#c0c0b0"], shares: [1, 2, 5]}}
  colorize: {type: Colorize, inputs: {particles: pack.particles, profiles: palette.profiles}}
  block: {type: RenderSolid, inputs: {particles: colorize.particles, shapes: shape.shapes}, params: {width: 64, height: 64, samples: 4}}
  figure: {type: ContactSheet, inputs: {images: block.image}}
  instances: {type: Export, inputs: {particles: colorize.particles, shapes: shape.shapes}, params: {path: stone.glb}}
  preview: {type: Export, inputs: {image: block.image}, params: {path: preview.png}}
  table: {type: Export, inputs: {particles: colorize.particles}, params: {path: stone.csv}}
`);
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache'), '--no-live'], { cwd: folder });
await report(server, async () => {
  const browser = await launch(executablePath, '--enable-unsafe-swiftshader');
  const page = await browser.newPage({ viewport: { width: 1024, height: 700 }, colorScheme: 'light', acceptDownloads: true });
  page.setDefaultTimeout(60000);
  const { card, state, until, idle, check } = watch(page);
  const shot = async name => process.env.SHOTS && page.screenshot({ path: join(process.env.SHOTS, `${name}.png`) });
  const panel = async name => { await page.click('.top button[aria-label=Panels]'); await page.click(`[role=menuitem]:text-is("${name}")`); };
  await page.goto(address);

  // While nothing is selected, the viewer shows the material: first nothing, at the end the picture that is written as the preview.
  await page.click('.viewer >> text=Compute the material');
  await page.waitForFunction(() => document.querySelector('.tabs b')?.textContent === 'block' && document.querySelector('.panzoom canvas'));
  await idle();
  result.selected = await page.locator('.react-flow__node.selected').count();
  await shot('material');

  // The palette: a color as text, from the picture, moved, removed, pasted.
  const colors = async () => /palette: .*colors: \[(.*?)\], shares: \[(.*?)\]/.exec((await state()).document.text).slice(1).join('; ').replace(/"/g, '');
  const changed = async was => { await page.waitForFunction(async was => !(await (await fetch('/api/state')).json()).document.text.includes(was), was); return colors(); };
  await card('palette').click();
  await page.fill('[aria-label="Color 1 as text"]', '#FF0000');
  await page.press('[aria-label="Color 1 as text"]', 'Enter');
  result.typed = await changed('#204060');
  await page.fill('[aria-label="Weight of color 2"]', '3');
  await page.press('[aria-label="Weight of color 2"]', 'Enter');
  result.weighted = await changed('[1, 2, 5]');
  await page.focus('[aria-label="Move color 1"]');
  await page.keyboard.press('ArrowDown');
  result.moved = await changed('["#ff0000", "#806040"');
  await page.click('[aria-label="Remove color 3"]');
  result.removed = await changed('#c0c0b0');
  await page.fill('[aria-label="Add to colors"]', '#0f0 and 123456');
  await page.press('[aria-label="Add to colors"]', 'Enter');
  result.pasted = await changed('"#ff0000"]');
  await idle();
  await check('palette');
  await shot('palette');
  await page.click('[aria-label="Take color 1 from the picture"]');
  await page.waitForSelector('.panzoom.pen canvas');
  const pixel = await page.locator('.panzoom.pen .content').boundingBox();
  await page.mouse.move(pixel.x + pixel.width / 2, pixel.y + pixel.height / 2);
  result.under = /#[0-9a-f]{6}/.exec(await page.textContent('.viewer .readout'))[0];
  await page.mouse.click(pixel.x + pixel.width / 2, pixel.y + pixel.height / 2);
  result.taken = await changed('#806040');
  await idle();

  // What nothing selected shows can be saved as a picture.
  await page.click('.react-flow__pane', { position: { x: 300, y: 90 } });
  await page.hover('.panzoom');
  const [picture] = await Promise.all([page.waitForEvent('download'), page.click('[aria-label="Save this picture"]')]);
  result.picture = picture.suggestedFilename();

  // The files: one that is written in another format, its download, and all.
  await panel('Files');
  const row = name => page.locator('.files tbody tr', { hasText: name });
  await row('stone.csv').waitFor();
  result.listed = await page.locator('.files tbody tr').count();
  result.unwritten = await row('stone.csv').textContent();
  await page.selectOption('[aria-label="Format of stone.csv"]', 'json');
  await row('stone.json').waitFor();
  await row('stone.json').locator('button:text-is("Write")').click();
  const link = row('stone.json').locator('a');
  await link.waitFor();
  result.block_stays = (await state()).nodes.block.state;
  const [file] = await Promise.all([page.waitForEvent('download'), link.click()]);
  result.same = readFileSync(await file.path()).equals(readFileSync(join(folder, 'out/stone.json')));
  result.name = file.suggestedFilename();
  await check('files');
  await shot('files');
  await panel('Files');
  await page.click('text=Run and write files');
  const notice = page.locator('.notices p', { hasText: '3 files in' });
  await notice.waitFor();
  result.notice = await notice.locator('b').textContent();
  result.expected_notice = `3 files in ${join(folder, 'out')}`;

  // A run that takes long: what it does is said, also after the page is loaded again, and what is canceled is called so.
  await page.evaluate(async () => {
    const edits = Object.entries({ width: '4000', height: '4000', samples: '1024' }).map(([name, value]) => ({ op: 'set', node: 'block', name, value }));
    await fetch('/api/edit', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ edits }) });
  });
  await until('the block is rendered', s => s.nodes.block.state === 'running');
  await page.reload();
  await page.waitForFunction(() => /^Rendering, 0 of 2 nodes, about \d/.test(document.querySelector('.waiting p')?.textContent ?? ''));
  result.waiting = await page.textContent('.waiting p');
  await shot('waiting');
  // What is asked for meanwhile waits, and says so.
  await panel('Files');
  await row('preview.png').locator('button:text-is("Write")').click();
  await row('preview.png').locator('td', { hasText: 'queued' }).waitFor();
  result.again = await row('preview.png').locator('button:text-is("Write")').isEnabled();
  await panel('Files');
  await page.click('.top button:text-is("Cancel")');
  await page.waitForFunction(() => /canceled/.test(document.querySelector('.status').textContent));
  result.canceled = await page.textContent('.status');
});
