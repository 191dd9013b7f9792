// What has become of nodes: states, values and wires, found in what the store holds.
import type { Target } from './store';
import type { Doc, DocNode, Message, NodeState, NodeType, OutputValue } from './types';

// What the canvas shows: the document, or the inside of a subgraph, whose nodes are named by their paths.
export const shownDoc = (s: { doc: Doc | null; inside: Doc | null }) => s.inside ?? s.doc;

export const declarationOf = (node: DocNode, types: Map<string, NodeType>) => node.declaration ?? types.get(node.type);

const rank: NodeState['state'][] = ['cached', 'computed', 'stale', 'skipped', 'canceled', 'waiting', 'running', 'failed'];
export const worse = (a: NodeState, b: NodeState) => (rank.indexOf(b.state) > rank.indexOf(a.state) ? b : a);

// A path without the names of elements: "part[3]/pack" becomes "part/pack".
const bare = (path: string) => path.replace(/\[[^\]]*\]/g, '');

// Whether a path is that of a node, or inside it.
export const belongsTo = (path: string, name: string) => `${bare(path)}/`.startsWith(name + '/');
// Whether a node, or one inside it, has an error in the graph.
export const isBroken = (name: string, s: { doc: Doc | null }) => !!s.doc?.messages.some(m => m.severity === 'error' && belongsTo(m.node, name));
// The error of a node that failed, with the node's path.
export const failureOf = (s: { nodes: Record<string, NodeState> }): Message | undefined => {
  const failed = Object.entries(s.nodes).find(([, n]) => n.error);
  return failed && { ...failed[1].error!, node: failed[0] };
};

export const elementsOf = (node: DocNode, nodes: Record<string, NodeState>) =>
  new Set(Object.keys(nodes).filter(p => p.startsWith(node.name + '[')).map(p => p.slice(0, p.indexOf(']')))).size;

const nothing: NodeState = { type: '', state: 'cached', progress: 0, note: '', seconds: 0, expected: 0, reasons: [], outputs: {}, previews: {}, metrics: {}, warnings: [], files: [] };

// The state of a node of the document. Those of a subgraph's nodes, and of elements, are joined.
export function stateOf(node: DocNode, nodes: Record<string, NodeState>): NodeState | undefined {
  if (node.bypass) return { ...nothing, state: 'bypassed' };
  if (!node.graph && nodes[node.name]) return nodes[node.name];
  const all = Object.entries(nodes).filter(([path]) => belongsTo(path, node.name));
  if (!all.length) return undefined;
  const read = all.filter(([, s]) => s.state !== 'stale' || s.reasons.length), inside = read.length ? read : all; // the others run for nobody
  const out: NodeState = { ...nothing, reasons: [], warnings: [], files: [] };
  for (const [path, s] of inside) {
    if (rank.indexOf(s.state) > rank.indexOf(out.state)) out.state = s.state;
    out.seconds += s.seconds, out.expected += s.expected;
    out.progress += (s.state === 'running' ? s.progress : s.state === 'waiting' ? 0 : 1) / inside.length;
    out.reasons.push(...s.reasons.map(r => `${path.slice(node.name.length).replace(/^\//, '')}: ${r}`));
    out.warnings.push(...s.warnings), out.files.push(...s.files);
    if (s.error && !out.error) out.error = s.error;
  }
  return out;
}

// The path and port of what makes an output, also inside of subgraphs. Of elements, the first.
export function placeOf(node: DocNode, port: string, nodes: Record<string, NodeState>): { path: string; port: string } | undefined {
  const at = node.graph || node.bypass ? node.inner?.[port] : { path: node.name, port };
  if (!at) return undefined;
  const path = nodes[at.path] ? at.path : Object.keys(nodes).find(p => bare(p) === at.path);
  return path === undefined ? undefined : { path, port: at.port };
}

function outputOf(node: DocNode, port: string, nodes: Record<string, NodeState>): { state: NodeState; port: string } | undefined {
  const at = placeOf(node, port, nodes);
  return at && { state: nodes[at.path], port: at.port };
}

export function valueOf(node: DocNode, port: string, nodes: Record<string, NodeState>): OutputValue | undefined {
  const at = outputOf(node, port, nodes);
  return at?.state.outputs[at.port];
}

// What the node has made of a value so far, while it computes.
export function previewOf(node: DocNode, port: string, nodes: Record<string, NodeState>): OutputValue | undefined {
  const at = outputOf(node, port, nodes), preview = at?.state.previews[at.port];
  return preview && { type: preview.type, hash: `preview/${preview.number}`, bytes: 0 };
}

export function splitWire(wire: string, doc: Doc, types: Map<string, NodeType>): Target {
  const dot = wire.lastIndexOf('.');
  if (dot > wire.lastIndexOf(']')) return { node: bare(wire.slice(0, dot)), port: wire.slice(dot + 1) };
  const node = doc.nodes.find(n => n.name === bare(wire));
  return { node: bare(wire), port: (node && declarationOf(node, types)?.outputs[0]?.name) ?? '' };
}

// The nearest value of a type, upstream or downstream of a node.
export function nearest(from: string, type: string, direction: 'up' | 'down', s: { doc: Doc | null; inside: Doc | null; types: Map<string, NodeType>; nodes: Record<string, NodeState> }): { target: Target; value: OutputValue } | null {
  const { types, nodes } = s, doc = shownDoc(s);
  if (!doc) return null;
  const seen = new Set([from]);
  let front = [from];
  while (front.length) {
    const next: string[] = [];
    for (const name of front) {
      const around = direction === 'up'
        ? Object.values(doc.nodes.find(n => n.name === name)?.inputs ?? {}).flat().map(w => splitWire(w, doc, types))
        : doc.nodes.filter(n => Object.values(n.inputs).flat().some(w => splitWire(w, doc, types).node === name))
          .flatMap(n => (declarationOf(n, types)?.outputs ?? []).map(p => ({ node: n.name, port: p.name })));
      for (const target of around) {
        const node = doc.nodes.find(n => n.name === target.node);
        const value = node && valueOf(node, target.port, nodes);
        if (value?.type === type) return { target, value };
        if (!seen.has(target.node)) seen.add(target.node), next.push(target.node);
      }
    }
    front = next;
  }
  return null;
}
