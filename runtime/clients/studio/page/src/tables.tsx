import { useMemo, useState } from 'react';

import { numberText } from './format';
import { fetchJson, useLoaded } from './load';
import type { OutputValue } from './types';

interface Sheet { columns: string[]; rows: (string | number | null)[][] }

const isNumber = (x: unknown): x is number => typeof x === 'number' && Number.isFinite(x);

// Columns of numbers over the first column of numbers, or over the row's number.
function Plot({ data }: { data: Sheet }) {
  const numbers = data.columns.map((_, k) => k).filter(k => data.rows.some(r => isNumber(r[k])));
  const [x, setX] = useState(-1), [y, setY] = useState(numbers[numbers.length > 1 ? 1 : 0] ?? -1);
  if (!numbers.length) return <p className="none">The table has no numbers.</p>;
  const points = data.rows.map((r, k) => [x < 0 ? k + 1 : r[x], r[y]]).filter((p): p is [number, number] => isNumber(p[0]) && isNumber(p[1])).slice(0, 20000);
  const W = 420, H = 240, left = 62, bottom = 34;
  const range = (k: 0 | 1) => points.reduce(([lo, hi], p) => [Math.min(lo, p[k]), Math.max(hi, p[k])], [Infinity, -Infinity]);
  const [x0, x1] = range(0), [y0, y1] = range(1);
  const px = (v: number) => left + ((v - x0) / (x1 - x0 || 1)) * (W - left - 10), py = (v: number) => H - bottom - ((v - y0) / (y1 - y0 || 1)) * (H - bottom - 12);
  const name = (k: number) => (k < 0 ? 'row' : data.columns[k]);
  const line = points.length > 1 && points.every((p, k) => !k || p[0] >= points[k - 1][0]);
  return (
    <>
      <svg className="plot" viewBox={`0 0 ${W} ${H}`} role="img" aria-label={`${name(y)} over ${name(x)}, ${points.length} points`}>
        {points.length > 0 && [0, 0.5, 1].map(f => (
          <g key={f}><line x1={left} x2={W - 10} y1={py(y0 + f * (y1 - y0))} y2={py(y0 + f * (y1 - y0))} />
            <text x={left - 6} y={py(y0 + f * (y1 - y0)) + 3} textAnchor="end">{Number((y0 + f * (y1 - y0)).toPrecision(3))}</text>
            <text x={px(x0 + f * (x1 - x0))} y={H - bottom + 14} textAnchor={f === 1 ? 'end' : 'middle'}>{Number((x0 + f * (x1 - x0)).toPrecision(3))}</text></g>
        ))}
        {line && <polyline className="curve" points={points.map(p => `${px(p[0])},${py(p[1])}`).join(' ')} />}
        {(!line || points.length < 60) && points.map((p, k) => <circle key={k} cx={px(p[0])} cy={py(p[1])} r={points.length > 400 ? 1.2 : 2.2}><title>{`${numberText(p[0])}, ${numberText(p[1])}`}</title></circle>)}
        <text x={(left + W) / 2} y={H - 4} textAnchor="middle">{name(x)}</text>
        <text x={10} y={H / 2 - 10} textAnchor="middle" transform={`rotate(-90 10 ${H / 2 - 10})`}>{name(y)}</text>
      </svg>
      <div className="options">
        <label>Plot <select value={y} onChange={e => setY(Number(e.target.value))}>{numbers.map(k => <option key={k} value={k}>{name(k)}</option>)}</select></label>
        <label>over <select value={x} onChange={e => setX(Number(e.target.value))}>{[-1, ...numbers].map(k => <option key={k} value={k}>{name(k)}</option>)}</select></label>
      </div>
    </>
  );
}

export function TableView({ value }: { value: OutputValue }) {
  const { data, error } = useLoaded(value.hash, () => fetchJson<Sheet>(value.hash, 'json'));
  const [sort, setSort] = useState<{ column: number; down: boolean } | null>(null), [plot, setPlot] = useState(false), [chosen, setChosen] = useState(-1);
  const order = useMemo(() => {
    const all = data?.rows.map((_, k) => k) ?? [];
    if (!data || !sort) return all;
    const sign = sort.down ? -1 : 1;
    return all.sort((i, j) => {
      const x = data.rows[i][sort.column], y = data.rows[j][sort.column];
      return sign * (typeof x === 'number' && typeof y === 'number' ? x - y : String(x).localeCompare(String(y)));
    });
  }, [data, sort]);
  if (!data) return <p className="none">{error || 'Loading…'}</p>;
  const rows = order.slice(0, 1000);
  const step = (by: number) => setChosen(rows[Math.min(Math.max(rows.indexOf(chosen) + by, 0), rows.length - 1)]);
  return (
    <>
      {plot ? <Plot data={data} /> : (
        <div className="sheet" tabIndex={0} role="region" aria-label="Table" onKeyDown={e => {
          if (e.key === 'ArrowDown') step(1), e.preventDefault();
          if (e.key === 'ArrowUp') step(-1), e.preventDefault();
          if (e.key === 'Escape') setChosen(-1);
        }}>
          <table>
            <thead><tr>{data.columns.map((c, k) => (
              <th key={k} aria-sort={sort?.column === k ? (sort.down ? 'descending' : 'ascending') : 'none'}>
                <button onClick={() => setSort({ column: k, down: sort?.column === k && !sort.down })}>{c}{sort?.column === k && (sort.down ? ' ↓' : ' ↑')}</button></th>
            ))}</tr></thead>
            <tbody>{rows.map(i => (
              <tr key={i} className={i === chosen ? 'chosen' : ''} onClick={() => setChosen(i === chosen ? -1 : i)} ref={el => { if (i === chosen) el?.scrollIntoView({ block: 'nearest' }); }}>
                {data.rows[i].map((x, c) => <td key={c} className={typeof x === 'number' ? 'n' : ''}>{typeof x === 'number' ? numberText(x) : x}</td>)}</tr>
            ))}</tbody>
          </table>
        </div>
      )}
      <div className="options">
        <button aria-pressed={plot} onClick={() => setPlot(!plot)}>Plot</button>
        <span>{data.rows.length} rows{order.length > 1000 && ', the first 1,000 are shown'}{chosen >= 0 && !plot && `, row ${chosen + 1} is selected`}</span></div>
    </>
  );
}
