import { useState } from 'react';

import { numberText } from './format';
import { fetchJson, useLoaded, useNearest } from './load';
import type { Pen } from './pen';
import { fetchRaster, PanZoom, Picture, type Raster } from './raster';
import { Summary } from './summary';
import type { OutputValue } from './types';

export interface Profile { index: number; area: number; class: number; border: boolean; center: [number, number]; points: [number, number][]; color: number }
export interface Outlines { window: [number, number]; area_fraction: number; binder: number; profiles: Profile[] }

const hex = (c: number) => `rgb(${c & 255} ${(c >> 8) & 255} ${(c >> 16) & 255})`;

// Outlines over the picture that they were found in. `weights`: by profile, from 0 to 1.
export function OutlinesPane({ data, under, weights, chosen, choose, brush }: {
  data: Outlines; under: Raster | null; weights?: Map<number, number> | null; chosen: number; choose: (index: number) => void; brush?: (indices: number[]) => void;
}) {
  const [w, h] = data.window, width = under?.width ?? 600, scale = width / w, height = h * scale;
  const pen: Pen | null = brush ? {
    least: 2, most: 2, freehand: false, shape: 'box', leave: () => brush([]),
    done: ([[x0, y0], [x1, y1]]) => {
      const [l, r, t, b] = [Math.min(x0, x1), Math.max(x0, x1), Math.min(y0, y1), Math.max(y0, y1)];
      const small = r - l < 3 && b - t < 3; // a click
      brush(data.profiles.filter(p => {
        if (small) return inside(p.points.map(([x, y]) => [x * scale, height - y * scale]), [x0, y0]);
        const [x, y] = [p.center[0] * scale, height - p.center[1] * scale];
        return x >= l && x <= r && y >= t && y <= b;
      }).map(p => p.index));
    },
  } : null;
  return (
    <PanZoom width={width} height={Math.round(height)} pen={pen}>
      {under && Math.abs(under.height - height) < 2 ? <Picture raster={under} opacity={weights ? 0.4 : 1} /> : null}
      <svg className={weights ? 'weighted' : ''} width={width} height={height} role="img" aria-label={`${data.profiles.length} profiles`}>
        {!under && <rect width={width} height={height} fill={hex(data.binder)} />}
        {data.profiles.map(p => {
          const weight = weights?.get(p.index) ?? 0;
          return <polygon key={p.index} points={p.points.map(([x, y]) => `${x * scale},${height - y * scale}`).join(' ')} vectorEffect="non-scaling-stroke"
            className={weights ? (weight > 0.02 ? 'brushed' : 'other') : p.index === chosen ? 'chosen' : p.border ? 'border' : ''} style={weights ? { fillOpacity: 0.65 * weight } : undefined}
            fill={under || weights ? undefined : hex(p.color)} onPointerEnter={() => choose(p.index)} />;
        })}
      </svg>
    </PanZoom>
  );
}

function inside(points: [number, number][], [x, y]: [number, number]): boolean {
  let odd = false;
  for (let i = 0, j = points.length - 1; i < points.length; j = i++) {
    const [xi, yi] = points[i], [xj, yj] = points[j];
    if ((yi > y) !== (yj > y) && x < ((xj - xi) * (y - yi)) / (yj - yi) + xi) odd = !odd;
  }
  return odd;
}

export function useOutlines(value: OutputValue | undefined) {
  return useLoaded(String(value?.hash), async () => (value ? fetchJson<Outlines>(value.hash, 'outlines') : null));
}

export function ProfilesView({ value, node }: { value: OutputValue; node: string }) {
  const base = useNearest(node, 'Image');
  const [chosen, setChosen] = useState(-1);
  const { data, error } = useOutlines(value);
  const under = useLoaded(String(base?.value.hash), async () => (base ? fetchRaster(base.value.hash, 'pixels', 0) : null));
  if (!data) return <p className="none">{error || 'Loading…'}</p>;
  if (!(data.window[0] > 0) || !data.profiles.some(p => p.points.length)) return <Summary value={value} />;
  const at = data.profiles.find(p => p.index === chosen);
  return (
    <>
      <OutlinesPane data={data} under={under.data} chosen={chosen} choose={setChosen} />
      <div className="options"><span>{data.profiles.length} profiles, {numberText(100 * data.area_fraction)} % of the area</span>
        {at && <span>profile {at.index + 1}: {numberText(at.area)} mm², class {at.class}{at.border ? ', touches the border' : ''}</span>}</div>
    </>
  );
}
