// node phases.mjs TERRAZZO FOLDER CHROMIUM: teaches a Phases node by strokes in its picture. Prints the observed states as one JSON object.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { launch, report, result, start, watch } from './session.mjs';

const [, , program, folder, executablePath] = process.argv;
const graph = join(folder, 'phases.yaml');
writeFileSync(graph, `# kept
terrazzo: 1
name: Phases
nodes:
  photo: {type: Pattern, params: {kind: marble, axis: z, width: 96, height: 64}}
  phases: {type: Phases, inputs: {image: photo.image}, params: {phases: 2, smoothing: 2}}
`);
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache')], { cwd: folder });
await report(server, async () => {
  const browser = await launch(executablePath);
  const page = await (await browser.newContext({ viewport: { width: 1360, height: 860 }, colorScheme: 'dark' })).newPage();
  page.setDefaultTimeout(60000);
  const { card, until, check } = watch(page);
  const shot = async name => process.env.SHOTS && page.screenshot({ path: join(process.env.SHOTS, `${name}.png`) });
  await page.goto(address);
  await card('phases').click();
  await page.waitForSelector('.panzoom canvas');
  await until('gray levels have found phases', s => s.nodes.phases?.state === 'computed');

  const button = k => page.locator('.pens button', { hasText: `Phase ${k}` });
  const drag = async (x, y, to) => {
    const picture = await page.locator('.panzoom .content').boundingBox();
    const at = (u, v) => [picture.x + picture.width * u, picture.y + picture.height * v];
    await page.mouse.move(...at(x, y));
    await page.mouse.down();
    await page.mouse.move(...at(to, y), { steps: 6 });
    await page.mouse.up();
  };
  result.in_order = await button(1).isDisabled();
  await button(0).click();
  await drag(0.1, 0.2, 0.3);
  let s = await until('a stroke is on phase 0', s => /on_phase_0.strokes/.test(s.document.text) && s.nodes.phases?.state === 'failed');
  result.says = s.nodes.phases.error.message;
  await page.waitForSelector('.panzoom canvas'); // the photograph is still there
  await button(1).click();
  await drag(0.6, 0.7, 0.8);
  await until('there are two phases', s => s.nodes.phases?.state === 'computed');
  await button(2).click();
  await drag(0.4, 0.5, 0.45);
  await until('there are three phases', s => s.nodes.phases?.metrics?.phases === 3);
  await button(1).click();
  await drag(0.6, 0.9, 0.8);
  s = await until('phase 1 has two strokes', s => s.nodes.phases?.state === 'computed' && (s.document.nodes.find(n => n.name === 'on_phase_1')?.params.strokes.value.length === 2));
  result.shown = await page.locator('.strokes polyline').count();
  result.text = s.document.text;
  await shot('phases');
  await check('phases');
  await page.click('.pens button:has-text("Done")');
  result.after = await page.locator('.strokes polyline').count();
  await button(1).click();
  for (const left of [3, 2, 1, 0]) {
    await page.click('button:has-text("Undo")');
    await until(`${left} strokes are left`, s => s.document.nodes.filter(n => n.type === 'Strokes').flatMap(n => n.params.strokes.value).length === left);
  }
  s = await until('the strokes are gone', s => !/on_phase/.test(s.document.text) && s.nodes.phases?.metrics?.phases === 2);
  result.undone = /phases: 2, smoothing: 2/.test(s.document.text);
  result.stale = await page.locator('.pens button[aria-pressed=true]').count();
  await drag(0.6, 0.7, 0.8); // the tool of phase 1, which is not the next one any more
  await button(0).click();
  for (const time of ['', ' again']) {
    await drag(0.1, 0.2, 0.3);
    s = await until(`a stroke is on phase 0${time}`, s => /on_phase_0/.test(s.document.text));
    if (time) break;
    await page.click('button:has-text("Undo")');
    await until('the stroke is gone', s => !/on_phase/.test(s.document.text));
  }
  result.nodes = s.document.nodes.filter(n => n.type === 'Strokes').map(n => n.name);
  await browser.close();
});
