import { ReactFlowProvider } from '@xyflow/react';
import flowStyle from '@xyflow/react/dist/style.css';
import { useEffect } from 'react';
import { createRoot } from 'react-dom/client';

import { Bar, Notices } from './bar';
import { Canvas } from './canvas';
import { Inspector } from './inspector';
import { Splitter } from './splitter';
import { connect, declarationOf, post, stateOf, useStore, valueOf } from './store';
import style from './style.css';
import { View } from './viewers';
import { Messages, Yaml } from './yaml';

// Constructed style sheets, because the page's policy allows no inline styles.
for (const text of [flowStyle, style]) {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(text);
  document.adoptedStyleSheets.push(sheet);
}

function Viewer() {
  const doc = useStore(s => s.doc), types = useStore(s => s.types), nodes = useStore(s => s.nodes);
  const pinned = useStore(s => s.pinned), selected = useStore(s => s.selected), port = useStore(s => s.port);
  const name = pinned?.node ?? selected;
  const node = doc?.nodes.find(n => n.name === name);
  const outputs = (node && declarationOf(node, types)?.outputs) ?? [];
  const shown = pinned?.port ?? port ?? outputs[0]?.name ?? '';
  const value = node && valueOf(node, shown, nodes);
  const state = node && stateOf(node, nodes);
  const old = value && state && !['cached', 'computed'].includes(state.state);
  return (
    <section className="viewer" aria-label="Viewer">
      <div className="tabs">
        <b>{name ?? 'Viewer'}</b>
        {outputs.map(p => <button key={p.name} aria-pressed={p.name === shown} onClick={() => useStore.setState(pinned ? { pinned: { node: pinned.node, port: p.name } } : { port: p.name })}>{p.name}</button>)}
        <span className="space" />
        {old && <span className="old">{state.state}: earlier result</span>}
        {node && <button aria-pressed={!!pinned} title={pinned ? 'Follow the selection' : 'Keep showing this node'}
          onClick={() => useStore.setState({ pinned: pinned ? null : { node: node.name, port: shown } })}>{pinned ? 'Pinned' : 'Pin'}</button>}
      </div>
      <div className={`stage${old ? ' stale' : ''}`}>
        {value && node ? <View key={value.type} value={value} node={node.name} />
          : <p className="none">{!node ? 'Select a node to see its result.' : !outputs.length ? 'This node writes files and has no outputs.' : 'There is no result yet.'}</p>}
      </div>
    </section>
  );
}

function App() {
  const drawer = useStore(s => s.drawer);
  const title = useStore(s => (s.doc ? `${s.doc.saved ? '' : '• '}${s.doc.name || s.doc.file.split('/').pop()}` : ''));
  useEffect(() => { if (title) document.title = `${title} – Terrazzo Studio`; }, [title]);
  useEffect(() => {
    void connect();
    if (location.search) history.replaceState(null, '', '/'); // the token is in the cookie now
    const key = (e: KeyboardEvent) => {
      if (!(e.ctrlKey || e.metaKey)) return;
      const typing = e.target instanceof HTMLElement && e.target.closest('input:not([type=range]):not([type=checkbox]), textarea');
      if (e.key === 's') void post('/api/save');
      else if (e.key === 'z' && !typing) void post(e.shiftKey ? '/api/redo' : '/api/undo');
      else if (e.key === 'Z' && !typing) void post('/api/redo');
      else return;
      e.preventDefault();
    };
    window.addEventListener('keydown', key);
    return () => window.removeEventListener('keydown', key);
  }, []);
  return (
    <div className="app">
      <Bar />
      <Notices />
      <div className="body">
        <div className="left"><Canvas />{drawer === 'yaml' && <Yaml />}{drawer === 'messages' && <Messages />}</div>
        <aside aria-label="Selected node"><Splitter /><Viewer /><Inspector /></aside>
      </div>
    </div>
  );
}

createRoot(document.getElementById('root')!).render(<ReactFlowProvider><App /></ReactFlowProvider>);
