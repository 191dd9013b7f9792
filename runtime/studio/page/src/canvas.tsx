import {
  applyNodeChanges, Background, BackgroundVariant, Controls, MiniMap, ReactFlow, useReactFlow, useStore as useFlow, type Connection, type Edge, type NodeChange,
} from '@xyflow/react';
import { useCallback, useEffect, useMemo, useRef, useState } from 'react';

import { copy, duplicate, paste } from './clipboard';
import { typeColor } from './format';
import { layout, nodeSize } from './layout';
import { NodeCard, type GraphNode } from './node';
import { Search } from './search';
import { declarationOf, edit, select, splitWire, useStore } from './store';
import type { Doc, NodeType } from './types';

const nodeTypes = { node: NodeCard };
const noPro = { hideAttribution: true };

const places = (file: string) => `terrazzo.places.${file}`;

const keepPlaces = (file: string, at: Record<string, { x: number; y: number }>) => localStorage.setItem(places(file), JSON.stringify(at));

function readPlaces(file: string): Record<string, { x: number; y: number }> {
  try {
    return JSON.parse(localStorage.getItem(places(file)) ?? '{}');
  } catch {
    return {};
  }
}

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
        });
      });
  return out;
}

const kMostNodes = 2000; // the layout of more takes minutes

export function Canvas() {
  const doc = useStore(s => s.doc);
  const types = useStore(s => s.types);
  const selected = useStore(s => s.selected);
  const lit = useStore(s => Object.entries(s.nodes).filter(([, n]) => n.state === 'running' || n.state === 'waiting').map(([p]) => p.split('/')[0]).join(' '));
  const flow = useReactFlow();
  const far = useFlow(s => s.transform[2] < 0.6);
  const moved = useRef<Record<string, { x: number; y: number }>>({});
  const shown = useRef(''), drawn = useRef(''); // the file; the names of its nodes
  const [nodes, setNodes] = useState<GraphNode[]>([]);
  const [search, setSearch] = useState<{ x: number; y: number; from?: { node: string; port: string; type: string } } | null>(null);

  const arrange = useCallback((keep: boolean) => {
    if (!doc || doc.nodes.length > kMostNodes) return;
    if (!keep) moved.current = {}, localStorage.removeItem(places(doc.file));
    const at = layout(doc, types);
    setNodes(before => doc.nodes.map(n => {
      const size = nodeSize(n, types);
      const old = before.find(b => b.id === n.name);
      return {
        ...(old ?? {}), id: n.name, type: 'node' as const, data: { node: n }, position: moved.current[n.name] ?? (keep && old ? old.position : at[n.name]), // nodes stay where they are
        selected: n.name === useStore.getState().selected, initialWidth: size.width, initialHeight: size.height,
        ariaLabel: `Node ${n.name}, ${n.type || n.graph}`,
      };
    }));
  }, [doc, types]);

  useEffect(() => {
    if (!doc) return;
    const first = shown.current !== doc.file;
    if (first) {
      // Saved under another name, the graph has the same nodes, and they stay where they are.
      const names = doc.nodes.map(n => n.name).join('\n'), same = shown.current && names === drawn.current;
      moved.current = { ...(same ? moved.current : {}), ...readPlaces(doc.file) };
      shown.current = doc.file;
      if (same) keepPlaces(doc.file, moved.current);
    }
    drawn.current = doc.nodes.map(n => n.name).join('\n');
    arrange(true);
    if (first) setTimeout(() => flow.fitView({ padding: 0.06 }), 60);
  }, [doc, types, arrange, flow]);

  useEffect(() => setNodes(all => all.map(n => (n.selected === (n.id === selected) ? n : { ...n, selected: n.id === selected }))), [selected]);

  const edges = useMemo(() => {
    const running = new Set(lit.split(' '));
    return doc && doc.nodes.length <= kMostNodes ? wiresOf(doc, types).map(e => ({ ...e, className: running.has(e.target) ? 'lit' : '' })) : [];
  }, [doc, types, lit]);

  const onNodesChange = useCallback((changes: NodeChange<GraphNode>[]) => {
    setNodes(all => applyNodeChanges(changes.filter(c => c.type !== 'remove'), all));
    for (const c of changes) {
      if (c.type === 'select' && c.selected) select(c.id);
      if (c.type === 'position' && c.position && c.dragging === false && shown.current) {
        moved.current[c.id] = c.position;
        keepPlaces(shown.current, moved.current);
      }
    }
  }, []);

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
    return c.source !== c.target && !!input && !!type && (!input.types.length || input.types.includes(type));
  };
  const connect = (c: Connection) => {
    const before = doc?.nodes.find(n => n.name === c.target)?.inputs[c.targetHandle!] ?? [];
    const wire = `${c.source}.${c.sourceHandle}`;
    void edit([{ op: 'connect', node: c.target, name: c.targetHandle!, wires: inputOf(c)?.many ? [...before, wire] : [wire] }]);
  };
  const remove = ({ nodes: gone, edges: cut }: { nodes: GraphNode[]; edges: Edge[] }) => {
    const edits = gone.map(n => ({ op: 'remove', node: n.id }) as Parameters<typeof edit>[0][number]);
    for (const e of cut) {
      if (gone.some(n => n.id === e.source || n.id === e.target)) continue;
      const node = doc?.nodes.find(n => n.name === e.target);
      const left = (node?.inputs[e.targetHandle!] ?? []).filter((_, k) => `${e.target}.${e.targetHandle}.${k}` !== e.id);
      edits.push({ op: 'connect', node: e.target, name: e.targetHandle!, wires: left });
    }
    if (edits.length) void edit(edits);
    return Promise.resolve(false); // the document's next event removes them
  };

  useEffect(() => {
    const chosen = nodes.filter(n => n.selected).map(n => n.id);
    const place = (names: Map<string, string>) => {
      for (const [from, to] of names) {
        const at = nodes.find(n => n.id === from)?.position;
        if (at) moved.current[to] = { x: at.x + 40, y: at.y + 40 };
      }
      keepPlaces(shown.current, moved.current);
      const first = [...names.values()][0];
      if (first) setTimeout(() => select(first), 80);
    };
    const key = (e: KeyboardEvent) => {
      if (e.target instanceof HTMLElement && e.target.closest('input, textarea, select, [role=dialog]')) return;
      if ((e.ctrlKey || e.metaKey) && !e.altKey && doc) {
        if (e.key === 'c' && chosen.length && !window.getSelection()?.toString()) copy(doc, chosen);
        else if (e.key === 'v') void paste(doc).then(place);
        else if (e.key === 'd' && chosen.length) void duplicate(doc, chosen).then(place);
        else return;
        return e.preventDefault();
      }
      if (e.ctrlKey || e.metaKey || e.altKey) return;
      if (e.key === 'f') void flow.fitView({ padding: 0.06, duration: 150 });
      else if (e.key === 'l') arrange(false);
      else if (e.key === 'a') setSearch({ x: window.innerWidth / 3, y: 160 });
      else return;
      e.preventDefault();
    };
    window.addEventListener('keydown', key);
    return () => window.removeEventListener('keydown', key);
  }, [flow, arrange, doc, nodes]);

  if (doc && doc.nodes.length > kMostNodes)
    return <main className="canvas" aria-label="Graph"><p className="none">The graph has {doc.nodes.length.toLocaleString('en-US')} nodes, and this view shows up to {kMostNodes.toLocaleString('en-US')}. Edit it as text: press YAML.</p></main>;
  return (
    <main className={`canvas${far ? ' far' : ''}`} aria-label="Graph">
      <ReactFlow<GraphNode>
        nodes={nodes} edges={edges} nodeTypes={nodeTypes} onNodesChange={onNodesChange} isValidConnection={valid} onConnect={connect}
        onBeforeDelete={remove} onPaneClick={() => select(null)} deleteKeyCode={['Delete', 'Backspace']} colorMode="system"
        minZoom={0.1} maxZoom={2} proOptions={noPro} selectNodesOnDrag={false} nodeDragThreshold={2} onlyRenderVisibleElements={nodes.length > 80}
        onDoubleClick={e => (e.target as HTMLElement).classList.contains('react-flow__pane') && setSearch({ x: e.clientX, y: e.clientY })}
        zoomOnDoubleClick={false}
        onConnectEnd={(e, c) => {
          if (c.isValid || !c.fromNode || c.fromHandle?.type !== 'source' || !('clientX' in e) || c.toNode) return;
          const type = outputOf(c.fromNode.id, c.fromHandle.id)?.types[0];
          if (type) setSearch({ x: e.clientX, y: e.clientY, from: { node: c.fromNode.id, port: c.fromHandle.id!, type } });
        }}>
        <Background variant={BackgroundVariant.Dots} gap={22} size={1} />
        <MiniMap pannable zoomable ariaLabel="Overview of the graph" nodeBorderRadius={6} />
        <Controls showInteractive={false} aria-label="Zoom" />
      </ReactFlow>
      <div className="tools">
        <button onClick={() => setSearch({ x: 140, y: 90 })} title="Add a node (A)">Add node</button>
        <button onClick={() => arrange(false)} title="Arrange all nodes (L)">Arrange</button>
        <button onClick={() => void flow.fitView({ padding: 0.06, duration: 150 })} title="Show all nodes (F)">Fit</button>
      </div>
      {search && <Search at={search} close={() => setSearch(null)} place={(name) => {
        moved.current[name] = flow.screenToFlowPosition({ x: search.x, y: search.y });
      }} />}
    </main>
  );
}
