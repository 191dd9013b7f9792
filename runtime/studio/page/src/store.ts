import { create } from 'zustand';
import type { Doc, DocNode, NodeState, NodeType, OutputValue, Run, StartInfo, State } from './types';

export interface Target { node: string; port: string }
export interface Trouble { message: string; hint: string; code: string; again?: () => void } // again: what to do anyway

interface Store {
  types: Map<string, NodeType>;
  doc: Doc | null;
  nodes: Record<string, NodeState>;
  run: Run;
  selected: string | null;
  port: string | null; // of the selected node, in the viewer
  pinned: Target | null;
  online: boolean;
  trouble: Trouble | null;
  drawer: 'none' | 'yaml' | 'messages';
  line: number; // to show in the YAML text; 0: none
  start: StartInfo | null;
  starting: boolean; // the start page is shown
  picture: File | null; // to make a graph of
  savingAs: boolean;
  tool: string | null; // that is used in the picture
}

export const useStore = create<Store>(() => ({
  types: new Map(), doc: null, nodes: {}, selected: null, port: null, pinned: null, online: false, trouble: null,
  run: { running: false, live: true, seconds: 0, expected: 0, trouble: '' }, drawer: 'none', line: 0,
  start: null, starting: false, picture: null, savingAs: false, tool: null,
}));
const set = useStore.setState;

export const select = (selected: string | null) => set({ selected, port: null });
export const goToLine = (line: number) => set({ drawer: 'yaml', line });

export const post = (path: string, body: unknown = {}, again?: () => void) => send(path, JSON.stringify(body), 'application/json', again);

async function send(path: string, body: BodyInit, type: string, again?: () => void): Promise<boolean> {
  try {
    const answer = await fetch(path, { method: 'POST', headers: { 'Content-Type': type }, body });
    if (answer.ok) {
      set({ trouble: null });
      return true;
    }
    const { message, hint, code } = await answer.json();
    set({ trouble: { message, hint, code, again: code === 'unsaved-changes' ? again : undefined } });
  } catch {
    set({ trouble: { message: 'the server does not answer', hint: 'is terrazzo studio still running?', code: 'offline' } });
  }
  return false;
}

const opened = (done: boolean) => {
  if (done) set({ starting: false, picture: null, start: { ...useStore.getState().start!, welcome: false } });
};
export const openMaterial = async (material: string, discard = false): Promise<void> =>
  opened(await post('/api/open', { material, discard }, () => void openMaterial(material, true)));
export async function upload(picture: File, folder: string, pixelSize: string, discard = false): Promise<void> {
  const query = new URLSearchParams({ name: picture.name, folder, pixel_size: pixelSize, discard: String(discard) });
  opened(await send(`/api/photograph?${query}`, picture, 'application/octet-stream', () => void upload(picture, folder, pixelSize, true)));
}
export const save = () => (useStore.getState().doc?.read_only ? set({ savingAs: true }) : void post('/api/save'));

export type Edit = { op: string; node?: string; name?: string; value?: unknown; wires?: string[]; type?: string; graph?: string; to?: string; index?: number };
// `merge`: one of many edits while a control moves. Those within a second are one step of undo.
let moving = { what: '', group: 0, at: 0 };
export function edit(edits: Edit[], merge = false): Promise<boolean> {
  if (!merge) return post('/api/edit', { edits });
  const what = edits.map(e => `${e.node}.${e.name}`).join(' ');
  moving = { what, group: moving.group + (what !== moving.what || performance.now() - moving.at > 1000 ? 1 : 0), at: performance.now() };
  return post('/api/edit', { edits, group: `${what} ${moving.group}` });
}

// --- events

let pending: Record<string, NodeState> = {};
let scheduled = false;

// Many nodes change at once, so their events are applied once per frame.
function later(path: string, state: NodeState) {
  pending[path] = state;
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(() => {
    scheduled = false;
    set(s => ({ nodes: { ...s.nodes, ...pending } }));
    pending = {};
  });
}

