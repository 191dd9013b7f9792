// Strokes that teach a Phases node: those on phase k are in the Strokes node that it reads at place k of its input.
import type { Pen, Point } from './pen';
import { strokeText } from './nib';
import type { Raster } from './raster';
import { splitWire } from './states';
import { edit, useStore, type Edit } from './store';
import { freshName } from './tools';
import type { Doc, DocNode } from './types';

const mostPhases = 8;
const toolOf = (phase: number) => `phase ${phase}`;

const strokesOf = (node: DocNode, doc: Doc): (DocNode | undefined)[] => (node.inputs.strokes ?? [])
  .map(w => doc.nodes.find(n => n.type === 'Strokes' && n.name === splitWire(w, doc, useStore.getState().types).node));

// The color of each phase in its labels; phase 0 has none there.
export type Colors = Map<number, string>;
export function colorsOf(labels: { colors: Raster; ids: Raster } | null | undefined): Colors {
  const out: Colors = new Map();
  if (!labels) return out;
  const ids = new Int32Array(labels.ids.data), rgba = new Uint8Array(labels.colors.data);
  for (let k = 0; k < ids.length; ++k) if (ids[k] > 0 && !out.has(ids[k])) out.set(ids[k], `rgb(${rgba.subarray(4 * k, 4 * k + 3).join(' ')})`);
  return out;
}
const colorOf = (colors: Colors, phase: number) => colors.get(phase) ?? (phase === 0 ? '#888' : '#fff');

// Strokes can be drawn on phases that have a Strokes node, and on the next one.
const isOpen = (taught: unknown[], phase: number) => (phase < taught.length ? !!taught[phase] : phase === taught.length);

// The phase that the tool draws on, or −1.
export function phaseOf(tool: string | null, node: DocNode, doc: Doc): number {
  const phase = tool?.startsWith('phase ') ? Number(tool.slice(6)) : -1;
  return phase >= 0 && isOpen(strokesOf(node, doc), phase) ? phase : -1;
}

// A stroke on a phase, as one step of undo.
async function draw(node: DocNode, doc: Doc, phase: number, points: Point[], radius: number): Promise<void> {
  const text = strokeText(points, radius), known = strokesOf(node, doc)[phase], wires = node.inputs.strokes ?? [];
  if (known) return void await edit([{ op: 'append', node: known.name, name: 'strokes', value: text }]);
  const name = freshName(doc, `on_phase_${phase}`);
  const edits: Edit[] = [
    { op: 'add', node: name, type: 'Strokes' },
    { op: 'append', node: name, name: 'strokes', value: text },
    { op: 'connect', node: node.name, name: 'strokes', wires: [...wires, `${name}.strokes`] },
  ];
  if (node.params.phases) edits.push({ op: 'reset', node: node.name, name: 'phases' }); // there are as many as strokes
  await edit(edits);
}

export const phasePen = (node: DocNode, doc: Doc, phase: number, radius: number, factor: number): Pen => ({
  least: 1, most: 1e9, freehand: true, shape: 'line', wide: (2 * radius) / factor, leave: () => useStore.setState({ tool: null }),
  done: points => void draw(node, doc, phase, points.map(([x, y]) => [x * factor, y * factor]), radius),
});

export function PhaseTools({ node, doc, colors, radius, setRadius }: { node: DocNode; doc: Doc; colors: Colors; radius: number; setRadius: (r: number) => void }) {
  const phase = phaseOf(useStore(s => s.tool), node, doc), taught = strokesOf(node, doc);
  const shown = Math.min(Math.max(taught.length + 1, 2), mostPhases);
  return (
    <div className="pens" role="toolbar" aria-label="Strokes on phases">
      {Array.from({ length: shown }, (_, k) => (
        <button key={k} aria-pressed={phase === k} disabled={!isOpen(taught, k)} style={{ boxShadow: `inset 0 -3px ${colorOf(colors, k)}` }}
          title={`Draw on phase ${k}: pixels that look like it get it`} onClick={() => useStore.setState(s => ({ tool: s.tool === toolOf(k) ? null : toolOf(k) }))}>Phase {k}</button>
      ))}
      {phase >= 0 && <>
        <label>Radius <input type="range" min={1} max={60} value={radius} onChange={e => setRadius(Number(e.target.value))} /> {radius} pixels</label>
        <button onClick={() => useStore.setState({ tool: null })}>Done</button></>}
    </div>
  );
}

export const phaseHint = (node: DocNode) => ((node.inputs.strokes ?? []).length < 2 ? 'Drag over some of the phase, then over some of the other.' : 'Drag over what has the wrong phase.');

// The strokes of a text such as "7: 20 20, 50 30". Areas are not drawn.
function lines(text: string): { radius: number; points: string }[] {
  const [radius, points] = text.split(':');
  return points && Number(radius) > 0 ? [{ radius: Number(radius), points: points.trim() }] : [];
}

// The strokes in the picture, whose pixels are `factor` times as large as those of the strokes.
export function PhaseStrokes({ node, doc, colors, width, height, factor }: { node: DocNode; doc: Doc; colors: Colors; width: number; height: number; factor: number }) {
  return (
    <svg className="strokes" viewBox={`0 0 ${width * factor} ${height * factor}`} aria-hidden="true">
      {strokesOf(node, doc).flatMap((strokes, k) => [strokes?.params.strokes?.value ?? []].flat().flatMap(lines).map(({ radius, points }, i) => (
        <polyline key={`${k} ${i}`} points={points.includes(',') ? points : `${points}, ${points}`} stroke={colorOf(colors, k)} strokeWidth={2 * radius} />
      )))}
    </svg>
  );
}
