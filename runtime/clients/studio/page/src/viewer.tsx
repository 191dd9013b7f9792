import { useEffect, useRef, useState } from 'react';

import { followed, galleryPicture, imagesOf, mainNode } from './follow';
import { LabelsView } from './labels';
import { LinkedView } from './linked';
import { useNearest, useNode } from './load';
import { PlaneBar, PlaneView } from './plane';
import { percentText } from './progress';
import { belongsTo, declarationOf, failureOf, previewOf, shownDoc, stateOf, valueOf } from './states';
import { edit, goToLine, isLocked, post, sourceOf, uploadInput, useStore, type Target } from './store';
import { View } from './viewers';
import { Waiting } from './waiting';
import type { DocNode, OutputValue } from './types';

// Views of a node that show more than one of its outputs.
export const extrasOf = (node: DocNode, outputs: { types: string[] }[]): string[] => [
  ...(node.type === 'Section' ? ['plane'] : []),
  ...(outputs.some(p => ['Profiles', 'SizeDistribution', 'Particles'].includes(p.types[0])) ? ['linked'] : []),
];

// Nothing of the material is there yet.
function Empty() {
  const picture = useStore(s => galleryPicture(s.doc, s.start)), valid = useStore(s => s.doc?.valid), live = useStore(s => s.run.live), failed = useStore(s => !!failureOf(s));
  if (picture) return <Gallery picture={picture} />;
  if (!valid) return <p className="none">The graph has errors.</p>;
  return <p className="none">{failed ? 'Fix this error to see the material here.' : live ? 'The first picture of the material appears in a few seconds.' : 'Nothing has been computed yet. '}
    {!live && <button className="primary" onClick={() => void post('/api/live', { live: true })}>Compute the material</button>}</p>;
}

function Gallery({ picture }: { picture: string }) {
  return <figure className="gallery"><img src={picture} alt="" /><figcaption>The picture of the gallery, until it has been made here</figcaption></figure>;
}

function Stage({ node, value, kind, extra }: { node: DocNode | undefined; value: OutputValue | undefined; kind: string | undefined; extra: string }) {
  const labels = useNearest(node?.name ?? '', 'Labels');
  if (!node) return <Empty />;
  if (extra === 'plane') return <PlaneView key={node.name} node={node} />;
  if (extra === 'linked') return <LinkedView key={node.name} node={node} />;
  if ((value?.type ?? kind) === 'Labels') return <LabelsView value={value ?? labels?.value} node={node} />;
  if (value) return <View key={value.type} value={value} node={node} />;
  return <p className="none">{!kind ? 'This node writes files and has no outputs.' : 'There is no result yet.'}</p>;
}

// What is wrong with the node in view, or with the graph, and what to do about it.
function Trouble({ node }: { node: DocNode | undefined }) {
  const message = useStore(s => {
    const errors = s.doc?.messages.filter(m => m.severity === 'error') ?? [], own = node && errors.find(m => belongsTo(m.node, node.name));
    return own ?? (node && stateOf(node, s.nodes)?.error) ?? (s.selected || s.pinned ? undefined : errors[0] ?? failureOf(s));
  }, (a, b) => a?.message === b?.message && a?.node === b?.node);
  const types = useStore(s => s.types), file = useStore(s => shownDoc(s)?.file), locked = useStore(isLocked);
  if (!message) return null;
  const at = shownNode(message.node || node?.name || ''), path = at && (message.parameter || types.get(at.type)?.parameters.find(p => p.kind === 'path')?.name);
  return (
    <div className="trouble" role="alert">
      <p><b>{(message.node || node?.name || '').split('/').pop()}</b> {message.message}{message.hint && <em> {message.hint}</em>}</p>
      <p>{!locked && message.code === 'no-file' && path && <ChooseFile node={at} parameter={path} />}
        {message.line > 0 && message.file === file && <button className="link" onClick={() => goToLine(message.line)}>line {message.line}</button>}
        <button className="link" onClick={() => useStore.setState({ drawer: 'messages' })}>Messages</button></p>
    </div>
  );
}

const shownNode = (path: string) => shownDoc(useStore.getState())?.nodes.find(n => n.name === path);

// Uploads a file beside the graph, and reads that instead of one that is missing.
function ChooseFile({ node, parameter }: { node: DocNode; parameter: string }) {
  const input = useRef<HTMLInputElement>(null);
  const take = async (chosen: File) => {
    const name = await uploadInput(chosen), from = sourceOf(node.params[parameter]?.value ?? '', useStore.getState());
    if (name) await (from ? edit(from.edits(name), false, {}, from.scope) : edit([{ op: 'set', node: node.name, name: parameter, value: name }]));
  };
  return <><button className="primary" onClick={() => input.current?.click()}>Choose a file</button>
    <input ref={input} type="file" className="sr" tabIndex={-1} aria-label="File for the graph" onChange={e => { if (e.target.files?.[0]) void take(e.target.files[0]); }} /></>;
}

const none: Target[] = [];
// A palette shows itself in the inspector, and the viewer the material that it colors.
const seesNothing = (s: ReturnType<typeof useStore.getState>) => shownDoc(s)?.nodes.find(n => n.name === s.selected)?.type === 'Palette';

