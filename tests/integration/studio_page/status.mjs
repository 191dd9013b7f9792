// node status.mjs TERRAZZO FOLDER CHROMIUM: what an evaluation says of itself, warnings, what the browser keeps, and small windows. Prints the
// observed states as one JSON object.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { drawn, launch, report, result, sooner, start, watch } from './session.mjs';

const [, , program, folder, executablePath] = process.argv;
const graph = join(folder, 'status.yaml');
writeFileSync(graph, `terrazzo: 1
name: A solid of dodecahedra
parameters: {resolution: {type: int, default: 24}}
nodes:
  marble: {type: Pattern, params: {kind: marble, axis: z, width: 96, height: 64}}
  shape: {type: Shape, params: {kind: dodecahedron}}
  sizes: {type: Distribution, inputs: {shapes: shape.shapes}, params: {kind: lognormal, mean: 1, sd: 0.3, volume_fraction: 0.2}}
  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: shape.shapes}, params: {size: 12}}
  voxels: {type: Voxelize, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {resolution: "\${resolution}"}}
  block: {type: RenderSolid, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {width: 64, height: 64, samples: 4}}
  sheet: {type: ContactSheet, inputs: {images: [block.image, marble.image]}}
`);
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache')], { cwd: folder });
await report(server, async () => {
  const browser = await launch(executablePath, '--enable-unsafe-swiftshader');
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 }, colorScheme: 'dark' });
  // What an earlier page left, damaged. It is written before the first page only.
  await context.addInitScript(() => {
    if (localStorage.getItem('seen')) return;
    for (const [name, text] of Object.entries({ seen: 'yes', 'terrazzo.light': '{"surrounding":', 'terrazzo.seconds': '{"RenderSolid": "long", "Anneal": null}', 'terrazzo.panel': '{"share": -3}', 'terrazzo.graph': '[[' }))
      localStorage.setItem(name, text);
  });
  const page = await context.newPage();
  page.setDefaultTimeout(60000);
  const shot = async name => process.env.SHOTS && page.screenshot({ path: join(process.env.SHOTS, `${name}.png`) });
  const { card, until, idle, check } = watch(page);
  const edit = edits => page.evaluate(async edits => {
    await fetch('/api/edit', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ edits }) });
  }, edits);
  const status = () => page.textContent('.status');
  const panel = () => page.evaluate(() => document.querySelector('aside').offsetWidth / window.innerWidth);
  await page.goto(address);
  await page.waitForSelector('.card');
  await idle();

  // Half of the window is the viewer's, until a person drags the border. The browser keeps that.
  result.half = await panel();
  await page.focus('.splitter');
  for (let k = 0; k < 8; ++k) await page.keyboard.press('ArrowRight');
  await page.reload();
  await page.waitForSelector('.card');
  result.kept = await panel();
  await page.focus('.splitter');
  for (let k = 0; k < 8; ++k) await page.keyboard.press('ArrowLeft');

  // A warning stays when the result gets worse.
  const warning = card('voxels').locator('.warn');
  const missing = async () => Number(/^(\d+) of/.exec(await warning.getAttribute('title'))[1]);
  const resolve = async n => {
    await edit([{ op: 'set_default', name: 'resolution', value: String(n) }]);
    await until('voxels are filled', s => s.document.text.includes(`default: ${n}}`) && s.nodes.voxels.state === 'computed');
    await drawn(page);
  };
  await warning.waitFor();
  result.missing = [await missing()];
  await resolve(12);
  result.missing.push(await sooner(missing, n => n > result.missing[0]));
  await page.click('button:has-text("Messages")');
  result.messages = await page.textContent('.messages');
  await shot('warning');
  await page.click('button:has-text("Messages")');

  // Paused: what an edit would run, and nothing runs.
  await page.click('label:has-text("Live") input');
  await edit([{ op: 'set', node: 'block', name: 'samples', value: '8' }]);
  result.paused = await sooner(status, s => /paused/.test(s));
  result.stale = await card('block').locator('.badge').getAttribute('aria-label');
  await shot('paused');
  await page.click('label:has-text("Live") input');
  await idle();

  // Pictures in the cards leave their times.
  const times = () => page.locator('.card time').evaluateAll(all => all.filter(t => t.textContent && t.offsetWidth && getComputedStyle(t).visibility === 'visible').length);
  await edit([{ op: 'set', node: 'marble', name: 'seed', value: '3' }]); // so that nodes have computed
  await idle();
  result.times = [await times()];
  await page.click('button:text-is("Pictures")');
  await page.waitForSelector('.card .thumb canvas');
  result.times.push(await times());
  result.covered = await page.evaluate(() => [...document.querySelectorAll('.card:has(.thumb) :is(time, b)')].filter(t => t.textContent).filter(t => {
    const r = t.getBoundingClientRect(), top = document.elementFromPoint(r.left + r.width / 2, r.top + r.height / 2);
    return top && !t.contains(top) && top.closest('.thumb');
  }).length);
  await shot('pictures_times');
  await page.click('button:text-is("Pictures")');

  // How far all is and how long it takes: at once, and after the page is loaded again.
  await edit(Object.entries({ width: '4000', height: '4000', samples: '1024' }).map(([name, value]) => ({ op: 'set', node: 'block', name, value })));
  await until('the block is rendered', s => s.nodes.block.state === 'running');
  result.running = [await sooner(status, s => /of \d+ nodes/.test(s))];
  result.queued = await card('sheet').locator('.badge').getAttribute('aria-label');
  result.bar = await sooner(() => page.getAttribute('.waiting [role=progressbar]', 'aria-valuenow'), n => n !== null);
  await page.reload();
  await page.waitForSelector('.card');
  result.running.push(await sooner(status, s => /of \d+ nodes/.test(s)));
  await shot('running');
  await page.click('.top button:text-is("Cancel")');
  result.canceled = await sooner(status, s => /canceled/.test(s));
  await edit([{ op: 'set', node: 'block', name: 'width', value: '64' }, { op: 'set', node: 'block', name: 'height', value: '64' }, { op: 'set', node: 'block', name: 'samples', value: '4' }]);
  await idle();

  // In a window of 720 pixels, nothing that is written lies over something else.
  await page.setViewportSize({ width: 720, height: 450 });
  const overprinted = () => page.evaluate(() => {
    const leaves = [...document.querySelectorAll('.top *, .tools *, .viewer *, .inspector *, .drawer *')].filter(e => e.checkVisibility() && !e.closest('.panzoom, .stage3d, svg, .tiles, .sr') && (e.matches('input, button, select, canvas') || [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim())));
    const boxes = leaves.map(e => {
      const r = e.getBoundingClientRect(), s = e.closest('.tabs .ports, .stage, .inspector, .drawer, .app').getBoundingClientRect(); // which clips it
      return { e, r: { left: Math.max(r.left, s.left), right: Math.min(r.right, s.right), top: Math.max(r.top, s.top), bottom: Math.min(r.bottom, s.bottom) } };
    }).filter(({ r }) => r.left < r.right && r.top < r.bottom);
    return boxes.flatMap(({ e, r }, k) => boxes.slice(k + 1).filter(({ e: f, r: s }) => !e.contains(f) && !f.contains(e) && r.left < s.right - 1 && s.left < r.right - 1 && r.top < s.bottom - 1 && s.top < r.bottom - 1)
      .map(({ e: f }) => `${e.outerHTML.slice(0, 60)} and ${f.outerHTML.slice(0, 60)}`));
  });
  result.over = {};
  for (const [name, node] of Object.entries({ material: '', picture: 'marble', particles: 'pack', voxels: 'voxels' })) {
    if (node) await page.evaluate(n => document.querySelector(`.react-flow__node[data-id="${n}"]`).click(), node);
    await page.waitForSelector(node === 'marble' || !node ? '.viewer .panzoom canvas' : '.viewer .stage3d canvas');
    await drawn(page);
    result.over[name] = await overprinted();
    await shot(`small_${name}`);
  }
  await page.click('.top button:text-is("Panels")');
  await page.click('[role=menuitem]:has-text("Variants")');
  await page.waitForSelector('.variants form');
  result.over.variants = await overprinted();
  await shot('small_variants');
  await check('small');
});
