import { ReactFlowProvider } from '@xyflow/react';
import flowStyle from '@xyflow/react/dist/style.css';
import { useEffect } from 'react';
import { createRoot } from 'react-dom/client';

import { loadAhead } from './ahead';
import { Bar, Notices } from './bar';
import { Canvas } from './canvas';
import { Files } from './files';
import { Inspector } from './inspector';
import { History } from './history';
import { Splitter } from './splitter';
import { Start } from './start';
import { change, connect, dropped, save, useStore } from './store';
import style from './style.css';
import { VariantsPanel } from './variants';
import { Viewer } from './viewer';
import { Messages, Yaml } from './yaml';
import { zipOfFolder } from './zip';

// Constructed style sheets, because the page's policy allows no inline styles.
for (const text of [flowStyle, style]) {
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(text);
  document.adoptedStyleSheets.push(sheet);
}

function App() {
  const drawer = useStore(s => s.drawer), file = useStore(s => s.doc?.file);
  const title = useStore(s => (s.doc ? `${s.doc.saved ? '' : '• '}${s.doc.name || s.doc.file.split('/').pop()}` : ''));
  useEffect(() => { if (title) document.title = `${title} – Terrazzo Studio`; }, [title]);
  useEffect(() => {
    void connect();
    const stop = loadAhead();
    if (location.search) history.replaceState(null, '', '/'); // the token is in the cookie now
    const key = (e: KeyboardEvent) => {
      if (!(e.ctrlKey || e.metaKey)) return;
      const typing = e.target instanceof HTMLElement && e.target.closest('input:not([type=range]):not([type=checkbox]), textarea');
      if (e.key === 's') save();
      else if (e.key === 'z' && !typing) void change(e.shiftKey ? '/api/redo' : '/api/undo');
      else if (e.key === 'Z' && !typing) void change('/api/redo');
      else return;
      e.preventDefault();
    };
    const over = (e: DragEvent) => { if (e.dataTransfer?.types.includes('Files')) e.preventDefault(); };
    const drop = (e: DragEvent) => {
      const file = e.dataTransfer?.files[0];
      if (!file) return;
      e.preventDefault();
      const entry = e.dataTransfer?.items[0]?.webkitGetAsEntry?.();
      if (entry?.isDirectory) void zipOfFolder(entry as FileSystemDirectoryEntry).then(dropped);
      else dropped(file);
    };
    window.addEventListener('keydown', key);
    window.addEventListener('dragover', over);
    window.addEventListener('drop', drop);
    return () => {
      stop();
      window.removeEventListener('keydown', key);
      window.removeEventListener('dragover', over);
      window.removeEventListener('drop', drop);
    };
  }, []);
  const starting = useStore(s => s.starting), wide = useStore(s => s.wide);
  return (
    <div className="app">
      <Bar />
      <Notices />
      <div className="below">
        {starting && <Start />}
        <div className={`body${wide ? ' wide' : ''}`} inert={starting}>
          <div className="left"><Canvas />{drawer === 'yaml' && <Yaml />}{drawer === 'messages' && <Messages />}{drawer === 'history' && <History />}{drawer === 'files' && <Files />}{drawer === 'variants' && <VariantsPanel key={file} />}</div>
          <aside aria-label="Selected node"><Splitter /><Viewer /><Inspector /></aside>
        </div>
      </div>
    </div>
  );
}

createRoot(document.getElementById('root')!).render(<ReactFlowProvider><App /></ReactFlowProvider>);
