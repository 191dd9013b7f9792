// node scenario.mjs TERRAZZO PHOTOGRAPH CHROMIUM FOLDER: makes a material of the photograph in FOLDER, as a new user would:
// corrects the binder and the particles, changes the size of the block, moves the plane, saves. Prints what it saw as one
// JSON object.
import { launch, report, result, start, watch } from './session.mjs';

const [, , program, photograph, executablePath, folder] = process.argv;
const { server, address } = await start(program, ['--no-cache', '--no-live'], { cwd: folder });
await report(server, async () => {
  const browser = await launch(executablePath, '--enable-unsafe-swiftshader');
  const page = await browser.newPage({ viewport: { width: 1360, height: 850 } });
  page.setDefaultTimeout(90000);
  const { card, until, idle, check } = watch(page);
  await page.goto(address);
  const done = s => n => ['computed', 'cached'].includes(s.nodes[n]?.state);
  const table = async (s, node, port) => page.evaluate(async h => (await (await fetch(`/api/value/${h}?as=json`)).json()).rows[0], s.nodes[node].outputs[port].hash);

  // A photograph becomes a graph.
  await page.waitForSelector('.materials li');
  result.materials = await page.locator('.materials li').count();
  await check('start');
  await page.setInputFiles('.start input[type=file]', photograph);
  await page.fill('.new input >> nth=0', '0.2');
  await page.waitForSelector('.new >> text=Recommended:');
  result.recommended = await page.locator('.new p[aria-live]').textContent();
  result.chosen = await page.locator('.new label:has(input:checked)').textContent();
  await check('new material');
  await page.click('text=Create the material');
  await until('the graph is open', s => s.document.file.endsWith('stones.yaml'));
  await card('segment').waitFor();
  // Small sizes, so that this takes seconds.
  await page.evaluate(async () => {
    const small = { resolution: '24', count: '40', detail: '16', sections: '2', shapes: '1', shape_method: 'morphed_generalized_cylinder' };
    const edits = Object.entries(small).map(([name, value]) => ({ op: 'set_default', name, value }));
    await fetch('/api/edit', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ edits }) });
  });
  await page.keyboard.press('Control+s');
  result.before = (await until('it is saved', s => s.document.saved)).document.text;
  await page.click('.check input');
  await card('segment').click();
  result.binder_before = await table(await until('there are labels', s => done(s)('segment')), 'segment', 'binder');

  // The binder is chosen with a click.
  await page.waitForSelector('.panzoom .content canvas');
  const box = await page.locator('.panzoom .content').boundingBox();
  const at = (x, y) => [box.x + (x / 320) * box.width, box.y + (y / 240) * box.height];
  await page.click('button:has-text("Pick binder")');
  await page.mouse.click(...at(20, 40));
  let s = await until('the binder is another', s => s.document.text.includes('binder: {type: color, default: "#') && done(s)('segment'));
  result.binder_after = await table(s, 'segment', 'binder');

  // Two stones are split: with the mouse, and with the keyboard.
  const stones = s.nodes.segment.metrics.profiles, cards = await page.locator('.card').count();
  await page.click('button:has-text("Split")');
  await page.mouse.move(...at(80, 76));
  await page.mouse.down();
  await page.mouse.move(...at(80, 124), { steps: 4 });
  await page.mouse.up();
  s = await until('a stone is split', s => done(s)('measure'));
  result.split_by_mouse = s.nodes.measure.metrics.profiles - stones;
  await page.waitForFunction(() => document.querySelector('.tabs b')?.textContent === 'edit_labels');
  await card('segment').locator('text=1 correction').waitFor();
  result.cards_added = (await page.locator('.card').count()) - cards;
  result.chosen_card = await page.locator('.react-flow__node.selected').evaluateAll(all => all.map(n => n.dataset.id));
  await page.click('button:has-text("Undo")');
  result.undone = (await until('the correction is undone', s => !s.nodes.edit_labels)).document.nodes.every(n => n.name !== 'measure');
  await page.click('button:has-text("Redo")');
  await until('it is done again', s => done(s)('measure'));
  await card('segment').locator('text=/correction/').click();
  await page.waitForSelector('.panzoom .content canvas');
  await check('tools');
  await page.locator('.panzoom').focus();
  await page.keyboard.press('ArrowUp'); // shows the cross, in the middle of the picture
  const step = await page.locator('.panzoom .content').evaluate(e => Math.max(1, Math.round(8 / (e.getBoundingClientRect().width / e.offsetWidth))));
  const press = async (key, pixels) => { for (let k = 0; k < Math.round(pixels / step); ++k) await page.keyboard.press(key); };
  await press('ArrowRight', 80);
  await press('ArrowUp', 44);
  await page.keyboard.press('Space');
  await press('ArrowDown', 48);
  await page.keyboard.press('Space');
  await page.keyboard.press('Enter');
  s = await until('another is split', s => s.nodes.edit_labels?.metrics.particles > stones + 1 && done(s)('measure'));
  result.split_by_keys = s.nodes.measure.metrics.profiles - stones - result.split_by_mouse;
  await page.keyboard.press('Escape');
  await idle();

  // The inspector adds an item to the list of corrections, and removes it.
  await card('segment').locator('text=/correction/').click();
  const items = page.locator('.items li'), corrections = await items.count();
  const listed = n => page.waitForFunction(n => document.querySelectorAll('.items li').length === n, n);
  await page.fill('[aria-label="Add to edits"]', 'ignore 0 0 2 2');
  await page.press('[aria-label="Add to edits"]', 'Enter');
  await listed(corrections + 1);
  result.added = await items.last().locator('span').textContent();
  await items.last().locator('button').click();
  await listed(corrections);
  await idle();

  // The size of the block: only what is downstream runs.
  await page.click('.react-flow__pane', { position: { x: 500, y: 30 } });
  await page.fill('#field-size', '30');
  await page.press('#field-size', 'Enter');
  await until('the packing runs', s => /size: .*default: 30/.test(s.document.text) && s.nodes.pack.state !== 'cached');
  s = await idle();
  await page.waitForSelector('.inspector >> text=Edit these colors'); // also while nothing is selected
  result.ran = Object.keys(s.nodes).filter(n => s.nodes[n].state === 'computed').sort();
  result.failed = Object.keys(s.nodes).filter(n => ['failed', 'skipped', 'canceled'].includes(s.nodes[n].state));

  // The plane is dragged.
  await card('section').click();
  await page.selectOption('.plane select', 'z');
  const slider = page.locator('.plane input[type=range]');
  await slider.waitFor();
  const bar = await slider.boundingBox();
  const hash = (await until('it has a section', s => /axis: z/.test(s.document.text) && done(s)('section'))).nodes.section.outputs.image.hash;
  await page.mouse.move(bar.x + bar.width / 2, bar.y + bar.height / 2);
  await page.mouse.down();
  await page.mouse.move(bar.x + bar.width * 0.8, bar.y + bar.height / 2, { steps: 8 });
  await page.mouse.up();
  await until('the section is another', s => s.document.text.includes('offsets: ') && done(s)('section') && s.nodes.section.outputs.image.hash !== hash);
  await check('plane');
  await page.waitForFunction(async () => {
    const offset = /offsets: \[?([\d.]+)/.exec((await (await fetch('/api/state')).json()).document.text)?.[1];
    return Math.abs(offset - document.querySelector('.plane input[type=range]').value) < 0.02;
  });
  await idle();

  await page.keyboard.press('Control+s');
  s = await until('it is saved again', s => s.document.saved);
  result.file = s.document.file;
  result.after = s.document.text;
  result.contents = Object.fromEntries(Object.entries(s.nodes).map(([name, n]) => [name, Object.fromEntries(Object.entries(n.outputs).map(([port, o]) => [port, o.hash]))]));
});
