import { useEffect, useState } from 'react';

import { bytesText } from './format';
import { declarationOf, shownDoc, splitWire, stateOf } from './states';
import { edit, post, select, useStore } from './store';
import type { Doc, DocNode, NodeState, NodeType } from './types';

interface Written { node: string; path: string; bytes?: number }
export interface Outputs { folder: string; files: Written[] }

export async function fetchOutputs(): Promise<Outputs | null> {
  const answer = await fetch('/api/outputs').catch(() => null);
  return answer?.ok ? await answer.json() as Outputs : null;
}

// The files that the graph writes, again after each change.
function useOutputs(): Outputs | null {
  const [outputs, setOutputs] = useState<Outputs | null>(null);
  const text = useStore(s => s.doc?.text), running = useStore(s => s.run.running);
  const wrote = useStore(s => Object.values(s.nodes).reduce((sum, n) => sum + (n.files.length && n.state === 'computed' ? n.files.length : 0), 0));
  useEffect(() => {
    let current = true;
    void fetchOutputs().then(o => current && o && setOutputs(o));
    return () => { current = false; };
  }, [text, running, wrote]);
  return outputs;
}

// The formats of a value, the usual one first.
const formats: Record<string, string[]> = {
  Image: ['png', 'jpg', 'tif', 'exr', 'hdr'], Labels: ['png', 'tif', 'exr'], Table: ['csv', 'json'], Profiles: ['csv', 'json'], SizeDistribution: ['csv', 'json'],
  KMatrix: ['csv', 'json'], Particles: ['glb', 'usda', 'xml', 'pbrt', 'lmp', 'csv', 'json'], Shapes: ['glb', 'obj', 'ply', 'stl', 'usda'],
  Volume: ['vdb', 'nvdb', 'vti', 'vtu', 'dream3d', 'nii.gz', 'npy', 'inp', 'tesr', 'foam', 'stl', 'msh'],
};
const titles: Record<string, string> = {
  glb: 'glTF', usda: 'OpenUSD', xml: 'Mitsuba 3', pbrt: 'pbrt-v4', vdb: 'OpenVDB', nvdb: 'NanoVDB', vti: 'VTK', vtu: 'VTK mesh', dream3d: 'DREAM.3D', 'nii.gz': 'NIfTI',
  npy: 'NumPy', inp: 'Abaqus', tesr: 'Neper', foam: 'OpenFOAM', lmp: 'LAMMPS', msh: 'Gmsh', exr: 'OpenEXR', mtlx: 'MaterialX',
};
export const formatOf = (path: string) => /\.(nii\.gz|[^./]+)$/.exec(path)?.[1] ?? '';

function offered(node: DocNode, doc: Doc, types: Map<string, NodeType>): string[] {
  const typeOf = (wire: string) => {
    const at = splitWire(wire, doc, types), source = doc.nodes.find(n => n.name === at.node);
    return source && declarationOf(source, types)?.outputs.find(p => p.name === at.port)?.types[0];
  };
  const found = Object.values(node.inputs).flat().map(typeOf);
  return formats[(found.includes('Particles') ? 'Particles' : found.length === 1 && found[0]) || ''] ?? [];
}

// The format of one file, which is the extension of its path.
function Format({ node, path }: { node: DocNode | undefined; path: string }) {
  const doc = useStore(shownDoc), types = useStore(s => s.types);
  const now = formatOf(path), written = String(node?.params.path?.value ?? '');
  const list = node && doc ? offered(node, doc, types) : [];
  if (!node || written.includes('${') || !list.includes(now)) return <span title={titles[now]}>{now.toUpperCase()}</span>;
  const change = (format: string) => void edit([{ op: 'set', node: node.name, name: 'path', value: `${written.slice(0, written.length - now.length)}${format}` }]);
  return <select value={now} aria-label={`Format of ${path}`} title={titles[now]} onChange={e => change(e.target.value)}>{list.map(f => <option key={f} value={f}>{f.toUpperCase()}{titles[f] ? `, ${titles[f]}` : ''}</option>)}</select>;
}

const upToDate = (s: NodeState | undefined) => s?.state === 'cached' || s?.state === 'computed';

