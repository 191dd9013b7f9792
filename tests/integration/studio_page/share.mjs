// node share.mjs TERRAZZO FOLDER CHROMIUM: shares a material whose picture is elsewhere, opens the bundle from the start page, and edits it.
// Prints the observed states as one JSON object.
import { existsSync, mkdirSync, readFileSync, renameSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { openPage, report, result, start } from './session.mjs';

const [, , program, folder, executablePath] = process.argv;
mkdirSync(join(folder, 'work'));
const graph = join(folder, 'work', 'two.yaml');
writeFileSync(graph, `# kept
terrazzo: 1
name: Two pictures
nodes:
  photo: {type: LoadImage, params: {path: ${join(folder, 'photo.png')}}}
  sheet: {type: ContactSheet, inputs: {images: photo.image}, params: {cell: 300}}
  preview: {type: Export, inputs: {image: sheet.image}, params: {path: preview.png}}
`);
const { server, address } = await start(program, [graph, '--cache', join(folder, 'cache')], { cwd: join(folder, 'work') });
await report(server, async () => {
  const { page, shot, card, until, idle, check } = await openPage(executablePath, { viewport: { width: 1440, height: 900 }, colorScheme: 'light' });
  await page.goto(address);
  const before = (await idle()).nodes.sheet.outputs.image.hash;

  await page.click('[aria-label="More to do with the file"]');
  await page.click('[role=menuitem]:has-text("Share…")');
  const name = page.locator('form[aria-label=Share] input').first();
  result.offered = await name.inputValue();
  await page.fill('form[aria-label=Share] input[placeholder^="such as"]', 'CC BY 4.0');
  await page.fill('form[aria-label=Share] input[placeholder^="who"]', 'A quarry');
  await page.waitForSelector('form[aria-label=Share] em:has-text("With the picture")');
  await shot('share');
  await check('share');
  await page.click('text=Write the bundle');
  await page.waitForSelector('.notices p:has-text("Wrote")');
  result.wrote = existsSync(join(folder, 'work', 'two.zip'));
  await page.click('.notices >> text=Dismiss');

  // A name that is taken is refused, and the form stays.
  await page.click('[aria-label="More to do with the file"]');
  await page.click('[role=menuitem]:has-text("Share…")');
  await page.click('text=Write the bundle');
  await page.waitForSelector('.notices .bad');
  result.refused = await page.textContent('.notices .bad b');
  result.errors.splice(0); // the refused request, which the browser logs
  await page.click('.notices >> text=Dismiss');
  await page.press('form[aria-label=Share] input', 'Escape');

  // The photograph is gone, and the bundle opens from the start page, as a graph to work on.
  renameSync(join(folder, 'photo.png'), join(folder, 'gone.png'));
  await page.click('text=New or open…');
  const bundle = page.locator('[aria-label=Bundles] button');
  await bundle.first().waitFor();
  await page.waitForFunction(() => document.querySelector('[aria-label=Bundles] img')?.naturalWidth > 0);
  result.bundles = await bundle.allTextContents();
  await shot('start_bundles');
  await check('start');
  await bundle.first().click();
  await until('the copy is open', s => s.document.file === join(folder, 'work', 'two', 'two.yaml'));
  const s = await idle();
  result.same = s.nodes.sheet.outputs.image.hash === before;
  result.text = s.document.text;
  result.notes = readFileSync(join(folder, 'work', 'two', 'NOTES.md'), 'utf8');
  await card('sheet').click();
  await page.fill('#field-cell', '100');
  await page.press('#field-cell', 'Enter');
  await until('the copy is edited', s => /cell: 100/.test(s.document.text));
  await page.keyboard.press('Control+s');
  await until('the copy is saved', s => s.document.saved);

  // Dropped on the page, a bundle from elsewhere opens; one that has other content gets a number, and what is none is refused.
  const drop = async (name, bytes) => {
    const files = await page.evaluateHandle(([name, data]) => {
      const files = new DataTransfer();
      files.items.add(new File([Uint8Array.from(atob(data), c => c.charCodeAt(0))], name, { type: 'application/zip' }));
      return files;
    }, [name, bytes.toString('base64')]);
    for (const type of ['dragover', 'drop']) await page.dispatchEvent('.canvas', type, { dataTransfer: files });
  };
  const shared = readFileSync(join(folder, 'work', 'two.zip'));
  await drop('granite.zip', shared);
  await until('it is open', s => s.document.file === join(folder, 'work', 'granite', 'two.yaml'));
  result.dropped = (await idle()).nodes.sheet.outputs.image.hash === before;
  // A folder, as the browser gives it, with the files of the one that is open.
  await page.evaluate(async text => {
    const file = (name, content) => ({ name, isDirectory: false, file: done => done(new File(content, name)) });
    const folder = (name, all) => ({ name, isDirectory: true, createReader: () => ({ readEntries: done => done(all.splice(0)) }) });
    const png = await (await fetch('/api/bundle_picture?file=granite')).blob();
    DataTransferItem.prototype.webkitGetAsEntry = () => folder('slate', [
      file('bundle.json', ['{"terrazzo_bundle": 1, "graph": "two.yaml", "title": "Slate"}']), file('two.yaml', [text]), folder('files', [file('photo.png', [png])]),
    ]);
  }, result.text);
  await drop('slate', Buffer.from(''));
  await until('the folder is open', s => s.document.file === join(folder, 'work', 'slate', 'two.yaml'));
  result.folder = (await idle()).nodes.sheet.state;
  await page.evaluate(() => { delete DataTransferItem.prototype.webkitGetAsEntry; });
  await drop('broken.zip', shared.subarray(0, 300));
  await page.waitForSelector('.notices .bad');
  result.broken = await page.textContent('.notices .bad b');
  result.errors.splice(0);
  await page.click('.notices >> text=Dismiss');
  result.left = existsSync(join(folder, 'work', 'broken.zip'));
  await page.click('text=New or open…');

  // Opened again, the bundle is the copy, with what was changed.
  const listed = await page.waitForFunction(() => { const all = [...document.querySelectorAll('[aria-label=Bundles] button')].map(b => b.title); return all.length > 2 && all; });
  result.listed = (await listed.jsonValue()).sort();
  await page.click('[aria-label=Bundles] button[title=two]');
  result.again = /cell: 100/.test((await until('the copy is there', s => s.document.file.endsWith('two/two.yaml'))).document.text);
});
