import dagre from '@dagrejs/dagre';

import { declarationOf, splitWire } from './states';
import { useStore } from './store';
import type { Doc, DocNode, NodeType, Port } from './types';

export const nodeWidth = 168;
export const rowHeight = 20;
export const thumbHeight = 108;

// Optional inputs without a wire appear only while the node is selected or a wire is being drawn.
export const inputsShown = (node: DocNode, inputs: Port[]) => inputs.filter(p => !p.optional || node.inputs[p.name]);

function sizeOf(inputs: number, outputs: number) {
  return { width: nodeWidth, height: 44 + rowHeight * Math.max(inputs, outputs, 1) };
}

export function nodeSize(n: DocNode, types: Map<string, NodeType>) {
  const d = declarationOf(n, types), all = d?.inputs ?? [], shown = inputsShown(n, all).length;
  const size = sizeOf(shown + (shown < all.length ? 1 : 0), d?.outputs.length ?? 0);
  if (n.parts?.length) size.height += 16; // its corrections
  if (useStore.getState().thumbnails && d?.outputs.some(p => ['Image', 'Labels'].includes(p.types[0]))) size.height += thumbHeight;
  return size;
}

export function layout(doc: Doc, types: Map<string, NodeType>): Record<string, { x: number; y: number }> {
  const g = new dagre.graphlib.Graph();
  g.setGraph({ rankdir: 'LR', nodesep: 16, ranksep: 24 });
  g.setDefaultEdgeLabel(() => ({}));
  for (const n of doc.nodes) {
    g.setNode(n.name, nodeSize(n, types));
  }
  for (const n of doc.nodes)
    for (const wires of Object.values(n.inputs))
      for (const w of wires) {
        const { node } = splitWire(w, doc, types);
        if (g.hasNode(node)) g.setEdge(node, n.name);
      }
  dagre.layout(g);
  const out: Record<string, { x: number; y: number }> = {};
  for (const n of doc.nodes) {
    const at = g.node(n.name);
    out[n.name] = { x: at.x - at.width / 2, y: at.y - at.height / 2 };
  }
  return out;
}
