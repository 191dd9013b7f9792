import { useEffect, useMemo, useState } from 'react';

import { numberText } from './format';
import { LabelsView } from './labels';
import { fetchRaster, isPreview, PanZoom, Picture, urlOf, type Raster } from './raster';
import { nearest, previewOf, useStore } from './store';
import type { DocNode, OutputValue } from './types';

// Loads something for a value; keeps what was shown before until the new value is there, so that nothing flickers.
export function useLoaded<T>(key: string, load: () => Promise<T>): { data: T | null; error: string } {
  const [state, setState] = useState<{ data: T | null; error: string }>({ data: null, error: '' });
  useEffect(() => {
    let current = true;
    // A preview that cannot be loaded has given way to a newer one, or to the result.
    load().then(data => current && setState({ data, error: '' }), e => current && !isPreview(key) && setState({ data: null, error: String(e.message ?? e) }));
    return () => { current = false; };
    // eslint-disable-next-line react-hooks/exhaustive-deps
  }, [key]);
  return state;
}

export async function fetchJson<T>(hash: string, as: string): Promise<T> {
  const answer = await fetch(`${urlOf(hash)}?as=${as}`);
  if (answer.status === 204) throw new Error('there is a newer preview');
  const body = await answer.json();
  if (!answer.ok) throw new Error(body.message);
  return body as T;
}

export function Sections({ count, section, set }: { count: number; section: number; set: (s: number) => void }) {
  if (count < 2) return null;
  return <label>Section <input type="number" min={1} max={count} value={section + 1} onChange={e => set(Math.min(Math.max(Number(e.target.value) - 1, 0), count - 1))} /> of {count}</label>;
}

function srgb(r: Raster, x: number, y: number): string {
  const at = 4 * (y * r.width + x), d = new Uint8Array(r.data, at, 3);
  return `${d[0]} ${d[1]} ${d[2]}  #${[...d].map(v => v.toString(16).padStart(2, '0')).join('')}`;
}

function ImageView({ value }: { value: OutputValue }) {
  const [section, setSection] = useState(0);
  const { data, error } = useLoaded(`${value.hash}.${section}`, () => fetchRaster(value.hash, 'pixels', section));
  if (!data) return <p className="none">{error || 'Loading…'}</p>;
  const factor = data.fullWidth / data.width;
  return (
    <>
      <PanZoom width={data.width} height={data.height} smooth={isPreview(value.hash)} hover={(x, y) => `${Math.round(x * factor)}, ${Math.round(y * factor)}   sRGB ${srgb(data, x, y)}`}>
        <Picture raster={data} />
      </PanZoom>
      <div className="options"><Sections count={data.sections} section={section} set={setSection} />
        {factor > 1 && <span>reduced from {data.fullWidth} × {data.fullHeight}</span>}</div>
    </>
  );
}

// Labels or outlines over the picture that they were found in.
export function useBase(node: string) {
  const doc = useStore(s => s.doc), types = useStore(s => s.types), nodes = useStore(s => s.nodes);
  return useMemo(() => nearest(node, 'Image', 'up', { doc, types, nodes }), [node, doc, types, nodes]);
}

interface Outlines { window: [number, number]; area_fraction: number; binder: number; profiles: { index: number; area: number; class: number; border: boolean; center: [number, number]; points: [number, number][]; color: number }[] }

function ProfilesView({ value, node }: { value: OutputValue; node: string }) {
  const base = useBase(node);
  const [chosen, setChosen] = useState(-1);
  const { data, error } = useLoaded(value.hash, () => fetchJson<Outlines>(value.hash, 'outlines'));
  const under = useLoaded(String(base?.value.hash), async () => (base ? fetchRaster(base.value.hash, 'pixels', 0) : null));
  if (!data) return <p className="none">{error || 'Loading…'}</p>;
  const [w, h] = data.window;
  if (!(w > 0) || !data.profiles.some(p => p.points.length)) return <Summary value={value} />;
  const width = under.data?.width ?? 600, scale = width / w, height = h * scale;
  const hex = (c: number) => `rgb(${c & 255} ${(c >> 8) & 255} ${(c >> 16) & 255})`;
  const at = data.profiles.find(p => p.index === chosen);
  return (
    <>
      <PanZoom width={width} height={Math.round(height)}>
        {under.data && Math.abs(under.data.height - height) < 2 ? <Picture raster={under.data} /> : null}
        <svg width={width} height={height} role="img" aria-label={`${data.profiles.length} profiles`}>
          {!under.data && <rect width={width} height={height} fill={hex(data.binder)} />}
          {data.profiles.map(p => (
            <polygon key={p.index} points={p.points.map(([x, y]) => `${x * scale},${height - y * scale}`).join(' ')} vectorEffect="non-scaling-stroke"
              className={p.index === chosen ? 'chosen' : p.border ? 'border' : ''} fill={under.data ? undefined : hex(p.color)} onPointerEnter={() => setChosen(p.index)} />
          ))}
        </svg>
      </PanZoom>
      <div className="options"><span>{data.profiles.length} profiles, {numberText(100 * data.area_fraction)} % of the area</span>
        {at && <span>profile {at.index + 1}: {numberText(at.area)} mm², class {at.class}{at.border ? ', touches the border' : ''}</span>}</div>
    </>
  );
}

