import { useEffect, useRef, useState, type PointerEvent } from 'react';

import { useLoaded, useReference } from './load';
import { colorAt } from './color';
import { useDropper } from './dropper';
import { nibOf, paint, setRegion } from './nib';
import type { Pen } from './pen';
import { fetchRaster, isPreview, PanZoom, Picture, type Raster } from './raster';
import { shownDoc } from './states';
import { isLocked, useStore } from './store';
import type { DocNode, OutputValue } from './types';

export function Sections({ count, section, set }: { count: number; section: number; set: (s: number) => void }) {
  if (count < 2) return null;
  return <label>Section <input type="number" min={1} max={count} value={section + 1} onChange={e => set(Math.min(Math.max(Number(e.target.value) - 1, 0), count - 1))} /> of {count}</label>;
}

function srgb(r: Raster, x: number, y: number): string {
  const at = 4 * (y * r.width + x), d = new Uint8Array(r.data, at, 3);
  return `${d[0]} ${d[1]} ${d[2]}  #${[...d].map(v => v.toString(16).padStart(2, '0')).join('')}`;
}

// The picture with another exposure: light doubles with each stop, then the display's encoding applies again.
function exposed(r: Raster, stops: number): Raster {
  if (!stops) return r;
  const table = new Uint8Array(256);
  for (let v = 0; v < 256; ++v) {
    const c = v / 255, light = Math.min(1, (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4) * 2 ** stops);
    table[v] = Math.round(255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * light ** (1 / 2.4) - 0.055));
  }
  const from = new Uint8Array(r.data), to = new Uint8Array(from.length);
  for (let k = 0; k < from.length; k += 4) to[k] = table[from[k]], to[k + 1] = table[from[k + 1]], to[k + 2] = table[from[k + 2]], to[k + 3] = from[k + 3];
  return { ...r, data: to.buffer };
}

// Where two pictures meet. It is dragged, or moved with the arrow keys.
export function Wipe({ share, set, label }: { share: number; set: (s: number) => void; label: string }) {
  const bar = useRef<HTMLDivElement>(null);
  const move = (e: PointerEvent) => {
    const r = bar.current!.parentElement!.getBoundingClientRect();
    if (e.buttons & 1) set(Math.min(Math.max((e.clientX - r.left) / r.width, 0), 1));
  };
  return (
    <div ref={bar} className="wipe" style={{ left: `${100 * share}%` }} role="slider" tabIndex={0} aria-label={`Boundary between ${label} and now`} aria-valuemin={0} aria-valuemax={100}
      aria-valuenow={Math.round(100 * share)} onPointerDown={e => { e.stopPropagation(); e.currentTarget.setPointerCapture(e.pointerId); }} onPointerMove={move} onDoubleClick={e => e.stopPropagation()}
      onKeyDown={e => {
        const by = { ArrowLeft: -0.02, ArrowRight: 0.02 }[e.key];
        if (by) set(Math.min(Math.max(share + by, 0), 1)), e.preventDefault(), e.stopPropagation();
      }}><span>{label}</span><span>now</span></div>
  );
}

// Cuts `over` where the picture behind it shows: left of the share of the view.
export function useClip(share: number, on: boolean) {
  const over = useRef<HTMLDivElement>(null);
  useEffect(() => {
    const element = over.current;
    if (!element) return;
    if (!on) {
      element.style.clipPath = '';
      return;
    }
    let frame = 0;
    const follow = () => {
      const view = element.closest('.panzoom')!.getBoundingClientRect(), own = element.getBoundingClientRect();
      const left = ((view.left + share * view.width - own.left) / own.width) * 100;
      element.style.clipPath = `inset(0 0 0 ${Math.min(Math.max(left, 0), 100)}%)`;
      frame = requestAnimationFrame(follow);
    };
    follow();
    return () => cancelAnimationFrame(frame);
  }, [share, on]);
  return over;
}

