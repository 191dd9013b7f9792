import { ReactFlowProvider } from '@xyflow/react';
import flowStyle from '@xyflow/react/dist/style.css';
import { useEffect } from 'react';
import { createRoot } from 'react-dom/client';

import { Bar, Notices } from './bar';
import { Canvas } from './canvas';
import { Inspector } from './inspector';
import { PlaneBar } from './plane';
import { Splitter } from './splitter';
import { Start } from './start';
import { connect, declarationOf, nearest, post, previewOf, save, stateOf, useStore, valueOf } from './store';
import style from './style.css';
import { LabelsView } from './labels';
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
  const preview = node && previewOf(node, shown, nodes);
  const value = preview ?? (node && valueOf(node, shown, nodes));
  const kind = outputs.find(p => p.name === shown)?.types[0];
  const state = node && stateOf(node, nodes);
  const old = value && !preview && state && !['cached', 'computed'].includes(state.state);
  return (
    <section className="viewer" aria-label="Viewer">
      <div className="tabs">
        <b>{name ?? 'Viewer'}</b>
        {outputs.map(p => <button key={p.name} aria-pressed={p.name === shown} onClick={() => useStore.setState(pinned ? { pinned: { node: pinned.node, port: p.name } } : { port: p.name })}>{p.name}</button>)}
        <span className="space" />
        {preview && <span className="old">preview{state?.state === 'running' ? `, ${Math.round(100 * state.progress)} %` : ''}</span>}
        {old && <span className="old">{state.state}: earlier result</span>}
        {node && <button aria-pressed={!!pinned} title={pinned ? 'Follow the selection' : 'Keep showing this node'}
          onClick={() => useStore.setState({ pinned: pinned ? null : { node: node.name, port: shown } })}>{pinned ? 'Pinned' : 'Pin'}</button>}
      </div>
      <div className={`stage${old ? ' stale' : ''}`}>
        {node && (value?.type ?? kind) === 'Labels' ? <LabelsView value={value ?? nearest(node.name, 'Labels', 'up', { doc, types, nodes })?.value} node={node} />
          : value && node ? <View key={value.type} value={value} node={node} />
            : <p className="none">{!node ? 'Select a node to see its result.' : !outputs.length ? 'This node writes files and has no outputs.' : 'There is no result yet.'}</p>}
        {node?.type === 'Section' && <PlaneBar key={node.name} node={node} />}
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
      if (e.key === 's') save();
      else if (e.key === 'z' && !typing) void post(e.shiftKey ? '/api/redo' : '/api/undo');
      else if (e.key === 'Z' && !typing) void post('/api/redo');
      else return;
      e.preventDefault();
    };
    const over = (e: DragEvent) => { if (e.dataTransfer?.types.includes('Files')) e.preventDefault(); };
    const drop = (e: DragEvent) => {
      const picture = e.dataTransfer?.files[0];
      if (!picture) return;
      e.preventDefault();
      useStore.setState({ starting: true, picture });
    };
    window.addEventListener('keydown', key);
    window.addEventListener('dragover', over);
    window.addEventListener('drop', drop);
    return () => {
      window.removeEventListener('keydown', key);
      window.removeEventListener('dragover', over);
      window.removeEventListener('drop', drop);
    };
  }, []);
  const starting = useStore(s => s.starting);
  return (
    <div className="app">
      <Bar />
      <Notices />
      <div className="below">
        {starting && <Start />}
        <div className="body" inert={starting}>
          <div className="left"><Canvas />{drawer === 'yaml' && <Yaml />}{drawer === 'messages' && <Messages />}</div>
          <aside aria-label="Selected node"><Splitter /><Viewer /><Inspector /></aside>
        </div>
      </div>
    </div>
  );
}

createRoot(document.getElementById('root')!).render(<ReactFlowProvider><App /></ReactFlowProvider>);