function TableView({ value }: { value: OutputValue }) {
  const { data, error } = useLoaded(value.hash, () => fetchJson<{ columns: string[]; rows: (string | number | null)[][] }>(value.hash, 'json'));
  const [sort, setSort] = useState<{ column: number; down: boolean } | null>(null);
  const rows = useMemo(() => {
    if (!data || !sort) return data?.rows ?? [];
    const sign = sort.down ? -1 : 1;
    return [...data.rows].sort((a, b) => {
      const x = a[sort.column], y = b[sort.column];
      return sign * (typeof x === 'number' && typeof y === 'number' ? x - y : String(x).localeCompare(String(y)));
    });
  }, [data, sort]);
  if (!data) return <p className="none">{error || 'Loading…'}</p>;
  return (
    <>
      <div className="sheet" tabIndex={0} role="region" aria-label="Table">
        <table>
          <thead><tr>{data.columns.map((c, k) => (
            <th key={k} aria-sort={sort?.column === k ? (sort.down ? 'descending' : 'ascending') : 'none'}>
              <button onClick={() => setSort({ column: k, down: sort?.column === k && !sort.down })}>{c}{sort?.column === k && (sort.down ? ' ↓' : ' ↑')}</button></th>
          ))}</tr></thead>
          <tbody>{rows.slice(0, 1000).map((r, k) => <tr key={k}>{r.map((x, c) => <td key={c} className={typeof x === 'number' ? 'n' : ''}>{typeof x === 'number' ? numberText(x) : x}</td>)}</tr>)}</tbody>
        </table>
      </div>
      <div className="options"><span>{data.rows.length} rows{rows.length > 1000 && ', the first 1,000 are shown'}</span></div>
    </>
  );
}

interface Distribution { class_edges: number[]; shapes: { N_V: number[]; low: number[]; high: number[] }[]; volume_fraction: number; d_max: number }

function DistributionView({ value }: { value: OutputValue }) {
  const { data, error } = useLoaded(value.hash, () => fetchJson<Distribution>(value.hash, 'json'));
  if (!data) return <p className="none">{error || 'Loading…'}</p>;
  const n = data.class_edges.length - 1;
  const sum = (k: 'N_V' | 'low' | 'high') => Array.from({ length: n }, (_, i) => data.shapes.reduce((s, e) => s + (e[k][i] ?? 0), 0));
  const mean = sum('N_V'), low = sum('low'), high = sum('high');
  const top = Math.max(...high, ...mean, 1e-300), W = 420, H = 220, left = 58, bottom = 34;
  const x0 = data.class_edges[0], x1 = data.class_edges[n];
  const x = (d: number) => left + ((d - x0) / (x1 - x0)) * (W - left - 8), y = (v: number) => H - bottom - (v / top) * (H - bottom - 12);
  return (
    <>
      <svg className="plot" viewBox={`0 0 ${W} ${H}`} role="img" aria-label={`Size distribution with ${n} classes up to ${numberText(x1)} mm`}>
        {[0, 0.5, 1].map(f => <g key={f}><line x1={left} x2={W - 8} y1={y(f * top)} y2={y(f * top)} /><text x={left - 6} y={y(f * top) + 3} textAnchor="end">{Number((f * top).toPrecision(2))}</text></g>)}
        {mean.map((v, i) => {
          const a = x(data.class_edges[i]), b = x(data.class_edges[i + 1]), m = (a + b) / 2;
          return (
            <g key={i}><title>{`${numberText(data.class_edges[i])} to ${numberText(data.class_edges[i + 1])} mm: ${numberText(v)} per mm³ (${numberText(low[i])} to ${numberText(high[i])})`}</title>
              <rect x={a + 0.5} width={Math.max(b - a - 1, 0.5)} y={y(v)} height={Math.max(H - bottom - y(v), 0)} />
              {high[i] > low[i] && <path d={`M${m} ${y(low[i])}V${y(high[i])}M${m - 3} ${y(high[i])}h6M${m - 3} ${y(low[i])}h6`} />}</g>
          );
        })}
        {[x0, (x0 + x1) / 2, x1].map(d => <text key={d} x={x(d)} y={H - bottom + 14} textAnchor={d === x1 ? 'end' : 'middle'}>{Number(d.toPrecision(3))}</text>)}
        <text x={(left + W) / 2} y={H - 4} textAnchor="middle">size, mm</text>
        <text x={10} y={H / 2 - 10} textAnchor="middle" transform={`rotate(-90 10 ${H / 2 - 10})`}>particles per mm³</text>
      </svg>
      <div className="options"><span>{numberText(100 * data.volume_fraction)} % of the volume, largest {numberText(data.d_max)} mm; bars show 90 % intervals</span></div>
    </>
  );
}

