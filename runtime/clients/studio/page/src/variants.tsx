// The result in view for several values of a parameter, side by side. A click keeps one.
import { useState, type KeyboardEvent } from 'react';

import { shownTarget } from './follow';
import { secondsText } from './format';
import { Facts, hasThumbnail, Thumbnail } from './peek';
import { declarationOf, placeOf, shownDoc, splitWire } from './states';
import { isLocked, localName, post, useStore } from './store';
import type { Doc, NodeType, OutputValue, Variant, Variants, Written } from './types';

interface Choice { target: string; group: string; spec: { kind: string; choices: string[]; min?: number; max?: number; min_open?: boolean }; value: Written }

const textOf = (v: unknown): Written => (Array.isArray(v) ? v.map(String) : v === undefined || v === null ? '' : String(v));

// The nodes of the document that a node's result comes from, itself first, then the nearest.
function sources(name: string, doc: Doc, types: Map<string, NodeType>): string[] {
  const found = [name];
  for (const at of found)
    for (const wire of Object.values(doc.nodes.find(n => n.name === at)?.inputs ?? {}).flat()) {
      const { node } = splitWire(wire, doc, types);
      if (!found.includes(node)) found.push(node);
    }
  return found;
}

// Parameters that can change the shown result: of the graph, and of the nodes that it comes from. Those of a subgraph get their values
// from its users.
function choicesOf(doc: Doc, types: Map<string, NodeType>, shown: string, scope: string): Choice[] {
  const out: Choice[] = scope ? [] : doc.parameters.map(p => ({ target: p.name, group: 'Graph', spec: p, value: p.value }));
  for (const name of sources(shown, doc, types)) {
    const node = doc.nodes.find(n => n.name === name);
    for (const p of (node && !node.bypass && declarationOf(node, types)?.parameters) || [])
      out.push({ target: `${localName(name, scope)}.${p.name}`, group: localName(name, scope), spec: p, value: node!.params[p.name]?.value ?? textOf(p.default) });
  }
  return out;
}

// Values around the present one, for a start.
export function suggested({ spec, value, target }: Choice, doc: Doc): string {
  const reference = /^\$\{(\w+)\}$/.exec(String(value))?.[1];
  const now = reference ? doc.parameters.find(p => p.name === reference)?.value ?? value : value;
  if (spec.kind === 'bool') return 'false, true';
  if (spec.kind === 'choice') return spec.choices.join(', ');
  if (Array.isArray(now)) return `[${now.join(', ')}]`;
  const number = Number(now);
  if (!['int', 'number'].includes(spec.kind) || now === '' || !Number.isFinite(number)) return now;
  const lo = spec.min ?? -Infinity, hi = spec.max ?? Infinity, whole = spec.kind === 'int';
  const near = /seed$/.test(target) ? [0, 1, 2, 3, 4, 5].map(k => number + k)
    : number === 0 ? (Number.isFinite(hi) ? [0, 0.25, 0.5, 0.75, 1].map(k => Math.max(lo, 0) + k * (hi - Math.max(lo, 0))) : [0, 1, 2, 4])
    : [0.5, 0.7, 1, 1.4, 2].map(k => number * k);
  const all = near.map(v => Math.min(Math.max(whole ? Math.round(v) : Number(v.toPrecision(2)), lo), hi)).filter(v => !(spec.min_open && v === lo));
  return [...new Set(all)].join(', ');
}

