import { useEffect, useRef, useState } from 'react';

import { numberText } from './format';
import { declarationOf, edit, splitWire, steadily, useStore, valueOf, type Edit } from './store';
import type { DocNode } from './types';
import { fetchJson, useLoaded } from './viewers';

const axes = ['x', 'y', 'z'];

// The box of what a Section cuts: its edges in mm.
function useBox(node: DocNode): number[] | null {
  const value = useStore(s => {
    const source = node.inputs.particles ?? node.inputs.volume;
    const { node: name, port } = splitWire(source?.[0] ?? '', s.doc!, s.types), from = s.doc?.nodes.find(n => n.name === name);
    return from && valueOf(from, port, s.nodes);
  });
  const { data } = useLoaded(String(value?.hash), async () => (value ? fetchJson<{ box?: number[]; grids?: { voxel_size: number; bounding_box: number[][] }[] }>(value.hash, 'summary') : null));
  if (data?.box) return data.box;
  const grid = data?.grids?.[0];
  return grid ? axes.map((_, k) => (grid.bounding_box[1][k] - grid.bounding_box[0][k] + 1) * grid.voxel_size) : null;
}

// Moves the plane of a Section along its axis.
export function PlaneBar({ node }: { node: DocNode }) {
  const types = useStore(s => s.types);
  const box = useBox(node);
  const [index, setIndex] = useState(0);
  const [moved, setMoved] = useState<number | null>(null);
  const text = (name: string) => {
    const own = node.params[name]?.value;
    return own === undefined ? String(declarationOf(node, types)?.parameters.find(p => p.name === name)?.default ?? '') : Array.isArray(own) ? own.join(' ') : own;
  };
  const axis = text('axis'), across = axes.indexOf(axis), extent = across >= 0 ? box?.[across] ?? 0 : 0;
  const own = text('offsets').split(/[ ,]+/).map(Number);
  const given = own.length > 0 && own.every(v => Number.isFinite(v)) && text('offsets') !== '';
  const count = given ? own.length : Number(text('planes')) || 1;
  const offsets = given ? own : Array.from({ length: count }, (_, k) => ((k + 0.5) / count) * extent);
  const at = Math.min(index, count - 1), shown = moved ?? offsets[at] ?? 0;

  const send = useRef((_: number): Promise<unknown> => Promise.resolve());
  send.current = v => {
    const now = offsets.map((o, k) => String(Number((k === at ? v : o).toFixed(3))));
    return edit([{ op: 'set', node: node.name, name: 'offsets', value: now.length === 1 ? now[0] : now }], true);
  };
  const [sender] = useState(() => steadily((v: number) => send.current(v)));
  useEffect(() => { if (!sender.busy()) setMoved(null); }, [sender, node.params.offsets?.value]);
  const choose = (a: string) => {
    const edits: Edit[] = [{ op: 'set', node: node.name, name: 'axis', value: a }];
    for (const p of a === 'random' ? ['offsets'] : ['width', 'height', 'offsets']) if (node.params[p]) edits.push({ op: 'reset', node: node.name, name: p });
    void edit(edits);
  };
  return (
    <div className="options plane">
      <label>Plane across <select value={axis} onChange={e => choose(e.target.value)}>{[...axes, 'random'].map(a => <option key={a}>{a}</option>)}</select></label>
      {across >= 0 && extent > 0 && (
        <>
          {count > 1 && <label>Plane <input type="number" min={1} max={count} value={at + 1} onChange={e => setIndex(Math.min(Math.max(Number(e.target.value) - 1, 0), count - 1))} /> of {count}</label>}
          <label className="wide">at <input type="range" aria-label={`Position of the plane along ${axis}, mm`} min={0} max={extent} step={extent / 500} value={shown}
            onChange={e => { setMoved(Number(e.target.value)); void sender.move(Number(e.target.value)); }} /> {numberText(Number(shown.toFixed(2)))} of {numberText(Number(extent.toFixed(2)))} mm</label>
        </>
      )}
      {across < 0 && <span>Choose an axis to move the plane.</span>}
    </div>
  );
}
