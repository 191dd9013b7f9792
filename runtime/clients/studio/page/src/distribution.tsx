import { numberText } from './format';
import { fetchJson, useLoaded, useReference } from './load';
import type { DocNode, OutputValue } from './types';

export interface Distribution { class_edges: number[]; shapes: { N_V: number[]; low: number[]; high: number[] }[]; volume_fraction: number; d_max: number }

export const densities = (d: Distribution, k: 'N_V' | 'low' | 'high' = 'N_V') =>
  Array.from({ length: d.class_edges.length - 1 }, (_, i) => d.shapes.reduce((s, e) => s + (e[k][i] ?? 0), 0));

// Bars with their intervals. `weights`: the share of each bar that is brushed. `before`: another distribution, as a line.
export function DistributionPlot({ data, weights, choose, before }: { data: Distribution; weights?: number[] | null; choose?: (c: number, more: boolean) => void; before?: Distribution | null }) {
  const n = data.class_edges.length - 1, mean = densities(data), low = densities(data, 'low'), high = densities(data, 'high'), old = before ? densities(before) : [];
  const top = Math.max(...high, ...mean, ...old, 1e-300), W = 420, H = 220, left = 58, bottom = 34;
  const x0 = data.class_edges[0], x1 = data.class_edges[n];
  const x = (d: number) => left + ((d - x0) / (x1 - x0)) * (W - left - 8), y = (v: number) => H - bottom - (v / top) * (H - bottom - 12);
  return (
    <svg className="plot" viewBox={`0 0 ${W} ${H}`} role="img" aria-label={`Size distribution with ${n} classes up to ${numberText(x1)} mm`}>
      {[0, 0.5, 1].map(f => <g key={f}><line x1={left} x2={W - 8} y1={y(f * top)} y2={y(f * top)} /><text x={left - 6} y={y(f * top) + 3} textAnchor="end">{Number((f * top).toPrecision(2))}</text></g>)}
      {mean.map((v, i) => {
        const a = x(data.class_edges[i]), b = x(data.class_edges[i + 1]), m = (a + b) / 2, w = Math.max(b - a - 1, 0.5);
        return (
          <g key={i} onClick={e => choose?.(i, e.shiftKey)} className={choose ? 'pick' : ''}><title>{`${numberText(data.class_edges[i])} to ${numberText(data.class_edges[i + 1])} mm: ${numberText(v)} per mm³ (${numberText(low[i])} to ${numberText(high[i])})`}</title>
            {choose && <rect className="hit" x={a} width={b - a} y={12} height={H - bottom - 12} />}
            <rect x={a + 0.5} width={w} y={y(v)} height={Math.max(H - bottom - y(v), 0)} className={weights ? 'other' : ''} />
            {weights && weights[i] > 0 && <rect x={a + 0.5} width={w} y={y(v * weights[i])} height={Math.max(H - bottom - y(v * weights[i]), 0)} />}
            {high[i] > low[i] && <path d={`M${m} ${y(low[i])}V${y(high[i])}M${m - 3} ${y(high[i])}h6M${m - 3} ${y(low[i])}h6`} />}</g>
        );
      })}
      {before && <polyline className="before" points={old.flatMap((v, i) => [`${x(before.class_edges[i])},${y(v)}`, `${x(before.class_edges[i + 1])},${y(v)}`]).join(' ')} />}
      {[x0, (x0 + x1) / 2, x1].map(d => <text key={d} x={x(d)} y={H - bottom + 14} textAnchor={d === x1 ? 'end' : 'middle'}>{Number(d.toPrecision(3))}</text>)}
      <text x={(left + W) / 2} y={H - 4} textAnchor="middle">size, mm</text>
      <text x={10} y={H / 2 - 10} textAnchor="middle" transform={`rotate(-90 10 ${H / 2 - 10})`}>particles per mm³</text>
    </svg>
  );
}

export function useDistribution(value: OutputValue | null | undefined) {
  return useLoaded(String(value?.hash), async () => (value ? fetchJson<Distribution>(value.hash, 'json') : null));
}

export function DistributionView({ value, node }: { value: OutputValue; node: DocNode }) {
  const { data, error } = useDistribution(value);
  const reference = useReference(node, value), before = useDistribution(reference).data;
  if (!data) return <p className="none">{error || 'Loading…'}</p>;
  return (
    <>
      <DistributionPlot data={data} before={reference ? before : null} />
      <div className="options"><span>{numberText(100 * data.volume_fraction)} % of the volume, largest {numberText(data.d_max)} mm; bars show 90 % intervals{reference && before ? '; the line is before' : ''}</span></div>
    </>
  );
}
