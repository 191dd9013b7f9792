import { useState, type KeyboardEvent } from 'react';

import { colorsIn, isHex } from './color';
import { DropperButton } from './dropper';
import { useSender } from './fields';
import { makePalette, profilesOf, useFoundColors } from './found';
import { shownDoc } from './states';
import { edit, isLocked, useStore, type Edit } from './store';
import type { DocNode, NodeType, Parameter } from './types';

export const isPalette = (items: string[]) => items.length > 0 && items.every(isHex);

const percent = (share: number) => `${share < 0.0995 ? (100 * share).toPrecision(1) : Math.round(100 * share)} %`;

// The node's other lists with one entry per color, such as shares: they change with the colors.
function besides(node: DocNode, declaration: NodeType, spec: Parameter, count: number): { name: string; values: string[] }[] {
  return declaration.parameters.filter(p => p.name !== spec.name && ['numbers', 'ints'].includes(p.kind))
    .map(p => ({ name: p.name, value: node.params[p.name]?.value }))
    .filter(p => Array.isArray(p.value) && p.value.length === count && count > 1).map(p => ({ name: p.name, values: p.value as string[] }));
}

// The colors of a list as swatches: each can be changed, taken from the picture, weighted, moved and removed.
export function PaletteEditor({ node, declaration, spec, items }: { node: DocNode; declaration: NodeType; spec: Parameter; items: string[] }) {
  const [added, setAdded] = useState(''), [held, setHeld] = useState<number | null>(null);
  const lists = besides(node, declaration, spec, items.length), weighted = declaration.parameters.some(p => p.name === 'shares');
  const shares = lists.find(l => l.name === 'shares')?.values ?? items.map(() => '1');
  const numbers = shares.map(Number), total = numbers.reduce((a, b) => a + b, 0);
  const sender = useSender((colors, merge) => edit([{ op: 'set', node: node.name, name: spec.name, value: colors }], merge));
  const [draft, setDraft] = useState<string[] | null>(null);
  const now = draft && sender.busy() ? draft : items;
  // Does the same to all lists: the entries of `order`, where −1 stands for a new one.
  const arrange = (order: number[], fresh: string[] = []) => {
    let next = 0;
    const colors = order.map(k => (k < 0 ? fresh[next++] : items[k]));
    const edits: Edit[] = [{ op: 'set', node: node.name, name: spec.name, value: colors }];
    for (const l of lists) edits.push({ op: 'set', node: node.name, name: l.name, value: order.map(k => (k < 0 ? l.values[items.length - 1] : l.values[k])) });
    void edit(edits);
  };
  const all = items.map((_, k) => k);
  const move = (from: number, to: number) => {
    if (to < 0 || to >= items.length || to === from) return;
    const order = all.filter(k => k !== from);
    order.splice(to, 0, from);
    arrange(order);
  };
  const change = (k: number, color: string, moving = false) => {
    const colors = items.map((c, i) => (i === k ? color : c));
    if (!moving) return sender.set(colors);
    setDraft(colors), sender.move(colors);
  };
  const add = (text: string) => {
    const colors = colorsIn(text);
    if (!colors.length) return useStore.setState({ trouble: { message: `'${text}' is no color`, hint: 'write colors such as #b0785a, separated by spaces or commas', code: 'bad-value' } });
    setAdded('');
    arrange([...all, ...colors.map(() => -1)], colors);
  };
  const keys = (e: KeyboardEvent, k: number) => {
    const by = { ArrowUp: -1, ArrowDown: 1 }[e.key];
    if (by) move(k, k + by), e.preventDefault();
  };
  return (
    <div className="palette">
      <h2 title={spec.doc}>{spec.name}, {items.length} <button className="link" title="Copy all colors as text" onClick={() => void navigator.clipboard?.writeText(items.join(' '))}>copy</button></h2>
      <div className="strip" aria-hidden="true">{now.map((c, k) => <i key={k} style={{ background: c, flexGrow: numbers[k] / total }} />)}</div>
      <ol>{now.map((color, k) => (
        <li key={k} className={held === k ? 'held' : ''} onDragOver={e => { if (held !== null) e.preventDefault(); }} onDrop={e => { e.preventDefault(); if (held !== null) move(held, k); setHeld(null); }}>
          <button className="grip" draggable title="Drag, or press the arrow keys, to move" aria-label={`Move color ${k + 1}`} onKeyDown={e => keys(e, k)}
            onDragStart={e => { e.dataTransfer.setData('text/plain', color); setHeld(k); }} onDragEnd={() => setHeld(null)}>⠿</button>
          <input type="color" value={color} aria-label={`Color ${k + 1}`} onChange={e => change(k, e.target.value, true)} />
          <input className="hex" defaultValue={color} key={color} aria-label={`Color ${k + 1} as text`} spellCheck={false} onBlur={e => { const [c] = colorsIn(e.target.value); if (c && c !== color) change(k, c); else e.target.value = color; }}
            onKeyDown={e => { if (e.key === 'Enter') e.currentTarget.blur(); }} />
          <DropperButton title={`Take color ${k + 1} from the picture`} take={c => change(k, c)} />
          {weighted && <><input className="weight" defaultValue={shares[k]} key={shares[k]} inputMode="decimal" aria-label={`Weight of color ${k + 1}`} title="Relative frequency" onKeyDown={e => { if (e.key === 'Enter') e.currentTarget.blur(); }}
            onBlur={e => { if (Number(e.target.value) > 0 && e.target.value !== shares[k]) void edit([{ op: 'set', node: node.name, name: 'shares', value: shares.map((s, i) => (i === k ? e.target.value : s)) }]); else e.target.value = shares[k]; }} />
            <span className="n">{percent(numbers[k] / total)}</span></>}
          <button className="reset" disabled={items.length < 2} title="Remove" aria-label={`Remove color ${k + 1}`} onClick={() => arrange(all.filter(i => i !== k))}>×</button>
        </li>
      ))}</ol>
      <p className="row"><input value={added} placeholder="Add colors: type or paste #rrggbb …" aria-label={`Add to ${spec.name}`} spellCheck={false} onChange={e => setAdded(e.target.value)}
        onKeyDown={e => { if (e.key === 'Enter' && added.trim()) add(added); }} />
        <DropperButton title="Add a color from the picture" take={add} /></p>
    </div>
  );
}

