// The nodes that write files, as one card.
import { Handle, Position, type Node, type NodeProps } from '@xyflow/react';
import { memo } from 'react';

import { declarationOf, isBroken, shownDoc, stateOf, useStore } from './store';
import type { Doc, DocNode, NodeType, StateWord } from './types';

export const filesCard = 'files '; // no node has this name
export type FilesNode = Node<{ node: DocNode }, 'files'>;

const kFew = 2; // which are not folded

export const writersOf = (doc: Doc, types: Map<string, NodeType>): DocNode[] => {
  const all = doc.nodes.filter(n => { const d = declarationOf(n, types); return d?.writes_files && !d.outputs.length; });
  return all.length > kFew ? all : [];
};

// The graph, with one card instead of the nodes that write files.
export function fold(doc: Doc, types: Map<string, NodeType>): Doc {
  const writers = writersOf(doc, types), names = new Set(writers.map(n => n.name));
  if (!writers.length) return doc;
  const wires = [...new Set(writers.flatMap(n => Object.values(n.inputs).flat()))];
  const declaration: NodeType = {
    type: filesCard, district: '', version: 0, doc: '', source: '', writes_files: true, parameters: [], outputs: [],
    inputs: [{ name: 'files', types: [], doc: '', optional: false, many: true }],
  };
  const card: DocNode = { name: filesCard, type: '', graph: '', doc: writers.map(n => n.name).join('\n'), line: 0, bypass: false, params: {}, inputs: { files: wires }, declaration };
  return { ...doc, nodes: [...doc.nodes.filter(n => !names.has(n.name)), card] };
}

// Shows the outputs of a graph one by one, or with "" as one card. The button for the way back takes the focus.
let asked = false;
export function unfold(file: string) {
  asked = true;
  useStore.setState({ unfolded: file });
}
export function takeFocus(button: HTMLButtonElement | null) {
  if (!button || !asked) return;
  asked = false;
  button.focus({ preventScroll: true });
}

// From the best to the worst.
const ranks: StateWord[] = ['cached', 'computed', 'bypassed', 'stale', 'canceled', 'skipped', 'waiting', 'running', 'failed'];

export const FilesCard = memo(function FilesCard({ data: { node } }: NodeProps<FilesNode>) {
  const names = node.doc.split('\n');
  const word = useStore(s => names.reduce((worst: StateWord, name) => {
    const own = shownDoc(s)?.nodes.find(n => n.name === name), state = isBroken(name, s) ? 'failed' : (own && stateOf(own, s.nodes)?.state) ?? 'stale';
    return ranks.indexOf(state) > ranks.indexOf(worst) ? state : worst;
  }, 'cached'));
  return (
    <div className={`card folded ${word}`} title={names.join('\n')}>
      <header><i className="badge" role="img" aria-label={word} title={word} /><b>{names.length} outputs</b></header>
      <div className="kind"><button className="link nodrag nopan" onClick={() => useStore.setState({ drawer: 'files' })}>files</button>
        <button className="link nodrag nopan" title="Show the nodes that write them" ref={takeFocus} onClick={() => unfold(shownDoc(useStore.getState())!.file)}>nodes</button></div>
      <div className="bar" />
      <div className="ports"><div className="socket in"><Handle type="target" id="files" position={Position.Left} className="many" isConnectable={false} /></div></div>
    </div>
  );
});
