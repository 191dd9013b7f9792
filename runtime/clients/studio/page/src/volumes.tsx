import { Plane, Vector3 } from 'three';
import { useEffect, useMemo, useState } from 'react';

import { numberText } from './format';
import { useLoaded, useReference } from './load';
import { fetchRaster, PanZoom, Picture } from './raster';
import { RenderedView } from './rendered';
import { loadVolume, StageView, useHead, webGL, type VolumeHead } from './solids';
import type { DocNode, OutputValue } from './types';

const axes = ['x', 'y', 'z'];
const shownWith = [['y', 'z'], ['x', 'z'], ['x', 'y']]; // to the right, and up

function SlicePane({ value, head, grid, axis, at, set }: { value: OutputValue; head: VolumeHead; grid: string; axis: number; at: number; set: (v: number) => void }) {
  const range = head.grids.find(g => g.name === grid)?.range ?? [0, 1], n = head.size[axis];
  const { data, error } = useLoaded(`${value.hash}.${grid}.${axis}.${at}`, () =>
    fetchRaster(value.hash, `slice&grid=${encodeURIComponent(grid)}&axis=${axis}&lo=${range[0]}&hi=${range[1]}`, at));
  return (
    <div className="slice">
      {data ? <PanZoom width={data.width} height={data.height} hover={(x, y) => `${shownWith[axis][0]} ${x}, ${shownWith[axis][1]} ${data.height - 1 - y}`}><Picture raster={data} /></PanZoom> : <p className="none">{error || 'Loading…'}</p>}
      <label>{axes[axis]} <input type="range" min={0} max={n - 1} value={at} onChange={e => set(Number(e.target.value))} /> {at + 1} of {n}</label>
    </div>
  );
}

// A block of voxels, and three slices across its axes.
export function VolumeView({ value, node }: { value: OutputValue; node: DocNode }) {
  const { data: head, error } = useHead(value);
  const [grid, setGrid] = useState(''), [sliced, setSliced] = useState(false), [at, setAt] = useState<number[] | null>(null);
  const [binder, setBinder] = useState(true), [level, setLevel] = useState(0.4), [cut, setCut] = useState(0), [across, setAcross] = useState(1);
  const shown = head?.grids.find(g => g.name === grid) ?? head?.grids.find(g => g.name === 'Cd') ?? head?.grids[0];
  const rendered = !webGL && shown?.name === 'Cd', slices = sliced || (!webGL && !rendered); // the server renders colors only
  const quantity = !!shown?.range, reference = useReference(node, value);
  const solid = useLoaded(`${value.hash}.${shown?.name}`, async () => (head && shown && webGL ? loadVolume(value, head, shown.name, 192) : null));
  const before = useLoaded(`${reference?.hash}.${shown?.name}`, async () => (reference && head && shown && webGL ? loadVolume(reference, head, shown.name, 192) : null)).data;
  const coverage = shown?.name === 'Cd' && head?.grids.some(g => g.name === 'density');
  useEffect(() => {
    const l = quantity ? level : binder || !coverage ? 0 : 0.5;
    solid.data?.level?.(l), before?.level?.(l);
  });
  const box = solid.data?.content.box;
  const plane = useMemo(() => (box && cut > 0 ? new Plane(new Vector3().setComponent(across, 1), -cut * box.getComponent(across)) : null), [box, cut, across]);
  if (!head || !shown) return <p className="none">{error || 'Loading…'}</p>;
  const places = at ?? head.size.map(n => n >> 1);
  const choice = (
    <label>Grid <select value={shown.name} onChange={e => setGrid(e.target.value)}>{head.grids.map(g => <option key={g.name}>{g.name}</option>)}</select></label>
  );
  return (
    <>
      {slices ? (
        <div className="slices">{axes.map((_, k) => <SlicePane key={k} value={value} head={head} grid={shown.name} axis={k} at={places[k]} set={v => setAt(places.map((p, i) => (i === k ? v : p)))} />)}</div>
      ) : rendered ? <RenderedView value={value} /> : solid.error ? <p className="none">{solid.error}</p> : <StageView solid={solid.data} before={reference ? before : null} plane={plane} label="Block of voxels" />}
      <div className="options">
        {(webGL || rendered) && <button aria-pressed={slices} onClick={() => setSliced(!sliced)}>Slices</button>}
        {choice}
        {!slices && !rendered && coverage && <label><input type="checkbox" checked={binder} onChange={e => setBinder(e.target.checked)} /> Binder</label>}
        {!slices && !rendered && quantity && <label>From <input type="range" min={0} max={1} step={0.01} value={level} onChange={e => setLevel(Number(e.target.value))} /> {numberText(shown.range![0] + level * (shown.range![1] - shown.range![0]))}</label>}
        {!slices && !rendered && <label>Cut <select value={across} aria-label="Axis of the cut" onChange={e => setAcross(Number(e.target.value))}>{axes.map((a, k) => <option key={a} value={k}>{a}</option>)}</select>
          <input type="range" aria-label="Depth of the cut" min={0} max={0.99} step={0.01} value={cut} onChange={e => setCut(Number(e.target.value))} /></label>}
        <span>{slices || rendered ? `${head.size.join(' × ')} voxels of ${numberText(head.spacing[0])} mm` : solid.data?.note ?? 'Loading…'}</span>
      </div>
    </>
  );
}
