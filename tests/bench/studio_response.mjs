// How the Studio's page responds, in Chromium with its software renderer: the first paint, results that are in the cache, frames while
// nodes compute, a graph of 200 nodes, 12,000 particles, and twelve pages at once.
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { loadavg, tmpdir } from 'node:os';
import { join } from 'node:path';

const sorted = list => [...list].sort((a, b) => a - b);
const at = (list, share) => sorted(list)[Math.min(list.length - 1, Math.floor(share * list.length))];
const say = (what, text) => console.log(`${what.padEnd(58)} ${text}   (load ${loadavg()[0].toFixed(1)})`);

// Intervals between frames while `act` runs: [median, 95th percentile] in ms, and frames per second.
async function frames(page, act) {
  await page.evaluate(() => {
    window.intervals = [], window.measuring = true;
    let before = performance.now();
    const tick = now => { window.intervals.push(now - before), before = now; if (window.measuring) requestAnimationFrame(tick); };
    requestAnimationFrame(tick);
  });
  await act();
  const list = await page.evaluate(() => { window.measuring = false; return window.intervals.slice(1); });
  const total = list.reduce((s, v) => s + v, 0);
  return `${((1000 * list.length) / total).toFixed(0)} frames/s, median ${at(list, 0.5).toFixed(0)} ms, 95 % below ${at(list, 0.95).toFixed(0)} ms`;
}

async function drag(page, box, seconds) {
  const x = box.x + box.width / 2, y = box.y + box.height / 2;
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (const end = Date.now() + 1000 * seconds, start = Date.now(); Date.now() < end;) {
    const a = (Date.now() - start) / 400;
    await page.mouse.move(x + 120 * Math.sin(a), y + 80 * Math.sin(0.7 * a));
  }
  await page.mouse.up();
}

