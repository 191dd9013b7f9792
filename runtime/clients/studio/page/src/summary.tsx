import { numberText } from './format';
import { fetchJson, useLoaded } from './load';
import type { OutputValue } from './types';

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

export function Summary({ value }: { value: OutputValue }) {
  const { data, error } = useLoaded(value.hash, () => fetchJson<unknown>(value.hash, 'summary'));
  if (data === null) return <p className="none">{error || 'Loading…'}</p>;
  return <div className="summary" tabIndex={0} role="region" aria-label="Summary"><Tree value={data} depth={0} /></div>;
}
