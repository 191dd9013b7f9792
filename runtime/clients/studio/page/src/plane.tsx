import { Plane, Vector3 } from 'three';
import { useEffect, useMemo, useRef, useState } from 'react';

import { numberText } from './format';
import { fetchJson, useLoaded, useNearest } from './load';
import type { View } from './pen';
import { fetchRaster, PanZoom, Picture } from './raster';
import { RenderedView } from './rendered';
import { loadParticles, loadVolume, StageView, useHead, useShapesOf, webGL } from './solids';
import { declarationOf, previewOf, shownDoc, splitWire, valueOf } from './states';
import { edit, steadily, useStore, type Edit } from './store';
import type { DocNode, OutputValue } from './types';

const axes = ['x', 'y', 'z'];

// What a Section cuts: the node and the value at its input.
function useCutValue(node: DocNode): { node: DocNode; value: OutputValue } | null {
  const doc = useStore(shownDoc), types = useStore(s => s.types), nodes = useStore(s => s.nodes);
  return useMemo(() => {
    if (!doc) return null;
    const { node: name, port } = splitWire((node.inputs.particles ?? node.inputs.volume)?.[0] ?? '', doc, types), from = doc.nodes.find(n => n.name === name);
    const value = from && valueOf(from, port, nodes);
    return value ? { node: from, value } : null;
  }, [doc, types, nodes, node]);
}

// The box of what a Section cuts: its edges in mm.
function useBox(node: DocNode): number[] | null {
  const value = useCutValue(node)?.value;
  const { data } = useLoaded(String(value?.hash), async () => (value ? fetchJson<{ box?: number[]; grids?: { voxel_size: number; bounding_box: number[][] }[] }>(value.hash, 'summary') : null));
  return useMemo(() => {
    if (data?.box) return data.box;
    const grid = data?.grids?.[0];
    return grid ? axes.map((_, k) => (grid.bounding_box[1][k] - grid.bounding_box[0][k] + 1) * grid.voxel_size) : null;
  }, [data]);
}

// The parameters that place a Section's plane, and what changes them.
function usePlane(node: DocNode) {
  const types = useStore(s => s.types), box = useBox(node);
  const [index, setIndex] = useState(0), [moved, setMoved] = useState<number[] | null>(null); // while they move: position, tilt, turn
  const text = (name: string) => {
    const own = node.params[name]?.value;
    return own === undefined ? String(declarationOf(node, types)?.parameters.find(p => p.name === name)?.default ?? '') : Array.isArray(own) ? own.join(' ') : own;
  };
  const axis = text('axis'), across = axes.indexOf(axis), free = axis === 'free';
  const numbers = (name: string) => text(name).split(/[ ,]+/).filter(t => t !== '').map(Number);
  const own = numbers('offsets'), given = own.length > 0 && own.every(v => Number.isFinite(v));
  const count = free ? 1 : given ? own.length : Number(text('planes')) || 1, at = Math.min(index, count - 1);
  const normal = numbers('normal').length === 3 ? new Vector3(...numbers('normal') as [number, number, number]).normalize() : new Vector3(0, 0, 1);
  const middle = box ? new Vector3(...box.map(v => v / 2) as [number, number, number]) : new Vector3();
  const through = numbers('through').length === 3 ? new Vector3(...numbers('through') as [number, number, number]) : middle;
  // A free plane is placed by its distance from the middle of the box, along its normal.
  const extent = !box ? 0 : free ? Math.hypot(...box) : across >= 0 ? box[across] : 0;
  const offsets = given ? own : Array.from({ length: count }, (_, k) => ((k + 0.5) / count) * extent);
  const angles = [Math.acos(Math.min(Math.max(normal.z, -1), 1)), Math.atan2(normal.y, normal.x)].map(v => (v * 180) / Math.PI);
  const places = moved ?? (free ? [through.clone().sub(middle).dot(normal) + extent / 2, ...angles] : [offsets[at] ?? 0]);
  const direction = ([, tilt, turn]: number[]) => new Vector3(Math.sin(tilt * Math.PI / 180) * Math.cos(turn * Math.PI / 180), Math.sin(tilt * Math.PI / 180) * Math.sin(turn * Math.PI / 180), Math.cos(tilt * Math.PI / 180));
  const send = useRef((_: number[]): Promise<unknown> => Promise.resolve());
  send.current = v => {
    const word = (x: number) => String(Number(x.toFixed(3)) + 0);
    if (free) {
      const n = direction(v), p = middle.clone().addScaledVector(n, v[0] - extent / 2);
      return edit([{ op: 'set', node: node.name, name: 'normal', value: n.toArray().map(word) }, { op: 'set', node: node.name, name: 'through', value: p.toArray().map(word) }], true);
    }
    const now = offsets.map((o, k) => word(k === at ? v[0] : o));
    return edit([{ op: 'set', node: node.name, name: 'offsets', value: now.length === 1 ? now[0] : now }], true);
  };
  const [sender] = useState(() => steadily((v: number[]) => send.current(v)));
  const written = JSON.stringify(['offsets', 'normal', 'through'].map(n => node.params[n]?.value));
  useEffect(() => { if (!sender.busy()) setMoved(null); }, [sender, written]);
  const move = (v: number[]) => {
    const kept = [Math.min(Math.max(v[0], 0), extent), ...v.slice(1)];
    setMoved(kept);
    void sender.move(kept);
  };
  const choose = (a: string) => {
    const edits: Edit[] = [{ op: 'set', node: node.name, name: 'axis', value: a }];
    for (const p of a === 'random' || a === 'free' ? ['offsets', 'planes'] : ['width', 'height', 'offsets']) if (node.params[p]) edits.push({ op: 'reset', node: node.name, name: p });
    for (const p of ['normal', 'through']) if (a !== 'free' && node.params[p]) edits.push({ op: 'reset', node: node.name, name: p });
    void edit(edits);
  };
  const key = places.join(' ');
  const plane = useMemo(() => {
    if (!box || (!free && across < 0)) return null;
    const n = free ? direction(places) : new Vector3().setComponent(across, 1);
    return new Plane(n, free ? -n.dot(middle) - (places[0] - extent / 2) : -places[0]);
    // eslint-disable-next-line react-hooks/exhaustive-deps
  }, [box, axis, key]);
  // A plane that was dragged along its normal.
  const drag = (p: Plane) => move([free ? -p.constant - p.normal.dot(middle) + extent / 2 : -p.constant, ...places.slice(1)]);
  return { axis, across, free, box, extent, count, at, setIndex, places, move, choose, plane, drag };
}

