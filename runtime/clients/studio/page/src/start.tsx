import { useEffect, useMemo, useRef, useState } from 'react';

import { followed } from './follow';
import { shownDoc, valueOf } from './states';
import { type Advice, change, type Content, dropped, fullName, openBundle, openGraph, openMaterial, post, recommended, select, upload, useStore } from './store';

const stem = (name: string) => name.replace(/\.[^.]*$/, '').replace(/[*?[\]$/\\]/g, '_');

const CONTENTS: [Content, string][] = [['particles', 'particles, such as stones or grains'], ['phases', 'phases, such as pores or an alloy']];

// A graph for a photograph: what it shows, where its files go, and the size of a pixel.
function NewMaterial({ picture, folder }: { picture: File; folder: string }) {
  const [place, setPlace] = useState(stem(picture.name));
  const [pixel, setPixel] = useState('0.1');
  const [size, setSize] = useState<{ w: number; h: number } | null>(null);
  const [busy, setBusy] = useState(false);
  const [advice, setAdvice] = useState<Advice | null>(null);
  const [choice, setChoice] = useState<Content | null>(null);
  useEffect(() => {
    let current = true;
    setAdvice(null);
    setChoice(null);
    void recommended(picture).then(a => current && setAdvice(a));
    return () => { current = false; };
  }, [picture]);
  const content = choice ?? advice?.content;
  const url = useMemo(() => URL.createObjectURL(picture), [picture]);
  useEffect(() => () => URL.revokeObjectURL(url), [url]);
  useEffect(() => setPlace(stem(picture.name)), [picture]);
  const mm = Number(pixel);
  const create = async () => {
    if (!content) return;
    setBusy(true);
    await upload(picture, place, pixel, content);
    setBusy(false);
  };
  const another = <button type="button" autoFocus={advice?.refused} onClick={() => useStore.setState({ picture: null })}>Choose another picture</button>;
  if (advice?.refused)
    return <div className="new" role="alert"><div><h2>{picture.name}</h2><p className="bad">{advice.why}</p><p className="row">{another}</p></div></div>;
  return (
    <form className="new" onSubmit={e => { e.preventDefault(); void create(); }}>
      <img src={url} alt={`Photograph ${picture.name}`} onLoad={e => setSize({ w: e.currentTarget.naturalWidth, h: e.currentTarget.naturalHeight })}
        onError={e => { e.currentTarget.hidden = true; }} />
      <div>
        <h2>{picture.name}{size && `, ${size.w} × ${size.h} pixels`}</h2>
        <label>{'Size of a pixel '}<input value={pixel} inputMode="decimal" aria-describedby="extent" onChange={e => setPixel(e.target.value)} autoFocus />{' mm'}</label>
        <p id="extent" className={mm >= 1e-6 && mm <= 1e6 ? 'doc' : 'bad'} role="status">{!(mm >= 1e-6 && mm <= 1e6) ? `“${pixel}” is not a size: enter a number of mm above 0, such as 0.05.` : size ? `The photograph shows ${(size.w * mm).toPrecision(3)} × ${(size.h * mm).toPrecision(3)} mm of the material.` : 'The edge of a pixel on the material’s surface.'}</p>
        <fieldset>
          <legend>It shows</legend>
          {CONTENTS.map(([name, label]) => <label key={name}><input type="radio" name="content" checked={content === name} onChange={() => setChoice(name)} />{' ' + label}</label>)}
        </fieldset>
        <p className="doc" aria-live="polite">{!advice ? 'Looking at the picture…' : advice.content ? `Recommended: ${advice.content}. ${advice.why}` : advice.why}</p>
        <label>Folder {folder}/<input value={place} spellCheck={false} onChange={e => setPlace(e.target.value)} /></label>
        <p className="doc">The picture is copied there, beside the new graph. Existing files are not replaced.</p>
        <p className="row"><button className="primary" disabled={busy || !content || !(mm >= 1e-6 && mm <= 1e6)}>{busy ? 'Creating…' : 'Create the material'}</button>
          {another}</p>
      </div>
    </form>
  );
}

