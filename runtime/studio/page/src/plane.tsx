import { useEffect, useRef, useState } from 'react';

import { numberText } from './format';
import { declarationOf, edit, splitWire, useStore, valueOf, type Edit } from './store';
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

// Waits until the node has its new result, but not for long.
async function settled(node: string) {
  for (let k = 0; k < 30; ++k) {
    await new Promise(done => setTimeout(done, 60));
    if (!['waiting', 'running'].includes(useStore.getState().nodes[node]?.state)) return;
  }
}

// Moves the plane of a Section along its axis. While it moves, the next position is sent when the last one is shown, because a
// new one cancels what is computed for the last one.
export function PlaneBar({ node }: { node: DocNode }) {
  const types = useStore(s => s.types);
  const box = useBox(node);
  const [index, setIndex] = useState(0);
  const [moved, setMoved] = useState<number | null>(null);
  const sending = useRef({ busy: false, next: null as number | null });
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
  useEffect(() => setMoved(null), [node.params.offsets?.value]);

  const send = async (v: number) => {
    const s = sending.current;
    s.next = v;
    if (s.busy) return;
    s.busy = true;
    while (s.next !== null) {
      const now = offsets.map((o, k) => String(Number((k === at ? s.next! : o).toFixed(3))));
      s.next = null;
      await edit([{ op: 'set', node: node.name, name: 'offsets', value: now.length === 1 ? now[0] : now }], true);
      await settled(node.name);
    }
    s.busy = false;
  };
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
            onChange={e => { setMoved(Number(e.target.value)); void send(Number(e.target.value)); }} /> {numberText(Number(shown.toFixed(2)))} of {numberText(Number(extent.toFixed(2)))} mm</label>
        </>
      )}
      {across < 0 && <span>Choose an axis to move the plane.</span>}
    </div>
  );
}