function Row({ file, folder }: { file: Written; folder: string }) {
  const name = file.node.split(/[/[]/)[0], node = useStore(s => s.doc?.nodes.find(n => n.name === name));
  const state = useStore(s => (node ? stateOf(node, s.nodes) : undefined), (a, b) => a?.state === b?.state && a?.error === b?.error);
  const exists = file.bytes !== undefined;
  const busy = state?.state === 'running' || state?.state === 'waiting';
  const said = state?.state === 'running' ? 'writing…' : state?.state === 'waiting' ? 'queued' : state?.state === 'failed' ? state.error?.message ?? 'failed' : !exists ? 'not written yet' : upToDate(state) ? '' : 'may be older than the graph';
  return (
    <tr>
      <td><button className="link" title={`Select ${name}`} onClick={() => select(name)}>{file.path}</button></td>
      <td><Format node={node} path={file.path} /></td>
      <td className="n">{exists ? bytesText(file.bytes!) : ''}</td>
      <td className={state?.state === 'failed' ? 'bad' : 'warning'}>{said}</td>
      <td className="acts">
        {exists ? <a className="button" href={`/api/output?path=${encodeURIComponent(file.path)}`} download={file.path.split('/').pop()}>Download</a> : <span />}
        <button className="path" onClick={() => void copy(`${folder}/${file.path}`)} title={`Copy ${folder}/${file.path}`}>Copy path</button>
        <button disabled={busy} onClick={() => void post('/api/run', { targets: [file.node] })} title={`Compute what ${file.path} needs, and write it`}>Write</button>
      </td>
    </tr>
  );
}

async function copy(text: string) {
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    useStore.setState({ trouble: { message: 'the browser does not allow this page to copy', hint: text, code: 'clipboard' } });
  }
}

// Every file that the graph writes: what it is, where it is, and whether it is up to date.
export function Files() {
  const outputs = useOutputs(), valid = useStore(s => s.doc?.valid);
  if (!outputs) return <section className="drawer" aria-label="Files"><p className="none">Loading…</p></section>;
  const { folder, files } = outputs, there = files.filter(f => f.bytes !== undefined);
  return (
    <section className="drawer files" aria-label="Files">
      <p className="where"><b>{there.length} of {files.length} {files.length === 1 ? 'file' : 'files'}</b> in <code>{folder}</code>
        <button onClick={() => void copy(folder)}>Copy folder</button><span className="space" />
        <button className="primary" disabled={!valid || !files.length} onClick={() => void post('/api/run')} title="Evaluate everything and write the files">Write all</button></p>
      <div className="sheet" tabIndex={0} role="region" aria-label="Files that the graph writes">
        {files.length ? <table><thead><tr><th>name</th><th>format</th><th className="n">size</th><th>state</th><th><span className="sr">actions</span></th></tr></thead>
          <tbody>{files.map(f => <Row key={`${f.node} ${f.path}`} file={f} folder={folder} />)}</tbody></table>
          : <p className="none">The graph writes no files. Add an Export node and connect what it should write.</p>}
      </div>
    </section>
  );
}

// Says what the last evaluation wrote.
export function WroteFiles() {
  const [said, setSaid] = useState<{ count: number; folder: string } | null>(null);
  const running = useStore(s => s.run.running), file = useStore(s => s.doc?.file), listed = useStore(s => s.drawer === 'files');
  useEffect(() => setSaid(null), [file, running]);
  useEffect(() => {
    if (running) return;
    let current = true;
    const timer = setTimeout(() => { // the last nodes report with the next frame
      const wrote = Object.values(useStore.getState().nodes).filter(upToDate).reduce((sum, n) => sum + n.files.length, 0);
      if (wrote) void fetchOutputs().then(o => current && o && setSaid({ count: wrote, folder: o.folder }));
    }, 200);
    return () => { current = false; clearTimeout(timer); };
  }, [running]);
  if (!said || listed) return null;
  return <p><b>{said.count} {said.count === 1 ? 'file' : 'files'} in {said.folder}</b>
    <button onClick={() => { useStore.setState({ drawer: 'files' }); setSaid(null); }}>Show</button>
    <button onClick={() => void copy(said.folder)}>Copy folder</button><button onClick={() => setSaid(null)}>Dismiss</button></p>;
}
