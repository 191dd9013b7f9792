import { useState } from 'react';

import { declarationOf, shownDoc, splitWire } from './states';
import { edit, isLocked, select, useStore } from './store';
import type { DocNode, Port } from './types';

const kMostFree = 4;

// The wires that lead to a node, as lists: with the keyboard, and where wires are long, they are easier to change here than in the graph.
export function Inputs({ node, inputs }: { node: DocNode; inputs: Port[] }) {
  const doc = useStore(shownDoc), types = useStore(s => s.types), locked = useStore(isLocked);
  const [all, setAll] = useState(false);
  if (!doc) return null;
  // Many optional inputs without a wire would push the parameters out of view.
  const free = inputs.filter(p => p.optional && !node.inputs[p.name]), hidden = all || free.length <= kMostFree ? [] : free;
  const set = (name: string, wires: string[]) => void edit([{ op: 'connect', node: node.name, name, wires }]);
  // Nodes downstream would make a cycle.
  const after = new Set([node.name]);
  for (let grown = true; grown;) {
    grown = false;
    for (const n of doc.nodes)
      if (!after.has(n.name) && Object.values(n.inputs).flat().some(w => after.has(splitWire(w, doc, types).node))) after.add(n.name), grown = true;
  }
  const offered = (p: Port) => doc.nodes.filter(n => !after.has(n.name)).flatMap(n => (declarationOf(n, types)?.outputs ?? [])
    .filter(o => !p.types.length || p.types.includes(o.types[0])).map(o => `${n.name}.${o.name}`));
  const full = (w: string) => { const at = splitWire(w, doc, types); return `${at.node}.${at.port}`; };
  return (
    <>
      <h2>Inputs</h2>
      <fieldset className="fields" disabled={locked}>{inputs.filter(p => !hidden.includes(p)).map(p => {
        const wires = node.inputs[p.name] ?? [], id = `input-${p.name}`, choices = offered(p);
        const go = (w: string) => <button className="reset" title={`Select ${splitWire(w, doc, types).node}`} aria-label={`Select ${splitWire(w, doc, types).node}`} onClick={() => select(splitWire(w, doc, types).node)}>→</button>;
        if (p.many) return (
          <div key={p.name} className={`field${wires.length ? ' own' : ''}`}>
            <label htmlFor={id} title={`${p.name}: ${p.doc}`}>{p.name}</label>
            <span className="wires">
              {wires.map((w, k) => <span key={k}>{w}{go(w)}<button className="reset" title="Disconnect" aria-label={`Disconnect ${w}`} onClick={() => set(p.name, wires.filter((_, i) => i !== k))}>×</button></span>)}
              <select id={id} value="" onChange={e => set(p.name, [...wires, e.target.value])}><option value="">add…</option>{choices.map(c => <option key={c}>{c}</option>)}</select>
            </span><span />
          </div>
        );
        const now = wires[0] ? full(wires[0]) : '';
        return (
          <div key={p.name} className={`field${now ? ' own' : ''}`}>
            <label htmlFor={id} title={`${p.name}: ${p.doc}`}>{p.name}</label>
            <select id={id} value={now} onChange={e => set(p.name, e.target.value ? [e.target.value] : [])}>
              <option value="">{p.optional ? 'none (optional)' : 'not connected'}</option>{[...choices, ...(now && !choices.includes(now) ? [now] : [])].map(c => <option key={c}>{c}</option>)}
            </select>
            {wires[0] ? go(wires[0]) : <span />}
          </div>
        );
      })}</fieldset>
      {hidden.length > 0 && <button className="link" title={hidden.map(p => p.name).join(', ')} onClick={() => setAll(true)}>{hidden.length} more optional inputs</button>}
    </>
  );
}
