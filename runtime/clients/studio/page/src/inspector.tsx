import { useEffect, useState } from 'react';

import { hexOfLinear } from './color';
import { Field } from './fields';
import { bytesText, numberText, secondsText } from './format';
import { readerOf, useFoundColor } from './found';
import { Inputs } from './inputs';
import { MenuButton, openMenu } from './menu';
import { colorizeOf, FoundColors, isPalette, PaletteEditor } from './palette';
import { percentText } from './progress';
import { declarationOf, shownDoc, stateOf, valueOf } from './states';
import { askPrice, bypass, edit, change, fullName, goToLine, isLocked, localName, post, priceText, sourceOf, useStore } from './store';
import type { Doc, DocNode, Parameter, Written } from './types';

function defaultText(p: Parameter): Written {
  const v = p.default;
  if (v === undefined || v === null) return '';
  if (Array.isArray(v)) {
    if (p.kind === 'color' && v.length === 3) return hexOfLinear(v as number[]);
    return v.map(String);
  }
  return String(v);
}

const escaped = (text: string) => text.replace(/[.*+?^${}()|[\]\\]/g, '\\$&');

function Name({ node }: { node: DocNode }) {
  const now = node.name.split('/').pop()!, [name, setName] = useState(now);
  useEffect(() => setName(now), [now]);
  const commit = () => {
    if (name === now) return;
    void edit([{ op: 'rename', node: node.name, to: name }]).then(done => done ? setTimeout(() => useStore.setState({ selected: fullName(name) }), 50) : setName(now));
  };
  return <input className="name" value={name} aria-label="Name of the node" spellCheck={false} onChange={e => setName(e.target.value)} onBlur={commit}
    onKeyDown={e => { if (e.key === 'Enter') commit(); if (e.key === 'Escape') setName(now); }} />;
}

function State({ node }: { node: DocNode }) {
  const file = useStore(s => s.doc?.file ?? ''), valid = useStore(s => s.doc?.valid);
  const state = useStore(s => stateOf(node, s.nodes), (a, b) => JSON.stringify(a) === JSON.stringify(b));
  if (!state) return null;
  const metrics = Object.entries(state.metrics), passed = Object.entries(node.inner ?? {});
  return (
    <div className="state">
      <p><span><b>{state.state === 'waiting' ? 'queued' : state.state}</b>
        {state.state === 'running' && ` ${percentText(state)}${state.note ? `, ${state.note}` : ''}`}
        {state.seconds > 0 && state.state !== 'running' && `, ${secondsText(state.seconds)}`}
        {(state.state === 'stale' || state.state === 'waiting') && state.expected > 0 && `, about ${secondsText(state.expected)}`}</span>
        {state.state === 'running'
          ? <button onClick={() => void post('/api/cancel', { node: node.name })}>Cancel</button>
          : !['cached', 'computed', 'bypassed'].includes(state.state) && !node.graph && <button onClick={() => void post('/api/run', { targets: [node.name] })}>Run to here</button>}
      </p>
      {node.bypass && <p>{passed.length ? <>It does not run. Its readers read {passed.map(([port, at], k) => <span key={port}>{k > 0 && ', '}<b>{at!.path}.{at!.port}</b> for {port}</span>)}.</>
        : valid ? 'It does not run, and none of its connected inputs has the type of an output.' : 'It does not run. The graph has errors.'}</p>}
      {state.error && <p className="bad">{state.error.message}{state.error.hint && <em> {state.error.hint}</em>}
        {state.error.line > 0 && <button className="link" onClick={() => goToLine(state.error!.line)}>line {state.error.line}</button>}</p>}
      {state.warnings.map(w => <p key={w} className="warning">{w}</p>)}
      {state.reasons.length > 0 && <details open={state.reasons.length < 4}><summary>Why it ran</summary><ul>{state.reasons.map(r => <li key={r} title={r}>{r.replace(new RegExp(`${escaped(file)}:(\\d+)(:\\d+)?`, 'g'), 'line $1')}</li>)}</ul></details>}
      {metrics.length > 0 && <details open={metrics.length < 5}><summary>{metrics.length === 1 ? '1 measure' : `${metrics.length} measures`}</summary>
        <dl>{metrics.map(([k, v]) => <div key={k}><dt>{k.replace(/_/g, ' ')}</dt><dd>{numberText(v)}</dd></div>)}</dl></details>}
      {state.files.length > 0 && <p>Wrote {state.files.join(', ')}</p>}
    </div>
  );
}

