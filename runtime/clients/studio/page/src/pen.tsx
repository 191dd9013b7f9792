import { useEffect, useState, type KeyboardEvent, type PointerEvent } from 'react';

export type Point = [number, number];
export interface View { x: number; y: number; k: number }

// A tool that takes points in a picture. `most`: it is done with so many points; `freehand`: dragging draws a line.
export interface Pen {
  least: number; most: number; freehand: boolean; shape: 'points' | 'line' | 'area' | 'box';
  wide?: number; // width of the line, in pixels of the picture
  done: (points: Point[]) => void;
  leave: () => void;
}

// The pointer and the keyboard as a pen. Points are in pixels of the picture.
export function usePen(pen: Pen | null, width: number, height: number) {
  const [points, setPoints] = useState<Point[]>([]);
  const [cursor, setCursor] = useState<Point | null>(null);
  const [from, setFrom] = useState<{ at: Point; dragged: boolean } | null>(null);
  const [to, setTo] = useState<Point | null>(null);
  const clear = () => { setPoints([]); setFrom(null); setTo(null); };
  const key = pen ? `${pen.least}${pen.most}${pen.shape}${pen.freehand}` : '';
  useEffect(clear, [key]);
  if (!pen) return null;

  const finish = (all: Point[]) => {
    if (all.length < pen.least) return;
    clear();
    pen.done(all);
  };
  const add = (p: Point) => {
    const all = [...points, p];
    if (all.length >= pen.most) finish(all);
    else setPoints(all);
  };
  return {
    points, cursor, from, to,
    down(e: PointerEvent, p: Point) {
      setCursor(null);
      setFrom({ at: p, dragged: false });
      setTo(p);
      e.currentTarget.setPointerCapture(e.pointerId);
    },
    move(p: Point, k: number) {
      setTo(p);
      if (!from) return;
      const last = from.dragged && pen.freehand ? points[points.length - 1] ?? from.at : from.at;
      if (Math.hypot(p[0] - last[0], p[1] - last[1]) * k < 4) return;
      if (pen.freehand) setPoints(from.dragged ? [...points, p] : [...points, from.at, p]);
      if (!from.dragged) setFrom({ ...from, dragged: true });
    },
    up(p: Point) {
      if (!from) return;
      setFrom(null);
      if (!from.dragged && pen.freehand && pen.least === 1) finish([...points, p]); // a dab
      else if (!from.dragged) add(p);
      else if (pen.freehand) finish(points);
      else if (pen.most === 1) add(p);
      else if (!points.length) finish([from.at, p]);
      else add(p);
    },
    twice() { finish(points.filter((p, k) => k === 0 || Math.hypot(p[0] - points[k - 1][0], p[1] - points[k - 1][1]) > 0.5)); },
    key(e: KeyboardEvent, k: number) {
      const step = e.shiftKey ? 1 : Math.max(1, Math.round(8 / k));
      const arrows: Record<string, Point> = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
      const arrow = arrows[e.key];
      const here = cursor ?? [Math.round(width / 2), Math.round(height / 2)];
      if (arrow) {
        const next: Point = [Math.min(Math.max(here[0] + arrow[0], 0), width - 1), Math.min(Math.max(here[1] + arrow[1], 0), height - 1)];
        setCursor(cursor ? next : here);
        setTo(cursor ? next : here);
      } else if (e.key === ' ' && cursor) add([cursor[0] + 0.5, cursor[1] + 0.5]);
      else if (e.key === 'Enter') finish(points);
      else if (e.key === 'Backspace') setPoints(points.slice(0, -1));
      else if (e.key === 'Escape') points.length || from ? clear() : pen.leave();
      else return;
      e.preventDefault();
      e.stopPropagation();
    },
  };
}

// What is drawn so far.
export function Draft({ pen, state, k, width, height }: { pen: Pen; state: NonNullable<ReturnType<typeof usePen>>; k: number; width: number; height: number }) {
  const { points, from, to, cursor } = state;
  const open = to && (from?.dragged ? !pen.freehand : points.length > 0) ? [to] : [];
  const all = [...points, ...(from?.dragged && !pen.freehand && !points.length ? [from.at] : []), ...open];
  const text = all.map(p => p.join(',')).join(' ');
  const r = 4 / k;
  return (
    <svg className="draft" viewBox={`0 0 ${width} ${height}`} aria-hidden="true">
      {pen.shape === 'box' && all.length === 2 ? <rect x={Math.min(all[0][0], all[1][0])} y={Math.min(all[0][1], all[1][1])} width={Math.abs(all[0][0] - all[1][0])} height={Math.abs(all[0][1] - all[1][1])} />
        : pen.shape === 'area' && all.length > 2 ? <polygon points={text} /> : pen.shape !== 'points' || all.length > 1 ? <polyline points={text} style={pen.wide ? { strokeWidth: pen.wide, vectorEffect: 'none', strokeLinecap: 'round', strokeLinejoin: 'round', opacity: 0.5 } : undefined} /> : null}
      {(from?.dragged && pen.freehand ? [] : points).map(([x, y], i) => <circle key={i} cx={x} cy={y} r={r} />)}
      {cursor && <path d={`M${cursor[0] + 0.5 - 3 * r} ${cursor[1] + 0.5}h${6 * r}M${cursor[0] + 0.5} ${cursor[1] + 0.5 - 3 * r}v${6 * r}`} />}
    </svg>
  );
}
