// node parameters.mjs TERRAZZO FOLDER CHROMIUM: changes a value that comes from a parameter of the graph, makes another one, and takes both
// back. Prints the observed states as one JSON object.
import { writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { openPage, report, result, start } from './session.mjs';

const [, , program, folder, executablePath] = process.argv;
const graph = join(folder, 'marble.yaml');
writeFileSync(graph, `# kept
terrazzo: 1
name: Marble
parameters:
  grain: {type: int, default: 3, doc: How it grows}
nodes:
  photo:
    type: Pattern
    params: {kind: marble, axis: z, width: 96, height: 64, seed: "\${grain}"}
`);
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache')], { cwd: folder });
await report(server, async () => {
  const { page, shot, card, until, idle, check } = await openPage(executablePath, { viewport: { width: 1440, height: 900 }, colorScheme: 'dark' });
  await page.goto(address);
  await idle();
  await card('photo').click();
  await page.waitForSelector('#field-seed');

  // The value is shown, and a change of it changes the graph's.
  result.shown = await page.inputValue('#field-seed');
  result.label = (await page.textContent('label[for=field-seed]')).trim();
  await page.fill('#field-seed', '5');
  await page.press('#field-seed', 'Enter');
  let s = await until('the graph has another value', s => /default: 5/.test(s.document.text));
  result.reads = /seed: "\$\{grain\}"/.test(s.document.text);

  // With the keyboard: a parameter of the node becomes one of the graph, in one step.
  await page.focus('[aria-label="More for width"]');
  await page.keyboard.press('Enter');
  await page.waitForSelector('[role=menu]');
  await shot('field_menu');
  await check('menu');
  await page.keyboard.press('ArrowDown');
  await page.keyboard.press('Enter');
  s = await until('there is a parameter', s => s.document.parameters.some(p => p.name === 'width'));
  result.made = s.document.text.split('\n').filter(l => /width/.test(l));
  result.declared = s.document.parameters.find(p => p.name === 'width');
  await page.waitForFunction(() => / = width$/.test(document.querySelector('label[for=field-width]')?.textContent ?? ''));
  await idle();
  await shot('field_from');
  await page.click('button:text-is("Undo")');
  await until('it is gone', s => s.document.parameters.length === 1);

  // With the right mouse button: the node gets a value of its own.
  await page.click('label[for=field-seed]', { button: 'right' });
  await page.click('[role=menuitem]:has-text("value of its own")');
  s = await until('the node has its own value', s => /seed: 5/.test(s.document.text));
  result.own = s.document.text.split('\n').at(-2).trim();
  await page.click('[aria-label="More for height"]');
  await page.click('[role=menuitem]:has-text("Show variants")');
  result.varied = await page.inputValue('.variants select');
  await page.keyboard.press('Escape');
});
