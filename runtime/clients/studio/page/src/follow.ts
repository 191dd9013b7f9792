// What the viewer shows while no node is selected: the material itself, as far as it is made.
import { declarationOf, shownDoc, splitWire, valueOf, previewOf } from './states';
import { useStore, type Target } from './store';
import type { Doc, DocNode, NodeState, NodeType, StartInfo } from './types';

// The solids that the node makes pictures of, as renderers and sections do.
const solidsOf = (node: DocNode, doc: Doc, types: Map<string, NodeType>): Target[] =>
  [...(node.inputs.particles ?? []), ...(node.inputs.volume ?? [])].map(wire => splitWire(wire, doc, types));

// The picture that the graph writes as its preview, or else as the file named after the graph.
function written(doc: Doc, types: Map<string, NodeType>): Target | undefined {
  const stem = doc.file.split('/').pop()!.replace(/\.ya?ml$/, '');
  const pathOf = (n: DocNode) => (n.type === 'Export' && n.inputs.image?.length === 1 ? String(n.params.path?.value ?? '') : '');
  const file = doc.nodes.find(n => /(^|_)preview\.\w+$/.test(pathOf(n))) ?? doc.nodes.find(n => pathOf(n).startsWith(`${stem}.`));
  return file && splitWire(file.inputs.image[0], doc, types);
}

// All outputs that show the material, the best first: its main picture, other pictures of the solid, the solid, its shapes, labels, the photograph.
export function pictures(doc: Doc, types: Map<string, NodeType>): Target[] {
  const all = doc.nodes.flatMap(node => (declarationOf(node, types)?.outputs ?? []).map(p => ({ node, port: p.name, type: p.types[0] })));
  const images = all.filter(o => o.type === 'Image'), sees = (node: DocNode) => solidsOf(node, doc, types).length > 0;
  const ranked: Target[] = [
    ...images.filter(o => o.port === 'preview'),
    ...images.filter(o => sees(o.node)).reverse(),
    ...images.flatMap(o => solidsOf(o.node, doc, types)).reverse(),
    ...all.filter(o => o.type === 'Shapes').reverse(),
    ...all.filter(o => o.type === 'Labels' && o.port === 'labels' && !sees(o.node)).reverse(),
    ...images.filter(o => !sees(o.node)),
  ].map(o => ({ node: typeof o.node === 'string' ? o.node : o.node.name, port: o.port }));
  const main = written(doc, types);
  return main ? [main, ...ranked] : ranked;
}

// They depend on the document only, and nodes change often.
let known: { doc: Doc; types: Map<string, NodeType>; list: Target[] } | null = null;
function picturesOf(doc: Doc, types: Map<string, NodeType>): Target[] {
  if (known?.doc !== doc || known.types !== types) known = { doc, types, list: pictures(doc, types) };
  return known.list;
}

interface Seen { doc: Doc | null; inside: Doc | null; types: Map<string, NodeType>; nodes: Record<string, NodeState> }

// The best picture that is there. While the graph computes, better ones follow.
export function followed(s: Seen): Target | null {
  const doc = shownDoc(s);
  if (!doc) return null;
  return picturesOf(doc, s.types).find(({ node, port }) => {
    const n = doc.nodes.find(x => x.name === node);
    return n && (previewOf(n, port, s.nodes) ?? valueOf(n, port, s.nodes));
  }) ?? null;
}

// The pictures that colors can be taken from: of the material, and the photograph.
export function imagesOf(s: Seen): Target[] {
  const doc = shownDoc(s);
  return doc ? picturesOf(doc, s.types).filter(({ node, port }, k, all) => {
    const n = doc.nodes.find(x => x.name === node);
    return n && valueOf(n, port, s.nodes)?.type === 'Image' && all.findIndex(t => t.node === node && t.port === port) === k
      && (k === 0 || solidsOf(n, doc, s.types).length > 0 || !Object.keys(n.inputs).length);
  }) : [];
}

// The main picture, whether it is there or not.
export const mainPicture = (s: Seen): Target | undefined => { const doc = shownDoc(s); return doc ? picturesOf(doc, s.types)[0] : undefined; };
export const mainNode = (s: Seen): string => mainPicture(s)?.node ?? '';

// What the viewer shows: what is pinned, selected, or the material.
export function shownTarget(s: ReturnType<typeof useStore.getState>): Target | null {
  if (s.pinned) return s.pinned;
  if (!s.selected) return followed(s);
  const node = shownDoc(s)?.nodes.find(n => n.name === s.selected);
  return { node: s.selected, port: s.port ?? (node && declarationOf(node, s.types)?.outputs[0]?.name) ?? '' };
}

// The picture of a material that comes with the program, shown until it has been made here.
export function galleryPicture(doc: Doc | null, start: StartInfo | null): string | null {
  const name = doc?.read_only ? doc.file.split('/').pop()!.replace(/\.yaml$/, '') : '';
  return start?.materials.some(m => m.name === name && m.picture) ? `/api/picture/${name}` : null;
}
