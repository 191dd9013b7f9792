// node habits.mjs TERRAZZO FOLDER CHROMIUM: what editors have: menus of nodes, a search for nodes and commands, F2, and the list of keys. Prints
// the observed states as one JSON object.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { openPage, report, result, start } from './session.mjs';

const [, , program, folder, executablePath] = process.argv;
const graph = join(folder, 'marble.yaml');
writeFileSync(graph, `terrazzo: 1
name: Marble
nodes:
  photo: {type: Pattern, params: {kind: marble, axis: z, width: 96, height: 64}}
  phases: {type: Phases, inputs: {image: photo.image}, params: {phases: 2}}
`);
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache')], { cwd: folder });
await report(server, async () => {
  const { page, shot, card, until, idle, check } = await openPage(executablePath, { viewport: { width: 1280, height: 800 }, colorScheme: 'dark' });
  const selected = () => page.locator('.react-flow__node.selected').evaluateAll(all => all.map(n => n.dataset.id));
  const focused = () => page.evaluate(() => document.activeElement?.getAttribute('aria-label') ?? document.activeElement?.textContent);
  await page.goto(address);
  await idle();

  // The menu of a node: the first entry has the focus, arrows move it, and Escape closes.
  await card('phases').click({ button: 'right' });
  await page.waitForSelector('[role=menu]');
  result.entries = await page.locator('[role=menuitem]').evaluateAll(all => all.map(b => b.firstChild.textContent));
  result.first = await focused();
  await shot('node_menu');
  await check('menu');
  await page.keyboard.press('Escape');
  await page.locator('[role=menu]').waitFor({ state: 'detached' });
  await card('phases').click({ button: 'right' });
  await page.click('[role=menuitem]:has-text("Duplicate")');
  await until('there are two', s => s.document.nodes.some(n => n.name === 'phases_2'));
  await card('phases_2').click({ button: 'right' });
  await page.click('[role=menuitem]:has-text("Remove")');
  await until('it is gone', s => s.document.nodes.length === 2);

  // F2 leads to the name.
  await card('phases').click();
  await page.keyboard.press('F2');
  await page.waitForFunction(() => document.activeElement?.classList.contains('name'));
  await page.keyboard.type('mask');
  await page.keyboard.press('Enter');
  await until('it has another name', s => s.document.nodes.some(n => n.name === 'mask'));
  await page.waitForFunction(() => document.querySelector('.react-flow__node.selected')?.dataset.id === 'mask');

  // Nodes and commands by name, also from a field.
  await page.keyboard.press('Control+k');
  await page.keyboard.type('pattern');
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.querySelector('.react-flow__node.selected')?.dataset.id === 'photo');
  result.found = await selected();
  await page.focus('#field-width');
  await page.keyboard.press('Control+f');
  await page.keyboard.type('h');
  await shot('find');
  await check('find');
  await page.keyboard.type('istory');
  await page.keyboard.press('Enter');
  await page.waitForSelector('.drawer.history');
  await page.click('.react-flow__pane', { position: { x: 20, y: 20 } });
  await page.keyboard.press('?');
  await page.waitForSelector('dialog[open]');
  result.keys = await page.locator('dialog tr').count();
  await shot('keys');
  await check('keys');
  await page.keyboard.press('Escape');
  await page.locator('dialog').waitFor({ state: 'detached' });
});
