import dagre from '@dagrejs/dagre';

import { isFolded } from './folded';
import { declarationOf, splitWire } from './states';
import { useStore } from './store';
import type { Doc, DocNode, NodeType, Port } from './types';

export const nodeWidth = 168;
export const rowHeight = 20;
export const thumbHeight = 108;
const columnGap = 24, rowGap = 60, mostColumns = 7;

// Optional inputs without a wire appear only while the node is selected or a wire is being drawn.
export const inputsShown = (node: DocNode, inputs: Port[]) => inputs.filter(p => !p.optional || node.inputs[p.name]);

function sizeOf(inputs: number, outputs: number) {
  return { width: nodeWidth, height: 44 + rowHeight * Math.max(inputs, outputs, 1) };
}

export function nodeSize(n: DocNode, types: Map<string, NodeType>) {
  const d = declarationOf(n, types), all = d?.inputs ?? [], shown = inputsShown(n, all).length;
  const size = sizeOf(shown + (shown < all.length ? 1 : 0), d?.outputs.length ?? 0);
  if (n.parts?.length) size.height += 16; // its corrections
  if (isFolded(n.name)) size.width += 24; // room for "10 outputs" in the largest letters
  if (useStore.getState().thumbnails && d?.outputs.some(p => ['Image', 'Labels'].includes(p.types[0]))) size.height += thumbHeight;
  return size;
}

// Places of nodes from left to right, and the middles of their columns.
function inColumns(nodes: DocNode[], doc: Doc, types: Map<string, NodeType>): { at: Record<string, { x: number; y: number }>; middle: (n: DocNode) => number; columns: number[] } {
  const g = new dagre.graphlib.Graph();
  g.setGraph({ rankdir: 'LR', nodesep: 16, ranksep: columnGap });
  g.setDefaultEdgeLabel(() => ({}));
  for (const n of nodes) g.setNode(n.name, nodeSize(n, types));
  for (const n of nodes)
    for (const wires of Object.values(n.inputs))
      for (const w of wires) {
        const { node } = splitWire(w, doc, types);
        if (g.hasNode(node)) g.setEdge(node, n.name);
      }
  dagre.layout(g);
  const at = Object.fromEntries(nodes.map(n => { const p = g.node(n.name); return [n.name, { x: p.x - p.width / 2, y: p.y - p.height / 2 }]; }));
  const middle = (n: DocNode) => g.node(n.name).x;
  return { at, middle, columns: [...new Set(nodes.map(middle))].sort((a, b) => a - b) };
}

// If a graph has too many columns to keep names legible beside the viewer, it wraps into another row, like text.
export function layout(doc: Doc, types: Map<string, NodeType>): Record<string, { x: number; y: number }> {
  const { at, middle, columns } = inColumns(doc.nodes, doc, types), rows = Math.ceil(columns.length / mostColumns);
  if (rows < 2) return at;
  const perRow = Math.ceil(columns.length / rows), out: typeof at = {};
  let top = 0;
  for (let row = 0; row < rows; ++row) {
    const nodes = doc.nodes.filter(n => Math.floor(columns.indexOf(middle(n)) / perRow) === row), own = inColumns(nodes, doc, types).at;
    for (const n of nodes) out[n.name] = { x: own[n.name].x, y: own[n.name].y + top };
    top = rowGap + Math.max(...nodes.map(n => out[n.name].y + nodeSize(n, types).height));
  }
  return out;
}
