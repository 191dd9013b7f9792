import { LabelsView } from './labels';
import { LinkedView } from './linked';
import { useNearest, useNode } from './load';
import { PlaneBar, PlaneView } from './plane';
import { declarationOf, previewOf, stateOf, useStore, valueOf } from './store';
import { View } from './viewers';
import type { DocNode, OutputValue } from './types';

// Views of a node that show more than one of its outputs.
export const extrasOf = (node: DocNode, outputs: { types: string[] }[]): string[] => [
  ...(node.type === 'Section' ? ['plane'] : []),
  ...(outputs.some(p => ['Profiles', 'SizeDistribution', 'Particles'].includes(p.types[0])) ? ['linked'] : []),
];

function Stage({ node, value, kind, extra }: { node: DocNode | undefined; value: OutputValue | undefined; kind: string | undefined; extra: string }) {
  const labels = useNearest(node?.name ?? '', 'Labels');
  if (!node) return <p className="none">Select a node to see its result.</p>;
  if (extra === 'plane') return <PlaneView key={node.name} node={node} />;
  if (extra === 'linked') return <LinkedView key={node.name} node={node} />;
  if ((value?.type ?? kind) === 'Labels') return <LabelsView value={value ?? labels?.value} node={node} />;
  if (value) return <View key={value.type} value={value} node={node} />;
  return <p className="none">{!kind ? 'This node writes files and has no outputs.' : 'There is no result yet.'}</p>;
}

export function Viewer() {
  const types = useStore(s => s.types), nodes = useStore(s => s.nodes);
  const pinned = useStore(s => s.pinned), selected = useStore(s => s.selected), port = useStore(s => s.port), wide = useStore(s => s.wide);
  const name = pinned?.node ?? selected, node = useNode(name);
  const reference = useStore(s => s.reference);
  const outputs = (node && declarationOf(node, types)?.outputs) ?? [], extras = node ? extrasOf(node, outputs) : [];
  const chosen = useStore(s => s.extra), extra = extras.includes(chosen) ? chosen : '';
  const shown = pinned?.port ?? port ?? outputs[0]?.name ?? '';
  const preview = node && previewOf(node, shown, nodes);
  const value = preview ?? (node && valueOf(node, shown, nodes));
  const state = node && stateOf(node, nodes);
  const old = value && !preview && state && !['cached', 'computed', 'bypassed'].includes(state.state);
  return (
    <section className={`viewer${extra ? ' tall' : ''}`} aria-label="Viewer">
      <div className="tabs">
        <b>{name?.split('/').pop() ?? 'Viewer'}</b>
        <span className="ports">
          {outputs.map(p => <button key={p.name} aria-pressed={!extra && p.name === shown} title={p.doc} onClick={() => useStore.setState({ extra: '', ...(pinned ? { pinned: { node: pinned.node, port: p.name } } : { port: p.name }) })}>{p.name}</button>)}
          {extras.map(x => <button key={x} aria-pressed={extra === x} title={x === 'plane' ? 'Drag the plane through the block' : 'Profiles, size classes and particles together'} onClick={() => useStore.setState({ extra: extra === x ? '' : x })}>{x === 'plane' ? 'Plane in 3D' : 'Linked'}</button>)}
        </span>
        {preview && <span className="old">preview{state?.state === 'running' ? `, ${Math.round(100 * state.progress)} %` : ''}</span>}
        {old && <span className="old">{state.state}: earlier result</span>}
        {(reference || (value && !preview)) && <button aria-pressed={!!reference} title={reference ? `Stop comparing with ${reference.label}` : 'Keep this result, and compare later ones with it'}
          onClick={() => useStore.setState({ reference: reference ? null : { label: `${name}.${shown}`, value } })}>{reference ? 'Comparing' : 'Hold'}</button>}
        {node && <button aria-pressed={!!pinned} title={pinned ? 'Follow the selection' : 'Keep showing this node'}
          onClick={() => useStore.setState({ pinned: pinned ? null : { node: node.name, port: shown } })}>{pinned ? 'Pinned' : 'Pin'}</button>}
        <button aria-pressed={wide} title="Give the result most of the window" onClick={() => useStore.setState({ wide: !wide })}>Wide</button>
      </div>
      <div className={`stage${old ? ' stale' : ''}`}>
        <Stage node={node} value={value} kind={outputs.find(p => p.name === shown)?.types[0]} extra={extra} />
        {node?.type === 'Section' && !node.name.includes('/') && !extra && <PlaneBar key={node.name} node={node} />}
      </div>
    </section>
  );
}
