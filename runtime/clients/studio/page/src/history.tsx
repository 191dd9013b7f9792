import { useEffect, useState } from 'react';

import { mainPicture } from './follow';
import { numberText } from './format';
import { hasThumbnail, Thumbnail } from './peek';
import { placeOf, shownDoc } from './states';
import { post, useStore } from './store';
import type { NodeState, OutputValue, Past } from './types';

interface Entry { number: number; changed: string; when: number; output?: OutputValue }

// Measures that differ between two states, with both values.
function differences(past: Past, nodes: Record<string, NodeState>): { name: string; before: number | undefined; now: number | undefined }[] {
  const out: { name: string; before: number | undefined; now: number | undefined }[] = [];
  for (const path of new Set([...Object.keys(past.nodes), ...Object.keys(nodes)])) {
    const a = past.nodes[path]?.metrics ?? {}, b = nodes[path]?.metrics ?? {};
    for (const m of new Set([...Object.keys(a), ...Object.keys(b)])) if (a[m] !== b[m]) out.push({ name: `${path}.${m}`, before: a[m], now: b[m] });
  }
  return out;
}

const clock = (when: number) => new Date(when * 1000).toLocaleTimeString([], { hour: '2-digit', minute: '2-digit', second: '2-digit' });
const text = (v: number | undefined) => (v === undefined ? '–' : numberText(v));

// States after earlier evaluations. One of them can be compared with what is there now, and taken back.
export function History() {
  const [list, setList] = useState<Entry[]>([]);
  const doc = useStore(s => s.doc), run = useStore(s => s.run), nodes = useStore(s => s.nodes), reference = useStore(s => s.reference);
  const main = useStore(s => { // what shows the material
    const at = mainPicture(s), node = at && shownDoc(s)?.nodes.find(n => n.name === at.node), place = node && placeOf(node, at!.port, s.nodes);
    return place ? `node=${encodeURIComponent(place.path)}&port=${place.port}` : '';
  });
  useEffect(() => {
    let current = true;
    void fetch(`/api/history?${main}`).then(a => a.json()).then((l: Entry[]) => current && setList(l)).catch(() => {});
    return () => { current = false; };
  }, [doc?.text, run.running, main]);
  const compare = async (e: Entry) => {
    const answer = await fetch(`/api/history/${e.number}`), past = await answer.json();
    if (answer.ok) useStore.setState({ reference: { label: `the state of ${clock(e.when)}`, past: past as Past } });
    else useStore.setState({ trouble: past });
  };
  const past = reference?.past, differ = past ? differences(past, nodes) : [];
  return (
    <section className="drawer history" aria-label="History">
      <ol className="states" tabIndex={0} aria-label="Earlier states">
        {[...list].reverse().map((e, k) => (
          <li key={e.number} aria-current={past?.number === e.number}>
            {hasThumbnail(e.output) && <Thumbnail value={e.output!} most={160} />}<div><time>{clock(e.when)}</time><span title={e.changed}>{e.changed || (k === list.length - 1 ? 'as opened' : 'lines removed')}{k === 0 && <em> now</em>}</span></div>
            <button aria-pressed={past?.number === e.number} onClick={() => (past?.number === e.number ? useStore.setState({ reference: null }) : void compare(e))} title="Compare results and measures with this state">Compare</button>
            <button onClick={() => void post('/api/restore', { number: e.number })} title="Go back to this state, also in subgraphs; Undo returns">Restore</button>
          </li>
        ))}
        {!list.length && <li className="none">States appear here when an evaluation ends.</li>}
      </ol>
      <div className="differ" tabIndex={0} role="region" aria-label="Differences">
        {!past ? <p className="none">Compare with a state to see which measures differ. The viewer then shows both results; drag the line between them.</p>
          : differ.length ? <table><thead><tr><th>measure</th><th>before</th><th>now</th><th>change</th></tr></thead>
            <tbody>{differ.map(d => <tr key={d.name}><td>{d.name.replace(/_/g, ' ')}</td><td className="n">{text(d.before)}</td><td className="n">{text(d.now)}</td>
              <td className="n">{d.before && d.now !== undefined ? `${d.now > d.before ? '+' : ''}${numberText(Number((100 * (d.now / d.before - 1)).toPrecision(3)))} %` : ''}</td></tr>)}</tbody></table>
            : <p className="none">All measures are equal.</p>}
      </div>
    </section>
  );
}
