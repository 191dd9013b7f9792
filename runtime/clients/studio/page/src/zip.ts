// A folder that was dropped on the page, as a zip archive, whose files are not compressed.
const crcTable = Uint32Array.from({ length: 256 }, (_, n) => { for (let k = 0; k < 8; ++k) n = n & 1 ? 0xedb88320 ^ (n >>> 1) : n >>> 1; return n; });
const crcOf = (bytes: Uint8Array) => { let c = ~0; for (const b of bytes) c = crcTable[(c ^ b) & 255] ^ (c >>> 8); return ~c >>> 0; };

// All files below a folder, by their paths in it.
async function filesIn(folder: FileSystemDirectoryEntry, prefix = ''): Promise<[string, File][]> {
  const reader = folder.createReader(), out: [string, File][] = [];
  for (;;) {
    const some = await new Promise<FileSystemEntry[]>((done, failed) => reader.readEntries(done, failed));
    if (!some.length) return out;
    for (const e of some) {
      if (e.isDirectory) out.push(...await filesIn(e as FileSystemDirectoryEntry, `${prefix}${e.name}/`));
      else out.push([prefix + e.name, await new Promise<File>((done, failed) => (e as FileSystemFileEntry).file(done, failed))]);
    }
  }
}

// Numbers as zip archives have them: the lowest byte first; each is [bytes, value].
function record(...numbers: [number, number][]): Uint8Array<ArrayBuffer> {
  const out = new Uint8Array(numbers.reduce((n, [bytes]) => n + bytes, 0));
  let at = 0;
  for (const [bytes, value] of numbers) for (let k = 0; k < bytes; ++k) out[at++] = Math.floor(value / 256 ** k) & 255;
  return out;
}

export async function zipOfFolder(folder: FileSystemDirectoryEntry): Promise<File> {
  const parts: BlobPart[] = [], index: BlobPart[] = [];
  let at = 0, length = 0, count = 0;
  for (const [path, file] of await filesIn(folder)) {
    const name = new TextEncoder().encode(path), bytes = new Uint8Array(await file.arrayBuffer());
    // Version, names in UTF-8, no compression, no time; sum, sizes, length of the name, no more fields.
    const common: [number, number][] = [[2, 20], [2, 0x800], [2, 0], [2, 0], [2, 0x21], [4, crcOf(bytes)], [4, bytes.length], [4, bytes.length], [2, name.length], [2, 0]];
    const head = record([4, 0x04034b50], ...common), entry = record([4, 0x02014b50], [2, 20], ...common, [2, 0], [2, 0], [2, 0], [4, 0], [4, at]);
    parts.push(head, name, bytes), index.push(entry, name);
    at += head.length + name.length + bytes.length, length += entry.length + name.length, ++count;
  }
  return new File([...parts, ...index, record([4, 0x06054b50], [2, 0], [2, 0], [2, count], [2, count], [4, length], [4, at], [2, 0])], `${folder.name}.zip`);
}
