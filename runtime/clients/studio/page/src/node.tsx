import { Handle, Position, useConnection, useUpdateNodeInternals, type Node, type NodeProps } from '@xyflow/react';
import { memo, useEffect, useState } from 'react';
import { createPortal } from 'react-dom';

import { secondsText, typeColor } from './format';
import { inputsShown } from './layout';
import { hasThumbnail, Peek, Thumbnail } from './peek';
import { percentText } from './progress';
import { belongsTo, declarationOf, elementsOf, isBroken, shownDoc, stateOf, valueOf, worse } from './states';
import { enter, select, useStore } from './store';
import type { DocNode, NodeState, Port } from './types';

export type GraphNode = Node<{ node: DocNode }, 'node'>;

const words: Record<string, string> = {
  cached: 'cached', computed: 'done', stale: 'stale', waiting: 'queued', running: 'running', failed: 'failed',
  skipped: 'skipped', canceled: 'canceled', bypassed: 'bypassed',
};

function Socket({ port, node, side }: { port: Port; node: DocNode; side: 'in' | 'out' }) {
  const value = useStore(s => (side === 'out' ? valueOf(node, port.name, s.nodes) : undefined));
  const [over, setOver] = useState<DOMRect | null>(null);
  const color = typeColor(port.types[0]);
  const title = `${port.name}: ${port.types.join(' or ') || 'any'}${port.many ? ', list' : ''}${port.optional ? ', optional' : ''}\n${port.doc}`
;
  return (
    <div className={`socket ${side}`} title={value ? undefined : title} onPointerEnter={e => setOver(e.currentTarget.getBoundingClientRect())} onPointerLeave={() => setOver(null)} onPointerDown={() => setOver(null)}>
      <Handle type={side === 'in' ? 'target' : 'source'} id={port.name} position={side === 'in' ? Position.Left : Position.Right}
        className={`${port.many ? 'many ' : ''}${side === 'in' && port.optional && !node.inputs[port.name] ? 'open' : ''}`}
        style={{ '--type': color } as React.CSSProperties} />
      <span>{port.name}<span className="sr">, {side === 'in' ? 'input' : 'output'}, {port.types.join(' or ') || 'any type'}</span></span>
      {value && over && createPortal(<Peek value={value} at={over} />, document.body)}
    </div>
  );
}

// The state of a node together with its corrections.
function joined(node: DocNode, s: ReturnType<typeof useStore.getState>): NodeState | undefined {
  const all = [node, ...(node.parts ?? []).flatMap(p => shownDoc(s)?.nodes.find(n => n.name === p) ?? [])].map(n => stateOf(n, s.nodes)).filter(x => x !== undefined);
  return all.length ? all.reduce((a, b) => ({ ...worse(a, b), seconds: a.seconds + b.seconds, warnings: [...a.warnings, ...b.warnings] })) : undefined;
}
const countOf = (node: DocNode, s: ReturnType<typeof useStore.getState>) => {
  const list = node.parts?.length ? shownDoc(s)?.nodes.find(n => n.name === node.parts![0])?.params.edits?.value : [];
  return Array.isArray(list) ? list.length : list ? 1 : 0;
};

export const NodeCard = memo(function NodeCard({ data: { node }, selected }: NodeProps<GraphNode>) {
  const declaration = useStore(s => declarationOf(node, s.types));
  const state = useStore(s => joined(node, s), (a, b) => JSON.stringify(a) === JSON.stringify(b));
  const broken = useStore(s => [node.name, ...node.parts ?? []].some(n => isBroken(n, s)));
  const corrections = useStore(s => countOf(node, s));
  const why = useStore(s => (word => word ? word[0].toUpperCase() + word.slice(1) : '')(s.doc?.messages.find(m => m.severity === 'error' && belongsTo(m.node, node.name))?.message ?? state?.error?.message ?? ''));
  const connecting = useConnection(c => c.inProgress);
  const priced = useStore(s => s.price?.nodes.some(n => `${n.path}/`.startsWith(`${node.name}/`)));
  const small = useStore(s => {
    if (!s.thumbnails) return undefined;
    return declaration?.outputs.map(p => valueOf(node, p.name, s.nodes)).find(hasThumbnail);
  });
  const elements = useStore(s => (node.each ? elementsOf(node, s.nodes) : 0));
  const inputs = declaration?.inputs ?? [];
  const shown = selected ? inputs : inputsShown(node, inputs), hidden = inputs.filter(p => !shown.includes(p));
  // While a wire is drawn, the card under the pointer offers its other inputs below it.
  const [over, setOver] = useState(false), offers = connecting && over && hidden.length > 0, measure = useUpdateNodeInternals();
  useEffect(() => measure(node.name), [offers, measure, node.name]);
  const word = broken ? 'failed' : state?.state ?? 'stale';
  const time = state?.state === 'running' ? percentText(state)
    : state?.seconds ? secondsText(state.seconds) : '';
  const warnings = state?.warnings.length ?? 0;
  return (
    <div className={`card ${word}${selected ? ' selected' : ''}${priced ? ' priced' : ''}`} onPointerEnter={() => setOver(true)} onPointerLeave={() => setOver(false)}>
      <header>
        <i className="badge" role="img" aria-label={broken ? 'has errors' : words[word]} title={broken ? 'has errors' : words[word]} />
        <b>{node.name.split('/').pop()!.split('_').flatMap((part, k) => (k ? ['_', <wbr key={k} />, part] : [part]))}</b>
        {warnings > 0 && <span className="warn" title={state!.warnings.join('\n')}>{warnings} !</span>}
        <time>{time}</time>
        {corrections > 0 && <button className="link fixes nodrag nopan" title="Show them and their result" onClick={e => { e.stopPropagation(); select(node.parts![0]); }}>{corrections} {corrections === 1 ? 'correction' : 'corrections'}</button>}
      </header>
      <div className={`kind${why ? ' bad' : ''}`} title={why}>{why || <>{node.graph && <button className="link nodrag" title="Show what is inside (double click)" onClick={() => void enter(node.name)}>open</button>}{node.graph ? node.graph.split('/').pop() : node.type}{elements > 0 && ` × ${elements}`}{node.bypass && ', bypassed'}</>}</div>
      {small && <Thumbnail value={small} most={320} />}
      <div className={`bar${word === 'running' && state!.progress >= 0.995 ? ' endless' : ''}`}><div style={{ width: word === 'running' ? `${100 * (state?.progress ?? 0)}%` : 0 }} /></div>
      <div className="ports">
        <div>{shown.map(p => <Socket key={p.name} port={p} node={node} side="in" />)}
          {hidden.length > 0 && <small title={hidden.map(p => p.name).join(', ')}>{hidden.length} more</small>}</div>
        <div>{declaration?.outputs.map(p => <Socket key={p.name} port={p} node={node} side="out" />)}</div>
      </div>
      {offers && <div className="more">{hidden.map(p => <Socket key={p.name} port={p} node={node} side="in" />)}</div>}
    </div>
  );
});