function Outputs({ node }: { node: DocNode }) {
  const declaration = useStore(s => declarationOf(node, s.types));
  const nodes = useStore(s => s.nodes);
  return (
    <dl>{declaration?.outputs.map(p => {
      const v = valueOf(node, p.name, nodes);
      return <div key={p.name}><dt title={p.doc}>{p.name}</dt><dd>{p.types[0]}{v && `, ${bytesText(v.bytes)}`}</dd></div>;
    })}</dl>
  );
}

// A list of texts, such as colors or edits. Other changes of items are made in the YAML text.
function Items({ node, spec, items }: { node: DocNode; spec: Parameter; items: string[] }) {
  const [added, setAdded] = useState('');
  const add = () => {
    if (!added.trim()) return;
    void edit([{ op: 'append', node: node.name, name: spec.name, value: added.trim() }]);
    setAdded('');
  };
  return (
    <>
      <h2 title={spec.doc}>{spec.name}{spec.unit && `, ${spec.unit}`}</h2>
      <ol className="items">{items.map((text, k) => (
        <li key={k}>{/^#[0-9a-f]{6}$/i.test(text) && <i className="swatch" style={{ background: text }} />}<span>{text}</span>
          <button className="reset" title="Remove" aria-label={`Remove ${text}`}
            onClick={() => void edit([{ op: 'remove_item', node: node.name, name: spec.name, index: k }])}>×</button></li>
      ))}</ol>
      <input value={added} placeholder="Add, then Enter" aria-label={`Add to ${spec.name}`} spellCheck={false}
        onChange={e => setAdded(e.target.value)} onKeyDown={e => { if (e.key === 'Enter') add(); }} />
    </>
  );
}

// Files below the graph's folder, for parameters that name one.
function useFiles(wanted: boolean): string[] {
  const [files, setFiles] = useState<string[]>([]);
  const doc = useStore(s => s.doc?.file);
  useEffect(() => {
    if (wanted) void fetch('/api/files').then(a => a.json()).then((l: { files: string[] }) => setFiles(l.files)).catch(() => {});
  }, [wanted, doc]);
  return files;
}

function PriceLine() {
  const price = useStore(s => s.price);
  return price && <em className="price">{priceText(price)}</em>;
}

// Fields of colors show what was found where they say auto, and fields that read a parameter of the graph show and change that.
function NodeField({ node, ...field }: { node: DocNode } & Parameters<typeof Field>[0]) {
  const doc = useStore(s => s.doc), inside = useStore(s => s.inside), scope = useStore(s => s.scope);
  const found = useFoundColor(field.spec.kind === 'color' ? node : undefined, field.spec.name), from = sourceOf(field.value, { doc, inside, scope });
  if (!from) return <Field {...field} found={found} />;
  return <Field {...field} found={found} from={from.name} value={from.value} send={(value, merge) => edit(from.edits(value), merge, {}, from.scope)}
    price={value => void askPrice(value === null ? null : from.edits(value), from.scope)} />;
}

// What else can be done with a parameter of a node.
function FieldMenu({ node, spec, value }: { node: DocNode; spec: Parameter; value: Written }) {
  const doc = useStore(s => s.doc), inside = useStore(s => s.inside), scope = useStore(s => s.scope), from = sourceOf(value, { doc, inside, scope });
  const vary = () => useStore.setState({ drawer: 'variants', vary: from && !scope ? from.name : `${localName(node.name, scope)}.${spec.name}` });
  return <MenuButton label={`More for ${spec.name}`} items={[
    { label: 'Show variants', act: vary },
    from ? { label: 'Give it a value of its own', act: () => void edit([{ op: 'set', node: node.name, name: spec.name, value: from.value }]) }
      : { label: `Make it a parameter of the ${scope ? 'sub' : ''}graph`, act: () => void change('/api/promote', { node: node.name.split('/').pop(), name: spec.name }) },
  ]} />;
}

function GraphField({ doc, ...field }: { doc: Doc } & Parameters<typeof Field>[0]) {
  const reader = field.spec.kind === 'color' ? readerOf(doc, field.spec.name) : undefined;
  return <Field {...field} found={useFoundColor(reader?.node, reader?.parameter ?? '')} />;
}

function NodeInspector({ node }: { node: DocNode }) {
  const declaration = useStore(s => declarationOf(node, s.types));
  const locked = useStore(isLocked);
  const files = useFiles(!!declaration?.parameters.some(p => p.kind === 'path'));
  const colored = declaration?.parameters.some(p => { // its editor has the shares
    const items = node.params[p.name]?.value ?? defaultText(p);
    return p.kind === 'texts' && Array.isArray(items) && isPalette(items);
  });
  return (
    <>
      <div className="title">{locked ? <b className="name">{node.name.split('/').pop()}</b> : <Name node={node} />}<span>{node.type || node.graph}</span>
        {locked ? <em>line {node.line}</em> : <>{!node.graph && <button aria-pressed={node.bypass} title="Bypass the node: its readers get its input of the same type (Ctrl+B)" onClick={() => bypass([node.name])}>Bypass</button>}<button className="link" onClick={() => goToLine(node.line)}>line {node.line}</button></>}</div>
      {declaration && <p className="doc">{declaration.doc}</p>}
      <State node={node} />
      <FoundColors node={node} />
      {!!declaration?.inputs.length && <Inputs key={node.name} node={node} inputs={declaration.inputs} />}
      {!!declaration?.parameters.length && <h2>Parameters <PriceLine /></h2>}
      {locked && <p className="doc">This node belongs to a file outside the folder of the graph. Copy the subgraph into the graph to change it.</p>}
      <fieldset className="fields" disabled={locked}>
        {declaration?.parameters.filter(p => p.name !== 'shares' || !colored).map(p => {
          const own = node.params[p.name];
          const items = own ? own.value : defaultText(p);
          if (p.kind === 'texts' && Array.isArray(items) && isPalette(items)) return <PaletteEditor key={`${node.name}.${p.name}`} node={node} declaration={declaration} spec={p} items={items} />;
          if (p.kind === 'texts' && Array.isArray(own?.value)) return <Items key={`${node.name}.${p.name}`} node={node} spec={p} items={own.value} />;
          return (
            <div key={`${node.name}.${p.name}`} className={`field${own ? ' own' : ''}`} onContextMenu={openMenu}>
              <NodeField node={node} spec={p} value={items}
                send={(value, merge) => edit([{ op: 'set', node: node.name, name: p.name, value }], merge)} files={p.kind === 'path' ? files : undefined}
                price={value => void askPrice(value === null ? null : [{ op: 'set', node: node.name, name: p.name, value }])} />
              {own && !p.required ? <button className="reset" title="Use the default" aria-label={`Reset ${p.name} to its default`}
                onClick={() => void edit([{ op: 'reset', node: node.name, name: p.name }])}>×</button> : <span />}
              {!locked && <FieldMenu node={node} spec={p} value={items} />}
            </div>
          );
        })}
      </fieldset>
      {!!declaration?.outputs.length && <h2>Outputs</h2>}
      <Outputs node={node} />
    </>
  );
}

function GraphInspector() {
  const doc = useStore(shownDoc)!, scope = useStore(s => s.scope), locked = useStore(isLocked), colorize = useStore(colorizeOf);
  const files = useFiles(doc.parameters.some(p => p.kind === 'path'));
  return (
    <>
      <div className="title"><b>{doc.name || 'Graph'}</b></div>
      {doc.doc && <p className="doc">{doc.doc}</p>}
      <p className="doc">{scope ? (locked ? 'The file is outside the folder of the graph, and is not changed here.' : 'Changes are saved to the file at once. Undo takes them back.') : 'The viewer shows the material. Select a node to see its parameters and its result.'}</p>
      {colorize && <FoundColors node={colorize} />}
      {doc.parameters.length > 0 && <h2>{scope ? 'Defaults of its parameters' : 'Parameters of the graph'} <PriceLine /></h2>}
      <fieldset className="fields" disabled={locked}>
        {doc.parameters.map(p => (
          <div key={p.name} className="field own" onContextMenu={openMenu}>
            <GraphField doc={doc} spec={p} value={p.value} send={(value, merge) => edit([{ op: 'set_default', name: p.name, value }], merge)} files={p.kind === 'path' ? files : undefined}
              price={value => void askPrice(value === null ? null : [{ op: 'set_default', name: p.name, value }])} /><span />
            {!scope && <MenuButton label={`More for ${p.name}`} items={[{ label: 'Show variants', act: () => useStore.setState({ drawer: 'variants', vary: p.name }) }]} />}
          </div>
        ))}
      </fieldset>
    </>
  );
}

export function Inspector() {
  const node = useStore(s => shownDoc(s)?.nodes.find(n => n.name === s.selected));
  const doc = useStore(s => s.doc);
  return (
    <section className="inspector" aria-label="Inspector" tabIndex={0}>
      {node ? <NodeInspector key={node.name} node={node} /> : doc && <GraphInspector />}
    </section>
  );
}