const words = (v: Written) => (Array.isArray(v) ? v.join(',') : v).replace(/[[\]\s"']/g, '');

function Sketch({ value, shapes, most }: { value: OutputValue; shapes?: OutputValue; most: number }) {
  if (hasThumbnail(value)) return <Thumbnail value={value} most={most} />;
  if (['Shapes', 'Volume'].includes(value.type) || shapes) return <Thumbnail value={value} most={most} as={`picture&shapes=${shapes?.hash ?? ''}`} />;
  return <div className="blank"><Facts value={value} /></div>;
}

const stateText = (t: Variant): string =>
  t.state === 'running' ? `${t.doing.split('/').pop() || 'starts'}${t.progress > 0 ? ` ${Math.floor(100 * t.progress)} %` : '…'}`
    : t.state === 'done' ? secondsText(t.seconds) || 'cached' : t.state === 'waiting' ? 'queued' : t.state;

function Tile({ tile, index, target, kept, size }: { tile: Variant; index: number; target: string; kept: boolean; size: number }) {
  const value = tile.output ?? (tile.preview && { type: tile.preview.type, hash: `preview/${tile.preview.number}`, bytes: 0 });
  const failed = tile.state === 'failed';
  return (
    <li>
      <button aria-pressed={kept} disabled={failed} onClick={() => void post('/api/variants/keep', { tile: index })}
        aria-label={`${target} ${tile.value}, ${failed ? `failed: ${tile.error}` : stateText(tile)}`} title={failed ? tile.error : kept ? 'This is the value now' : `Keep ${tile.value}; Undo returns`}>
        {failed ? <span className="blank bad">{tile.error}</span> : value ? <Sketch value={value} shapes={tile.shapes} most={size} /> : <span className="blank" />}
        <span className="says"><b>{tile.value}</b><em>{kept ? 'kept' : stateText(tile)}</em></span>
        {tile.state === 'running' && <span className="share"><i style={{ width: `${100 * tile.progress}%` }} /></span>}
      </button>
    </li>
  );
}

// Arrow keys move between tiles.
function walk(e: KeyboardEvent<HTMLUListElement>) {
  const all = [...e.currentTarget.querySelectorAll('button')], at = all.indexOf(document.activeElement as HTMLButtonElement);
  const columns = all.filter(b => b.getBoundingClientRect().top === all[0].getBoundingClientRect().top).length;
  const step = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: columns, ArrowUp: -columns }[e.key];
  if (at < 0 || !step) return;
  e.preventDefault();
  all[at + step]?.focus();
}

const left = (v: Variants): string => {
  const done = v.tiles.filter(t => t.state === 'done'), rest = v.tiles.filter(t => t.state !== 'done' && t.state !== 'failed').length;
  const seconds = done.length ? (rest * done.reduce((s, t) => s + t.seconds, 0)) / done.length : 0;
  return seconds >= 1 ? `, about ${secondsText(seconds)} left` : '';
};

export function VariantsPanel() {
  const root = useStore(s => s.doc), doc = useStore(shownDoc), scope = useStore(s => s.scope), locked = useStore(isLocked), types = useStore(s => s.types), variants = useStore(s => s.variants);
  const shown = useStore(shownTarget, (a, b) => a?.node === b?.node && a?.port === b?.port);
  const place = useStore(s => { // of what the viewer shows
    const node = shown && shownDoc(s)?.nodes.find(n => n.name === shown.node);
    return node && shown!.port ? placeOf(node, shown!.port, s.nodes) ?? null : null;
  }, (a, b) => a?.path === b?.path && a?.port === b?.port);
  const chosen = useStore(s => s.vary), target = chosen || (variants?.target ?? '');
  const [typed, setTyped] = useState({ target: variants?.target ?? '', values: variants?.values ?? '' }), [size, setSize] = useState(170);
  if (!root || !doc) return null;
  const name = shown?.node ?? '', choices = locked ? [] : choicesOf(doc, types, scope ? name : name.split('/')[0], scope), groups = [...new Set(choices.map(c => c.group))];
  const seed = choices.find(c => /(^|\.)seed$/.test(c.target)) ?? choices[0];
  const choice = choices.find(c => c.target === target) ?? seed, list = (typed.target === choice?.target && typed.values) || (choice ? suggested(choice, doc) : '');
  const known = variants?.scope === scope && choices.find(c => c.target === variants.target);
  const finished = variants?.tiles.filter(t => t.state === 'done' || t.state === 'failed').length ?? 0;
  return (
    <section className="drawer variants" aria-label="Variants" style={{ '--tile': `${size}px` } as React.CSSProperties}>
      <form onSubmit={e => { e.preventDefault(); if (place && choice) void post('/api/variants', { target: choice.target, values: list, node: place.path, port: place.port, scope }); }}>
        <label>Vary <select value={choice?.target ?? ''} onChange={e => useStore.setState({ vary: e.target.value })}>
          {groups.map(g => <optgroup key={g} label={g}>{choices.filter(c => c.group === g).map(c => <option key={c.target} value={c.target}>{c.target}</option>)}</optgroup>)}</select></label>
        <label>Values <input value={list} size={26} spellCheck={false} title="A list such as 1, 2, 3, or a range such as 0.2:0.5:0.1" onChange={e => setTyped({ target: choice?.target ?? '', values: e.target.value })} /></label>
        {variants?.running ? <button type="button" onClick={() => void post('/api/variants/cancel')}>Cancel variants</button>
          : <button className="primary" disabled={!place || !choice || !list.trim() || !root.valid}>Show variants</button>}
        <em role="status">{variants ? `${variants.node}.${variants.port}: ${finished} of ${variants.tiles.length}${variants.running ? left(variants) : ''}` : locked ? 'This file is not changed here' : place ? `of ${place.path}.${place.port}` : 'Show a result first'}</em>
        {variants && !root.varied && <em className="warning">of an earlier graph</em>}
        <span className="space" /><label>Size <input type="range" min={110} max={420} step={10} value={size} onChange={e => setSize(Number(e.target.value))} /></label>
      </form>
      {variants ? (
        <ul className="tiles" aria-label={`Variants of ${variants.target}`} onKeyDown={walk}>
          {variants.tiles.map((t, k) => <Tile key={k} tile={t} index={k} target={variants.target} size={size > 240 ? 1024 : 512} kept={!!known && root.varied && words(known.value) === words(t.value)} />)}
        </ul>
      ) : <p className="none">Choose a parameter and values. Each value shows the result in view; a click on one keeps it.</p>}
    </section>
  );
}
