import {
  applyNodeChanges, Background, BackgroundVariant, MiniMap, ReactFlow, useReactFlow, useStore as useFlow, type Connection, type Edge, type EdgeChange, type NodeChange,
} from '@xyflow/react';
import { useCallback, useEffect, useMemo, useRef, useState } from 'react';

import { paste, textOf } from './clipboard';
import { typeColor } from './format';
import { Find } from './find';
import { correctedBy, fold, FoldedCard, groupsOf, isFolded, takeFocus, unfold, type FoldedNode } from './folded';
import { keep } from './kept';
import { layout, nodeSize, nodeWidth } from './layout';
import { NodeCard, type GraphNode } from './node';
import { addNote, changeNote, NoteCard, removeNotes, type NoteNode } from './note';
import { keepPlaces, placesOf, readPlaces, writtenPlaces, type Places } from './places';
import { nextNode } from './next_node';
import { MenuButton } from './menu';
import { NodeMenu, rename } from './node_menu';
import { Search, type SearchAt } from './search';
import { declarationOf, shownDoc, splitWire } from './states';
import { bypass, edit, enter, isLocked, post, select, useStore, type Edit } from './store';
import type { Doc, DocNode, NodeType } from './types';

const nodeTypes = { node: NodeCard, note: NoteCard, folded: FoldedCard };
const noPro = { hideAttribution: true };
type AnyNode = GraphNode | NoteNode | FoldedNode;

function wiresOf(doc: Doc, types: Map<string, NodeType>): Edge[] {
  const out: Edge[] = [];
  for (const n of doc.nodes)
    for (const [input, wires] of Object.entries(n.inputs))
      wires.forEach((w, k) => {
        const from = splitWire(w, doc, types);
        const source = doc.nodes.find(x => x.name === from.node);
        const port = source && declarationOf(source, types)?.outputs.find(p => p.name === from.port);
        const target = declarationOf(n, types)?.inputs.find(p => p.name === input);
        if (!source || !port || !target) return; // the messages say what is wrong
        out.push({
          id: `${n.name}.${input}.${k}`, source: from.node, sourceHandle: from.port, target: n.name, targetHandle: input,
          style: { stroke: typeColor(port.types[0]) }, ariaLabel: `Wire from ${w} to ${n.name}.${input}`,
          ...((isFolded(n.name) || isFolded(from.node)) && { selectable: false, focusable: false, deletable: false }),
        });
      });
  return out;
}

// The wire that a node was dropped on, if the node can stand in it: the edits that put it there.
function insertion(node: DocNode, edge: Edge, doc: Doc, types: Map<string, NodeType>, source: string): Edit[] | null {
  const typeOf = (name: string, port: string | null | undefined) => {
    const n = doc.nodes.find(x => x.name === name), d = n && declarationOf(n, types);
    return d?.outputs.find(p => p.name === port)?.types[0];
  };
  const target = doc.nodes.find(n => n.name === edge.target), own = declarationOf(node, types);
  const accepts = target && declarationOf(target, types)?.inputs.find(p => p.name === edge.targetHandle)?.types;
  const type = typeOf(edge.source, edge.sourceHandle);
  const input = own?.inputs.find(p => !node.inputs[p.name] && type && (!p.types.length || p.types.includes(type)));
  const output = own?.outputs.find(p => accepts && (!accepts.length || accepts.includes(p.types[0])));
  if (!target || !input || !output) return null;
  const wires = [...(target.inputs[edge.targetHandle!] ?? [])];
  wires[Number(edge.id.split('.').pop())] = `${node.name}.${output.name}`;
  return [{ op: 'connect', node: node.name, name: input.name, wires: [`${source}.${edge.sourceHandle}`] }, { op: 'connect', node: target.name, name: edge.targetHandle!, wires }];
}

// The nodes that each node is wired to, first those before it.
function neighborsOf(doc: Doc, types: Map<string, NodeType>): Map<string, string[]> {
  const wires = doc.nodes.flatMap(n => Object.values(n.inputs).flat().map(w => [splitWire(w, doc, types).node, n.name]));
  const out = new Map(doc.nodes.map(n => [n.name, [] as string[]]));
  for (const [from, to] of wires) out.get(to)!.push(from);
  for (const [from, to] of wires) out.get(from)?.push(to);
  return out;
}

