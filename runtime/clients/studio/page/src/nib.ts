// The nib: texture that is painted into a picture. Strokes are a list of the Strokes node that a TextureNib reads.
import type { Point } from './pen';
import { shownDoc, splitWire } from './states';
import { edit, fullName, select, useStore, type Edit } from './store';
import { freshName, simplified } from './tools';
import type { Doc, DocNode } from './types';

// The nodes that strokes on this node's picture go to, if there are any.
export function nibOf(node: DocNode, doc: Doc): { nib: DocNode; strokes: DocNode } | null {
  if (node.type !== 'TextureNib') return null;
  const strokes = doc.nodes.find(n => n.type === 'Strokes' && n.name === splitWire(node.inputs.strokes?.[0] ?? '', doc, useStore.getState().types).node);
  return strokes ? { nib: node, strokes } : null;
}

const number = (v: number) => String(Number(v.toFixed(1)));

// A stroke as the node Strokes reads it.
export const strokeText = (points: Point[], radius: number) => `${number(radius)}: ${simplified(points).map(p => p.map(number).join(' ')).join(', ')}`;

// A stroke on the picture at an output of a node. The first one puts a TextureNib behind it, and what read the picture reads that.
export async function paint(node: DocNode, port: string, points: Point[], radius: number): Promise<void> {
  const doc = shownDoc(useStore.getState());
  if (!doc) return;
  const text = strokeText(points, radius);
  const known = nibOf(node, doc);
  if (known) return void edit([{ op: 'append', node: known.strokes.name, name: 'strokes', value: text }]);
  const nib = freshName(doc, 'nib'), strokes = freshName(doc, 'strokes');
  const edits: Edit[] = [
    { op: 'add', node: strokes, type: 'Strokes' },
    { op: 'append', node: strokes, name: 'strokes', value: text },
    { op: 'add', node: nib, type: 'TextureNib' },
    { op: 'connect', node: nib, name: 'image', wires: [`${node.name}.${port}`] },
    { op: 'connect', node: nib, name: 'strokes', wires: [`${strokes}.strokes`] },
    { op: 'rewire', node: nib, name: `${node.name}.${port}`, to: `${nib}.image` },
  ];
  if (await edit(edits)) setTimeout(() => select(fullName(nib)), 50);
}

// The rectangle whose texture a nib paints.
export const setRegion = (nib: DocNode, [[x0, y0], [x1, y1]]: Point[]) => edit([{
  op: 'set', node: nib.name, name: 'region',
  value: [Math.min(x0, x1), Math.min(y0, y1), Math.abs(x1 - x0), Math.abs(y1 - y0)].map(v => String(Math.round(v))),
}]);