export function ImageView({ value, node }: { value: OutputValue; node: DocNode }) {
  const [section, setSection] = useState(0), [stops, setStops] = useState(0), [share, setShare] = useState(0.5);
  const reference = useReference(node, value);
  const { data, error } = useLoaded(`${value.hash}.${section}`, () => fetchRaster(value.hash, 'pixels', section));
  const old = useLoaded(`${reference?.hash}.${section}`, async () => (reference ? fetchRaster(reference.hash, 'pixels', section) : null)).data;
  const over = useClip(share, !!reference && !!old);
  const tool = useStore(s => (s.tool === 'nib' || s.tool === 'region' ? s.tool : null)), doc = useStore(shownDoc), locked = useStore(isLocked);
  const [radius, setRadius] = useState(8);
  const dropper = useDropper(data);
  if (!data) return <p className="none">{error || 'Loading…'}</p>;
  const factor = data.fullWidth / data.width, known = doc && nibOf(node, doc);
  const port = Object.entries(useStore.getState().nodes[node.name]?.outputs ?? {}).find(([, o]) => o.hash === value.hash)?.[0] ?? 'image';
  const choose = (name: string) => useStore.setState(s => ({ tool: s.tool === name ? null : name }));
  const leave = () => useStore.setState({ tool: null });
  const full = (points: [number, number][]): [number, number][] => points.map(([x, y]) => [x * factor, y * factor]);
  const pen: Pen | null = dropper ?? (tool === 'nib' && !locked ? { least: 1, most: 1e9, freehand: true, shape: 'line', wide: (2 * radius) / factor, leave, done: points => void paint(node, port, full(points), radius) }
    : tool === 'region' && known ? { least: 2, most: 2, freehand: false, shape: 'box', leave, done: points => void setRegion(known.nib, full(points)).then(leave) } : null);
  return (
    <>
      {!locked && !isPreview(value.hash) && tool && (
        <div className="pens" role="toolbar" aria-label="Nib">
          <button aria-pressed={tool === 'nib'} onClick={() => choose('nib')}>Paint</button>
          {known && <button aria-pressed={tool === 'region'} onClick={() => choose('region')}>Region</button>}
          <label>Radius <input type="range" min={1} max={60} value={radius} onChange={e => setRadius(Number(e.target.value))} /> {radius} pixels</label>
          <button onClick={leave}>Done</button>
        </div>
      )}
      <div className="wiped">
        <PanZoom pen={pen} width={data.width} height={data.height} smooth={isPreview(value.hash)} hover={(x, y) => dropper ? `color ${colorAt(data, [x, y])}` : `${Math.round(x * factor)}, ${Math.round(y * factor)}   sRGB ${srgb(data, x, y)}`}>
          {reference && old && <Picture raster={exposed(old, stops)} />}
          <div ref={over} className="over"><Picture raster={exposed(data, stops)} /></div>
        </PanZoom>
        {reference && old && <Wipe share={share} set={setShare} label="before" />}
      </div>
      <div className="options"><Sections count={data.sections} section={section} set={setSection} />
        <label>Exposure <input type="range" min={-4} max={4} step={0.25} value={stops} onChange={e => setStops(Number(e.target.value))} onDoubleClick={() => setStops(0)} aria-valuetext={`${stops} stops`} /> {stops > 0 ? `+${stops}` : stops}</label>
        {!locked && !isPreview(value.hash) && data.sections === 1 && !tool && <button onClick={() => choose('nib')} title="Paint texture into the picture: it grows out of its surroundings">Nib</button>}
        {tool && <span>{tool === 'region' ? 'Drag a rectangle over the texture that is painted.' : 'Drag over what you want to erase. Points with the keyboard: Space, then Enter.'}</span>}
        {factor > 1 && <span>reduced from {data.fullWidth} × {data.fullHeight}</span>}</div>
    </>
  );
}