function Controls({ plane: p, types }: { plane: ReturnType<typeof usePlane>; types: string[] }) {
  const degrees = (k: number, name: string, most: number) => (
    <label>{name} <input type="range" aria-label={`${name} of the plane, degrees`} min={k === 1 ? 0 : -180} max={most} step={1} value={p.places[k]}
      onChange={e => p.move(p.places.map((v, i) => (i === k ? Number(e.target.value) : v)))} /> {Math.round(p.places[k])}°</label>
  );
  return (
    <div className="options plane">
      <label>Plane across <select value={p.axis} onChange={e => p.choose(e.target.value)}>{types.map(a => <option key={a}>{a}</option>)}</select></label>
      {(p.across >= 0 || p.free) && p.extent > 0 && (
        <>
          {p.count > 1 && <label>Plane <input type="number" min={1} max={p.count} value={p.at + 1} onChange={e => p.setIndex(Math.min(Math.max(Number(e.target.value) - 1, 0), p.count - 1))} /> of {p.count}</label>}
          <label className="wide">at <input type="range" aria-label={`Position of the plane along ${p.free ? 'its normal' : p.axis}, mm`} min={0} max={p.extent} step={p.extent / 500} value={p.places[0]}
            onChange={e => p.move([Number(e.target.value), ...p.places.slice(1)])} /> {numberText(Number(p.places[0].toFixed(2)))} of {numberText(Number(p.extent.toFixed(2)))} mm</label>
          {p.free && degrees(1, 'tilt', 180)}{p.free && degrees(2, 'turn', 180)}
        </>
      )}
      {p.axis === 'random' && <span>Choose an axis to move the plane.</span>}
    </div>
  );
}

const useAxes = (node: DocNode) => useStore(s => declarationOf(node, s.types)?.parameters.find(p => p.name === 'axis')?.choices) ?? axes;

// Moves the plane of a Section.
export function PlaneBar({ node }: { node: DocNode }) {
  return <Controls plane={usePlane(node)} types={useAxes(node)} />;
}