function Tree({ value, depth }: { value: unknown; depth: number }) {
  if (typeof value === 'number') return <>{numberText(value)}</>;
  if (value === null || typeof value !== 'object') return <>{String(value)}</>;
  if (Array.isArray(value)) {
    if (value.every(v => typeof v !== 'object')) return <>{value.slice(0, 12).map(v => (typeof v === 'number' ? numberText(v) : String(v))).join(', ')}{value.length > 12 && ` … (${value.length} values)`}</>;
    return <details><summary>{value.length} entries</summary><ol>{value.slice(0, 50).map((v, k) => <li key={k}><Tree value={v} depth={depth + 1} /></li>)}</ol></details>;
  }
  const o = value as Record<string, unknown>;
  if (Array.isArray(o.shown) && typeof o.of === 'number') return <details><summary>{o.of.toLocaleString('en-US')} entries, the first {o.shown.length} are shown</summary><ol>{o.shown.slice(0, 50).map((v, k) => <li key={k}><Tree value={v} depth={depth + 1} /></li>)}</ol></details>;
  return <dl className={depth ? 'inner' : ''}>{Object.entries(o).map(([k, v]) => <div key={k}><dt>{k.replace(/_/g, ' ')}</dt><dd><Tree value={v} depth={depth + 1} /></dd></div>)}</dl>;
}

function Summary({ value }: { value: OutputValue }) {
  const { data, error } = useLoaded(value.hash, () => fetchJson<unknown>(value.hash, 'summary'));
  if (data === null) return <p className="none">{error || 'Loading…'}</p>;
  return <div className="summary" tabIndex={0} role="region" aria-label="Summary"><Tree value={data} depth={0} /></div>;
}

// A value without a viewer of its own: a picture that was made of it downstream, and a summary.
function OtherView({ value, node }: { value: OutputValue; node: string }) {
  const doc = useStore(s => s.doc), types = useStore(s => s.types), nodes = useStore(s => s.nodes);
  const picture = useMemo(() => (['Volume', 'Shapes', 'Particles'].includes(value.type) ? nearest(node, 'Image', 'down', { doc, types, nodes }) : null), [value, node, doc, types, nodes]);
  const from = doc?.nodes.find(n => n.name === picture?.target.node);
  return (
    <div className="both">
      {picture && <figure><ImageView value={(from && previewOf(from, picture.target.port, nodes)) ?? picture.value} /><figcaption>{picture.target.node}.{picture.target.port}, made from this value</figcaption></figure>}
      <Summary value={value} />
    </div>
  );
}

export function View({ value, node }: { value: OutputValue; node: DocNode }) {
  switch (value.type) {
    case 'Image': return <ImageView value={value} />;
    case 'Labels': return <LabelsView value={value} node={node} />;
    case 'Profiles': return <ProfilesView value={value} node={node.name} />;
    case 'Table': return <TableView value={value} />;
    case 'SizeDistribution': return <DistributionView value={value} />;
    default: return <OtherView value={value} node={node.name} />;
  }
}
