import { create } from 'zustand';

import type { Dropper } from './dropper';
import { mainNode } from './follow';
import { secondsText } from './format';
import { kept } from './kept';
import { learn } from './progress';
import { failureOf, shownDoc } from './states';
import type { Arrangement, Doc, NodeState, NodeType, OutputValue, Past, Price, Run, StartInfo, State, Variants, Written } from './types';

export interface Target { node: string; port: string }
export interface Trouble { message: string; hint: string; code: string; again?: () => void } // again: what to do anyway

interface Store {
  types: Map<string, NodeType>;
  doc: Doc | null; // the document
  scope: string; // the path of the subgraph that is open, or ""
  inside: Doc | null; // what is in it
  nodes: Record<string, NodeState>;
  run: Run;
  selected: string | null;
  port: string | null; // of the selected node, in the viewer
  pinned: Target | null;
  online: boolean;
  trouble: Trouble | null;
  drawer: 'none' | 'yaml' | 'messages' | 'history' | 'files' | 'variants';
  variants: Variants | null; // of a result, side by side
  finding: '' | 'all' | 'keys'; // what is open: the search for nodes and commands, or the list of keys
  vary: string; // the parameter that was chosen for them last
  line: { number: number } | null; // to show in the YAML text
  start: StartInfo | null;
  starting: boolean; // the start page is shown
  picture: File | null; // to make a graph of
  savingAs: boolean;
  sharing: boolean;
  grouping: string[] | null; // nodes to make a subgraph of
  shared: string; // the bundle that was written last
  tool: string | null; // that is used in the picture
  dropper: Dropper | null; // that takes a color from a picture
  extra: string; // another view of the selected node than that of its output, or ""
  reference: Reference | null; // what results are compared with
  price: Price | null; // of an edit that is being made
  arrangement: Arrangement;
  thumbnails: boolean;
  unfolded: Record<string, string>; // by folded card, the file of the graph whose nodes are shown one by one
  wide: boolean; // the panel takes most of the window
}

// An earlier state, or one value, whichever is given.
export interface Reference { label: string; past?: Past; value?: OutputValue }

export const useStore = create<Store>(() => ({
  types: new Map(), doc: null, scope: '', inside: null, nodes: {}, selected: null, port: null, pinned: null, online: false, trouble: null,
  run: { running: false, live: true, seconds: 0, expected: 0, unfinished: 0, trouble: '' }, drawer: 'none', variants: null, vary: '', finding: '', line: null,
  start: null, starting: false, picture: null, savingAs: false, sharing: false, grouping: null, shared: '', tool: null, dropper: null, extra: '', reference: null, price: null,
  arrangement: {}, thumbnails: !!kept('graph').thumbnails, unfolded: {}, wide: false,
}));
const set = useStore.setState;

// Whether what is shown is the inside of a subgraph that cannot be changed here.
export const isLocked = (s: Pick<Store, 'inside'>) => !!s.inside?.read_only;
// Names of nodes in the file that is shown, and their paths, which begin with the path of the subgraph.
export const localName = (path: string, scope: string) => (scope && path.startsWith(`${scope}/`) ? path.slice(scope.length + 1) : path);
export const fullName = (name: string, scope = useStore.getState().scope) => (scope ? `${scope}/${localName(name, scope)}` : name);

export const select = (selected: string | null) => set(s => (s.selected === selected ? s : { selected, port: null, extra: '', dropper: null }));
export const goToLine = (number: number) => set({ drawer: 'yaml', line: { number } });

export const post = (path: string, body: unknown = {}, again?: () => void) => send(path, JSON.stringify(body), 'application/json', again);
// Changes the document, or the file of the subgraph that is shown.
export const change = (path: string, body: object = {}, scope = useStore.getState().scope) => post(path, { ...body, scope });

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
  if (done) set({ starting: false, savingAs: false, sharing: false, picture: null, start: { ...useStore.getState().start!, welcome: false } });
};
export const openMaterial = async (material: string, discard = false): Promise<void> =>
  opened(await post('/api/open', { material, discard }, () => void openMaterial(material, true)));
export const openGraph = async (graph: string, discard = false): Promise<void> =>
  opened(await post('/api/open', { graph, discard }, () => void openGraph(graph, true)));
export const openBundle = async (bundle: string, discard = false): Promise<void> =>
  opened(await post('/api/open', { bundle, discard }, () => void openBundle(bundle, true)));