// The node whose colors a person means who asks for those of the material: the only one of its kind.
export const colorizeOf = (s: ReturnType<typeof useStore.getState>): DocNode | undefined => {
  const all = shownDoc(s)?.nodes.filter(n => n.type === 'Colorize') ?? [];
  return all.length === 1 ? all[0] : undefined;
};

// What was found where no colors are given.
export function FoundColors({ node }: { node: DocNode }) {
  const profiles = useStore(s => profilesOf(node, s), (a, b) => a?.hash === b?.hash), found = useFoundColors(profiles), locked = useStore(isLocked);
  const colorize = useStore(s => (node.type === 'Colorize' ? node : colorizeOf(s))), taken = useStore(s => !!colorize && !!profilesOf(colorize, s));
  if (!profiles || !found?.colors.length) return null;
  return (
    <div className="palette found">
      <h2>Colors found in the photograph</h2>
      <ul>{found.colors.map(c => <li key={c.color} title={`${c.color}, ${percent(c.share)} of the particles' area`}><i style={{ background: c.color }} /><code>{c.color}</code><span>{percent(c.share)}</span></li>)}
        <li title={`${found.binder}, the binder`}><i style={{ background: found.binder }} /><code>{found.binder}</code><span>binder</span></li></ul>
      {colorize && taken && !locked && <p className="row"><button className="primary" title="Puts a Palette with these colors in place of the photograph's" onClick={() => void makePalette(colorize, found)}>Edit these colors</button></p>}
    </div>
  );
}
