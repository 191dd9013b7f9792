// node studio.mjs REPOSITORY [GRAPH | response | pictures]: how soon the Studio's page shows an edit, in Chromium. For each edit: the first new picture, the
// final one, and how long the nodes compute that a page without previews and kept geometry waits for.
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { mkdtempSync, rmSync, cpSync } from 'node:fs';
import { createRequire } from 'node:module';
import { loadavg, tmpdir } from 'node:os';
import { join } from 'node:path';

import { takePictures } from './studio_pictures.mjs';
import { measureResponse } from './studio_response.mjs';

const [, , repository, only = ''] = process.argv;
const { chromium } = createRequire(join(repository, 'build/studio/package.json'))('playwright-core');
const executablePath = process.env.CHROMIUM ?? '/usr/bin/chromium';
const folder = mkdtempSync(join(tmpdir(), 'terrazzo-bench-'));
cpSync(join(repository, 'graphs'), join(folder, 'graphs'), { recursive: true });
const median = list => [...list].sort((a, b) => a - b)[list.length >> 1];
const ms = x => String(Math.round(x)).padStart(7);

// Each case: the node that is shown, the node and the parameter that change, its values, the nodes that run. The graphs share a cache, so
// no value may come twice.
const cases = {
  'materials/terrazzo.yaml': [
    ['block', 'block', 'azimuth', [-30, -20, -10, -50, -60], ['block']],
    ['block', 'block', 'gloss', [0.1, 0.2, 0.5, 0.6, 0.7], ['block']],
    ['block', 'colorize', 'seed', [2, 3, 4, 5, 6], ['colorize', 'block']],
    ['section', 'colorize', 'seed', [7, 8, 9, 10, 11], ['colorize', 'section']],
    ['section', 'section', 'seed', [2, 3, 4, 5, 6], ['section']],
    ['section', 'detail', 'seed', [2, 3], ['detail', 'section']],
  ],
  'library/aggregate.yaml': [
    ['section', 'section', 'seed', [12, 13, 14, 15, 16], ['section']],
    ['section', 'colorize', 'seed', [17, 18, 19, 20, 21], ['colorize', 'section']],
    ['section', 'detail', 'seed', [4, 5], ['detail', 'section']],
  ],
};

async function measure(graph, list) {
  const server = spawn(join(repository, 'build/release/terrazzo'), ['studio', join(folder, 'graphs', graph), '--no-browser', '--cache', join(folder, 'cache')],
    { cwd: folder, stdio: ['ignore', 'pipe', 'ignore'] });
  const [first] = await once(server.stdout, 'data');
  const browser = await chromium.launch({ executablePath, args: ['--no-sandbox', '--enable-unsafe-swiftshader'] });
  const page = await browser.newPage({ viewport: { width: 1360, height: 850 } });
  page.setDefaultTimeout(180000);
  await page.addInitScript(() => {
    window.drawn = [];
    const put = CanvasRenderingContext2D.prototype.putImageData;
    CanvasRenderingContext2D.prototype.putImageData = function (...a) { put.apply(this, a); requestAnimationFrame(() => window.drawn.push(performance.now())); };
  });
  await page.goto(String(first).trim());
  const state = () => page.evaluate(async () => (await fetch('/api/state')).json());
  const idle = async () => {
    for (;;) {
      const s = await state();
      if (!s.run.running && !Object.values(s.nodes).some(n => ['waiting', 'running'].includes(n.state))) return s;
      await page.waitForTimeout(100);
    }
  };
  const post = (path, body) => page.evaluate(([p, b]) => fetch(p, { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(b) }), [path, body]);
  await idle();
  console.log(`\n${graph.padEnd(40)}  first   final  baseline  first/baseline   (median, ms; load ${loadavg()[0].toFixed(1)})`);
  for (const [shown, node, name, values, runs] of list) {
    await page.click(`.react-flow__node[data-id="${shown}"]`);
    await page.waitForSelector('.panzoom canvas');
    const firsts = [], finals = [], baselines = [];
    for (const value of values) {
      await idle();
      await page.evaluate(async ([node, name, value]) => {
        window.drawn.length = 0, window.started = performance.now();
        await fetch('/api/edit', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ edits: [{ op: 'set', node, name, value: String(value) }] }) });
      }, [node, name, value]);
      const seen = await page.waitForFunction(() => window.drawn.length && window.drawn[0] - window.started);
      firsts.push(await seen.jsonValue());
      const now = await idle();
      await page.waitForFunction(() => !document.querySelector('.tabs .old'));
      await page.waitForTimeout(200);
      finals.push(await page.evaluate(() => window.drawn.at(-1) - window.started));
      baselines.push(runs.reduce((s, n) => s + now.nodes[n].seconds, 0) * 1000);
    }
    const [a, b, c] = [firsts, finals, baselines].map(median);
    console.log(`${`${node}.${name}, ${shown} is shown`.padEnd(38)} ${ms(a)} ${ms(b)} ${ms(c)}   ${(a / c).toFixed(2).padStart(10)}`);
  }
  await post('/api/cancel', {});
  await browser.close();
  server.kill();
}

try {
  if (only === 'pictures') await takePictures(repository);
  for (const [graph, list] of Object.entries(cases)) if (graph.includes(only)) await measure(graph, list);
  if ('response'.includes(only)) await measureResponse(repository, { graphs: join(folder, 'graphs'), cache: join(folder, 'cache') });
} finally {
  rmSync(folder, { recursive: true });
}
