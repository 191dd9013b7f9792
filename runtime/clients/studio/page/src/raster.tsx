import { useCallback, useEffect, useRef, useState, type PointerEvent, type ReactNode, type WheelEvent } from 'react';

import { SavePicture } from './save_picture';
import { Draft, usePen, type Pen, type View } from './pen';

export interface Raster { width: number; height: number; sections: number; fullWidth: number; fullHeight: number; data: ArrayBuffer }

export const isPreview = (hash: string) => hash.startsWith('preview/');
export const urlOf = (hash: string) => (isPreview(hash) ? `/api/${hash}` : `/api/value/${hash}`);

async function load(url: string): Promise<Raster> {
  const answer = await fetch(url);
  if (answer.status === 204) throw new Error('there is a newer preview');
  if (!answer.ok) throw new Error((await answer.json()).message);
  const bytes = await answer.arrayBuffer();
  const head = new Uint32Array(bytes, 0, 5);
  return { width: head[0], height: head[1], sections: head[2], fullWidth: head[3], fullHeight: head[4], data: bytes.slice(20) };
}

// The last pictures stay, so that going back and forth between nodes loads nothing. Nothing writes into them.
const kept = new Map<string, Promise<Raster>>();
const mostKept = 12; // of at most 16 MB each

export function fetchRaster(hash: string, as: string, section: number, most = 2048): Promise<Raster> {
  const url = `${urlOf(hash)}?as=${as}&section=${section}&most=${most}`;
  if (isPreview(hash)) return load(url);
  const raster = kept.get(url) ?? load(url);
  kept.delete(url); // the newest is last
  kept.set(url, raster);
  raster.catch(() => kept.delete(url));
  if (kept.size > mostKept) kept.delete(kept.keys().next().value!);
  return raster;
}

export function Picture({ raster, opacity }: { raster: Raster; opacity?: number }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const c = canvas.current!;
    c.width = raster.width, c.height = raster.height;
    c.getContext('2d')!.putImageData(new ImageData(new Uint8ClampedArray(raster.data), raster.width, raster.height), 0, 0);
  }, [raster]);
  return <canvas ref={canvas} style={{ opacity }} />;
}

// Zoom with the wheel, pan by dragging, double click to fit. Children are drawn in pixels of the picture. With a pen, dragging
// draws, and other buttons pan. A picture of other resolution takes the place of the one before. `smooth`: pixels are never sharp.
// Pictures with one `link` move together: its view is in mm, and `scale` is the size of this picture's pixel.
export interface Link { view: View | null; set: (v: View) => void; scale: number }

export function PanZoom({ width, height, children, hover, pen = null, smooth = false, link }: { width: number; height: number; children: ReactNode; hover?: (x: number, y: number) => string; pen?: Pen | null; smooth?: boolean; link?: Link }) {
  const box = useRef<HTMLDivElement>(null);
  const [own, setOwn] = useState<View | null>(null);
  const view = link ? link.view && { ...link.view, k: link.view.k * link.scale } : own;
  const linked = useRef(link);
  linked.current = link;
  const setView = useCallback((v: View) => (linked.current ? linked.current.set({ ...v, k: v.k / linked.current.scale }) : setOwn(v)), []);
  const draft = usePen(pen, width, height);
  const [note, setNote] = useState('');
  const drag = useRef<{ x: number; y: number } | null>(null);
  const fitted = useRef(false);
  const fit = useCallback(() => {
    const b = box.current;
    fitted.current = true;
    if (!b || !width || !b.clientWidth) return;
    const k = Math.min((b.clientWidth - 16) / width, (b.clientHeight - 16) / height);
    setView({ k, x: (b.clientWidth - k * width) / 2, y: (b.clientHeight - k * height) / 2 });
  }, [width, height, setView]);
  // A picture that fills its place fills it again when the place changes.
  useEffect(() => {
    const observer = new ResizeObserver(() => { if (fitted.current) fit(); });
    observer.observe(box.current!);
    return () => observer.disconnect();
  }, [fit]);
  const before = useRef({ width: 0, height: 0 });
  useEffect(() => {
    const old = before.current;
    before.current = { width, height };
    if (old.width && Math.abs(old.width / old.height / (width / height) - 1) < 0.02) { if (!linked.current) setOwn(v => v && { ...v, k: (v.k * old.width) / width }); } else if (!linked.current?.view) fit();
  }, [fit, width, height]);
  const wheel = (e: WheelEvent) => {
    if (!view) return;
    const r = box.current!.getBoundingClientRect(), px = e.clientX - r.left, py = e.clientY - r.top;
    const k = Math.min(Math.max(view.k * 2 ** (-e.deltaY / 300), 0.02), 64), q = k / view.k;
    fitted.current = false;
    setView({ k, x: px - (px - view.x) * q, y: py - (py - view.y) * q });
  };
  const pointOf = (e: PointerEvent, v: View): [number, number] => {
    const r = box.current!.getBoundingClientRect();
    return [(e.clientX - r.left - v.x) / v.k, (e.clientY - r.top - v.y) / v.k];
  };
  const move = (e: PointerEvent) => {
    if (!view) return;
    if (drag.current) {
      fitted.current = false;
      setView({ ...view, x: view.x + e.clientX - drag.current.x, y: view.y + e.clientY - drag.current.y });
      drag.current = { x: e.clientX, y: e.clientY };
    }
    const [px, py] = pointOf(e, view), x = Math.floor(px), y = Math.floor(py);
    draft?.move([px, py], view.k);
    setNote(hover && x >= 0 && y >= 0 && x < width && y < height ? hover(x, y) : '');
  };
  return (
    <div ref={box} className={`panzoom${view && view.k > 2 && !smooth ? ' sharp' : ''}${pen ? ' pen' : ''}`} onWheel={wheel} onDoubleClick={draft ? draft.twice : fit} onPointerMove={move} tabIndex={0} role="group"
      aria-label={pen ? 'Picture: arrow keys move the cross, Space sets a point, Enter ends, Escape cancels' : 'Picture: zoom with the wheel, drag to pan, double click to fit'}
      onKeyDown={e => { if (e.key === '0') fit(); else if (view) draft?.key(e, view.k); }}
      onPointerDown={e => {
        if (draft && view && e.button === 0) return draft.down(e, pointOf(e, view));
        drag.current = { x: e.clientX, y: e.clientY }; e.currentTarget.setPointerCapture(e.pointerId);
      }}
      onPointerUp={e => {
        if (draft && view && !drag.current) draft.up(pointOf(e, view));
        drag.current = null;
      }} onPointerLeave={() => setNote('')}>
      {view && <div className="content" style={{ transform: `translate(${view.x}px, ${view.y}px) scale(${view.k})`, width, height }}>{children}{draft && <Draft pen={pen!} state={draft} k={view.k} width={width} height={height} />}</div>}
      <SavePicture canvases={() => [...box.current!.querySelectorAll('canvas')]} />
      <output className="readout">{note || (view && !smooth ? `${width} × ${height} pixels, ${Math.round(100 * view.k)} %` : '')}</output>
    </div>
  );
}
