// The pictures of docs/studio.md, taken in Chromium: `./dev bench studio pictures`. Everything that they show is made here or belongs to
// the project. The results of the default material come from the cache of `./dev gallery`, or are computed first, which takes minutes.
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const most = 120_000; // bytes of a picture

// A cut of dark stones with thin joints, under round pools of cement, which Segment takes for the particles. Runs in the page.
function stonesUnderPools() {
  const width = 480, height = 360, cell = 80;
  let seed = 5;
  const random = () => (seed = (seed * 16807) % 2147483647) / 2147483647;
  const stones = [], pools = [], kinds = [[84, 79, 78], [112, 83, 70], [92, 95, 104]];
  for (let y = -cell; y < height + cell; y += cell)
    for (let x = -cell; x < width + cell; x += cell) stones.push({ x: x + cell * random(), y: y + cell * random(), color: kinds[Math.floor(3 * random())] });
  for (let k = 0; k < 4000 && pools.length < 52; ++k) {
    const p = { x: width * random(), y: height * random(), r: 10 + 14 * random() ** 2 };
    if (pools.every(q => Math.hypot(p.x - q.x, p.y - q.y) > p.r + q.r + 16)) pools.push(p);
  }
  const canvas = document.createElement('canvas');
  canvas.width = width, canvas.height = height;
  const c = canvas.getContext('2d'), image = c.createImageData(width, height);
  for (let y = 0; y < height; ++y)
    for (let x = 0; x < width; ++x) {
      const [a, b] = stones.map(s => ({ s, d: Math.hypot(x - s.x, y - s.y) })).sort((a, b) => a.d - b.d);
      const cement = b.d - a.d < 5 || pools.some(p => Math.hypot(x - p.x, y - p.y) < p.r), grain = 0.93 + 0.14 * random();
      image.data.set((cement ? [196, 186, 166] : a.s.color).map(v => v * grain).concat(255), 4 * (y * width + x));
    }
  c.putImageData(image, 0, 0);
  return canvas.toDataURL('image/png').split(',')[1];
}