// Measures of the nodes downstream that compare the section with the photograph.
function Figures({ node }: { node: DocNode }) {
  const doc = useStore(shownDoc), types = useStore(s => s.types), nodes = useStore(s => s.nodes);
  const found = useMemo(() => {
    if (!doc) return [];
    const seen = new Set([node.name]);
    for (let grown = true; grown;) {
      grown = false;
      for (const n of doc.nodes)
        if (!seen.has(n.name) && Object.values(n.inputs).flat().some(w => seen.has(splitWire(w, doc, types).node))) seen.add(n.name), grown = true;
    }
    return doc.nodes.filter(n => seen.has(n.name) && ['Compare', 'TextureObserver'].includes(n.type));
  }, [doc, types, node.name]);
  const own = nodes[node.name]?.metrics ?? {};
  const rows = [...Object.entries(own).map(([k, v]) => [k, v] as const), ...found.flatMap(n => Object.entries(nodes[n.name]?.metrics ?? {}).map(([k, v]) => [`${n.name}.${k}`, v] as const))];
  return <dl className="figures" tabIndex={0} aria-label="Measures of the section">{rows.map(([k, v]) => <div key={k}><dt>{k.replace(/_/g, ' ')}</dt><dd>{numberText(v)}</dd></div>)}{!rows.length && <p className="none">There are no measures yet.</p>}</dl>;
}

// A picture at a scale that two pictures share.
function Scaled({ value, title, view, set }: { value: OutputValue | undefined; title: string; view: View | null; set: (v: View) => void }) {
  const { data, error } = useLoaded(String(value?.hash), async () => (value ? fetchRaster(value.hash, 'pixels', 0) : null));
  const size = useLoaded(`${value?.hash}.size`, async () => (value ? fetchJson<{ pixel_size: number }>(value.hash, 'summary') : null)).data?.pixel_size;
  return <figure>{data && size ? <PanZoom width={data.width} height={data.height} link={{ view, set, scale: (size * data.fullWidth) / data.width }}><Picture raster={data} /></PanZoom> : <p className="none">{error || 'There is no picture yet.'}</p>}<figcaption>{title}</figcaption></figure>;
}

// The block with its plane, and beside it the section and the photograph at one scale. The block is cut here while the plane moves; the
// section is the node's own.
export function PlaneView({ node }: { node: DocNode }) {
  const p = usePlane(node), names = useAxes(node), cut = useCutValue(node), nodes = useStore(s => s.nodes);
  const down = useNearest(cut?.node.name ?? '', 'Volume', 'down'), volume = cut?.value.type === 'Volume' ? cut.value : down?.value;
  const { value: drawn, head } = useHead(volume).data ?? {}, shapes = useShapesOf(cut?.node ?? node, cut?.value);
  const grid = head && (head.grids.find(g => g.name === 'Cd') ?? head.grids[0]).name;
  const [binder, setBinder] = useState(true);
  const block = useLoaded(`${drawn?.hash}.${grid}`, async () => (drawn && head && grid && webGL ? loadVolume(drawn, head, grid, 160) : null));
  const bodies = useLoaded(`${cut?.value.hash}.${shapes?.hash}.${!!volume}`, async () => (cut?.value.type === 'Particles' && webGL ? loadParticles(cut.value, shapes) : null));
  const solid = volume && binder ? block.data : bodies.data ?? block.data;
  const [view, setView] = useState<View | null>(null);
  const photo = useNearest(node.name, 'Image', 'up'), section = previewOf(node, 'image', nodes) ?? valueOf(node, 'image', nodes);
  const editable = !node.name.includes('/');
  return (
    <>
      <div className="cutting">
        <div className="pane">{!webGL && (volume ?? cut) ? <RenderedView value={volume ?? cut!.value} shapes={shapes} /> : solid ? <StageView solid={solid} plane={p.plane} onPlane={editable && p.plane ? p.drag : undefined} label="Block with its plane; drag the blue handle" />
          : <p className="none">{block.error || bodies.error || (cut ? 'Loading…' : 'There is nothing to cut yet.')}</p>}</div>
        <div className="pictures"><Scaled value={section} title={`${node.name}.image`} view={view} set={setView} />
          {photo ? <Scaled value={photo.value} title={`${photo.target.node}.${photo.target.port}`} view={view} set={setView} />
            : <figure><p className="none">The graph has no photograph to compare the section with.</p></figure>}</div>
        <Figures node={node} />
      </div>
      <div className="options">{volume && bodies.data && <label><input type="checkbox" checked={binder} onChange={e => setBinder(e.target.checked)} /> Binder</label>}
        <span>{solid?.note}</span></div>
      {editable && <Controls plane={p} types={names} />}
    </>
  );
}