export async function measureResponse(repository, { graphs, cache }) {
  const { chromium } = createRequire(join(repository, 'build/studio/package.json'))('playwright-core');
  const executablePath = process.env.CHROMIUM ?? '/usr/bin/chromium';
  const folder = mkdtempSync(join(tmpdir(), 'terrazzo-response-'));
  const browser = await chromium.launch({ executablePath, args: ['--no-sandbox', '--enable-unsafe-swiftshader'] });
  const open = async (graph, extra = []) => {
    const server = spawn(join(repository, 'build/release/terrazzo'), ['studio', graph, '--no-browser', '--cache', cache, ...extra], { cwd: folder, stdio: ['ignore', 'pipe', 'ignore'] });
    const [first] = await once(server.stdout, 'data');
    const context = await browser.newContext({ viewport: { width: 1360, height: 850 } }), page = await context.newPage();
    await page.addInitScript(() => {
      window.painted = 0;
      const put = CanvasRenderingContext2D.prototype.putImageData;
      CanvasRenderingContext2D.prototype.putImageData = function (...a) { put.apply(this, a); window.painted = performance.now(); };
    });
    page.setDefaultTimeout(300000);
    const start = Date.now();
    await page.goto(String(first).trim());
    await page.waitForSelector('.card');
    const ready = Date.now() - start;
    const state = () => page.evaluate(async () => (await fetch('/api/state')).json());
    const idle = async () => {
      for (;;) {
        const s = await state();
        if (!s.run.running && !Object.values(s.nodes).some(n => ['waiting', 'running'].includes(n.state))) return s;
        await page.waitForTimeout(200);
      }
    };
    return { server, context, page, ready, idle, address: String(first).trim() };
  };
  console.log('\nHow the page responds');
  try {
    const main = join(graphs, 'materials/terrazzo.yaml');
    let s = await open(main);
    await s.idle();
    const paints = [], cards = [];
    for (let k = 0; k < 5; ++k) {
      const start = Date.now();
      await s.page.goto(s.address);
      await s.page.waitForSelector('.card');
      cards.push(Date.now() - start);
      paints.push(await s.page.evaluate(() => performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? NaN));
    }
    say('first paint; the graph is there (ms, medians of 5)', `${at(paints, 0.5).toFixed(0)}; ${at(cards, 0.5)}`);

    const shows = [];
    for (const node of ['photo', 'segment', 'section', 'block', 'unfold', 'comparison', 'compare', 'sheet']) {
      if (!(await s.page.locator(`.react-flow__node[data-id="${node}"]`).count())) continue;
      const took = await s.page.evaluate(async node => {
        const start = performance.now();
        const card = document.querySelector(`.react-flow__node[data-id="${node}"] .card`), r = card.getBoundingClientRect();
        for (const type of ['pointerdown', 'mousedown', 'pointerup', 'mouseup', 'click'])
          card.dispatchEvent(new (type.startsWith('p') ? PointerEvent : MouseEvent)(type, { bubbles: true, clientX: r.x + 5, clientY: r.y + 5 }));
        for (;;) {
          await new Promise(requestAnimationFrame);
          const title = document.querySelector('.tabs b')?.textContent, stage = document.querySelector('.stage');
          // A picture of the node before stays until the new one is drawn.
          if (title === node && (stage.querySelector('table, .plot, .summary dl') || (stage.querySelector('canvas') && window.painted > start))) return performance.now() - start;
          if (performance.now() - start > 20000 || (title === node && /no outputs/.test(stage.textContent))) return NaN;
        }
      }, node);
      if (took > 0) shows.push(took);
    }
    say('a cached result is shown (ms, median; slowest)', `${at(shows, 0.5).toFixed(0)}; ${Math.max(...shows).toFixed(0)}`);

    await s.page.evaluate(() => fetch('/api/edit', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ edits: [{ op: 'set', node: 'detail', name: 'seed', value: '77' }] }) }));
    const pane = await s.page.locator('.react-flow__pane').boundingBox();
    say('frames while nodes compute, and the graph is panned', await frames(s.page, () => drag(s.page, { ...pane, y: pane.y - 200 }, 4)));
    await s.page.evaluate(() => fetch('/api/cancel', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: '{}' }));

    // Pages share one stream of events, because browsers open six connections to one host.
    const pages = [];
    for (let k = 0; k < 11; ++k) pages.push(await s.context.newPage());
    const start = Date.now();
    await Promise.all(pages.map(p => p.goto(s.address).then(() => p.waitForSelector('.card', { timeout: 120000 }))));
    const opened = Date.now() - start;
    const seen = Date.now();
    await s.page.evaluate(() => fetch('/api/edit', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ edits: [{ op: 'rename', node: 'photo', to: 'twelve' }] }) }));
    await Promise.all([s.page, ...pages].map(p => p.waitForSelector('.react-flow__node[data-id="twelve"]')));
    say('eleven more pages are open; all twelve show an edit (ms)', `${opened}; ${Date.now() - seen}`);
    await s.context.close();
    s.server.kill();

    const many = join(folder, 'many.yaml');
    writeFileSync(many, 'terrazzo: 1\nnodes:\n' + Array.from({ length: 100 }, (_, k) =>
      `  shape_${k}: {type: Shape, params: {kind: cube, size: ${k + 1}}}\n  sizes_${k}: {type: Distribution, inputs: {shapes: shape_${Math.max(0, k - (k % 7))}.shapes}, params: {kind: lognormal, mean: 1, sd: 0.3}}\n`).join(''));
    s = await open(many, ['--no-live']);
    await s.page.waitForTimeout(1000);
    const space = await s.page.locator('.react-flow__pane').boundingBox();
    await s.page.locator('[aria-label="Zoom out"]').click({ clickCount: 8 });
    say('panning 200 nodes, all of them in view', await frames(s.page, () => drag(s.page, space, 4)));
    await s.page.locator('[aria-label="Zoom in"]').click({ clickCount: 8 });
    say('panning 200 nodes, zoomed in', await frames(s.page, () => drag(s.page, space, 4)));
    await s.context.close();
    s.server.kill();

    const particles = join(folder, 'particles.yaml');
    writeFileSync(particles, 'terrazzo: 1\nnodes:\n  stone: {type: Shape, params: {kind: rock, size: 1}}\n'
      + '  sizes: {type: Distribution, params: {kind: lognormal, mean: 1, sd: 0.2, volume_fraction: 0.2}}\n'
      + '  pack: {type: Pack, inputs: {distribution: sizes.distribution, shapes: stone.shapes}, params: {method: anneal, count: 12000}}\n');
    s = await open(particles);
    await s.idle();
    await s.page.locator('.react-flow__node[data-id="pack"]').click();
    await s.page.waitForSelector('.stage3d canvas');
    await s.page.waitForFunction(() => /particles/.test(document.querySelector('.options')?.textContent ?? ''));
    const stage = await s.page.locator('.stage3d').boundingBox();
    say(`turning ${await s.page.locator('.options').first().textContent()}`.slice(0, 57), await frames(s.page, () => drag(s.page, stage, 5)));
    await s.context.close();
    s.server.kill();
  } finally {
    await browser.close();
    rmSync(folder, { recursive: true, force: true });
  }
}
