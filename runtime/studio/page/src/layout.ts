import dagre from '@dagrejs/dagre';

import { declarationOf, splitWire } from './store';
import type { Doc, NodeType } from './types';

export const nodeWidth = 190;
export const rowHeight = 20;

export function sizeOf(inputs: number, outputs: number) {
  return { width: nodeWidth, height: 44 + rowHeight * Math.max(inputs, outputs, 1) };
}

export function layout(doc: Doc, types: Map<string, NodeType>): Record<string, { x: number; y: number }> {
  const g = new dagre.graphlib.Graph();
  g.setGraph({ rankdir: 'LR', nodesep: 22, ranksep: 64, ranker: 'tight-tree' });
  g.setDefaultEdgeLabel(() => ({}));
  for (const n of doc.nodes) {
    const d = declarationOf(n, types);
    g.setNode(n.name, sizeOf(d?.inputs.length ?? 0, d?.outputs.length ?? 0));
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
