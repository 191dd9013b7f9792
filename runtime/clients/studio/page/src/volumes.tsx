import { Plane, Vector3 } from 'three';
import { useEffect, useMemo, useState } from 'react';

import { numberText } from './format';
import { useLoaded, useReference } from './load';
import { colorByValue, rampStyle } from './ramp';
import { fetchRaster, PanZoom, Picture, type Raster } from './raster';
import { RenderedView } from './rendered';
import { loadVolume, StageView, useHead, webGL, type GridHead, type VolumeHead } from './solids';
import type { DocNode, OutputValue } from './types';

const axes = ['x', 'y', 'z'];
const shownWith = [['y', 'z'], ['x', 'z'], ['x', 'y']]; // to the right, and up

// Units of quantities, as docs/grids.md defines them.
const units: Record<string, string> = {
  flow: 'for a slope of 1', potential: 'mm for a slope of 1', speed: 'mm² for a slope of 1', pressure: 'mm for a slope of 1', stress: 'for a strain of 1', surface: 'mm',
};
const short = (x: number) => numberText(Number(x.toPrecision(3)));

// The values of the colors. Those beyond the ends have the colors of the ends.
function Scale({ grid }: { grid: GridHead }) {
  const [lo, hi] = grid.shown!, [least, most] = grid.range!;
  return (
    <span className="scale" title={`${grid.name}: ${short(least)} to ${short(most)} ${units[grid.name] ?? ''}`}>
      {least < lo && '≤ '}{short(lo)} <i style={{ background: rampStyle }} /> {most > hi && '≥ '}{short(hi)} {units[grid.name]}
    </span>
  );
}

// The colors of a slice, and what its pixels say about the values.
function colored(raster: Raster, grid: GridHead): { raster: Raster; valueAt: (x: number, y: number) => string } {
  const gray = new Uint8Array(raster.data), data = raster.data.slice(0), [lo, hi] = grid.shown!;
  colorByValue(new Uint8Array(data));
  const valueAt = (x: number, y: number) => {
    const g = gray[4 * (x + y * raster.width)];
    return `${grid.name} ${g === 255 && grid.range![1] > hi ? '≥ ' : g === 0 && grid.range![0] < lo ? '≤ ' : ''}${short(lo + (g / 255) * (hi - lo))}`;
  };
  return { raster: { ...raster, data }, valueAt };
}

function SlicePane({ value, head, grid, axis, at, set }: { value: OutputValue; head: VolumeHead; grid: GridHead; axis: number; at: number; set: (v: number) => void }) {
  const range = grid.shown ?? [0, 1], n = head.size[axis];
  const { data, error } = useLoaded(`${value.hash}.${grid.name}.${range}.${axis}.${at}`, async () => {
    const raster = await fetchRaster(value.hash, `slice&grid=${encodeURIComponent(grid.name)}&axis=${axis}&lo=${range[0]}&hi=${range[1]}`, at);
    return grid.shown ? colored(raster, grid) : { raster, valueAt: () => '' };
  });
  const picture = data?.raster, step = picture ? Math.max(1, Math.ceil(picture.fullWidth / picture.width)) : 1;
  return (
    <div className="slice">
      {picture ? <PanZoom width={picture.width} height={picture.height} hover={(x, y) => `${shownWith[axis][0]} ${step * x}, ${shownWith[axis][1]} ${Math.max(picture.fullHeight - 1 - step * y, 0)}  ${data.valueAt(x, y)}`}><Picture raster={picture} /></PanZoom> : <p className="none">{error || 'Loading…'}</p>}
      <label>{axes[axis]} <input type="range" min={0} max={n - 1} value={at} onChange={e => set(Number(e.target.value))} /> {at + 1} of {n}</label>
    </div>
  );
}

