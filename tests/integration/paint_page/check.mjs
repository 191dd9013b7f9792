// node check.mjs TERRAZZO IMAGE GRAPH CHROMIUM: picks a nib, paints, undoes and saves to GRAPH like a user. Prints the
// observed states as one JSON object.
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { chromium } from 'playwright-core';

const [, , program, image, graph, executablePath] = process.argv;
const server = spawn(program, ['paint', image, '--save', graph], { stdio: ['ignore', 'pipe', 'inherit'] });
const [first] = await once(server.stdout, 'data');
const address = String(first).trim();
const browser = await chromium.launch({ executablePath, args: ['--no-sandbox'] });
const result = { errors: [] };
try {
  const page = await browser.newPage({ viewport: { width: 1100, height: 750 } });
  page.on('pageerror', (e) => result.errors.push(e.message));
  page.on('console', (m) => m.type() === 'error' && result.errors.push(m.text()));
  await page.goto(address);
  const settled = async () => {
    await page.waitForFunction(() => document.body.dataset.busy === '0');
  };
  const pixels = async () => (await page.evaluate(() => terrazzo.pixels())).join();
  const strokes = () => page.evaluate(() => terrazzo.state().strokes);
  const status = () => page.textContent('#status');
  const drag = async (points) => {
    for (const [i, [x, y]] of points.entries()) {
      const at = await page.evaluate(([x, y]) => terrazzo.screenAt(x, y), [x, y]);
      await page.mouse.move(at[0], at[1], { steps: i ? 5 : 1 });
      if (i === 0) await page.mouse.down();
    }
    await page.mouse.up();
    await settled();
  };
  await settled();
  const untouched = await pixels();

  await page.keyboard.press('p'); // without a nib
  await drag([[60, 40], [62, 42]]);
  result.without_nib = { status: await status(), unchanged: (await pixels()) === untouched };

  await page.keyboard.press('r');
  await drag([[2, 2], [42, 62]]);
  result.nib = await page.textContent('#nib');
  await page.fill('#size', '16');
  await drag([[54, 36], [60, 40], [66, 46]]);
  const one = await pixels();
  result.painted = one !== untouched;
  result.milliseconds = parseFloat((await status()).match(/([\d.]+) ms/)?.[1] ?? 'NaN');
  await drag([[58, 30], [66, 34]]);
  const two = await pixels();
  result.painted_again = two !== one && (await strokes()) === 2;
  await page.click('#undo');
  await settled();
  result.undone = (await pixels()) === one && (await strokes()) === 1;

  await page.selectOption('#view', 'occupancy');
  await settled();
  const occupancy = await page.evaluate(() => terrazzo.pixels());
  result.occupied = occupancy.filter((v, i) => i % 4 === 0 && v === 255).length;
  await page.selectOption('#view', 'base_relative');
  await settled();
  result.base_relative = (await pixels()) !== one;
  await page.selectOption('#view', 'picture');
  await settled();

  await page.keyboard.press('o'); // another nib, with its texture outlined
  await drag([[3, 3], [40, 6], [44, 40], [30, 60], [4, 56]]);
  result.corners = await page.evaluate(() => terrazzo.state().nib.region.length / 2);
  result.outlined = await page.textContent('#nib');
  await page.keyboard.press('p');
  await page.fill('#extent', '2'); // another kernel for it
  await page.dispatchEvent('#extent', 'change');
  await settled();
  await page.fill('#size', '60'); // a dab takes longer than a frame
  await drag([[56, 44], [64, 48], [70, 40]]);
  const last = await pixels();
  await page.click('#save');
  await settled();
  result.saved = await status();
  result.state = await page.evaluate(() => fetch('/api/state').then((r) => r.json()));
  const served = new Uint8Array(await page.evaluate(() => fetch('/api/view?kind=picture').then((r) => r.arrayBuffer()).then((b) => Array.from(new Uint8Array(b)))));
  result.shows_what_is_served = Array.from(served).join() === last;
} catch (e) {
  result.errors.push(String(e));
} finally {
  await browser.close();
  server.kill('SIGINT');
}
result.exit_code = server.exitCode ?? (await once(server, 'exit'))[0];
console.log(JSON.stringify(result));
