import { useEffect, useRef, useState } from 'react';

import { numberText } from './format';
import { fetchJson, useLoaded } from './load';
import type { OutputValue } from './types';

export interface Kernel { classes: number; averaging: string; residual: number; shapes: { probability: number; K: number[][]; profiles_per_caliper: number }[] }

// From background to foreground through one hue, so that order can be seen.
function heat(share: number): [number, number, number] {
  const s = Math.sqrt(share);
  return [24 + 225 * s ** 1.6, 26 + 190 * s, 34 + 120 * s * (1 - s) * 2 + 120 * s];
}

// The matrix of profile classes (rows) and particle classes (columns) as a heat map. The square root makes small values visible.
export function MatrixView({ value }: { value: OutputValue }) {
  const { data, error } = useLoaded(value.hash, () => fetchJson<Kernel>(value.hash, 'json'));
  const [shape, setShape] = useState(-1), [at, setAt] = useState<[number, number] | null>(null);
  const canvas = useRef<HTMLCanvasElement>(null);
  const n = data?.classes ?? 0;
  const value_at = (i: number, j: number) => (!data ? 0 : shape >= 0 ? data.shapes[shape].K[i][j] : data.shapes.reduce((s, e) => s + e.probability * e.K[i][j], 0));
  useEffect(() => {
    const c = canvas.current;
    if (!c || !data) return;
    c.width = c.height = n;
    const image = new ImageData(n, n);
    let most = 1e-300;
    for (let i = 0; i < n; ++i) for (let j = 0; j < n; ++j) most = Math.max(most, value_at(i, j));
    for (let i = 0; i < n; ++i)
      for (let j = 0; j < n; ++j) image.data.set([...heat(Math.max(value_at(i, j), 0) / most), 255], 4 * ((n - 1 - i) * n + j));
    c.getContext('2d')!.putImageData(image, 0, 0);
  });
  if (!data) return <p className="none">{error || 'Loading…'}</p>;
  return (
    <>
      <div className="matrix">
        <span className="y">profile’s size class</span>
        <canvas ref={canvas} role="img" aria-label={`K matrix with ${n} classes`} onPointerLeave={() => setAt(null)} onPointerMove={e => {
          const r = e.currentTarget.getBoundingClientRect();
          const k = (v: number) => Math.min(Math.max(Math.floor(v * n), 0), n - 1);
          setAt([n - 1 - k((e.clientY - r.top) / r.height), k((e.clientX - r.left) / r.width)]);
        }} />
        <span className="x">particle’s size class</span>
      </div>
      <div className="options">
        {data.shapes.length > 1 && <label>Shape <select value={shape} onChange={e => setShape(Number(e.target.value))}><option value={-1}>all, by number</option>
          {data.shapes.map((s, k) => <option key={k} value={k}>{k + 1} ({numberText(100 * s.probability)} %)</option>)}</select></label>}
        <span>{at ? `profiles of class ${at[0] + 1} from particles of class ${at[1] + 1}: ${numberText(value_at(...at))}` : `${n} classes, rows from the smallest at the bottom`}</span>
      </div>
    </>
  );
}
