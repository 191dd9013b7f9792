import { useEffect, useState } from 'react';

import { bytesText, numberText } from './format';
import { fetchJson, useLoaded } from './load';
import { fetchRaster, Picture } from './raster';
import type { OutputValue } from './types';

// A small picture of a value, for cards.
export function Thumbnail({ value, most, as = 'pixels' }: { value: OutputValue; most: number; as?: string }) {
  const { data } = useLoaded(`${value.hash}.${most}`, () => fetchRaster(value.hash, as, 0, most));
  return <div className="thumb">{data && <Picture raster={data} />}</div>;
}

export const hasThumbnail = (v: OutputValue | undefined): boolean => !!v && ['Image', 'Labels'].includes(v.type);

const line = (v: unknown): string => (typeof v === 'number' ? numberText(v) : typeof v === 'string' ? v : Array.isArray(v) ? (v.every(x => typeof x === 'number') && v.length < 5 ? v.map(x => numberText(x as number)).join(', ') : `${v.length} entries`)
  : v && typeof v === 'object' && 'of' in v ? `${String((v as { of: number }).of)} entries` : '…');

// What is in a value, in a few lines.
export function Facts({ value }: { value: OutputValue }) {
  const { data } = useLoaded(value.hash, () => fetchJson<Record<string, unknown>>(value.hash, 'summary'));
  return data && <dl>{Object.entries(data).slice(0, 7).map(([k, v]) => <div key={k}><dt>{k.replace(/_/g, ' ')}</dt><dd>{line(v)}</dd></div>)}</dl>;
}

// What is at a socket, shown while the pointer rests on it.
export function Peek({ value, at }: { value: OutputValue; at: DOMRect }) {
  const [ready, setReady] = useState(false);
  useEffect(() => {
    const timer = window.setTimeout(() => setReady(true), 250);
    return () => window.clearTimeout(timer);
  }, []);
  if (!ready) return null;
  return (
    <div className="peek" style={{ left: Math.min(at.right + 10, window.innerWidth - 230), top: Math.min(at.top - 8, window.innerHeight - 220) }} role="tooltip">
      <b>{value.type}</b> <span>{bytesText(value.bytes)}</span>
      {hasThumbnail(value) ? <Thumbnail value={value} most={320} /> : <Facts value={value} />}
    </div>
  );
}