export function Viewer() {
  const types = useStore(s => s.types), nodes = useStore(s => s.nodes);
  const pinned = useStore(s => s.pinned), port = useStore(s => s.port), wide = useStore(s => s.wide);
  const selected = useStore(s => (seesNothing(s) ? null : s.selected));
  const auto = useStore(s => (s.pinned || (s.selected && !seesNothing(s)) ? null : followed(s)), (a, b) => a?.node === b?.node && a?.port === b?.port);
  const follows = useStore(s => !s.selected || seesNothing(s)); // otherwise a picture that a person works on would change its size
  const gallery = useStore(s => (auto && s.run.running && auto.node !== mainNode(s) ? galleryPicture(s.doc, s.start) : null));
  const dropper = useStore(s => s.dropper), sources = useStore(s => (s.dropper ? imagesOf(s) : none), (a, b) => JSON.stringify(a) === JSON.stringify(b));
  const [source, setSource] = useState<Target | null>(null);
  useEffect(() => setSource(null), [dropper]);
  useEffect(() => {
    const key = (e: KeyboardEvent) => { if (e.key === 'Escape') useStore.setState({ dropper: null }); };
    if (dropper) window.addEventListener('keydown', key);
    return () => window.removeEventListener('keydown', key);
  }, [dropper]);
  const drop = dropper ? source ?? sources[0] ?? null : null;
  const name = drop?.node ?? pinned?.node ?? selected ?? auto?.node, node = useNode(name);
  const reference = useStore(s => s.reference), locked = useStore(isLocked);
  const outputs = (node && declarationOf(node, types)?.outputs) ?? [], extras = node ? extrasOf(node, outputs) : [];
  const chosen = useStore(s => s.extra), extra = extras.includes(chosen) ? chosen : '';
  const shown = drop?.port ?? pinned?.port ?? (selected ? port : auto?.port) ?? outputs[0]?.name ?? '';
  const preview = node && previewOf(node, shown, nodes);
  const value = preview ?? (node && valueOf(node, shown, nodes));
  const state = node && stateOf(node, nodes);
  const old = value && !preview && state && !['cached', 'computed', 'bypassed'].includes(state.state);
  if (drop && node && value)
    return (
      <section className="viewer" aria-label="Viewer">
        <div className="tabs"><b>{dropper!.title}</b>
          <span className="ports">{sources.map(t => <button key={`${t.node}.${t.port}`} aria-pressed={t.node === drop.node && t.port === drop.port} onClick={() => setSource(t)}>{t.node}{t.port === 'image' ? '' : `.${t.port}`}</button>)}</span>
          <button onClick={() => useStore.setState({ dropper: null })}>Cancel</button></div>
        <div className="stage"><View key={value.hash} value={value} node={node} /></div>
      </section>
    );
  return (
    <section className={`viewer${extra ? ' tall' : ''}`} aria-label="Viewer">
      <div className="tabs">
        <b>{name?.split('/').pop() ?? 'Viewer'}</b>
        <span className="ports">
          {outputs.map(p => <button key={p.name} aria-pressed={!extra && p.name === shown} title={p.doc} onClick={() => useStore.setState({ extra: '', selected: name ?? null, ...(pinned ? { pinned: { node: pinned.node, port: p.name } } : { port: p.name }) })}>{p.name}</button>)}
          {extras.map(x => <button key={x} aria-pressed={extra === x} title={x === 'plane' ? 'Drag the plane through the block' : 'Profiles, size classes and particles together'} onClick={() => useStore.setState({ selected: name ?? null, extra: extra === x ? '' : x })}>{x === 'plane' ? 'Plane in 3D' : 'Linked'}</button>)}
        </span>
        {preview && <span className="old">preview{state?.state === 'running' ? `, ${percentText(state)}` : ''}</span>}
        {old && <span className="old">{state.state}: earlier result</span>}
        {(reference || (value && !preview)) && <button aria-pressed={!!reference} title={reference ? `Stop comparing with ${reference.label}` : 'Keep this result, and compare later ones with it'}
          onClick={() => useStore.setState({ reference: reference ? null : { label: `${name}.${shown}`, value } })}>{reference ? 'Comparing' : 'Hold'}</button>}
        {node && <button aria-pressed={!!pinned} title={pinned ? 'Follow the selection' : 'Keep showing this node'}
          onClick={() => useStore.setState({ pinned: pinned ? null : { node: node.name, port: shown } })}>{pinned ? 'Pinned' : 'Pin'}</button>}
        <button aria-pressed={wide} title="Give the result most of the window" onClick={() => useStore.setState({ wide: !wide })}>Wide</button>
      </div>
      <Trouble node={node} />
      <div className={`stage${old ? ' stale' : ''}`}>
        {gallery ? <Gallery picture={gallery} /> : <Stage node={node} value={value} kind={outputs.find(p => p.name === shown)?.types[0]} extra={extra} />}
        {node?.type === 'Section' && !locked && !extra && <PlaneBar key={node.name} node={node} />}
        {follows && <Waiting />}
      </div>
    </section>
  );
}