// Shows the start page, with the graphs that are there now.
export async function showStart(): Promise<void> {
  useStore.setState({ starting: true, savingAs: false, sharing: false, picture: null });
  const answer = await fetch('/api/start').catch(() => null);
  if (answer?.ok) useStore.setState({ start: await answer.json() as StartInfo });
}
export type Content = 'particles' | 'phases';
// What to take a picture for, and why. One that cannot be read is refused.
export interface Advice { content?: Content; why: string; refused?: boolean }
export async function recommended(picture: File): Promise<Advice> {
  try {
    const answer = await fetch(`/api/recommend?${new URLSearchParams({ name: picture.name })}`, { method: 'POST', headers: { 'Content-Type': 'application/octet-stream' }, body: picture });
    const said = await answer.json();
    return answer.ok ? said : { why: `${said.message}.${said.hint ? ` ${said.hint[0].toUpperCase()}${said.hint.slice(1)}.` : ''}`, refused: true };
  } catch {
    return { why: 'The server does not answer.' };
  }
}
export async function upload(picture: File, folder: string, pixelSize: string, content: Content, discard = false): Promise<void> {
  const query = new URLSearchParams({ name: picture.name, folder, pixel_size: pixelSize, content, discard: String(discard) });
  opened(await send(`/api/photograph?${query}`, picture, 'application/octet-stream', () => void upload(picture, folder, pixelSize, content, true)));
}
// A file that was dropped or chosen: a bundle opens, and a picture may become a material.
export function dropped(file: File): void {
  if (/\.zip$/i.test(file.name)) void uploadBundle(file);
  else set({ starting: true, savingAs: false, picture: file });
}
async function uploadBundle(bundle: File, discard = false): Promise<void> {
  const query = new URLSearchParams({ name: bundle.name, discard: String(discard) });
  opened(await send(`/api/bundle?${query}`, bundle, 'application/octet-stream', () => void uploadBundle(bundle, true)));
}
// Writes a file beside the graph. Returns its name there, or "".
export async function uploadInput(file: File): Promise<string> {
  const answer = await fetch(`/api/input?${new URLSearchParams({ name: file.name, scope: useStore.getState().scope })}`, { method: 'POST', headers: { 'Content-Type': 'application/octet-stream' }, body: file }).catch(() => null);
  const said = await answer?.json();
  if (answer?.ok) return said.file as string;
  set({ trouble: said ?? { message: 'the server does not answer', hint: '', code: 'offline' } });
  return '';
}
export const save = () => (useStore.getState().doc?.read_only ? set({ savingAs: true }) : void post('/api/save'));

export type Edit = { op: string; node?: string; name?: string; value?: unknown; wires?: string[]; type?: string; graph?: string; to?: string; index?: number; bypass?: boolean };
// Changes with the same name are one step of undo if less than a second is between them.
let moving = { what: '', group: 0, at: 0 };
function groupOf(what: string): string {
  moving = { what, group: moving.group + (what !== moving.what || performance.now() - moving.at > 1000 ? 1 : 0), at: performance.now() };
  return `${what} ${moving.group}`;
}
// `merge`: one of many edits while a control moves. `places`: where nodes go that the edits add.
export function edit(edits: Edit[], merge = false, places: Arrangement['places'] = {}, scope = useStore.getState().scope): Promise<boolean> {
  return change('/api/edit', { edits: localEdits(edits, scope), places: placesIn(places, name => localName(name, scope)), group: merge ? groupOf(edits.map(e => `${e.node}.${e.name}`).join(' ')) : '' }, scope);
}
function localEdits(edits: Edit[], scope: string): Edit[] {
  const local = (name: string) => localName(name, scope), maybe = (name: string | undefined) => name && local(name);
  return edits.map(e => ({ ...e, node: maybe(e.node), name: maybe(e.name), to: maybe(e.to), wires: e.wires?.map(local) }));
}
export const placesIn = (places: Arrangement['places'], name: (n: string) => string): Arrangement['places'] =>
  places && Object.fromEntries(Object.entries(places).map(([n, at]) => [name(n), at]));
export const localPlaces = (places: Arrangement['places']) => { const { scope } = useStore.getState(); return placesIn(places, n => localName(n, scope)); };

// --- events

