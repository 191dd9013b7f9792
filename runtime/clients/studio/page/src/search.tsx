import { useMemo, useState } from 'react';

import { writtenPlaces } from './places';
import { shownDoc } from './states';
import { edit, fullName, select, useStore, type Edit } from './store';
import type { NodeType } from './types';

// Where the search opens, and the wire that the new node gets: from an output, or to an input.
type End = { node: string; port: string; types: string[]; many: boolean };
export interface SearchAt { x: number; y: number; from?: End; to?: End }

interface Props {
  at: SearchAt;
  close: () => void;
  place: { x: number; y: number }; // of the new node
}

const accepts = (types: string[], type: string) => !types.length || types.includes(type);
const snake = (type: string) => type.replace(/([a-z0-9])([A-Z])/g, '$1_$2').toLowerCase();

// What other programs call it.
const synonyms: Record<string, string> = {
  Adjust: 'levels curves hsv hsl hue saturation brightness contrast exposure gamma grayscale crop color', Blend: 'mix layer multiply screen overlay add composite over mask merge',
  Export: 'usd usda usdz gltf glb vdb openvdb png exr obj ply stl csv json save write file output', LoadImage: 'photo picture texture file input open import jpg png tiff exr raw',
  LoadMesh: 'gltf glb obj ply stl import model geometry', LoadVolume: 'vdb openvdb import grid dicom', Palette: 'hsv hue color ramp swatches recolor', Colorize: 'hsv hue recolor tint color',
  TextureSet: 'pbr maps albedo basecolor normal height roughness ao displacement material tileable', Bake: 'pbr maps uv normal albedo ao texture', RenderSolid: 'render camera viewport preview shader light',
  RenderVolume: 'render camera volume', Pack: 'scatter instances distribute physics', Anneal: 'scatter instances distribute', Shape: 'primitive sphere cube rock stone', Tessellate: 'voronoi cells fracture',
  Section: 'cut slice plane boolean', Carve: 'boolean mesh sculpt bake', Voxelize: 'sdf grid volume voxel', Pattern: 'noise procedural perlin marble wood', Segment: 'mask detect particles instances',
  Phases: 'threshold mask levels', EditLabels: 'mask paint correct', ContactSheet: 'grid montage collage', TextureNib: 'clone heal inpaint erase', DetailSolid: 'grunge detail noise', SolidOptimize: 'texture synthesis 3d',
  Distribution: 'histogram random size', Compare: 'difference statistics', View: 'preview photograph', MixShapes: 'switch random merge', MixDistributions: 'merge', Grain: 'film noise blur camera',
};

// Finds a node type by name or description and adds a node of it.
export function Search({ at, close, place }: Props) {
  const types = useStore(s => s.types);
  const [text, setText] = useState('');
  const [index, setIndex] = useState(0);
  const found = useMemo(() => {
    const words = text.toLowerCase().split(/\s+/).filter(Boolean);
    const fits = (t: NodeType) => (!at.from || t.inputs.some(p => accepts(p.types, at.from!.types[0]))) && (!at.to || t.outputs.some(p => accepts(at.to!.types, p.types[0])));
    const all = [...types.values()].filter(fits);
    // Formats and methods are in the source and in what parameters say. All words must be found; the worst one counts.
    const score = (t: NodeType) => {
      const n = t.type.toLowerCase(), doc = t.doc.toLowerCase(), other = synonyms[t.type] ?? '', also = [t.source, t.district, ...t.parameters.map(p => p.doc)].join(' ').toLowerCase();
      return Math.max(...words.map(q => (n.startsWith(q) ? 0 : ` ${other}`.includes(` ${q}`) ? 1 : n.includes(q) ? 2 : doc.includes(q) ? 3 : also.includes(q) ? 4 : 5)));
    };
    if (!words.length) return all; // by district, as the server lists them
    return all.filter(t => score(t) < 5).sort((a, b) => score(a) - score(b) || a.type.localeCompare(b.type)).slice(0, 60);
  }, [text, types, at.from, at.to]);

  const add = (type: string) => {
    const doc = shownDoc(useStore.getState()), taken = new Set(doc?.nodes.map(n => n.name.split('/').pop()));
    let name = snake(type);
    for (let k = 2; taken.has(name); ++k) name = `${snake(type)}_${k}`;
    const edits: Edit[] = [{ op: 'add', node: name, type }];
    const input = at.from && types.get(type)?.inputs.find(p => accepts(p.types, at.from!.types[0]));
    const output = at.to && types.get(type)?.outputs.find(p => accepts(at.to!.types, p.types[0]));
    const before = at.to?.many ? doc?.nodes.find(n => n.name === at.to!.node)?.inputs[at.to.port] ?? [] : [];
    if (output) edits.push({ op: 'connect', node: at.to!.node, name: at.to!.port, wires: [...before, `${name}.${output.name}`] });
    if (input) edits.push({ op: 'connect', node: name, name: input.name, wires: [`${at.from!.node}.${at.from!.port}`] });
    close();
    void edit(edits, false, writtenPlaces({ [name]: place })).then(done => done && setTimeout(() => select(fullName(name)), 50));
  };

  return (
    <div className="search" role="dialog" aria-label="Add a node" style={{ left: Math.min(at.x, window.innerWidth - 360), top: Math.min(at.y, window.innerHeight - 380) }}>
      <input autoFocus value={text} placeholder={at.from ? `Add a node that accepts ${at.from.types[0]}` : at.to ? `Add a node that makes ${at.to.types.join(' or ') || 'a value'}` : 'Add a node'} aria-label="Find a node type"
        onChange={e => { setText(e.target.value); setIndex(0); }} onBlur={e => { if (!e.currentTarget.parentElement?.contains(e.relatedTarget)) setTimeout(close, 150); }}
        onKeyDown={e => {
          if (e.key === 'Escape') close();
          if (e.key === 'ArrowDown') setIndex(i => Math.min(i + 1, found.length - 1)), e.preventDefault();
          if (e.key === 'ArrowUp') setIndex(i => Math.max(i - 1, 0)), e.preventDefault();
          if (e.key === 'Enter' && found[index]) add(found[index].type);
        }} />
      <ul role="listbox" aria-label="Node types" tabIndex={0}>
        {found.map((t, k) => [
          !text && t.district !== found[k - 1]?.district && <li key={`district ${t.district}`} className="district" role="presentation">{t.district || 'other'}</li>,
          <li key={t.type} role="option" aria-selected={k === index} className={k === index ? 'at' : ''} onPointerDown={e => { e.preventDefault(); add(t.type); }}
            ref={el => { if (k === index) el?.scrollIntoView({ block: 'nearest' }); }}>
            <b>{t.type}</b><span>{t.doc}</span>
          </li>,
        ])}
        {!found.length && <li className="none">No node type matches.</li>}
      </ul>
    </div>
  );
}
