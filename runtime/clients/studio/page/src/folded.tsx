// The nodes that write files, and the nodes that check the result, as one card each. Corrections are in the card of what they correct.
import { Handle, Position, type Node, type NodeProps } from '@xyflow/react';
import { memo } from 'react';

import { typeColor } from './format';
import { declarationOf, isBroken, shownDoc, splitWire, stateOf } from './states';
import { useStore } from './store';
import type { Doc, DocNode, NodeType, StateWord } from './types';

export const filesCard = 'files ', checksCard = 'checks '; // no nodes have these names
export const isFolded = (name: string) => name === filesCard || name === checksCard;
export type FoldedNode = Node<{ node: DocNode }, 'folded'>;

const kFew: Record<string, number> = { [filesCard]: 2, [checksCard]: 1 }; // which are not folded
const checks = ['Compare', 'TextureObserver', 'InstanceScore', 'Measure3D', 'ShapeMetrics', 'GrainSize'];

// The nodes of each card. Checks are those that only files and other checks read, and what is made for them alone.
export function groupsOf(doc: Doc, types: Map<string, NodeType>): Map<string, DocNode[]> {
  const card = new Map<string, string>(), readers = new Map(doc.nodes.map(n => [n.name, [] as string[]]));
  for (const n of doc.nodes) for (const w of Object.values(n.inputs).flat()) readers.get(splitWire(w, doc, types).node)?.push(n.name);
  for (const n of doc.nodes) { const d = declarationOf(n, types); if (d?.writes_files && !d.outputs.length) card.set(n.name, filesCard); }
  for (let grown = true; grown;) {
    grown = false;
    for (const n of doc.nodes) {
      const all = readers.get(n.name)!, check = checks.includes(n.type);
      if (card.has(n.name) || !all.every(r => card.get(r) === checksCard || (check && card.has(r))) || !(check || all.length)) continue;
      card.set(n.name, checksCard), grown = true;
    }
  }
  const groups = [filesCard, checksCard].map(c => [c, doc.nodes.filter(n => card.get(n.name) === c)] as const);
  return new Map(groups.filter(([c, nodes]) => nodes.length > kFew[c]));
}

// The Segment whose card has a node: the corrections of its labels, and the Segment that measures these.
export function correctedBy(doc: Doc, types: Map<string, NodeType>): Map<string, string> {
  const out = new Map<string, string>(), sourceOf = (n: DocNode) => splitWire(n.inputs.labels?.[0] ?? '', doc, types);
  for (const edits of doc.nodes.filter(n => n.type === 'EditLabels')) {
    const found = doc.nodes.find(n => n.type === 'Segment' && n.name === sourceOf(edits).node && !n.inputs.labels);
    const measures = doc.nodes.filter(n => n.type === 'Segment' && sourceOf(n).node === edits.name);
    if (found && measures.length === 1 && ![...out.values()].includes(found.name)) out.set(edits.name, found.name).set(measures[0].name, found.name);
  }
  return out;
}

// The graph, with a card in place of the nodes of each group.
export function fold(doc: Doc, types: Map<string, NodeType>, groups: Map<string, DocNode[]>): Doc {
  const corrected = correctedBy(doc, types);
  if (!groups.size && !corrected.size) return doc;
  const owner = new Map([...corrected, ...[...groups].flatMap(([card, nodes]) => nodes.map(n => [n.name, card] as const))]);
  const through = (w: string) => {
    const { node, port } = splitWire(w, doc, types), card = owner.get(node);
    return !card ? w : isFolded(card) ? `${card}.results` : `${card}.${port}`; // a Segment that measures has the outputs of one that finds
  };
  const wiresOf = (wires: string[]) => [...new Set(wires.map(through))];
  const partsOf = (name: string) => [...corrected].filter(([, card]) => card === name).map(([part]) => part);
  const nodes: DocNode[] = doc.nodes.filter(n => !owner.has(n.name))
    .map(n => ({ ...n, parts: partsOf(n.name), inputs: Object.fromEntries(Object.entries(n.inputs).map(([port, w]) => [port, w.map(through)])) }));
  for (const [card, all] of groups) {
    const port = { types: [] as string[], doc: '', optional: false, many: true };
    const declaration: NodeType = {
      type: card, district: '', version: 0, doc: '', source: '', writes_files: card === filesCard, parameters: [],
      inputs: [{ ...port, name: 'inputs' }], outputs: card === checksCard ? [{ ...port, name: 'results', types: ['Table'] }] : [],
    };
    const inputs = { inputs: wiresOf(all.flatMap(n => Object.values(n.inputs).flat())).filter(w => w !== `${card}.results`) };
    nodes.push({ name: card, type: '', graph: '', doc: all.map(n => n.name).join('\n'), line: 0, bypass: false, params: {}, inputs, declaration });
  }
  return { ...doc, nodes };
}

// Shows the nodes of a card one by one, or with "" as one card. The button for the way back takes the focus.
let asked = false;
export function unfold(cards: string[], file: string) {
  asked = true;
  useStore.setState(s => ({ unfolded: { ...s.unfolded, ...Object.fromEntries(cards.map(c => [c, file])) } }));
}
export function takeFocus(button: HTMLButtonElement | null) {
  if (!button || !asked) return;
  asked = false;
  button.focus({ preventScroll: true });
}

// From the best to the worst.
const ranks: StateWord[] = ['cached', 'computed', 'bypassed', 'stale', 'canceled', 'skipped', 'waiting', 'running', 'failed'];

export const FoldedCard = memo(function FoldedCard({ data: { node } }: NodeProps<FoldedNode>) {
  const names = node.doc.split('\n'), files = node.name === filesCard;
  const word = useStore(s => names.reduce((worst: StateWord, name) => {
    const own = shownDoc(s)?.nodes.find(n => n.name === name), state = isBroken(name, s) ? 'failed' : (own && stateOf(own, s.nodes)?.state) ?? 'stale';
    return ranks.indexOf(state) > ranks.indexOf(worst) ? state : worst;
  }, 'cached'));
  return (
    <div className={`card folded ${word}`} title={names.join('\n')}>
      <header><i className="badge" role="img" aria-label={word} title={word} /><b>{names.length} {files ? 'outputs' : 'checks'}</b></header>
      <div className="kind">{files && <button className="link nodrag nopan" onClick={() => useStore.setState({ drawer: 'files' })}>files</button>}
        <button className="link nodrag nopan" title={files ? 'Show the nodes that write them' : 'Show the nodes that check the result'} ref={takeFocus}
          onClick={() => unfold([node.name], shownDoc(useStore.getState())!.file)}>nodes</button></div>
      <div className="bar" />
      <div className="ports"><div className="socket in"><Handle type="target" id="inputs" position={Position.Left} className="many" isConnectable={false} /></div>
        {!files && <div className="socket out"><Handle type="source" id="results" position={Position.Right} isConnectable={false} style={{ '--type': typeColor('Table') } as React.CSSProperties} /></div>}</div>
    </div>
  );
});