const started = (n: NodeState): NodeState => (n.elapsed === undefined ? n : { ...n, since: performance.now() - 1000 * n.elapsed });

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
  const uses = new Map<string, (data: never) => void>();
  const on = <T>(type: string, use: (data: T) => void) => uses.set(type, use as (data: never) => void);
  on<State>('state', s => {
    pending = {};
    const first = !useStore.getState().doc;
    showErrors(s.document, useStore.getState().doc);
    if (first && failureOf(s)) openDrawer('messages');
    set({ doc: s.document, nodes: Object.fromEntries(Object.entries(s.nodes).map(([path, n]) => [path, started(n)])), run: s.run, variants: s.variants, online: true, ...rootArrangement(s.document.arrangement) });
    void enter(useStore.getState().scope);
  });
  on<{ arrangement: Arrangement; can_undo: boolean; can_redo: boolean; trouble: string }>('arrangement', ({ arrangement, ...rest }) => {
    set(s => ({ doc: s.doc && { ...s.doc, ...rest, arrangement }, ...rootArrangement(arrangement) }));
  });
  on<Doc>('document', doc => {
    showErrors(doc, useStore.getState().doc);
    set(s => (s.doc && doc.file !== s.doc.file && doc.text !== s.doc.text ? {
      doc, nodes: {}, selected: null, pinned: null, port: null, tool: null, starting: false, savingAs: false, line: null, scope: '', inside: null, reference: null, price: null, arrangement: doc.arrangement,
    } : {
      ...rootArrangement(doc.arrangement), doc, savingAs: s.savingAs && doc.file === s.doc?.file, unfolded: Object.fromEntries(Object.entries(s.unfolded).map(([card, file]) => [card, file === s.doc?.file ? doc.file : file])), selected: s.scope || doc.nodes.some(n => n.name === s.selected) ? s.selected : null,
      pinned: s.pinned && (s.scope || doc.nodes.some(n => n.name === s.pinned!.node)) ? s.pinned : null,
    }));
    void enter(useStore.getState().scope);
  });
  on<Run>('run', run => { // after what nodes have told of themselves
    set(s => ({ run, nodes: { ...s.nodes, ...pending } }));
    pending = {};
  });
  on<Variants | null>('variants', variants => set({ variants }));
  on<NodeState & { path: string }>('node', n => {
    learn(n), later(n.path, started(n));
    if (n.state === 'failed' && useStore.getState().nodes[n.path]?.state !== 'failed') openDrawer('messages');
  });
  on<{ path: string; progress: number; note: string }>('progress', p => {
    const before = pending[p.path] ?? useStore.getState().nodes[p.path];
    if (before) later(p.path, { ...before, since: before.since ?? performance.now(), state: 'running', progress: p.progress, note: p.note });
  });
  listen(uses);
}

// What a person opened stays.
function openDrawer(drawer: 'messages' | 'yaml', line: { number: number } | null = null) {
  if (useStore.getState().drawer === 'none') set({ drawer, line });
}
// Text that is no YAML opens the text at the place, and other errors the messages, when they come.
function showErrors(doc: Doc, before: Doc | null) {
  if (doc.valid || (before?.file === doc.file && !before.valid)) return;
  const first = doc.messages.find(m => m.severity === 'error');
  if (first?.code === 'yaml' && first.file === doc.file) openDrawer('yaml', { number: first.line });
  else if (first) openDrawer('messages');
}

// Follows the server: through a worker that all pages share, or alone where browsers have no such workers.
function listen(uses: Map<string, (data: never) => void>) {
  const failed = (closed: boolean) => {
    set({ online: false });
    if (closed) // refused: another server, with another token
      set({ trouble: { message: 'this page belongs to a server that has ended', hint: 'open the address that terrazzo studio printed last', code: 'offline' } });
  };
  if (typeof SharedWorker === 'undefined') {
    const events = new EventSource('/api/events');
    events.onopen = () => set({ online: true });
    events.onerror = () => failed(events.readyState === EventSource.CLOSED);
    for (const [type, use] of uses) events.addEventListener(type, e => use(JSON.parse((e as MessageEvent<string>).data) as never));
    return;
  }
  const { port } = new SharedWorker('/events.js', 'terrazzo events');
  port.onmessage = (e: MessageEvent<{ kind: string; data?: string; closed?: boolean }>) => {
    const { kind, data, closed } = e.data;
    if (kind === 'open') set({ online: true });
    else if (kind === 'error') failed(!!closed);
    else uses.get(kind)?.(JSON.parse(data!) as never);
  };
  window.addEventListener('pagehide', () => port.postMessage('leave'));
  window.addEventListener('pageshow', e => { if (e.persisted) location.reload(); });
}

// Opens a subgraph by the path of its node; "" is the document itself. Its file may have changed.
export async function enter(scope: string): Promise<void> {
  const there = useStore.getState().doc?.nodes.some(n => n.graph && n.name === scope.split('/')[0]);
  if (!scope || !there) return leave();
  const answer = await fetch(`/api/subgraph?path=${encodeURIComponent(scope)}`);
  if (!answer.ok) {
    return leave();
  }
  const doc = await answer.json() as Doc, path = (name: string) => `${scope}/${name}`;
  const nodes = doc.nodes.map(n => ({
    ...n, name: path(n.name), inputs: Object.fromEntries(Object.entries(n.inputs).map(([port, wires]) => [port, wires.map(path)])),
    inner: n.bypass ? n.inner : n.inner && Object.fromEntries(Object.entries(n.inner).map(([port, at]) => [port, at && { ...at, path: path(at.path) }])),
  }));
  const arrangement = { ...doc.arrangement, places: placesIn(doc.arrangement.places, path) };
  if (useStore.getState().scope !== scope) missed = null;
  set(s => ({
    scope, inside: { ...doc, nodes, messages: [], arrangement }, ...(s.scope === scope ? { ...arrangementOf(arrangement) } : { arrangement, selected: null, tool: null }),
  }));
}

