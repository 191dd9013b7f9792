// What the scripts of this folder share: the Studio, its browser, and what they see of a page.
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';
import { chromium } from 'playwright-core';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const browsers = [];
export const result = { errors: [], violations: [] };

// Starts the Studio. Its first line is its address.
export async function start(program, args, options = {}) {
  const server = spawn(program, ['studio', ...args, '--no-browser'], { ...options, stdio: ['ignore', 'pipe', 'inherit'] });
  const [first] = await once(server.stdout, 'data');
  return { server, address: String(first).trim() };
}

export async function launch(executablePath, ...args) {
  browsers.push(await chromium.launch({ executablePath, args: ['--no-sandbox', ...args] }));
  return browsers.at(-1);
}

// A page in a browser of its own, with what watch() returns, and `shot(name)`, which saves a picture if SHOTS names a folder.
export async function openPage(executablePath, options) {
  const page = await (await launch(executablePath)).newPage(options);
  page.setDefaultTimeout(60000);
  const shot = async name => process.env.SHOTS && page.screenshot({ path: join(process.env.SHOTS, `${name}.png`) });
  return { page, shot, ...watch(page) };
}

// Until the view shows what fits of the graph as it is now.
export const fitted = page => page.waitForFunction(() => {
  const flow = document.querySelector('.flow');
  return flow.dataset.fitted === `${flow.clientWidth} ${flow.clientHeight} ${document.querySelectorAll('.react-flow__node').length}`;
});
// Until the page has drawn what it knows.
export const drawn = page => page.evaluate(() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done))));

// Repeats `look` until `good` holds of what it gives, at most 10 s, and returns that.
export async function sooner(look, good) {
  for (const end = Date.now() + 10000; ;) {
    const seen = await look();
    if (good(seen) || Date.now() > end) return seen;
    await new Promise(done => setTimeout(done, 50));
  }
}

// Does `work`, adds its error to the result, ends the browsers and the Studio, and prints the result.
export async function report(server, work) {
  try {
    await work();
  } catch (e) {
    result.errors.push(String(e));
  } finally {
    for (const browser of browsers) await browser.close();
    server.kill();
  }
  console.log(JSON.stringify(result));
}

// Adds the page's errors to the result. Returns what scripts ask of a page.
export function watch(page) {
  page.on('pageerror', e => result.errors.push(e.message));
  page.on('console', m => m.type() === 'error' && result.errors.push(m.text()));
  const card = name => page.locator(`.react-flow__node[data-id="${name}"]`);
  const state = () => page.evaluate(async () => (await fetch('/api/state')).json());
  const until = async (what, holds) => {
    for (const end = Date.now() + 90000; Date.now() < end; await page.waitForTimeout(100)) {
      const s = await state();
      if (holds(s)) return s;
    }
    throw new Error(`waited in vain until ${what}`);
  };
  const idle = () => until('all is computed', s => !s.run.running && !Object.values(s.nodes).some(n => ['waiting', 'running'].includes(n.state)));
  // Adds what hinders some users to the result.
  const check = async where => {
    await page.evaluate(axe);
    const found = await page.evaluate(() => axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'best-practice'] }));
    for (const v of found.violations) result.violations.push(`${where}: ${v.id}: ${v.nodes.map(n => n.html.slice(0, 120)).slice(0, 2).join(' ')}`);
  };
  return { card, state, until, idle, check };
}