export async function connect() {
  const types = await (await fetch('/api/types')).json() as NodeType[];
  set({ types: new Map(types.map(t => [t.type, t])) });
  const start = await (await fetch('/api/start')).json() as StartInfo;
  set({ start, starting: start.welcome });
  const events = new EventSource('/api/events');
  const on = <T>(type: string, use: (data: T) => void) =>
    events.addEventListener(type, e => use(JSON.parse((e as MessageEvent<string>).data) as T));
  events.onopen = () => set({ online: true });
  events.onerror = () => {
    set({ online: false });
    if (events.readyState === EventSource.CLOSED) // refused: another server, with another token
      set({ trouble: { message: 'this page belongs to a server that has ended', hint: 'open the address that terrazzo studio printed last', code: 'offline' } });
  };
  on<State>('state', s => {
    pending = {};
    set({ doc: s.document, nodes: s.nodes, run: s.run, online: true });
  });
  on<Doc>('document', doc => set(s => (s.doc && doc.file !== s.doc.file && doc.text !== s.doc.text ? {
    doc, nodes: {}, selected: null, pinned: null, port: null, tool: null, starting: false, line: 0,
  } : {
    doc, selected: doc.nodes.some(n => n.name === s.selected) ? s.selected : null,
    pinned: s.pinned && doc.nodes.some(n => n.name === s.pinned!.node) ? s.pinned : null,
  })));
  on<Run>('run', run => set({ run }));
  on<NodeState & { path: string }>('node', n => later(n.path, n));
  on<{ path: string; progress: number; note: string }>('progress', p => {
    const before = pending[p.path] ?? useStore.getState().nodes[p.path];
    if (before) later(p.path, { ...before, state: 'running', progress: p.progress, note: p.note });
  });
}

// The server computes first what is shown.
let shown = '';
useStore.subscribe(s => {
  const name = s.pinned?.node ?? s.selected ?? '', node = s.doc?.nodes.find(n => n.name === name);
  const path = (node?.graph ? Object.values(node.inner ?? {})[0]?.path : name) ?? '';
  if (path === shown || !s.doc) return;
  shown = path;
  void fetch('/api/view', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ node: path }) }).catch(() => {});
});

// Sends values while a control moves. Each waits until what is shown has changed, if only as a preview, because it would cancel
// what the last one started; but not for long.
export function steadily<T>(send: (value: T) => Promise<unknown>) {
  let next: { value: T } | null = null, busy = false;
  const newest = () => Math.max(0, ...Object.values(useStore.getState().nodes[shown]?.previews ?? {}).map(p => p.number));
  return {
    async move(value: T) {
      next = { value };
      if (busy) return;
      busy = true;
      while (next) {
        const now: T = next.value, before = newest(), end = performance.now() + 900;
        next = null;
        await send(now);
        do await new Promise(done => setTimeout(done, 60));
        while (performance.now() < end && newest() <= before && ['waiting', 'running'].includes(useStore.getState().nodes[shown]?.state));
      }
      busy = false;
    },
    drop() { next = null; },
    busy: () => busy,
  };
}

// --- nodes of the document

export const declarationOf = (node: DocNode, types: Map<string, NodeType>) => node.declaration ?? types.get(node.type);

const rank: NodeState['state'][] = ['cached', 'computed', 'stale', 'skipped', 'canceled', 'waiting', 'running', 'failed'];

// A path without the names of elements: "part[3]/pack" becomes "part/pack".
const bare = (path: string) => path.replace(/\[[^\]]*\]/g, '');

export const elementsOf = (node: DocNode, nodes: Record<string, NodeState>) =>
  new Set(Object.keys(nodes).filter(p => p.startsWith(node.name + '[')).map(p => p.slice(0, p.indexOf(']')))).size;

// The state of a node of the document. Those of a subgraph's nodes, and of elements, are joined.
export function stateOf(node: DocNode, nodes: Record<string, NodeState>): NodeState | undefined {
  if (!node.graph && !node.each) return nodes[node.name];
  const inside = Object.entries(nodes).filter(([path]) => `${bare(path)}/`.startsWith(node.name + '/'));
  if (!inside.length) return undefined;
  const out: NodeState = {
    state: 'cached', progress: 0, note: '', seconds: 0, expected: 0, reasons: [], outputs: {}, previews: {}, metrics: {}, warnings: [], files: [],
  };
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

function outputOf(node: DocNode, port: string, nodes: Record<string, NodeState>): { state: NodeState; port: string } | undefined {
  const at = node.graph ? node.inner?.[port] : { path: node.name, port };
  if (!at) return undefined;
  const path = nodes[at.path] ? at.path : Object.keys(nodes).find(p => bare(p) === at.path); // the first element
  return path === undefined ? undefined : { state: nodes[path], port: at.port };
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
export function nearest(from: string, type: string, direction: 'up' | 'down', s: Pick<Store, 'doc' | 'types' | 'nodes'>): { target: Target; value: OutputValue } | null {
  const { doc, types, nodes } = s;
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
