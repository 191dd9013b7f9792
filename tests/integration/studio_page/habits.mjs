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
  stones: {type: SyntheticPhoto, params: {width: 96, height: 64}}
  found: {type: Segment, inputs: {image: stones.image}}
`);
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache')], { cwd: folder });
await report(server, async () => {
  const { page, shot, card, state, until, idle, check } = await openPage(executablePath, { viewport: { width: 1280, height: 800 }, colorScheme: 'dark' });
  const selected = () => page.locator('.react-flow__node.selected').evaluateAll(all => all.map(n => n.dataset.id));
  const focused = () => page.evaluate(() => document.activeElement?.getAttribute('aria-label') ?? document.activeElement?.textContent);
  await page.goto(address);
  await idle();

  // Tab leads from the toolbar to the first node, and arrows to its neighbors. Shift and an arrow moves the node.
  await page.focus('[aria-label="Zoom in"]');
  await page.mouse.move(1200, 700);
  await page.keyboard.press('Tab');
  result.tab = await page.evaluate(() => document.activeElement.dataset.id ?? document.activeElement.outerHTML);
  await page.keyboard.press('ArrowRight');
  await page.waitForSelector('.react-flow__node.selected[data-id="phases"]');
  result.right = await page.evaluate(() => document.activeElement.dataset.id);
  await page.keyboard.press('ArrowRight'); // nothing is there
  await page.keyboard.press('ArrowLeft');
  await page.waitForSelector('.react-flow__node.selected[data-id="photo"]');
  result.left = await selected();
  result.stays = (await state()).document.can_undo;
  await page.keyboard.press('Shift+ArrowDown');
  await until('it is moved', s => s.document.arrangement.places?.photo);
  await page.click('button:text-is("Undo")');
  await until('it is back', s => !s.document.arrangement.places);

  // What other programs call nodes.
  result.added = {};
  for (const word of ['usd', 'gltf', 'hsv', 'voronoi', 'normal map', 'xyzzy']) {
    await page.click('button:has-text("Add node")');
    await page.fill('.search input', word);
    result.added[word] = await page.locator('.search [role=option] b').first().textContent({ timeout: 500 }).catch(() => '');
    if (word === 'hsv') await shot('add_hsv');
    await page.keyboard.press('Escape');
    await page.locator('.search').waitFor({ state: 'detached' });
  }

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
  await until('it is gone', s => s.document.nodes.length === 4);

  // F2 leads to the name.
  await card('phases').click();
  await page.keyboard.press('F2');
  await page.waitForFunction(() => document.activeElement?.classList.contains('name'));
  await page.keyboard.type('mask');
  await page.keyboard.press('Enter');
  await until('it has another name', s => s.document.nodes.some(n => n.name === 'mask'));
  await page.waitForFunction(() => document.querySelector('.react-flow__node.selected')?.dataset.id === 'mask');

  // Letters choose tools wherever the focus is, if labels are shown.
  await until('there are labels', s => s.nodes.found?.outputs.labels);
  await card('found').click();
  await page.waitForSelector('.pens');
  await page.focus('button:text-is("History")');
  await page.keyboard.press('s');
  result.tools = [await page.textContent('.pens [aria-pressed=true]')];
  await card('found').focus();
  await page.keyboard.press('m');
  result.tools.push(await page.textContent('.pens [aria-pressed=true]'));
  await page.focus('.inspector input.name');
  await page.keyboard.press('d');
  result.tools.push(await page.textContent('.pens [aria-pressed=true]'));
  await page.keyboard.press('Escape');

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
