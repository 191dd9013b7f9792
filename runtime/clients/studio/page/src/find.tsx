// Finds nodes and commands by name (Ctrl+F, Ctrl+K), and shows the keys (?).
import { useEffect, useMemo, useRef, useState } from 'react';

import { shownDoc } from './states';
import { change, post, save, select, showStart, useStore } from './store';

interface Entry { name: string; what: string; act: () => void }

const drawer = (name: 'files' | 'variants' | 'history' | 'messages' | 'yaml') => () => useStore.setState({ drawer: name, line: null });
const commands: Entry[] = [
  ['New or open', () => void showStart()], ['Save', save], ['Save as', () => useStore.setState({ savingAs: true })], ['Share', () => useStore.setState({ sharing: true, shared: '' })],
  ['Undo', () => void change('/api/undo')], ['Redo', () => void change('/api/redo')], ['Run and write files', () => void post('/api/run')], ['Cancel', () => void post('/api/cancel')],
  ['Files', drawer('files')], ['Variants', drawer('variants')], ['History', drawer('history')], ['Messages', drawer('messages')], ['YAML', drawer('yaml')],
  ['Wide viewer', () => useStore.setState(s => ({ wide: !s.wide }))], ['Keys', () => useStore.setState({ finding: 'keys' })],
].map(([name, act]) => ({ name: name as string, what: 'command', act: act as () => void }));

// `show`: brings a node into view.
export function Find({ show }: { show: (node: string) => void }) {
  const finding = useStore(s => s.finding), doc = useStore(shownDoc);
  const [text, setText] = useState(''), [index, setIndex] = useState(0);
  const close = () => useStore.setState({ finding: '' });
  useEffect(() => { setText(''), setIndex(0); }, [finding]);
  const found = useMemo(() => {
    const q = text.trim().toLowerCase();
    const nodes: Entry[] = (doc?.nodes ?? []).map(n => ({ name: n.name, what: n.type || n.graph, act: () => { select(n.name), show(n.name); } }));
    const score = (e: Entry) => { const n = e.name.toLowerCase(); return n.startsWith(q) ? 0 : n.includes(q) ? 1 : e.what.toLowerCase().includes(q) ? 2 : 3; };
    return [...nodes, ...commands].filter(e => score(e) < 3).sort((a, b) => score(a) - score(b)).slice(0, 40);
  }, [text, doc, show]);
  if (finding !== 'all') return finding === 'keys' ? <Keys close={close} /> : null;
  const go = (e: Entry | undefined) => { if (e) close(), e.act(); };
  return (
    <div className="search find" role="dialog" aria-label="Find" style={{ left: Math.max(20, window.innerWidth / 2 - 170), top: 70 }}>
      <input autoFocus value={text} placeholder="Find a node or a command" aria-label="Find a node or a command" onChange={e => { setText(e.target.value), setIndex(0); }}
        onBlur={e => { if (!e.currentTarget.parentElement?.contains(e.relatedTarget)) setTimeout(close, 150); }}
        onKeyDown={e => {
          if (e.key === 'Escape') close();
          else if (e.key === 'ArrowDown') setIndex(i => Math.min(i + 1, found.length - 1));
          else if (e.key === 'ArrowUp') setIndex(i => Math.max(i - 1, 0));
          else if (e.key === 'Enter') go(found[index]);
          else return;
          e.preventDefault();
        }} />
      <ul role="listbox" aria-label="Nodes and commands" tabIndex={0}>
        {found.map((f, k) => <li key={`${f.what} ${f.name}`} role="option" aria-selected={k === index} className={k === index ? 'at' : ''} onPointerDown={e => { e.preventDefault(), go(f); }}
          ref={el => { if (k === index) el?.scrollIntoView({ block: 'nearest' }); }}><b>{f.name}</b><span>{f.what}</span></li>)}
        {!found.length && <li className="none">Nothing has this name.</li>}
      </ul>
    </div>
  );
}

const keys: [string, string][] = [
  ['Ctrl+F, Ctrl+K', 'find a node or a command'], ['Ctrl+S', 'save'], ['Ctrl+Z, Ctrl+Shift+Z', 'undo, redo'], ['A', 'add a node'], ['F2', 'rename the selected node'],
  ['Ctrl+B', 'bypass'], ['Ctrl+G', 'make a subgraph of the selected nodes'], ['Arrows, Shift+arrows', 'in the graph: go to the next node, move the selected ones'], ['Ctrl+D', 'duplicate'], ['Ctrl+C, Ctrl+V', 'copy, paste'], ['Delete', 'remove nodes or a wire'], ['Enter, Escape', 'open a subgraph, go back'],
  ['N', 'write a note'], ['F, L', 'show all nodes, arrange them'], ['B, M, S, D, O, I', 'with labels: pick the binder, merge, split, delete, outline, ignore'],
  ['Arrows, +, −, 0', 'in a 3D view: turn (with Shift: the light), zoom, start again'], ['?', 'this list'],
];

function Keys({ close }: { close: () => void }) {
  const dialog = useRef<HTMLDialogElement>(null);
  useEffect(() => dialog.current?.showModal(), []);
  return (
    <dialog ref={dialog} className="keys" aria-label="Keys" onClose={close}>
      <div className="head"><h2>Keys</h2><button onClick={close}>Close</button></div>
      <table><tbody>{keys.map(([k, what]) => <tr key={k}><td>{k}</td><td>{what}</td></tr>)}</tbody></table>
    </dialog>
  );
}
