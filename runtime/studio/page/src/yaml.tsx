import { useEffect, useRef, useState } from 'react';

import { goToLine, post, select, useStore } from './store';

const lineHeight = 18;

export function Yaml() {
  const text = useStore(s => s.doc?.text ?? '');
  const messages = useStore(s => s.doc?.messages);
  const file = useStore(s => s.doc?.file);
  const line = useStore(s => s.line);
  const [draft, setDraft] = useState<string | null>(null);
  const area = useRef<HTMLTextAreaElement>(null), gutter = useRef<HTMLPreElement>(null);
  const shown = draft ?? text;
  const bad = new Map(messages?.filter(m => m.file === file).map(m => [m.line, m]));

  useEffect(() => {
    const at = area.current;
    if (!line || !at) return;
    const start = at.value.split('\n').slice(0, line - 1).reduce((n, l) => n + l.length + 1, 0);
    const end = at.value.indexOf('\n', start);
    at.focus();
    at.setSelectionRange(start, end < 0 ? at.value.length : end);
    at.scrollTop = Math.max(0, (line - 5) * lineHeight);
  }, [line]);

  const apply = async () => {
    if (draft !== null && (draft === text || await post('/api/text', { text: draft }))) setDraft(null);
  };
  return (
    <section className="drawer" aria-label="YAML text">
      <div className="yaml">
        <pre ref={gutter} aria-hidden="true">
          {shown.split('\n').map((_, k) => <div key={k} className={bad.has(k + 1) ? bad.get(k + 1)!.severity : ''} title={bad.get(k + 1)?.message}>{k + 1}</div>)}
        </pre>
        <textarea ref={area} value={shown} spellCheck={false} wrap="off" aria-label="Text of the graph file"
          onScroll={e => { if (gutter.current) gutter.current.scrollTop = e.currentTarget.scrollTop; }}
          onChange={e => setDraft(e.target.value)}
          onKeyDown={e => { if (e.key === 'Enter' && (e.ctrlKey || e.metaKey)) void apply(); }} />
      </div>
      {draft !== null && draft !== text && (
        <p className="actions"><button className="primary" onClick={() => void apply()} title="Ctrl+Enter">Apply</button>
          <button onClick={() => setDraft(null)}>Discard</button></p>
      )}
    </section>
  );
}

export function Messages() {
  const doc = useStore(s => s.doc);
  const nodes = useStore(s => s.nodes);
  const run = Object.entries(nodes).flatMap(([path, n]) => [
    ...(n.error ? [{ ...n.error, node: path }] : []),
    ...n.warnings.map(w => ({ severity: 'warning', message: w, hint: '', node: path, line: 0, file: '', parameter: '' })),
  ]);
  const all = [...(doc?.messages ?? []), ...run];
  return (
    <section className="drawer" aria-label="Messages">
      <ul className="messages" tabIndex={0} aria-label="Messages">
        {all.map((m, k) => (
          <li key={k} className={m.severity}>
            <button className="link" onClick={() => select(m.node.split(/[/[]/)[0] || null)}>{m.node || 'graph'}{m.parameter && `.${m.parameter}`}</button>
            <span>{m.message}{m.hint && <em> {m.hint}</em>}</span>
            {m.line > 0 && m.file === doc?.file && <button className="link" onClick={() => goToLine(m.line)}>line {m.line}</button>}
          </li>
        ))}
        {!all.length && <li className="none">No messages.</li>}
      </ul>
    </section>
  );
}