// The wire that passes nearest to a point on the screen, within 30 pixels.
function wireAt(x: number, y: number): string | null {
  let found: string | null = null, least = 30;
  for (const g of document.querySelectorAll<SVGGElement>('.react-flow__edge')) {
    const path = g.querySelector<SVGPathElement>('.react-flow__edge-path'), matrix = path?.getScreenCTM();
    if (!path || !matrix) continue;
    const length = path.getTotalLength();
    for (let k = 1; k < 20; ++k) {
      const p = path.getPointAtLength((k / 20) * length).matrixTransform(matrix), d = Math.hypot(p.x - x, p.y - y);
      if (d < least) least = d, found = g.dataset.id ?? null;
    }
  }
  return found;
}

const kMostNodes = 2000; // the layout of more takes minutes
const kNames = 12; // pixels on the screen that names have at least when the graph is fitted
const kLargestName = 24; // in a card, which it still fits
const kLeastZoom = kNames / kLargestName;
const countOf = (doc: Doc) => doc.node_count ?? doc.nodes.length;

export function Canvas() {
  const all = useStore(shownDoc), root = useStore(s => s.doc), scope = useStore(s => s.scope), locked = useStore(isLocked);
  const types = useStore(s => s.types), unfolded = useStore(s => s.unfolded);
  const selected = useStore(s => s.selected);
  const groups = useMemo(() => (all ? groupsOf(all, types) : new Map<string, DocNode[]>()), [all, types]);
  const corrected = useMemo(() => (all ? correctedBy(all, types) : new Map<string, string>()), [all, types]);
  const chosenCard = selected && (corrected.get(selected) ?? selected); // a correction is in the card of what it corrects
  const opened = all ? [...groups.keys()].filter(card => unfolded[card] === all.file) : [], open = opened.join();
  const doc = useMemo(() => all && fold(all, types, new Map([...groups].filter(([card]) => unfolded[card] !== all.file))), [all, types, groups, open]);
  useEffect(() => {
    const hidden = [...groups].filter(([card, nodes]) => !opened.includes(card) && nodes.some(n => n.name === selected)).map(([card]) => card);
    if (all && hidden.length) useStore.setState({ unfolded: { ...unfolded, ...Object.fromEntries(hidden.map(c => [c, all.file])) } });
  }, [all, groups, open, selected]);
  const lit = useStore(s => (s.price ? s.price.nodes.map(n => n.path) : Object.entries(s.nodes).filter(([, n]) => n.state === 'running').map(([p]) => p))
    .map(p => (s.scope && p.startsWith(s.scope + '/') ? `${s.scope}/${p.slice(s.scope.length + 1).split('/')[0]}` : p.split('/')[0])).join(' '));
  const notes = useStore(s => s.arrangement.notes), arranged = useStore(s => s.arrangement.places), thumbnails = useStore(s => s.thumbnails);
  const flow = useReactFlow<AnyNode>();
  const far = useFlow(s => s.transform[2] < 0.8);
  const nameSize = useFlow(s => Math.min(Math.ceil(kNames / Math.min(s.transform[2], 1)), kLargestName));
  const [overview, setOverview] = useState(false);
  const host = useRef<HTMLDivElement>(null), fitted = useRef(false); // the view shows what fits, and nobody moved it
  const moved = useRef<Places>({}), homes = useRef<Places>({}); // where a person put nodes, and where these were before
  const dragging = useRef(false); // with the pointer, not with keys
  const shown = useRef(''), drawn = useRef(''), small = useRef(thumbnails); // the file; the names of its nodes; as they were laid out
  const pointer = useRef<{ x: number; y: number } | null>(null); // over the canvas, if that is where the user works
  const [nodes, setNodes] = useState<AnyNode[]>([]);
  const [search, setSearch] = useState<SearchAt | null>(null);

  const loosen = useCallback(() => { fitted.current = false, delete host.current?.dataset.fitted; }, []);

  // Shows all of the graph if its names stay legible, else the part with the selected node, or the part from the left where most is.
  const fit = useCallback((duration = 0) => {
    const shown = flow.getNodes(), box = host.current, margin = 18;
    const width = (box?.clientWidth ?? 0) - 2 * margin, height = (box?.clientHeight ?? 0) - 2 * margin;
    if (!shown.length || width < 40 || height < 40) return;
    const bounds = flow.getNodesBounds(shown), zoom = Math.min(Math.max(Math.min(width / bounds.width, height / bounds.height), kLeastZoom), 1.2);
    const rects = shown.map(n => flow.getNodesBounds([n])), at = shown.findIndex(n => n.selected);
    const start = (from: number, size: number, view: number, center: number) =>
      size <= view ? from + (size - view) / 2 : Math.min(Math.max(center - view / 2, from), from + size - view);
    const x = start(bounds.x, bounds.width, width / zoom, at < 0 ? bounds.x : rects[at].x + rects[at].width / 2);
    const near = at < 0 ? rects.filter(r => r.x < x + width / zoom && r.x + r.width > x) : [rects[at]];
    const y = start(bounds.y, bounds.height, height / zoom, near.reduce((sum, r) => sum + r.y + r.height / 2, 0) / Math.max(near.length, 1));
    loosen();
    fitted.current = true;
    // Once the view is there, data-fitted says for what: the size of the canvas, and the number of its nodes.
    void flow.setViewport({ x: margin - x * zoom, y: margin - y * zoom, zoom }, { duration }).then(() => {
      if (fitted.current) box!.dataset.fitted = `${box!.clientWidth} ${box!.clientHeight} ${shown.length}`;
    });
  }, [flow]);
  const attach = useCallback((box: HTMLDivElement | null) => {
    host.current = box;
    if (!box) return;
    const observer = new ResizeObserver(() => { if (fitted.current) fit(); });
    observer.observe(box);
    return () => observer.disconnect();
  }, [fit]);
  const refit = useCallback(() => setTimeout(() => { if (fitted.current) fit(150); }, 60), [fit]); // once new cards are there
  useEffect(() => { refit(); }, [unfolded, refit]);

  const arrangeAll = useCallback((keep: boolean) => {
    if (!doc || countOf(doc) > kMostNodes) return;
    if (!keep) moved.current = {}, homes.current = {}, keepPlaces({});
    const at = layout(doc, types);
    setNodes(before => {
      // Nodes stay where they are. Others come beside the nodes that they are wired to, as they would in a new layout, or below what
      // is there already.
      const old = new Map(before.map(b => [b.id, b.position])), cardOf = (name: string) => [...groups].find(([, nodes]) => nodes.some(n => n.name === name))?.[0] ?? '';
      const placed = (n: DocNode) => moved.current[n.name] ?? (keep ? old.get(n.name) : undefined);
      const known = new Map(doc.nodes.flatMap(n => { const p = placed(n); return p ? [[n.name, p] as const] : []; }));
      const boxes = doc.nodes.filter(n => known.has(n.name)).map(n => { const { width: w, height: h } = nodeSize(n, types); return { ...known.get(n.name)!, w, h }; });
      const neighbors = old.size ? neighborsOf(doc, types) : null;
      for (const n of doc.nodes) {
        if (!known.size || known.has(n.name)) continue;
        const place = { ...at[n.name] }, { width: w, height: h } = nodeSize(n, types), beside = neighbors?.get(n.name)!.find(m => old.has(m) && known.has(m));
        const card = old.get(cardOf(n.name));
        if (card) place.x = card.x, place.y = card.y; // it was in the card
        else if (beside) place.x += known.get(beside)!.x - at[beside].x, place.y += known.get(beside)!.y - at[beside].y;
        for (let k = 0; k < 200 && boxes.some(t => place.x < t.x + t.w && t.x < place.x + w && place.y < t.y + t.h && t.y < place.y + h); ++k) place.y += 20;
        at[n.name] = place;
        known.set(n.name, place);
        boxes.push({ ...place, w, h });
      }
      return doc.nodes.map(n => {
        const size = nodeSize(n, types);
        const old = before.find(b => b.id === n.name);
        return {
          ...(old ?? {}), id: n.name, data: { node: n }, position: placed(n) ?? at[n.name],
          ...(isFolded(n.name) ? { type: 'folded' as const, selectable: false, draggable: false, deletable: false, focusable: false } : { type: 'node' as const }),
          selected: old ? old.selected : n.name === chosenCard, initialWidth: size.width, initialHeight: size.height,
          ariaLabel: isFolded(n.name) ? n.name.trim() : `Node ${n.name}, ${n.type || n.graph}`,
        } as AnyNode;
      });
    });
  }, [doc, types, groups]);

  useEffect(() => {
    if (!doc) return;
    const place = `${scope} ${doc.file}`, first = shown.current !== place;
    if (first) {
      // Saved under another name, the graph has the same nodes, and they stay where they are.
      const names = doc.nodes.map(n => n.name).join('\n'), same = shown.current && names === drawn.current;
      moved.current = readPlaces();
      shown.current = place;
      if (!same) homes.current = {}, setNodes([]); // another graph's nodes may have the same names
    }
    // Nodes that an edit adds come with their places. What else changed in the arrangement follows below.
    if (!first) moved.current = { ...readPlaces(), ...moved.current };
    drawn.current = doc.nodes.map(n => n.name).join('\n');
    const taller = small.current !== thumbnails && !Object.keys(moved.current).length;
    small.current = thumbnails;
    arrangeAll(!taller);
    if (first) setTimeout(fit, 60);
  }, [doc, types, arrangeAll, fit, thumbnails, scope]);

  // Another page moved nodes, or places were undone.
  useEffect(() => {
    if (!doc) return;
    const before = moved.current, now = placesOf(arranged), same = (a: Places, b: Places) => Object.entries(writtenPlaces(a)).every(([n, [x, y]]) => b[n] && Math.round(b[n].x) === x && Math.round(b[n].y) === y);
    if (same(before, now) && same(now, before)) return;
    const home = { ...layout(doc, types), ...homes.current };
    moved.current = now;
    setNodes(all => all.map(n => (now[n.id] ? { ...n, position: now[n.id] } : before[n.id] && home[n.id] ? { ...n, position: home[n.id] } : n)));
  }, [arranged]);

  // Of several nodes that are selected, the last one is shown.
  useEffect(() => setNodes(all => (all.some(n => n.selected && n.id === chosenCard) ? all
    : all.map(n => (!!n.selected === (n.id === chosenCard) ? n : { ...n, selected: n.id === chosenCard })))), [chosenCard]);

  const [noteNodes, setNoteNodes] = useState<NoteNode[]>([]);
  useEffect(() => setNoteNodes(before => (notes ?? []).map((note, k) => ({
    id: `note ${k}`, type: 'note' as const, data: { index: k, note }, position: { x: note.x, y: note.y }, width: note.width, height: note.height, zIndex: note.frame ? -1 : 0,
    selected: before[k]?.selected ?? false, ariaLabel: `${note.frame ? 'Frame' : 'Note'}: ${note.text}`,
  }))), [notes]);

  // A selected wire and a selected node at once would both be deleted, so a click on a wire selects nothing else.
  const [cuts, setCuts] = useState<ReadonlySet<string>>(new Set());
  const onEdgesChange = useCallback((changes: EdgeChange[]) => {
    for (const c of changes) if (c.type === 'select') setCuts(before => { const now = new Set(before); c.selected ? now.add(c.id) : now.delete(c.id); return now; });
  }, []);
  useEffect(() => setCuts(new Set()), [doc]);

  const wires = useMemo(() => (doc && countOf(doc) <= kMostNodes ? wiresOf(doc, types) : []), [doc, types]);
  const edges = useMemo(() => {
    const running = new Set(lit.split(' '));
    return wires.map(e => ({ ...e, selected: cuts.has(e.id), className: `${running.has(e.target) ? 'lit ' : ''}${e.source === chosenCard || e.target === chosenCard ? 'own' : ''}` }));
  }, [wires, lit, cuts, chosenCard]);

  const onNodesChange = useCallback((changes: NodeChange<AnyNode>[]) => {
    const isNote = (c: NodeChange<AnyNode>) => 'id' in c && c.id.startsWith('note ');
    setNodes(all => applyNodeChanges(changes.filter(c => c.type !== 'remove' && !isNote(c)), all));
    setNoteNodes(all => applyNodeChanges(changes.filter(c => c.type !== 'remove' && isNote(c)) as NodeChange<NoteNode>[], all));
    let places = false;
    for (const c of changes) {
      if (c.type === 'select' && c.selected && !isNote(c)) select(c.id);
      if (c.type !== 'position' || !c.position || c.dragging !== false || !shown.current) continue;
      if (isNote(c)) changeNote(Number(c.id.slice(5)), { x: c.position.x, y: c.position.y });
      else moved.current[c.id] = c.position, places = true;
    }
    if (places) keepPlaces(moved.current, dragging.current ? '' : 'keys');
  }, []);

  // A frame takes the nodes in it along.
  const held = useRef<{ from: { x: number; y: number }; nodes: Record<string, { x: number; y: number }> } | null>(null);
  const onNodeDragStart = (_: unknown, n: AnyNode, all: AnyNode[]) => {
    dragging.current = true;
    for (const m of all) if (!moved.current[m.id]) homes.current[m.id] = m.position;
    held.current = null;
    if (n.type !== 'note' || !n.data.note.frame) return;
    const { x, y } = n.position, w = n.width ?? 0, h = n.height ?? 0;
    const within = nodes.filter(m => !isFolded(m.id) && m.position.x >= x && m.position.y >= y && m.position.x + (m.measured?.width ?? 0) <= x + w && m.position.y + (m.measured?.height ?? 0) <= y + h);
    for (const m of within) if (!moved.current[m.id]) homes.current[m.id] = m.position;
    held.current = { from: n.position, nodes: Object.fromEntries(within.map(m => [m.id, m.position])) };
  };
  const onNodeDrag = (_: unknown, n: AnyNode) => {
    const h = held.current;
    if (h) setNodes(all => all.map(m => (h.nodes[m.id] ? { ...m, position: { x: h.nodes[m.id].x + n.position.x - h.from.x, y: h.nodes[m.id].y + n.position.y - h.from.y } } : m)));
  };
  const onNodeDragStop = (e: MouseEvent | TouchEvent, n: AnyNode) => {
    dragging.current = false;
    if (held.current) {
      for (const m of nodes) if (held.current.nodes[m.id]) moved.current[m.id] = m.position;
      held.current = null;
      return keepPlaces(moved.current);
    }
    const own = doc?.nodes.find(x => x.name === n.id);
    if (!doc || !own || locked || !('clientX' in e) || Object.keys(own.inputs).length || edges.some(w => w.source === n.id)) return;
    const box = document.querySelector(`.react-flow__node[data-id="${CSS.escape(n.id)}"]`)!.getBoundingClientRect();
    const edge = edges.find(w => w.id === wireAt(box.left + box.width / 2, box.top + box.height / 2)), edits = edge && insertion(own, edge, all!, types, sourceNode(edge.source, edge.sourceHandle));
    if (edits) void edit(edits);
  };

  const inputOf = (c: Connection | Edge) => {
    const node = doc?.nodes.find(n => n.name === c.target);
    return node && declarationOf(node, types)?.inputs.find(p => p.name === c.targetHandle);
  };
  const outputOf = (name: string, port: string | null | undefined) => {
    const node = doc?.nodes.find(n => n.name === name);
    return node && declarationOf(node, types)?.outputs.find(p => p.name === port);
  };
  const valid = (c: Connection | Edge) => {
    const input = inputOf(c), type = outputOf(c.source, c.sourceHandle)?.types[0];
    return !locked && c.source !== c.target && !!input && !!type && (!input.types.length || input.types.includes(type));
  };
  // What a card gives is what was measured after its corrections.
  const sourceNode = (name: string, port: string | null | undefined) => {
    const parts = doc?.nodes.find(n => n.name === name)?.parts ?? [];
    return [...parts].reverse().find(p => { const n = all?.nodes.find(x => x.name === p); return n && declarationOf(n, types)?.outputs.some(o => o.name === port); }) ?? name;
  };
  const withParts = useCallback((names: string[]) => names.flatMap(n => [n, ...doc?.nodes.find(x => x.name === n)?.parts ?? []]), [doc]);
  const connect = (c: Connection) => {
    const before = all?.nodes.find(n => n.name === c.target)?.inputs[c.targetHandle!] ?? []; // as written, not as drawn
    const wire = `${sourceNode(c.source, c.sourceHandle)}.${c.sourceHandle}`;
    void edit([{ op: 'connect', node: c.target, name: c.targetHandle!, wires: inputOf(c)?.many ? [...before, wire] : [wire] }]);
  };
  const remove = ({ nodes: some, edges: cut }: { nodes: AnyNode[]; edges: Edge[] }) => {
    const text = some.filter(n => n.type === 'note').map(n => n.data.index as number), gone = some.filter(n => n.type !== 'note');
    if (text.length) removeNotes(text);
    if (locked) return Promise.resolve(false);
    const edits = withParts(gone.map(n => n.id)).map(n => ({ op: 'remove', node: n }) as Parameters<typeof edit>[0][number]);
    for (const e of cut) {
      if (gone.some(n => n.id === e.source || n.id === e.target)) continue;
      const node = all?.nodes.find(n => n.name === e.target);
      const left = (node?.inputs[e.targetHandle!] ?? []).filter((_, k) => `${e.target}.${e.targetHandle}.${k}` !== e.id);
      edits.push({ op: 'connect', node: e.target, name: e.targetHandle!, wires: left });
    }
    if (edits.length) void edit(edits);
    return Promise.resolve(false); // the document's next event removes them
  };

  // A note where the pointer is, or a frame around the selected nodes.
  const write = (frame: boolean, here: { x: number; y: number } | null = null) => {
    const around = nodes.filter(n => n.selected);
    if (frame && around.length) {
      const x = Math.min(...around.map(n => n.position.x)) - 20, y = Math.min(...around.map(n => n.position.y)) - 40;
      const right = Math.max(...around.map(n => n.position.x + (n.measured?.width ?? nodeWidth))), bottom = Math.max(...around.map(n => n.position.y + (n.measured?.height ?? 80)));
      return addNote({ x, y, width: right - x + 20, height: bottom - y + 20, text: '', frame });
    }
    const at = flow.screenToFlowPosition(here ?? { x: window.innerWidth / 4, y: 160 });
    addNote({ ...at, width: frame ? 320 : 190, height: frame ? 200 : 70, text: '', frame });
  };

  // Copies are beside what they are copies of.
  const duplicate = useCallback(async (text: string) => {
    const first = await paste(text, writtenPlaces(Object.fromEntries(nodes.filter(n => n.type === 'node').map(n => [n.id, { x: n.position.x + 40, y: n.position.y + 40 }]))));
    if (first) setTimeout(() => select(first), 80);
  }, [nodes]);
  const showNode = useCallback((name: string) => {
    loosen();
    void flow.fitView({ nodes: [{ id: corrected.get(name) ?? name }], maxZoom: 1, duration: 150, padding: 0.4 });
  }, [flow, loosen, corrected]);
  // Moves the view as far as the node needs.
  const bringIntoView = (name: string) => {
    const card = document.querySelector(`.react-flow__node[data-id="${CSS.escape(name)}"]`)?.getBoundingClientRect(), box = host.current?.getBoundingClientRect(), margin = 16;
    if (!card || !box) return;
    const across = Math.max(box.left + margin - card.left, 0) || Math.min(box.right - margin - card.right, 0);
    const down = Math.max(box.top + margin - card.top, 0) || Math.min(box.bottom - margin - card.bottom, 0);
    if (!across && !down) return;
    loosen();
    const { x, y, zoom } = flow.getViewport();
    void flow.setViewport({ x: x + across, y: y + down, zoom });
  };
  const [menu, setMenu] = useState<{ name: string; x: number; y: number } | null>(null);

  useEffect(() => {
    const chosen = nodes.filter(n => n.selected && n.type === 'node').map(n => n.id);
    const find = (e: KeyboardEvent) => { // also from fields
      if (!(e.ctrlKey || e.metaKey) || e.altKey || e.shiftKey || !['f', 'k'].includes(e.key) || useStore.getState().starting) return;
      useStore.setState({ finding: 'all' });
      e.preventDefault();
    };
    const elsewhere = (e: Event) => useStore.getState().starting || e.target instanceof HTMLElement && e.target.closest('input, textarea, select, dialog, [role=dialog], [role=menu]');
    // Events of the clipboard need no permission.
    const copied = (e: ClipboardEvent) => {
      if (elsewhere(e) || !doc || !chosen.length || window.getSelection()?.toString()) return;
      e.clipboardData?.setData('text/plain', textOf(all!, withParts(chosen)));
      e.preventDefault();
    };
    const pasted = (e: ClipboardEvent) => {
      const text = e.clipboardData?.getData('text/plain');
      if (elsewhere(e) || locked || !text?.trim()) return;
      void duplicate(text);
      e.preventDefault();
    };
    const key = (e: KeyboardEvent) => {
      if (elsewhere(e)) return;
      if ((e.ctrlKey || e.metaKey) && !e.altKey && doc) {
        if (e.key === 'b' && chosen.length && !locked) bypass(chosen);
        else if (e.key === 'd' && chosen.length && !locked) void duplicate(textOf(all!, withParts(chosen)));
        else if (e.key === 'g' && chosen.length && !locked) useStore.setState({ grouping: withParts(chosen) });
        else return;
        return e.preventDefault();
      }
      if (e.ctrlKey || e.metaKey || e.altKey) return;
      if (e.key === '?') useStore.setState({ finding: 'keys' });
      else if (e.key === 'F2' && chosen.length === 1) rename(chosen[0]);
      else if (e.key === 'f') fit(150);
      else if (e.key === 'l') arrangeAll(false), refit();
      else if (e.key === 'a' && !locked) setSearch(pointer.current ?? { x: window.innerWidth / 3, y: 160 });
      // Tab moves the focus, except for users who work in the canvas with the pointer.
      else if (e.key === 'Tab' && !e.shiftKey && !locked && pointer.current) setSearch(pointer.current);
      else if (e.key === 'n') write(false, pointer.current);
      else if (e.key === 'Enter' && chosen.length === 1 && doc?.nodes.find(n => n.name === chosen[0])?.graph) void enter(chosen[0]);
      else if (e.key === 'Escape' && scope && !chosen.length) void enter(scope.split('/').slice(0, -1).join('/'));
      else return;
      e.preventDefault();
    };
    // Before the graph moves the selected node: arrows go to the next one. With Shift, they move it.
    const arrow = (e: KeyboardEvent) => {
      const at = e.target instanceof HTMLElement && e.target.closest<HTMLElement>('.react-flow__node')?.dataset.id;
      if (elsewhere(e) || e.shiftKey || e.ctrlKey || e.metaKey || e.altKey || !e.key.startsWith('Arrow')) return;
      if (!at && !(chosen.length === 1 && e.target instanceof HTMLElement && (e.target === document.body || e.target.closest('.canvas')))) return;
      const next = nextNode(nodes, at || chosen[0], e.key);
      e.preventDefault(), e.stopPropagation();
      if (!next) return;
      select(next);
      document.querySelector<HTMLElement>(`.react-flow__node[data-id="${CSS.escape(next)}"]`)?.focus({ preventScroll: true });
      bringIntoView(next);
    };
    window.addEventListener('keydown', arrow, true);
    window.addEventListener('keydown', find);
    window.addEventListener('keydown', key);
    window.addEventListener('copy', copied);
    window.addEventListener('paste', pasted);
    return () => {
      window.removeEventListener('keydown', arrow, true);
      window.removeEventListener('keydown', find);
      window.removeEventListener('keydown', key);
      window.removeEventListener('copy', copied);
      window.removeEventListener('paste', pasted);
    };
  }, [fit, refit, arrangeAll, doc, nodes, scope, locked, duplicate, all, withParts]);

  const slim = useFlow(s => s.width > 0 && s.width < 560);
  const tools = [
    ...(locked ? [] : [{ label: 'Note', keys: 'N', title: 'Write a note (N)', act: () => write(false) }, { label: 'Frame', title: 'A frame around the selected nodes', act: () => write(true) }]),
    { label: 'Pictures', title: 'Show pictures in the nodes', pressed: thumbnails, act: () => {
      keep('graph', { thumbnails: thumbnails ? 0 : 1 });
      useStore.setState({ thumbnails: !thumbnails });
    } },
  ] as { label: string; keys?: string; title: string; pressed?: boolean; act: () => void }[];
  const view = { label: 'Overview', title: 'Show where the view is in the graph', act: () => setOverview(!overview) };
  if (doc && countOf(doc) > kMostNodes)
    return <main className="canvas" aria-label="Graph"><p className="none">The graph has {countOf(doc).toLocaleString('en-US')} nodes, and this view shows up to {kMostNodes.toLocaleString('en-US')}. Edit it as text: press YAML.</p></main>;
  const steps = scope ? scope.split('/') : [], used = root?.nodes.find(n => n.name === scope)?.graph, users = used ? root!.nodes.filter(n => n.graph === used).length : 0;
  return (
    <main className={`canvas${far ? ' far' : ''}`} aria-label="Graph" onPointerMove={e => { pointer.current = { x: e.clientX, y: e.clientY }; }} onPointerLeave={() => { pointer.current = null; }} style={{ '--name': `${nameSize}px` } as React.CSSProperties}>
      <div className="tools" role="toolbar" aria-label="Graph">
        {scope ? (
          <nav aria-label="Subgraph"><button onClick={() => void enter('')}>{root?.name || 'Graph'}</button>
            {steps.map((name, k) => <span key={k}> › <button aria-current={k === steps.length - 1} onClick={() => void enter(steps.slice(0, k + 1).join('/'))}>{name}</button></span>)}
            <em> {doc?.file.split('/').pop()}, {locked ? 'read only' : 'saved with each change'}{users > 1 && `, used by ${users} nodes`}</em>
            {steps.length === 1 && <button className="primary" title="Replace the subgraph by copies of its nodes, which you can edit; Undo returns" onClick={() => void post('/api/expand', { node: scope }).then(done => { if (done) void enter(''); })}>Copy into this graph</button>}</nav>
        ) : null}
        {!locked && <button onClick={() => setSearch({ x: 140, y: 90 })} title="Add a node (A, or Tab over the canvas)">Add node</button>}
        <button onClick={() => { arrangeAll(false); refit(); }} title="Arrange all nodes (L)">Arrange</button>
        <button onClick={() => fit(150)} title="Show all nodes (F)">Fit</button>
        {!slim && tools.map(t => <button key={t.label} aria-pressed={t.pressed} title={t.title} onClick={t.act}>{t.label}</button>)}
        {opened.length > 0 && <button ref={takeFocus} onClick={() => { select(null); unfold(opened, ''); }} title="Show the nodes that write files, and those that check the result, as one card each">Fold</button>}
        <span className="right">{slim ? <MenuButton label="More to do with the graph" text="More" items={[...tools, view]} /> : <button aria-pressed={overview} title={view.title} onClick={view.act}>{view.label}</button>}
        <button aria-label="Zoom out" title="Zoom out" onClick={() => { loosen(); void flow.zoomOut(); }}>−</button>
        <button aria-label="Zoom in" title="Zoom in" onClick={() => { loosen(); void flow.zoomIn(); }}>+</button></span>
      </div>
      <div className="flow" ref={attach}>
      <ReactFlow<AnyNode>
        nodes={[...noteNodes, ...nodes]} edges={edges} nodeTypes={nodeTypes} onNodesChange={onNodesChange} onEdgesChange={onEdgesChange} onEdgeClick={() => select(null)} isValidConnection={valid} onConnect={connect}
        onNodeDragStart={onNodeDragStart} onNodeDrag={onNodeDrag} onNodeDragStop={onNodeDragStop} nodesConnectable={!locked} edgesFocusable={false}
        onNodeContextMenu={(e, n) => { if (n.type !== 'node') return; e.preventDefault(); if (!n.selected) select(n.id); setMenu({ name: n.id, x: e.clientX, y: e.clientY }); }}
        onNodeClick={(e, n) => { if (n.type === 'node' && !e.ctrlKey && !e.metaKey && !e.shiftKey) select(n.id); /* also from its corrections */ }}
        onNodeDoubleClick={(_, n) => { if (n.type === 'node' && n.data.node.graph) void enter(n.id); }}
        onBeforeDelete={remove} onPaneClick={() => select(null)} onMoveStart={e => { if (e) loosen(); }} deleteKeyCode={['Delete', 'Backspace']} colorMode="system"
        minZoom={0.1} maxZoom={2} proOptions={noPro} selectNodesOnDrag={false} nodeDragThreshold={2} onlyRenderVisibleElements={nodes.length > 80}
        onDoubleClick={e => !locked && (e.target as HTMLElement).classList.contains('react-flow__pane') && setSearch({ x: e.clientX, y: e.clientY })}
        zoomOnDoubleClick={false}
        onConnectEnd={(e, c) => {
          if (c.isValid || !c.fromNode || !('clientX' in e) || c.toNode || locked) return;
          const node = c.fromNode.id, port = c.fromHandle?.id ?? '', at = { x: e.clientX, y: e.clientY };
          if (c.fromHandle?.type === 'source') {
            const type = outputOf(node, port)?.types[0];
            if (type) setSearch({ ...at, from: { node: sourceNode(node, port), port, types: [type], many: false } });
          } else {
            const input = inputOf({ source: '', sourceHandle: null, target: node, targetHandle: port });
            if (input) setSearch({ ...at, to: { node, port, types: input.types, many: input.many } });
          }
        }}>
        <Background variant={BackgroundVariant.Dots} gap={22} size={1} />
        {overview && <MiniMap pannable zoomable ariaLabel="Overview of the graph" nodeBorderRadius={6} />}
      </ReactFlow>
      </div>
      {menu && <NodeMenu key={`${menu.name} ${menu.x} ${menu.y}`} menu={menu} chosen={withParts(nodes.filter(n => n.selected && n.type === 'node').map(n => n.id))} close={() => setMenu(null)} remove={name => void flow.deleteElements({ nodes: [{ id: name }] })}
        duplicate={name => { if (doc) void duplicate(textOf(all!, withParts([name]))); }} />}
      <Find show={showNode} />
      {search && <Search at={search} close={() => setSearch(null)} place={flow.screenToFlowPosition({ x: search.x, y: search.y })} />}
    </main>
  );
}