export async function takePictures(repository) {
  const { chromium } = createRequire(join(repository, 'build/studio/package.json'))('playwright-core');
  const executablePath = process.env.CHROMIUM ?? '/usr/bin/chromium';
  const folder = mkdtempSync(join(tmpdir(), 'terrazzo-pictures-')), materials = join(folder, 'materials'), out = join(repository, 'docs/images');
  mkdirSync(materials);
  const browser = await chromium.launch({ executablePath, args: ['--no-sandbox', '--enable-unsafe-swiftshader'] });
  const servers = [];

  const open = async (graph, cache, colorScheme, height = 850) => {
    const server = spawn(join(repository, 'build/release/terrazzo'), ['studio', ...graph, '--no-browser', '--cache', cache], { cwd: materials, stdio: ['ignore', 'pipe', 'inherit'] });
    servers.push(server);
    const [first] = await once(server.stdout, 'data');
    const page = await browser.newPage({ viewport: { width: 1360, height }, colorScheme });
    page.setDefaultTimeout(60000);
    await page.goto(String(first).trim());
    const state = () => page.evaluate(async () => (await fetch('/api/state')).json());
    const until = async (holds, minutes = 2) => {
      for (const end = Date.now() + 60000 * minutes; Date.now() < end; await page.waitForTimeout(100)) {
        const s = await state();
        if (holds(s)) return s;
      }
      throw new Error(`waited in vain until ${holds}`);
    };
    return {
      page, until,
      idle: minutes => until(s => !s.run.running && !Object.values(s.nodes).some(n => ['waiting', 'running'].includes(n.state)), minutes),
      card: name => page.locator(`.react-flow__node[data-id="${name}"]`),
      tab: name => page.click(`.tabs .ports button:text-is("${name}")`),
      shoot: async (name, what = page) => {
        await page.waitForTimeout(800); // for transitions
        for (let quality = 88; ; quality -= 6) {
          const bytes = await what.screenshot({ type: 'jpeg', quality });
          if (bytes.length > most && quality > 40) continue;
          writeFileSync(join(out, `studio_${name}.jpg`), bytes);
          console.log(`docs/images/studio_${name}.jpg  ${bytes.length} bytes`);
          return;
        }
      },
    };
  };

  // From a photograph to a material, as docs/studio.md walks through it.
  const walk = async () => {
    const { page, until, idle, card, tab, shoot } = await open([], join(folder, 'cache'), 'dark', 760);
    const panel = page.locator('aside');
    const done = s => n => ['computed', 'cached'].includes(s.nodes[n]?.state);
    await page.waitForSelector('.materials img');
    const picture = await page.evaluate(stonesUnderPools);
    const files = await page.evaluateHandle(async data => {
      const files = new DataTransfer();
      files.items.add(new File([Uint8Array.from(atob(data), c => c.charCodeAt(0))], 'stones.png', { type: 'image/png' }));
      return files;
    }, picture);
    for (const type of ['dragover', 'drop']) await page.dispatchEvent('.start', type, { dataTransfer: files });
    await page.waitForSelector('.new >> text=Recommended:');
    await page.click('text=particles, such as stones');
    await shoot('start');
    await page.click('text=Create the material');
    await until(s => s.document.file.endsWith('stones.yaml'));
    await card('segment').waitFor();
    // A small block, so that this takes a minute.
    await page.evaluate(async () => {
      const small = { count: '200', resolution: '96', sections: '2', shapes: '1', shape_method: 'morphed_generalized_cylinder' };
      const edits = Object.entries(small).map(([name, value]) => ({ op: 'set_default', name, value }));
      await fetch('/api/edit', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ edits }) });
    });
    await card('segment').click();
    await until(s => done(s)('segment'));

    const at = async (x, y) => {
      const box = await page.locator('.panzoom .content').boundingBox();
      return [box.x + (x / 480) * box.width, box.y + (y / 360) * box.height];
    };
    await page.click('button:has-text("Pick binder")');
    await page.waitForSelector('.panzoom .content canvas');
    const pool = await page.evaluate(async data => {
      const image = new Image();
      image.src = `data:image/png;base64,${data}`;
      await image.decode();
      const canvas = document.createElement('canvas');
      canvas.width = image.width, canvas.height = image.height;
      const c = canvas.getContext('2d');
      c.drawImage(image, 0, 0);
      const light = (x, y) => c.getImageData(x - 8, y - 8, 17, 17).data.filter((_, k) => k % 4 === 0).every(v => v > 150);
      for (let y = 150; y < 330; y += 3) for (let x = 200; x < 450; x += 3) if (light(x, y)) return [x, y];
    }, picture);
    await page.mouse.move(...await at(...pool));
    await shoot('binder', panel);
    await page.mouse.click(...await at(...pool));
    let s = await until(s => s.document.text.includes('binder: {type: color, default: "#') && s.nodes.segment.state === 'computed');

    // The largest stones are split from top to bottom.
    await page.click('button:has-text("Split")');
    for (const first of [true, false]) {
      const node = first ? 'segment' : 'edit_labels';
      const found = await page.evaluate(async hash => (await fetch(`/api/value/${hash}?as=outlines`)).json(), s.nodes[first ? 'segment' : 'measure'].outputs.profiles.hash);
      const size = found.window[0] / 480, inside = found.profiles.filter(p => p.points.length && p.points.every(([x, y]) => x > 2 * size && y > 2 * size && x < found.window[0] - 2 * size && y < found.window[1] - 2 * size));
      const stone = inside.sort((a, b) => b.area - a.area)[first ? 0 : 3], ys = stone.points.map(p => found.window[1] - p[1]), x = stone.center[0] / size;
      await page.waitForFunction(name => document.querySelector('.tabs b')?.textContent === name, node);
      await page.mouse.move(...await at(x, Math.min(...ys) / size - 4));
      await page.mouse.down();
      await page.mouse.move(...await at(x, Math.max(...ys) / size + 4), { steps: 12 });
      if (first) await shoot('split', panel);
      await page.mouse.up();
      const splits = first ? 1 : 2;
      s = await until(s => done(s)('measure') && (s.document.text.match(/split \d/g) ?? []).length >= splits);
    }
    await page.keyboard.press('Escape');
    await idle();
    await page.click('button:text-is("Fit")'); // the corrections added two nodes

    // The price of another size, and then the size.
    await page.keyboard.press('Escape');
    await page.click('.react-flow__pane', { position: { x: 20, y: 20 } });
    await page.fill('#field-size', '30');
    await page.waitForSelector('.card.priced');
    await shoot('price');
    await page.press('#field-size', 'Enter');
    await until(s => /size: .*default: 30/.test(s.document.text));
    await idle();

    await card('section').click();
    await page.selectOption('.plane select', 'y');
    await page.locator('.plane input[type=range]').waitFor();
    await tab('Plane in 3D');
    await page.click('.tabs button:text-is("Wide")');
    await page.waitForSelector('.cutting .stage3d canvas');
    await idle();
    const bar = await page.locator('.plane input[type=range]').boundingBox();
    await page.mouse.move(bar.x + bar.width / 2, bar.y + bar.height / 2);
    await page.mouse.down();
    await page.mouse.move(bar.x + bar.width * 0.4, bar.y + bar.height / 2, { steps: 8 });
    await page.mouse.up();
    await idle();
    await shoot('plane');

    await page.click('.tabs button:text-is("Wide")');
    await tab('image');
    await page.keyboard.press('Control+s');
    await until(s => s.document.saved);
    await page.click('button:text-is("YAML")');
    await page.click('.title .link');
    await shoot('saved');
  };

  const material = async () => {
    const graph = join(repository, 'graphs/materials/terrazzo.yaml'), cache = join(repository, 'build/gallery/cache');
    const dark = await open([graph], cache, 'dark');
    await dark.idle(20);
    await dark.card('segment').click();
    await dark.page.waitForSelector('.panzoom canvas');
    await dark.shoot('dark');
    await dark.tab('Linked');
    await dark.page.click('.tabs button:text-is("Wide")');
    await dark.page.waitForSelector('.linked .stage3d canvas');
    await dark.page.locator('.linked .plot .pick').nth(4).click({ force: true });
    await dark.shoot('linked');
    await dark.page.close();
    const light = await open([graph], cache, 'light');
    await light.idle();
    await light.card('pack').click();
    await light.page.waitForFunction(() => /\d particles/.test(document.querySelector('.options')?.textContent ?? ''));
    await light.shoot('light');
  };

  try {
    const only = process.argv[4] ?? '';
    if ('walk'.includes(only)) await walk();
    if ('material'.includes(only)) await material();
  } finally {
    await browser.close();
    for (const server of servers) server.kill();
    rmSync(folder, { recursive: true, force: true });
  }
}