// A block of voxels, and three slices across its axes.
export function VolumeView({ value: newest, node }: { value: OutputValue; node: DocNode }) {
  const { data, error } = useHead(newest), { value, head } = data ?? { value: newest };
  const [grid, setGrid] = useState(''), [sliced, setSliced] = useState(false), [at, setAt] = useState<number[] | null>(null);
  const [binder, setBinder] = useState(true), [chosen, setLevel] = useState<{ grid: string; level: number } | null>(null), [cut, setCut] = useState(0), [across, setAcross] = useState(1);
  const shown = head?.grids.find(g => g.name === grid) ?? head?.grids.find(g => g.name === 'Cd') ?? head?.grids[0];
  const rendered = !webGL && shown?.name === 'Cd', slices = sliced || (!webGL && !rendered); // the server renders colors only
  const quantity = !!shown?.shown, [lo, hi] = shown?.shown ?? [0, 1];
  // At first the highest fifth of the values, where four fifths are not all the same.
  const fifth = (shown?.most ?? 0) - lo, level = chosen && chosen.grid === shown?.name ? chosen.level : fifth > 0.02 * (hi - lo) && fifth < 0.98 * (hi - lo) ? fifth / (hi - lo) : 0.5;
  const reference = useReference(node, newest);
  const solid = useLoaded(`${value.hash}.${shown?.name}.${lo}.${hi}`, async () => (head && shown && webGL ? loadVolume(value, head, shown.name, 192) : null));
  const before = useLoaded(`${reference?.hash}.${value.hash}.${shown?.name}.${lo}.${hi}`, async () => (reference && head && shown && webGL ? loadVolume(reference, head, shown.name, 192) : null)).data;
  const coverage = shown?.name === 'Cd' && head?.grids.some(g => g.name === 'density');
  useEffect(() => {
    const l = quantity ? level : binder || !coverage ? 0 : 0.5;
    solid.data?.level?.(l), before?.level?.(l);
  });
  const box = solid.data?.content.box;
  const plane = useMemo(() => (box && cut > 0 ? new Plane(new Vector3().setComponent(across, 1), -cut * box.getComponent(across)) : null), [box, cut, across]);
  if (!head || !shown) return <p className="none">{error || 'Loading…'}</p>;
  const places = head.size.map((n, k) => Math.min(at?.[k] ?? n >> 1, n - 1));
  const choice = (
    <label>Grid <select value={shown.name} onChange={e => setGrid(e.target.value)}>{head.grids.map(g => <option key={g.name}>{g.name}</option>)}</select></label>
  );
  return (
    <>
      {slices ? (
        <div className="slices">{axes.map((_, k) => <SlicePane key={k} value={value} head={head} grid={shown} axis={k} at={places[k]} set={v => setAt(places.map((p, i) => (i === k ? v : p)))} />)}</div>
      ) : rendered ? <RenderedView value={value} /> : solid.error ? <p className="none">{solid.error}</p> : <StageView solid={solid.data} before={reference ? before : null} plane={plane} label="Block of voxels" />}
      <div className="options">
        {(webGL || rendered) && <button aria-pressed={slices} onClick={() => setSliced(!sliced)}>Slices</button>}
        {choice}
        {quantity && !rendered && <Scale grid={shown} />}
        {!slices && !rendered && coverage && <label><input type="checkbox" checked={binder} onChange={e => setBinder(e.target.checked)} /> Binder</label>}
        {!slices && !rendered && quantity && <label>From <input type="range" min={0} max={1} step={0.01} value={level} onChange={e => setLevel({ grid: shown.name, level: Number(e.target.value) })} /> {short(lo + level * (hi - lo))}</label>}
        {!slices && !rendered && <label>Cut <select value={across} aria-label="Axis of the cut" onChange={e => setAcross(Number(e.target.value))}>{axes.map((a, k) => <option key={a} value={k}>{a}</option>)}</select>
          <input type="range" aria-label="Depth of the cut" min={0} max={0.99} step={0.01} value={cut} onChange={e => setCut(Number(e.target.value))} /></label>}
        <span>{slices || rendered ? `${head.size.join(' × ')} voxels of ${numberText(head.spacing[0])} mm` : solid.data?.note ?? 'Loading…'}</span>
      </div>
    </>
  );
}
