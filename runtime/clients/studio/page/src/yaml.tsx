import { useEffect, useMemo, useRef, useState } from 'react';
import { flushSync } from 'react-dom';

import { shownDoc } from './states';
import { change, goToLine, select, useStore } from './store';

const lineHeight = 18;

function countLines(text: string): number {
  let n = 1;
  for (let at = text.indexOf('\n'); at >= 0; at = text.indexOf('\n', at + 1)) ++n;
  return n;
}

// Where a line begins.
function startOf(text: string, line: number): number {
  let at = 0;
  for (let k = 1; k < line; ++k) {
    const end = text.indexOf('\n', at);
    if (end < 0) break;
    at = end + 1;
  }
  return at;
}

export function Yaml() {
  const text = useStore(s => shownDoc(s)?.text ?? '');
  const messages = useStore(s => s.doc?.messages);
  const file = useStore(s => shownDoc(s)?.file);
  const line = useStore(s => s.line);
  const [draft, setDraft] = useState<string | null>(null), [base, setBase] = useState(''); // base: the text that the draft began with
  const area = useRef<HTMLTextAreaElement>(null), gutter = useRef<HTMLPreElement>(null);
  const [top, setTop] = useState(0); // the first line in view
  const shown = draft ?? text;
  const bad = useMemo(() => new Map(messages?.filter(m => m.file === file).map(m => [m.line, m])), [messages, file]);
  const lines = useMemo(() => countLines(shown), [shown]);
  // Only the numbers in view are drawn: a text may have a hundred thousand lines.
  const first = Math.max(0, top - 20), numbers = Array.from({ length: Math.max(0, Math.min(lines, first + 100) - first) }, (_, k) => first + k + 1);

  useEffect(() => {
    const at = area.current;
    if (!line || !at) return;
    const start = startOf(at.value, line.number);
    const end = at.value.indexOf('\n', start);
    at.focus();
    at.setSelectionRange(start, end < 0 ? at.value.length : end);
    at.scrollTop = Math.max(0, (line.number - 5) * lineHeight);
  }, [line]);

  const apply = async () => {
    if (draft !== null && (draft === text || await change('/api/text', { text: draft }))) setDraft(null);
  };
  return (
    <section className="drawer" aria-label="YAML text">
      <div className="yaml">
        <pre ref={gutter} aria-hidden="true" style={{ minWidth: `calc(${String(lines).length}ch + 18px)` }}>
          <div style={{ height: first * lineHeight }} />
          {numbers.map(n => <div key={n} className={bad.get(n)?.severity ?? ''} title={bad.get(n)?.message}>{n}</div>)}
          <div style={{ height: (lines - first - numbers.length) * lineHeight }} />
        </pre>
        <textarea ref={area} value={shown} spellCheck={false} wrap="off" aria-label="Text of the graph file"
          onScroll={e => {
            const y = e.currentTarget.scrollTop;
            flushSync(() => setTop(Math.floor(y / lineHeight)));
            if (gutter.current) gutter.current.scrollTop = y;
          }}
          onChange={e => {
            if (draft === null) setBase(text);
            setDraft(e.target.value);
          }}
          onKeyDown={e => { if (e.key === 'Enter' && (e.ctrlKey || e.metaKey)) void apply(); }} />
      </div>
      {draft !== null && draft !== text && (
        <p className="actions">{base !== text && <span className="warning" role="status">The graph has changed since you began to type; Apply replaces that.</span>}<button className="primary" onClick={() => void apply()} title="Ctrl+Enter">Apply</button>
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
