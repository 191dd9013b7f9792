// node variants.mjs TERRAZZO FOLDER CHROMIUM: shows a result for several values, cancels, keeps one with the keyboard, and undoes. Prints the
// observed states as one JSON object.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { openPage, report, result, start } from './session.mjs';

const [, , program, folder, executablePath] = process.argv;
const graph = join(folder, 'marble.yaml');
writeFileSync(graph, `# kept
terrazzo: 1
name: Marble
parameters:
  seed: {type: int, default: 3}
nodes:
  photo: {type: Pattern, params: {kind: marble, axis: z, width: 96, height: 64, seed: "\${seed}"}}
  phases: {type: Phases, inputs: {image: photo.image}, params: {phases: 2, smoothing: 2}}
  shape: {type: Shape, params: {kind: dodecahedron}}
  sizes: {type: Distribution, inputs: {shapes: shape.shapes}, params: {kind: lognormal, mean: 1, sd: 0.3, volume_fraction: 0.2}}
  pack: {type: Anneal, inputs: {distribution: sizes.distribution, shapes: shape.shapes}, params: {size: 6}}
  block: {type: RenderSolid, inputs: {particles: pack.particles, shapes: shape.shapes}, params: {width: 48, height: 48, samples: 4}}
`);
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache')], { cwd: folder });
await report(server, async () => {
  const { page, shot, card, state, until, idle, check } = await openPage(executablePath, { viewport: { width: 1440, height: 900 }, colorScheme: process.env.SCHEME ?? 'dark' });
  const tiles = page.locator('.tiles button');
  const finished = () => until('all variants are done', s => s.variants && !s.variants.running);
  await page.goto(address);
  await idle();

  // A parameter of the graph, for the labels: the values are suggested, and pictures fill the tiles.
  await card('phases').click();
  await page.waitForSelector('.panzoom canvas');
  await page.click('button:text-is("Variants")');
  result.offered = [await page.inputValue('.variants select'), await page.inputValue('.variants form input:not([type])')];
  result.groups = await page.locator('.variants optgroup').evaluateAll(all => all.map(g => g.label));
  await page.click('text=Show variants');
  let s = await finished();
  result.seeds = s.variants.tiles.map(t => t.state);
  result.different = new Set(s.variants.tiles.map(t => t.output.hash)).size;
  await page.waitForFunction(() => document.querySelectorAll('.tiles canvas').length === 6);
  result.kept_before = await page.locator('.tiles [aria-pressed=true]').evaluateAll(all => all.map(b => b.querySelector('b').textContent));
  await shot('variants_labels');
  await check('variants, dark');

  // With the keyboard: the third one is kept, as one step of undo, and nothing is computed again.
  await tiles.first().focus();
  for (let k = 0; k < 2; ++k) await page.keyboard.press('ArrowRight');
  await page.keyboard.press('Enter');
  s = await until('the seed is kept', s => /default: 5/.test(s.document.text));
  s = await idle();
  result.kept_text = s.document.text.split('\n')[4];
  result.kept_states = ['photo', 'phases'].map(n => s.nodes[n].state);
  result.same = s.nodes.phases.outputs.labels.hash === s.variants.tiles[2].output.hash;
  await page.waitForFunction(() => document.querySelector('.tiles [aria-pressed=true] b')?.textContent === '5');
  await page.click('button:text-is("Undo")');
  s = await until('undo returns', s => /default: 3/.test(s.document.text));
  result.undone = !s.document.can_undo;
  result.fits = s.document.varied;

  // A value that cannot be is an error of its tile; a change of another parameter makes the tiles old.
  await page.selectOption('.variants select', 'phases.phases');
  await page.fill('.variants form input:not([type])', '2, 1000, x');
  await page.click('text=Show variants');
  s = await until('the values have been tried', s => s.variants?.target === 'phases.phases' && !s.variants.running);
  result.tried = s.variants.tiles.map(t => t.state);
  await page.waitForFunction(() => document.querySelectorAll('.tiles .bad').length === 2);
  result.why = await page.locator('.tiles .bad').allTextContents();
  await shot('variants_errors');
  await page.fill('#field-smoothing', '3');
  await page.press('#field-smoothing', 'Enter');
  await page.waitForSelector('.variants .warning');
  await page.click('button:text-is("Undo")');
  await page.locator('.variants .warning').waitFor({ state: 'detached' });

  // Lists that are none.
  await page.fill('.variants form input:not([type])', '1:5:0');
  await page.click('text=Show variants');
  await page.waitForSelector('.notices .bad');
  result.refused = await page.textContent('.notices .bad b');
  await page.click('.notices >> text=Dismiss');
  result.errors.splice(0); // the refused request, which the browser logs

  // Renderings: previews come for all before the first is done, and Cancel leaves what is there.
  await card('block').click();
  await page.click('.viewer button:text-is("Pin")');
  await page.selectOption('.variants select', 'block.samples');
  await page.fill('.variants form input:not([type])', '20000, 30000, 40000');
  await page.click('text=Show variants');
  s = await until('all have previews', s => s.variants?.target === 'block.samples' && s.variants.tiles.every(t => t.preview));
  result.done_at_previews = s.variants.tiles.filter(t => t.state === 'done').length;
  await page.waitForFunction(() => document.querySelectorAll('.tiles canvas').length === 3);
  await shot('variants_previews');
  await page.click('text=Cancel variants');
  s = await finished();
  result.canceled = s.variants.tiles.map(t => t.state);
  await page.waitForFunction(() => document.querySelectorAll('.tiles em').length === 3 && [...document.querySelectorAll('.tiles em')].every(e => /canceled|kept/.test(e.textContent)));
  result.pictures_left = await page.locator('.tiles canvas').count();
  await page.reload();
  await page.click('button:text-is("Variants")');
  await tiles.nth(2).waitFor();
  result.after_reload = await tiles.count();

  // Particles are drawn by the program.
  await card('pack').click();
  await page.selectOption('.variants select', 'sizes.volume_fraction');
  result.fractions = await page.inputValue('.variants form input:not([type])');
  await page.click('text=Show variants');
  await until('packings are done', s => s.variants?.node === 'pack' && !s.variants.running);
  await page.waitForFunction(() => document.querySelectorAll('.tiles canvas').length === document.querySelectorAll('.tiles button').length);
  await shot('variants_particles');
  await page.setViewportSize({ width: 1024, height: 700 });
  await shot('variants_small');
  await check('variants, small');
  result.text_at_end = (await state()).document.text.split('\n')[4];
});
