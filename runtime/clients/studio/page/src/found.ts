// Colors that nodes found in a photograph.
import { hexOfInt, hexOfLinear, mainColors, type Share } from './color';
import { fetchJson, useLoaded } from './load';
import type { Outlines } from './profiles';
import { declarationOf, shownDoc, splitWire, valueOf } from './states';
import { edit, fullName, select, useStore, type Edit } from './store';
import { freshName } from './tools';
import type { Doc, DocNode, OutputValue } from './types';

const mostColors = 6; // as many as a person keeps apart

// The color that a parameter such as binder: auto stands for, from the table of the same name that the node makes.
export function useFoundColor(node: DocNode | undefined, parameter: string): string | null {
  const table = useStore(s => {
    const v = node && valueOf(node, parameter, s.nodes);
    return v?.type === 'Table' ? v : null;
  }, (a, b) => a?.hash === b?.hash);
  const { data } = useLoaded(String(table?.hash), async () => (table ? fetchJson<{ columns: string[]; rows: number[][] }>(table.hash, 'json') : null));
  const row = data?.rows[0], at = ['r', 'g', 'b'].map(c => data?.columns.indexOf(c) ?? -1);
  return row && at.every(k => k >= 0) ? hexOfLinear(at.map(k => row[k])) : null;
}

// The node whose parameter takes its value from a parameter of the graph.
export const readerOf = (doc: Doc, name: string): { node: DocNode; parameter: string } | undefined => {
  for (const node of doc.nodes)
    for (const [parameter, { value }] of Object.entries(node.params)) if (value === `\${${name}}`) return { node, parameter };
  return undefined;
};

export interface Found { colors: Share[]; binder: string }

// The main colors of profiles, by area.
export function useFoundColors(value: OutputValue | undefined): Found | null {
  const { data } = useLoaded(String(value?.hash), async () => {
    if (!value) return null;
    const all = await fetchJson<Outlines>(value.hash, 'outlines');
    return { colors: mainColors(all.profiles.map(p => ({ color: hexOfInt(p.color), weight: p.area })), mostColors), binder: hexOfInt(all.binder) };
  });
  return data;
}

// The profiles that a node makes, or that it colors particles with.
export function profilesOf(node: DocNode, s: ReturnType<typeof useStore.getState>): OutputValue | undefined {
  const doc = shownDoc(s), own = declarationOf(node, s.types)?.outputs.find(p => p.types[0] === 'Profiles');
  if (node.type === 'Palette') return undefined;
  if (own && !node.inputs.particles && !node.inputs.volume) return valueOf(node, own.name, s.nodes);
  if (node.type !== 'Colorize' || !doc || !node.inputs.profiles) return undefined;
  const at = splitWire(node.inputs.profiles[0], doc, s.types), source = doc.nodes.find(n => n.name === at.node);
  return source && source.type !== 'Palette' ? valueOf(source, at.port, s.nodes) : undefined;
}

// Puts a Palette with the colors in place of the photograph's, as one step of undo.
export async function makePalette(node: DocNode, found: Found): Promise<void> {
  const doc = shownDoc(useStore.getState());
  if (!doc) return;
  const name = freshName(doc, 'colors'), percent = (s: number) => String(Math.max(1, Math.round(100 * s)));
  const edits: Edit[] = [
    { op: 'add', node: name, type: 'Palette' },
    { op: 'set', node: name, name: 'colors', value: found.colors.map(c => c.color) },
    { op: 'set', node: name, name: 'shares', value: found.colors.map(c => percent(c.share)) },
    { op: 'set', node: name, name: 'binder', value: found.binder },
    { op: 'connect', node: node.name, name: 'profiles', wires: [`${name}.profiles`] },
    { op: 'set', node: node.name, name: 'mode', value: 'random' },
  ];
  if (await edit(edits)) setTimeout(() => select(fullName(name)), 50);
}