// What to work on: a photograph, or a material that comes with the program.
export function Start() {
  const info = useStore(s => s.start);
  const picture = useStore(s => s.picture);
  const file = useRef<HTMLInputElement>(null);
  const box = useRef<HTMLElement>(null);
  useEffect(() => box.current?.focus(), []);
  const close = () => (info?.welcome ? void openMaterial(info.materials[0].name) : useStore.setState({ starting: false }));
  return (
    <section className="start" role="dialog" aria-label="Start" tabIndex={-1} ref={box} onKeyDown={e => { if (e.key === 'Escape') close(); }}>
      <div>
        <div className="head"><h2>New material from a photograph</h2><button onClick={close}>{info?.welcome ? 'Skip' : 'Close'}</button></div>
        {picture && info ? <NewMaterial picture={picture} folder={info.folder} /> : (
          <div className="drop">
            <p>Drop a photograph of a cut surface here, or a bundle (a .zip or a folder), or</p>
            <button className="primary" autoFocus onClick={() => file.current?.click()}>Choose a photograph</button>
            <input ref={file} type="file" className="sr" tabIndex={-1} aria-label="Photograph" accept="image/*,.exr,.hdr,.tif,.tiff,.zip" onChange={e => { if (e.target.files?.[0]) dropped(e.target.files[0]); }} />
          </div>
        )}
        {!!info?.graphs.length && <>
          <h2>Graphs in {info.folder}</h2>
          <ul className="graphs" aria-label="Graphs">
            {info.graphs.map(g => <li key={g.file}><button onClick={() => void openGraph(g.file)}><b>{g.file}</b><time>{new Date(g.changed * 1000).toLocaleString([], { dateStyle: 'medium', timeStyle: 'short' })}</time></button></li>)}
          </ul>
        </>}
        {!!info?.bundles.length && <>
          <h2>Bundles in {info.folder}</h2>
          <ul className="materials" aria-label="Bundles">
            {info.bundles.map(b => (
              <li key={b.file}><button onClick={() => void openBundle(b.file)} title={`${b.file}${b.doc && `\n${b.doc}`}`}>
                {b.picture ? <img src={`/api/bundle_picture?${new URLSearchParams({ file: b.file })}`} alt="" /> : <i />}
                <b>{b.title}</b></button></li>
            ))}
          </ul>
        </>}
        <h2>Materials that come with Terrazzo</h2>
        <ul className="materials">
          {info?.materials.map(m => (
            <li key={m.name}><button onClick={() => void openMaterial(m.name)} title={m.doc}>
              {m.picture ? <img src={`/api/picture/${m.name}`} alt="" /> : <i />}
              <b>{m.title}</b></button></li>
          ))}
        </ul>
      </div>
    </section>
  );
}

// Where to save a graph under a new name.
export function SaveAs() {
  const doc = useStore(s => s.doc), folder = useStore(s => s.start?.folder ?? '');
  const [name, setName] = useState(() => {
    const file = doc?.file ?? '';
    return doc?.read_only || !file.startsWith(folder + '/') ? file.split('/').pop()! : file.slice(folder.length + 1).replace(/\.ya?ml$/, '_2.yaml');
  });
  const close = () => useStore.setState({ savingAs: false });
  return (
    <form className="save" onSubmit={e => { e.preventDefault(); void post('/api/save_as', { file: name }).then(done => done && close()); }}>
      <label>Save as {folder}/<input value={name} autoFocus spellCheck={false} size={40} onChange={e => setName(e.target.value)}
        onKeyDown={e => { if (e.key === 'Escape') close(); }} /></label>
      <button className="primary">Save</button><button type="button" onClick={close}>Cancel</button>
    </form>
  );
}

// Makes a subgraph of nodes.
export function Group({ nodes }: { nodes: string[] }) {
  const [name, setName] = useState('group'), close = () => useStore.setState({ grouping: null });
  const make = async () => {
    const local = nodes.map(n => n.split('/').pop()), at = useStore.getState().arrangement.places?.[nodes[0]];
    if (await change('/api/collapse', { nodes: local, name, places: at ? { [name]: at } : {} })) close(), setTimeout(() => select(fullName(name)), 50);
  };
  return (
    <form className="save" aria-label="Make a subgraph" onSubmit={e => { e.preventDefault(); void make(); }} onKeyDown={e => { if (e.key === 'Escape') close(); }}>
      <label>Make a subgraph of {nodes.length === 1 ? nodes[0].split('/').pop() : `${nodes.length} nodes`}, named <input value={name} autoFocus spellCheck={false} size={20} onFocus={e => e.target.select()} onChange={e => setName(e.target.value)} /></label>
      <button className="primary">Make it</button><button type="button" onClick={close}>Cancel</button>
      <em>A new file beside the graph has the nodes. Undo brings them back.</em>
    </form>
  );
}

// Writes the material as a bundle, with the picture in view.
export function Share() {
  const doc = useStore(s => s.doc), folder = useStore(s => s.start?.folder ?? '');
  const [name, setName] = useState(() => `${stem(doc?.file.split('/').pop() ?? 'material')}.zip`), [license, setLicense] = useState(''), [source, setSource] = useState('');
  const [busy, setBusy] = useState(false);
  const picture = useStore(s => {
    const at = followed(s), node = at && shownDoc(s)?.nodes.find(n => n.name === at.node);
    const value = node && valueOf(node, at!.port, s.nodes);
    return value?.type === 'Image' ? value.hash : '';
  });
  const close = () => useStore.setState({ sharing: false });
  const write = async () => {
    setBusy(true);
    const file = name.endsWith('.zip') ? name : `${name}.zip`;
    if (await post('/api/share', { file, license, source, picture })) useStore.setState({ sharing: false, shared: `${folder}/${file}` });
    else setBusy(false);
  };
  return (
    <form className="save" aria-label="Share" onSubmit={e => { e.preventDefault(); void write(); }} onKeyDown={e => { if (e.key === 'Escape') close(); }}>
      <label>Share as {folder}/<input value={name} autoFocus spellCheck={false} size={26} onChange={e => setName(e.target.value)} /></label>
      <label>License <input value={license} size={14} placeholder="such as CC BY 4.0" onChange={e => setLicense(e.target.value)} /></label>
      <label>Source <input value={source} size={22} placeholder="who took the pictures" onChange={e => setSource(e.target.value)} /></label>
      <button className="primary" disabled={busy || !doc?.valid}>{busy ? 'Writing…' : 'Write the bundle'}</button><button type="button" onClick={close}>Cancel</button>
      <em>{picture ? 'With the picture of the material' : 'Without a picture: none has been computed yet'}</em>
    </form>
  );
}
