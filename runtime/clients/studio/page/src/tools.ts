import { shownDoc, splitWire } from './states';
import { edit, fullName, select, sourceOf, useStore, type Edit } from './store';
import type { Pen, Point } from './pen';
import type { Doc, DocNode } from './types';

export interface Tool { name: string; title: string; hint: string; key: string; pen: Omit<Pen, 'done' | 'leave'> }

const clicks = { least: 2, most: 1e9, freehand: false };
export const tools: Tool[] = [
  { name: 'binder', title: 'Pick binder', key: 'b', hint: 'Click the binder, the material between the particles.', pen: { least: 1, most: 1, freehand: false, shape: 'points' } },
  { name: 'merge', title: 'Merge', key: 'm', hint: 'Click two parts of one particle, or drag from one to the other.', pen: { least: 2, most: 2, freehand: false, shape: 'line' } },
  { name: 'split', title: 'Split', key: 's', hint: 'Drag a line across a particle; or click points and press Enter.', pen: { ...clicks, shape: 'line' } },
  { name: 'delete', title: 'Delete', key: 'd', hint: 'Click a particle that is binder.', pen: { least: 1, most: 1, freehand: false, shape: 'points' } },
  { name: 'outline', title: 'Outline', key: 'o', hint: 'Draw around a particle; or click points and press Enter.', pen: { ...clicks, least: 3, freehand: true, shape: 'area' } },
  { name: 'ignore', title: 'Ignore', key: 'i', hint: 'Drag a rectangle over what is not material.', pen: { least: 2, most: 2, freehand: false, shape: 'box' } },
];

// The node of Segment's that a color of the binder is set on, and the node that gets corrections.
export const segmentOf = (node: DocNode): DocNode | undefined => {
  const { types } = useStore.getState(), doc = shownDoc(useStore.getState());
  const up = (n: DocNode, input: string) => doc?.nodes.find(x => x.name === splitWire(n.inputs[input]?.[0] ?? '', doc, types).node);
  for (let n: DocNode | undefined = node, k = 0; n && k < 8; ++k) {
    if (n.type === 'Segment' && !n.inputs.labels) return n;
    n = up(n, 'labels');
  }
  return undefined;
};

export function editLabelsOf(node: DocNode): DocNode | undefined {
  const { types } = useStore.getState(), doc = shownDoc(useStore.getState());
  if (node.type === 'EditLabels') return node;
  const source = doc?.nodes.find(n => n.type === 'EditLabels' && n.name === splitWire(node.inputs.labels?.[0] ?? '', doc, types).node);
  return source ?? doc?.nodes.find(n => n.type === 'EditLabels' && n.inputs.labels?.[0] === `${node.name}.labels`);
}

// Whether the tool can be used on the labels of this node.
export const usable = (tool: Tool, node: DocNode) =>
  tool.name === 'binder' ? !!segmentOf(node) : tool.name !== 'ignore' || !segmentOf(node)?.inputs.mask;

export const freshName = (doc: Doc, name: string) => {
  for (let k = 1; ; ++k) {
    const full = k === 1 ? name : `${name}_${k}`;
    if (!doc.nodes.some(n => n.name.split('/').pop() === full)) return full;
  }
};

// EditLabels behind a Segment, and a second Segment that measures its labels for everything that read the first one. The
// picture without light keeps the colors as they were.
function insert(doc: Doc, segment: DocNode, text: string): { name: string; edits: Edit[] } {
  const name = freshName(doc, 'edit_labels'), measure = freshName(doc, 'measure'), from = segment.name;
  const kept = ['color_classes', 'ignore', 'seed'].filter(p => segment.params[p]);
  return {
    name, edits: [
      { op: 'add', node: name, type: 'EditLabels' },
      { op: 'connect', node: name, name: 'labels', wires: [`${from}.labels`] },
      { op: 'append', node: name, name: 'edits', value: text },
      { op: 'add', node: measure, type: 'Segment' },
      { op: 'connect', node: measure, name: 'image', wires: [`${from}.delit`] },
      { op: 'connect', node: measure, name: 'labels', wires: [`${name}.labels`] },
      { op: 'connect', node: measure, name: 'mask', wires: segment.inputs.mask ?? [`${name}.not_material`] },
      ...kept.map(p => ({ op: 'set', node: measure, name: p, value: segment.params[p].value })),
      { op: 'rewire', node: name, name: `${from}.labels`, to: `${measure}.labels` },
      { op: 'rewire', name: `${from}.profiles`, to: `${measure}.profiles` },
      { op: 'rewire', name: `${from}.binder`, to: `${measure}.binder` },
    ],
  };
}

// The points of a drawn line that matter by more than half a pixel (Douglas and Peucker 1973).
export function simplified(points: Point[]): Point[] {
  if (points.length < 3) return points;
  const [a, b] = [points[0], points[points.length - 1]], dx = b[0] - a[0], dy = b[1] - a[1], length = Math.hypot(dx, dy);
  let far = 0, most = 0.5;
  for (let k = 1; k + 1 < points.length; ++k) {
    const [x, y] = [points[k][0] - a[0], points[k][1] - a[1]];
    const off = length > 0 ? Math.abs(x * dy - y * dx) / length : Math.hypot(x, y);
    if (off > most) far = k, most = off;
  }
  return far ? [...simplified(points.slice(0, far + 1)).slice(0, -1), ...simplified(points.slice(far))] : [a, b];
}

// Adds a correction, as one step of undo.
export async function correct(node: DocNode, tool: string, points: Point[], section: number): Promise<void> {
  const doc = shownDoc(useStore.getState());
  const number = (v: number) => String(Number(v.toFixed(1)));
  const text = `${section ? `${section}: ` : ''}${tool} ${(tool === 'outline' ? simplified(points) : points).flat().map(number).join(' ')}`;
  const editor = editLabelsOf(node), segment = segmentOf(node);
  if (!doc || (!editor && !segment)) return;
  const { name, edits } = editor ? { name: editor.name, edits: [{ op: 'append', node: editor.name, name: 'edits', value: text }] } : insert(doc, segment!, text);
  if (await edit(edits)) setTimeout(() => select(fullName(name)), 50);
}

// Sets the binder's color, in the parameter of the graph if the node takes it from there.
export async function setBinder(node: DocNode, color: string): Promise<void> {
  const segment = segmentOf(node);
  if (!segment) return;
  const from = sourceOf(segment.params.binder?.value ?? '', useStore.getState());
  await (from ? edit(from.edits(color), false, {}, from.scope) : edit([{ op: 'set', node: segment.name, name: 'binder', value: color }]));
}