function leave() {
  if (!useStore.getState().inside) return;
  missed = null;
  set(s => ({ scope: '', inside: null, selected: null, tool: null, arrangement: s.doc?.arrangement ?? {} }));
}

// Keeps where nodes and notes are, as a step of undo. Several changes at once are one request. Changes that name the same `group` are
// one step if less than a second is between them.
let keeping = 0; // requests that are under way
let missed: Arrangement | null = null; // what the server reported meanwhile, which may be older
let scheduled_group: string | null = null;
export function arrange(next: Partial<Arrangement>, group = '') {
  set(s => ({ arrangement: { ...s.arrangement, ...next } }));
  const first = scheduled_group === null, { scope } = useStore.getState();
  scheduled_group = group;
  if (!first) return;
  ++keeping;
  setTimeout(async () => {
    const group = scheduled_group!;
    scheduled_group = null;
    const { arrangement } = useStore.getState();
    await change('/api/arrange', { arrangement: { ...arrangement, places: localPlaces(arrangement.places) ?? {} }, group: group && groupOf(group) }, scope);
    if (--keeping || !missed) return;
    set({ arrangement: missed });
    missed = null;
  });
}

const rootArrangement = (reported: Arrangement) => (useStore.getState().scope ? {} : arrangementOf(reported));

function arrangementOf(reported: Arrangement): { arrangement?: Arrangement } {
  if (!keeping) return { arrangement: reported };
  missed = reported;
  return {};
}

export const priceText = (p: Price) => {
  const sure = p.nodes.filter(n => !n.perhaps).length, n = p.nodes.length;
  return !n ? 'nothing runs' : `${n} ${n === 1 ? 'node' : 'nodes'}${p.seconds > 0 ? `, about ${secondsText(p.seconds)}` : ''}${sure < n && sure > 0 ? ' at most' : ''}`;
};

// The nodes that edits would run, and for how long.
let asked = 0;
export async function askPrice(edits: Edit[] | null, scope = useStore.getState().scope): Promise<void> {
  const number = ++asked;
  if (!edits || (useStore.getState().doc?.node_count ?? 0) > 500) return set({ price: null });
  const answer = await fetch('/api/price', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ edits: localEdits(edits, scope), scope }) }).catch(() => null);
  if (number !== asked) return;
  set({ price: answer?.ok ? await answer.json() as Price : null });
}

// The server computes first what is shown.
let shown = '';
useStore.subscribe(s => {
  const name = s.pinned?.node ?? (s.selected || mainNode(s)), node = shownDoc(s)?.nodes.find(n => n.name === name);
  const path = (node?.graph || node?.bypass ? Object.values(node.inner ?? {})[0]?.path : name) ?? '';
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

// Bypasses nodes, or no longer if all of them are.
export function bypass(names: string[]) {
  const nodes = shownDoc(useStore.getState())?.nodes.filter(n => names.includes(n.name) && !n.graph) ?? [], on = !nodes.every(n => n.bypass);
  if (nodes.length) void edit(nodes.map(n => ({ op: 'bypass', node: n.name, bypass: on })));
}

// Where a value such as ${seed} comes from: its parameter of the graph, or of the node that is the subgraph, and what changes it.
export interface Source { name: string; value: Written; edits: (value: Written) => Edit[]; scope: string }
export function sourceOf(written: Written, s: Pick<Store, 'doc' | 'inside' | 'scope'>): Source | undefined {
  const nameIn = (value: Written) => /^\$\{([^}]+)\}$/.exec(String(value))?.[1];
  const own = shownDoc(s)?.parameters.find(p => p.name === nameIn(written));
  if (!own) return undefined;
  if (!s.scope) return { name: own.name, value: own.value, edits: value => [{ op: 'set_default', name: own.name, value }], scope: '' };
  const user = s.doc?.nodes.find(n => n.name === s.scope); // of a subgraph in a subgraph, nothing is known here
  if (!user) return undefined;
  const value = user.params[own.name]?.value, outer = value === undefined ? undefined : sourceOf(value, { doc: s.doc, inside: null, scope: '' });
  return outer ?? { name: own.name, value: value ?? own.value, edits: v => [{ op: 'set', node: user.name, name: own.name, value: v }], scope: '' };
}
