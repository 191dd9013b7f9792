import { edit, useStore, type Edit } from './store';
import type { Doc, DocNode } from './types';

// Copied nodes are kept for all pages of this server. The clipboard gets their text.
const key = 'copied nodes';

function textOf(doc: Doc, node: DocNode): string {
  const lines = doc.text.split('\n'), indent = lines[node.line - 1].search(/\S/);
  let end = node.line;
  while (end < lines.length && (lines[end].trim() === '' || lines[end].search(/\S/) > indent)) ++end;
  return lines.slice(node.line - 1, end).join('\n').trimEnd();
}

function refuse(message: string, hint: string): null {
  useStore.setState({ trouble: { message, hint, code: 'cannot-copy' } });
  return null;
}

function chosen(doc: Doc, names: string[]): DocNode[] | null {
  const nodes = doc.nodes.filter(n => names.includes(n.name));
  const repeated = nodes.find(n => n.each || n.doc);
  return repeated ? refuse(`'${repeated.name}' has entries that only the YAML text can copy`, 'copy its lines there') : nodes;
}

export function copy(doc: Doc, names: string[]) {
  const nodes = chosen(doc, names);
  if (!nodes?.length) return;
  localStorage.setItem(key, JSON.stringify(nodes));
  void navigator.clipboard?.writeText(nodes.map(n => textOf(doc, n)).join('\n') + '\n').catch(() => {});
}

// Adds copies under free names, as one step of undo. Wires between them lead to the copies; wires from nodes that the graph does not
// have are left out. Returns the new names, by the old ones.
async function add(doc: Doc, nodes: DocNode[]): Promise<Map<string, string>> {
  const taken = new Set(doc.nodes.map(n => n.name)), names = new Map<string, string>();
  for (const { name } of nodes) {
    const stem = name.replace(/_\d+$/, '');
    let free = name;
    for (let k = 2; taken.has(free); ++k) free = `${stem}_${k}`;
    taken.add(free), names.set(name, free);
  }
  const source = (wire: string) => wire.split(/[.[]/)[0];
  const edits: Edit[] = nodes.map(n => ({ op: 'add', node: names.get(n.name), type: n.type, graph: n.graph }));
  for (const n of nodes) {
    if (n.bypass) edits.push({ op: 'bypass', node: names.get(n.name), bypass: true });
    for (const [name, { value }] of Object.entries(n.params)) edits.push({ op: 'set', node: names.get(n.name), name, value });
    for (const [name, list] of Object.entries(n.inputs)) {
      const wires = list.filter(w => taken.has(source(w))).map(w => (names.get(source(w)) ?? source(w)) + w.slice(source(w).length));
      if (wires.length) edits.push({ op: 'connect', node: names.get(n.name), name, wires });
    }
  }
  return (await edit(edits)) ? names : new Map();
}

export const paste = (doc: Doc) => add(doc, JSON.parse(localStorage.getItem(key) ?? '[]') as DocNode[]);
export const duplicate = async (doc: Doc, names: string[]) => add(doc, chosen(doc, names) ?? []);
