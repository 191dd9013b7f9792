// node check.mjs FOLDER SHADER CHROMIUM [PICTURE.png]: samples FOLDER/solid.png and solid.ktx2 in three.js with SHADER on the plane of
// points that FOLDER/points.json describes, and prints the linear values as one JSON object. With PICTURE, also takes a picture of a
// block, textured by the slices.
import { readFile, writeFile } from 'node:fs/promises';
import { extname, join } from 'node:path';
import { chromium } from 'playwright-core';

const [, , folder, shader, executablePath, picture] = process.argv;
const three = new URL('node_modules/three/', import.meta.url).pathname;
const types = { '.js': 'text/javascript', '.png': 'image/png', '.html': 'text/html', '.json': 'application/json' };
const page_text = `<!doctype html><script type="importmap">{"imports": {"three": "/three/build/three.module.js",
  "three/addons/": "/three/examples/jsm/"}}</script><script type="module" src="/page.js"></script>`;

const browser = await chromium.launch({ executablePath, args: ['--no-sandbox', '--enable-unsafe-swiftshader'] });
const errors = [];
try {
  const page = await browser.newPage({ viewport: { width: 640, height: 640 } });
  page.on('pageerror', e => errors.push(e.message));
  page.on('console', m => ['error', 'warning'].includes(m.type()) && errors.push(m.text()));
  await page.route('http://terrazzo.test/**', async route => {
    const { pathname } = new URL(route.request().url());
    if (pathname === '/') return route.fulfill({ contentType: 'text/html', body: page_text });
    const file = pathname === '/page.js' ? new URL('page.js', import.meta.url).pathname
      : pathname === '/shader.glsl' ? shader
        : pathname.startsWith('/three/') ? join(three, pathname.slice(7)) : join(folder, pathname);
    try {
      await route.fulfill({ contentType: types[extname(file)] ?? 'application/octet-stream', body: await readFile(file) });
    } catch {
      await route.fulfill({ status: 404, body: '' });
    }
  });
  await page.goto('http://terrazzo.test/');
  await page.waitForFunction(() => window.sample);
  const result = await page.evaluate(() => window.sample());
  if (picture) {
    await page.evaluate(() => window.show());
    await writeFile(picture, await page.locator('canvas').screenshot());
  }
  console.log(JSON.stringify({ ...result, errors: errors.filter(e => !/GPU stall|favicon/.test(e)) }));
} finally {
  await browser.close();
}
