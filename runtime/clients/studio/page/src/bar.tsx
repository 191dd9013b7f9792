import { WroteFiles } from './files';
import { secondsText } from './format';
import { MenuButton, useNarrow } from './menu';
import { progressText } from './progress';
import { Group, SaveAs, Share } from './start';
import { shownDoc } from './states';
import { change, post, priceText, save, showStart, useStore } from './store';
import { useProgress } from './waiting';

export function Bar() {
  const doc = useStore(s => s.doc), shown = useStore(shownDoc);
  const run = useStore(s => s.run);
  const online = useStore(s => s.online);
  const drawer = useStore(s => s.drawer);
  const failed = useStore(s => Object.values(s.nodes).filter(n => n.state === 'failed').length);
  const stale = useStore(s => Object.values(s.nodes).filter(n => n.state === 'stale' && n.reasons.length > 0).length);
  const errors = doc?.messages.filter(m => m.severity === 'error').length ?? 0;
  const price = useStore(s => s.price), progress = useProgress();
  const toggle = (d: 'yaml' | 'messages' | 'history' | 'files' | 'variants') => useStore.setState({ drawer: drawer === d ? 'none' : d, line: null });
  const panels = [
    { name: 'files', label: 'Files', title: 'The files that the graph writes' }, { name: 'variants', label: 'Variants', title: 'The result in view for several values of a parameter' },
    { name: 'history', label: 'History', title: 'Earlier states' }, { name: 'messages', label: `Messages${doc?.messages.length ? ` (${doc.messages.length})` : ''}`, title: 'Errors and warnings' },
    { name: 'yaml', label: 'YAML', title: 'The text of the file' },
  ] as const;
  const narrow = useNarrow(1180), small = useNarrow(800);
  const steps = [{ label: 'New or open…', act: () => void showStart() }, { label: 'Undo', keys: 'Ctrl+Z', act: () => void change('/api/undo') }, { label: 'Redo', keys: 'Ctrl+Shift+Z', act: () => void change('/api/redo') }];
  const status = !online ? 'not connected'
    : price && !run.running ? `would run: ${priceText(price)}`
    : errors ? `${errors} ${errors === 1 ? 'error' : 'errors'} in the graph`
    : run.running ? (progress.total ? progressText(progress) : `${run.unfinished.toLocaleString('en-US')} unfinished`)
    : failed ? `${failed} failed` : progress.canceled ? `canceled, ${progress.done} of ${progress.total} done`
    : stale ? `${run.live ? '' : 'paused, '}${stale} to run${run.expected > 0 ? `, about ${secondsText(run.expected)}` : ''}` : run.seconds ? `done in ${secondsText(run.seconds)}` : 'up to date';
  return (
    <header className="top">
      <h1 title={doc?.file}>{doc?.name || 'Terrazzo Studio'}</h1>
      <span className="file">{!small && doc?.file.split('/').pop()}{doc && !doc.saved && <em> edited</em>}</span>
      {!small && <button onClick={() => void showStart()} title="Open a graph or a material, or make one from a photograph">New or open…</button>}
      <div className="group">
        {!small && <><button disabled={!shown?.can_undo} onClick={() => void change('/api/undo')} title="Undo (Ctrl+Z)">Undo</button>
          <button disabled={!shown?.can_redo} onClick={() => void change('/api/redo')} title="Redo (Ctrl+Shift+Z)">Redo</button></>}
        <button disabled={!doc || (doc.saved && !doc.read_only)} onClick={save} title="Save (Ctrl+S)">Save</button>
        <MenuButton label="More to do with the file" text="More" items={[
          ...(small ? steps : []),
          { label: 'Save as…', act: () => useStore.setState({ savingAs: true, sharing: false }) },
          { label: 'Share…', act: () => useStore.setState({ sharing: true, savingAs: false, shared: '' }) },
        ]} />
      </div>
      {run.running && <div className="share" aria-hidden="true"><i style={{ width: `${100 * Math.min(progress.share, 0.99)}%` }} /></div>}
      <span className={`status ${errors || failed || !online ? 'bad' : run.running ? 'busy' : ''}`} role="status" title={status}>{status}</span>
      <button className={run.running ? '' : 'away'} onClick={() => void post('/api/cancel')}>Cancel</button>
      <label className="check" title="Evaluate after every change">
        <input type="checkbox" checked={run.live} onChange={e => void post('/api/live', { live: e.target.checked })} />Live
      </label>
      <button className="primary" disabled={!doc?.valid} onClick={() => void post('/api/run')} title="Evaluate everything and write the output files">Run and write files</button>
      {narrow ? <MenuButton label="Panels" text={panels.find(p => p.name === drawer)?.label ?? 'Panels'} items={panels.map(p => ({ label: p.label, act: () => toggle(p.name) }))} />
        : <div className="group">{panels.map(p => <button key={p.name} aria-pressed={drawer === p.name} title={p.title} onClick={() => toggle(p.name)}>{p.label}</button>)}</div>}
    </header>
  );
}

// Questions and problems that concern the whole document.
export function Notices() {
  const doc = useStore(s => s.doc);
  const trouble = useStore(s => s.trouble);
  const runTrouble = useStore(s => s.run.trouble);
  const savingAs = useStore(s => s.savingAs), sharing = useStore(s => s.sharing), grouping = useStore(s => s.grouping), shared = useStore(s => s.shared);
  const dismiss = () => useStore.setState({ trouble: null });
  return (
    <div className="notices" aria-live="polite">
      {savingAs && <SaveAs key={doc?.file} />}
      {grouping && <Group nodes={grouping} />}
      {sharing && <Share key={`share ${doc?.file}`} />}
      {shared && <p><b>Wrote {shared}</b><button onClick={() => useStore.setState({ shared: '' })}>Dismiss</button></p>}
      {doc?.recovered && (
        <p><b>An earlier session left unsaved changes.</b>
          <button onClick={() => void post('/api/recover', { use: true })}>Restore them</button>
          <button onClick={() => void post('/api/recover', { use: false })}>Discard them</button></p>
      )}
      {doc?.disk_changed && (
        <p><b>Another program changed the file.</b> You also have unsaved changes.
          <button onClick={() => void post('/api/reload')}>Load its version</button>
          <button onClick={() => void post('/api/save', { overwrite: true })}>Overwrite it</button></p>
      )}
      <WroteFiles />
      {doc?.trouble && <p>{doc.trouble}</p>}
      {runTrouble && <p>{runTrouble}</p>}
      {trouble && <p className="bad"><b>{trouble.message}</b> {trouble.hint}{trouble.again && <button onClick={trouble.again}>Open anyway</button>}<button onClick={dismiss}>Dismiss</button></p>}
    </div>
  );
}
