// node errors.mjs TERRAZZO FOLDER CHROMIUM PICTURE: a graph without its picture, text that is no YAML, and sizes that are none. Prints the observed
// states as one JSON object.
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { openPage, report, result, start } from './session.mjs';

const [, , program, folder, executablePath, picture] = process.argv;
const graph = join(folder, 'lost.yaml');
writeFileSync(graph, `terrazzo: 1
name: Lost
parameters: {photo: {type: path, default: gone.png}}
nodes:
  photo: {type: LoadImage, params: {path: "\${photo}", tilt: 5}}
  sheet: {type: ContactSheet, inputs: {images: photo.image}}
`);
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache')], { cwd: folder });
await report(server, async () => {
  const { page, shot, card, until, idle, check } = await openPage(executablePath, { viewport: { width: 1280, height: 800 }, colorScheme: 'light' });
  await page.goto(address);

  // What failed is said in the viewer, on the card and in the messages, which open.
  await page.waitForSelector('.viewer .trouble');
  result.trouble = await page.textContent('.viewer .trouble');
  await page.waitForSelector('.messages li.error');
  result.card = await card('photo').locator('.kind').textContent();
  await shot('error');
  await check('error');
  const [chooser] = await Promise.all([page.waitForEvent('filechooser'), page.click('text=Choose a file')]);
  await chooser.setFiles(picture);
  let s = await until('the picture is read', s => s.nodes.sheet?.outputs.image);
  // It warns, in amber.
  const warned = card('photo').locator('.warn');
  result.warned = [await warned.textContent(), await warned.getAttribute('title'), await warned.evaluate(e => getComputedStyle(e).color)];
  result.text = /default: ([^}]+)/.exec(s.document.text)[1];
  result.beside = existsSync(join(folder, result.text));
  await page.locator('.viewer .trouble').waitFor({ state: 'detached' });
  await page.keyboard.press('Control+s');
  await until('it is saved', s => s.document.saved);

  // Another program breaks the text: the editor opens at the line.
  await page.click('button:text-is("Messages")');
  await page.locator('.messages').waitFor({ state: 'detached' });
  const text = readFileSync(graph, 'utf8');
  writeFileSync(graph, text.replace('  sheet: {', '  sheet: {{'));
  await page.waitForSelector('.yaml textarea');
  await page.waitForFunction(() => document.activeElement?.tagName === 'TEXTAREA');
  result.line = await page.evaluate(() => { const a = document.activeElement; return a.value.slice(a.selectionStart, a.selectionEnd); });
  result.yaml = await page.textContent('.viewer .trouble');
  await shot('error_yaml');
  writeFileSync(graph, text);
  await idle();
  await page.locator('.viewer .trouble').waitFor({ state: 'detached' });

  // A size of a pixel that is none is refused with the reason.
  await page.click('text=New or open…');
  await page.setInputFiles('.start input[type=file]', picture);
  await page.waitForSelector('.new >> text=Recommended:');
  await page.fill('.new input >> nth=0', '0,05');
  result.size = await page.textContent('#extent');
  result.can = await page.locator('button:has-text("Create the material")').isEnabled();
  await shot('error_size');
  await check('size');
});
