import { useEffect, useRef, useState } from 'react';

import { isHex } from './color';
import { DropperButton } from './dropper';
import { steadily } from './store';
import type { Written } from './types';

export interface FieldSpec {
  name: string; kind: string; unit: string; doc: string; choices: string[]; keywords: string[]; min?: number; max?: number;
}

const lists = ['ints', 'numbers', 'texts'];
const textOf = (w: Written) => (Array.isArray(w) ? w.join(', ') : w);
// What a person typed, as the document's value. A list is written with commas.
function written(text: string, kind: string): Written {
  const t = text.trim();
  if (!lists.includes(kind) && !(kind === 'color' && t.includes(','))) return t;
  const items = t.replace(/^\[|\]$/g, '').split(',').map(x => x.trim());
  return items.length > 1 ? items : items[0];
}

type Send = (v: Written, merge: boolean) => Promise<unknown>;

export function useSender(send: Send) {
  const latest = useRef(send);
  latest.current = send;
  const [moving] = useState(() => steadily((v: Written) => latest.current(v, true)));
  return {
    move: (v: Written) => void moving.move(v),
    busy: moving.busy,
    set(v: Written) { moving.drop(); void latest.current(v, false); },
  };
}

// `price` receives the value that would be sent, and null once it was sent or dropped.
export function Field({ spec, value, send, price, files = [], found, from }: { spec: FieldSpec; value: Written; send: Send; price?: (v: Written | null) => void; files?: string[]; found?: string | null; from?: string }) {
  const [draft, setDraft] = useState<string | null>(null);
  const sender = useSender(send);
  const drag = useRef<{ x: number; start: number; step: number } | null>(null);
  const text = draft ?? textOf(value);
  useEffect(() => { if (!sender.busy()) setDraft(null); }, [value]); // else an earlier value arrives while the control moves
  const commit = () => {
    price?.(null);
    if (draft !== null && draft !== textOf(value)) sender.set(written(draft, spec.kind));
    else setDraft(null);
  };
  const id = `field-${spec.name}`;
  const number = (spec.kind === 'int' || spec.kind === 'number') && text.trim() !== '' && Number.isFinite(Number(text));
  const move = (v: number) => {
    const lo = spec.min ?? -Infinity, hi = spec.max ?? Infinity;
    const clamped = Math.min(Math.max(spec.kind === 'int' ? Math.round(v) : Number(v.toPrecision(6)), lo), hi);
    setDraft(String(clamped));
    price?.(String(clamped));
    sender.move(String(clamped));
  };
  const label = (
    <label htmlFor={id} className={number ? 'scrub' : ''} title={`${spec.doc}${number ? '\nDrag to change.' : ''}`}
      onPointerDown={e => {
        if (!number || e.button) return;
        const start = Number(text), range = Number.isFinite(spec.max ?? NaN) && Number.isFinite(spec.min ?? NaN) ? spec.max! - spec.min! : Infinity;
        const step = Math.max(Math.abs(start) / 100, spec.kind === 'int' ? 0.2 : 0, Math.min(range / 400, 0.01));
        drag.current = { x: e.clientX, start, step };
        e.currentTarget.setPointerCapture(e.pointerId);
      }}
      onPointerMove={e => { if (drag.current && Math.abs(e.clientX - drag.current.x) > 2) move(drag.current.start + (e.clientX - drag.current.x) * drag.current.step); }}
      onPointerUp={() => { drag.current = null; price?.(null); }}>
      {spec.name}{spec.unit && <small> {spec.unit}</small>}
      {from && <small className="from" title={`The value of the graph's parameter ${from}, which a change here changes`}> = {from}</small>}
    </label>
  );
  const isReference = text.includes('${');
  if (spec.kind === 'bool' && !isReference)
    return <>{label}<input id={id} type="checkbox" checked={text === 'true'} onChange={e => sender.set(String(e.target.checked))} /></>;
  if (spec.kind === 'choice' && !isReference)
    return (
      <>{label}<select id={id} value={text} onChange={e => sender.set(e.target.value)}>
        {[...spec.choices, ...spec.keywords, ...(spec.choices.concat(spec.keywords).includes(text) ? [] : [text])].map(c => <option key={c}>{c}</option>)}
      </select></>
    );
  const slider = number && spec.min !== undefined && spec.max !== undefined && spec.max - spec.min <= 1000;
  return (
    <>{label}
      <span className="control">
        <input id={id} value={text} list={spec.keywords.length || spec.choices.length || files.length ? `${id}-words` : undefined} spellCheck={false}
          onChange={e => { setDraft(e.target.value); if (e.target.value.trim()) price?.(written(e.target.value, spec.kind)); }} onBlur={commit}
          onKeyDown={e => { if (e.key === 'Enter') commit(); if (e.key === 'Escape') setDraft(null), price?.(null); }} />
        {spec.kind === 'color' && (isHex(text) || found) && <>
          <input type="color" className={isHex(text) ? '' : 'found'} value={isHex(text) ? text : found!} title={isHex(text) ? '' : `${text}: ${found} was found`} aria-label={isHex(text) ? `${spec.name}, color` : `${spec.name}, found ${found}`}
            onChange={e => { setDraft(e.target.value); sender.move(e.target.value); }} />
          <DropperButton title={`Take ${spec.name} from the picture`} take={c => sender.set(c)} /></>}
        {slider && <input type="range" aria-label={`${spec.name}, slider`} min={spec.min} max={spec.max} step={spec.kind === 'int' ? 1 : (spec.max! - spec.min!) / 200}
          value={Number(text)} onChange={e => move(Number(e.target.value))} onPointerUp={() => price?.(null)} onBlur={() => price?.(null)} />}
        {(spec.keywords.length > 0 || spec.choices.length > 0 || files.length > 0) && <datalist id={`${id}-words`}>{[...spec.keywords, ...spec.choices, ...files].map(k => <option key={k} value={k} />)}</datalist>}
      </span>
    </>
  );
}
