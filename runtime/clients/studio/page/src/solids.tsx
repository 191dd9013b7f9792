// Shapes, particles and volumes in three dimensions.
import { Plane, Vector3 } from 'three';
import { useEffect, useMemo, useRef, useState, type KeyboardEvent, type ReactNode } from 'react';

import { particleBodies, readParticles, readShapes, shapeBodies, voxelBlock, type Bodies, type ParticleTable } from './bodies';
import { numberText } from './format';
import { Wipe } from './images';
import { fetchBytes, fetchJson, useLoaded, useReference } from './load';
import { SavePicture } from './save_picture';
import { nearest, shownDoc, splitWire, valueOf } from './states';
import { useStore } from './store';
import { hasWebGL, Stage, type Content } from './stage';
import { look, setLook, surroundings } from './studio_light';
import type { DocNode, OutputValue } from './types';

export const webGL = hasWebGL();
export const noWebGL = 'This browser has no WebGL, so the program renders a picture.';

export interface VolumeHead { size: [number, number, number]; spacing: [number, number, number]; grids: GridHead[] }
// range: of a quantity; shown: without outliers; most: what four fifths of its numbers are below.
export interface GridHead { name: string; type: string; range?: [number, number]; shown?: [number, number]; most?: number }

// Of a volume, or of the one before until the new one is there: `value` is the one that the head belongs to.
export const useHead = (value: OutputValue | undefined) => useLoaded(String(value?.hash), async () => (value ? { value, head: await fetchJson<VolumeHead>(value.hash, 'head') } : null));
export const edgesOf = (h: VolumeHead) => new Vector3(...h.size.map((n, k) => n * h.spacing[k]) as [number, number, number]);

// What a page draws at once: fewer triangles for each particle if there are many.
const trianglesFor = (count: number) => Math.round(Math.min(Math.max(420000 / Math.max(count, 1), 24), 4000));

// The shapes of particles: what a consumer of both reads with them, or the nearest ones.
export function useShapesOf(node: DocNode, value: OutputValue | undefined): OutputValue | null {
  const doc = useStore(s => s.doc), inside = useStore(s => s.inside), types = useStore(s => s.types), nodes = useStore(s => s.nodes);
  return useMemo(() => {
    const shown = shownDoc({ doc, inside });
    if (!shown || !value) return null;
    const own = Object.values(nodes[node.name]?.outputs ?? {}).find(o => o.type === 'Shapes');
    if (own) return own;
    for (const n of shown.nodes) {
      if (!n.inputs.shapes || !(n.inputs.particles ?? []).some(w => splitWire(w, shown, types).node === node.name)) continue;
      const at = splitWire(n.inputs.shapes[0], shown, types), source = shown.nodes.find(x => x.name === at.node), found = source && valueOf(source, at.port, nodes);
      if (found) return found;
    }
    return nearest(node.name, 'Shapes', 'up', { doc, inside, types, nodes })?.value ?? null;
  }, [node, value, doc, inside, types, nodes]);
}

export interface Solid { content: Content; bodies?: Bodies; table?: ParticleTable; level?: (v: number) => void; shapes?: { triangles: number; full: number }[]; note: string }

export async function loadParticles(value: OutputValue, shapes: OutputValue | null): Promise<Solid> {
  const table = readParticles(await fetchBytes(value.hash, 'as=particles'));
  const meshes = shapes && readShapes(await fetchBytes(shapes.hash, `as=meshes&most=${Math.max(16, trianglesFor(table.count))}`));
  const bodies = particleBodies(table, meshes);
  const rough = meshes?.some(m => m.full > m.triangles);
  return { content: bodies, bodies, table, note: `${table.count.toLocaleString('en-US')} particles${rough ? ', with simplified shapes' : meshes ? '' : ', as spheres of their size'}` };
}

export async function loadVolume(value: OutputValue, head: VolumeHead, grid: string, most: number): Promise<Solid> {
  const range = head.grids.find(g => g.name === grid)?.shown;
  const block = voxelBlock(await fetchBytes(value.hash, `as=voxels&grid=${encodeURIComponent(grid)}&most=${most}&lo=${range?.[0] ?? 0}&hi=${range?.[1] ?? 1}`), edgesOf(head), !!range);
  return { content: block, level: block.setLevel, note: block.factor > 1 ? `reduced from ${head.size.join(' × ')} voxels; slices show all` : `${head.size.join(' × ')} voxels` };
}

async function loadShapes(value: OutputValue): Promise<Solid> {
  const shapes = readShapes(await fetchBytes(value.hash, 'as=meshes&most=6000'));
  return { content: shapeBodies(shapes), shapes, note: `${shapes.length} ${shapes.length === 1 ? 'shape' : 'shapes'}` };
}

// Keeps a Stage and shows what was loaded. Each content is disposed of when it is replaced.
export function StageView({ solid, before, plane, onPlane, onPick, label, children }: {
  solid: Solid | null; before?: Solid | null; plane?: Plane | null; onPlane?: (p: Plane) => void; onPick?: (hit: ReturnType<Stage['pick']>) => void; label: string; children?: ReactNode;
}) {
  const host = useRef<HTMLDivElement>(null), stage = useRef<Stage | null>(null);
  const [share, setShare] = useState(0.5), [, redraw] = useState(0);
  const light = (surrounding: number, roughness: number) => { setLook(surrounding, roughness), redraw(n => n + 1); };
  const down = useRef<[number, number] | null>(null);
  useEffect(() => {
    const made = new Stage(host.current!);
    stage.current = made;
    return () => { made.dispose(); stage.current = null; };
  }, []);
  useEffect(() => {
    stage.current?.show(solid?.content ?? null);
    return () => { stage.current?.show(null); solid?.content.dispose(); };
  }, [solid]);
  useEffect(() => {
    stage.current?.show(before?.content ?? null, 1);
    return () => { stage.current?.show(null, 1); before?.content.dispose(); };
  }, [before]);
  useEffect(() => { if (stage.current) stage.current.onPlane = onPlane ?? null; });
  useEffect(() => { stage.current?.cut(plane ?? null); }, [plane, solid, before]);
  useEffect(() => { stage.current?.wipe(share); }, [share]);
  useEffect(() => { stage.current?.draw(); });
  const key = (e: KeyboardEvent) => {
    const s = stage.current, turns: Record<string, [number, number]> = { ArrowLeft: [-10, 0], ArrowRight: [10, 0], ArrowUp: [0, 10], ArrowDown: [0, -10] };
    if (!s || e.target !== e.currentTarget) return;
    if (turns[e.key]) e.shiftKey ? s.turnLight(...turns[e.key]) : s.turn(...turns[e.key]);
    else if (e.key === '+' || e.key === '=') s.zoom(1 / 1.2);
    else if (e.key === '-') s.zoom(1.2);
    else if (e.key === '0' && solid) s.lookAt(solid.content.box, new Vector3(-0.55, -1, 0.62));
    else return;
    e.preventDefault(), e.stopPropagation();
  };
  return (
    <div className="stage3d" ref={host} tabIndex={0} role="group" aria-label={`${label}. Drag to turn, wheel to zoom, right button to pan, Shift to turn the light; with keys: arrows, plus, minus, 0`} onKeyDown={key}
      onPointerDownCapture={e => { down.current = [e.clientX, e.clientY]; }}
      onPointerUp={e => {
        const from = down.current;
        down.current = null;
        if (from && onPick && e.button === 0 && e.target instanceof HTMLCanvasElement && Math.hypot(e.clientX - from[0], e.clientY - from[1]) < 4) onPick(stage.current?.pick(e.clientX, e.clientY) ?? null);
      }}
      onDoubleClick={() => { if (solid) stage.current?.lookAt(solid.content.box, new Vector3(-0.55, -1, 0.62)); }}>
      <SavePicture canvases={() => (stage.current ? [stage.current.picture()] : [])} />
      {before && <Wipe share={share} set={setShare} label="before" />}
      <div className="look" onPointerDown={e => e.stopPropagation()} onDoubleClick={e => e.stopPropagation()}>
        <select aria-label="Light" title="What lights the solid" value={look.surrounding.value} onChange={e => light(Number(e.target.value), look.roughness.value)}>
          {surroundings.map((name, k) => <option key={name} value={k}>{name}</option>)}</select>
        {look.surrounding.value > 0 && <label>Roughness <input type="range" min={0} max={1} step={0.01} value={look.roughness.value} onChange={e => light(look.surrounding.value, Number(e.target.value))} /></label>}
      </div>
      {children}
    </div>
  );
}

function Row({ table, at }: { table: ParticleTable; at: number }) {
  const p = table.position(at), c = table.color(at);
  return (
    <dl className="picked">
      {[['particle', String(at + 1)], ['size', `${numberText(table.size(at))} mm`], ['position', p.toArray().map(v => v.toFixed(2)).join(', ') + ' mm'], ['shape', String(table.shape(at) + 1)], ['color', `sRGB ${c.join(' ')}`]]
        .map(([k, v]) => <div key={k}><dt>{k}</dt><dd>{v}</dd></div>)}
    </dl>
  );
}

export function ParticlesView({ value, node }: { value: OutputValue; node: DocNode }) {
  const shapes = useShapesOf(node, value), reference = useReference(node, value);
  const { data, error } = useLoaded(`${value.hash}.${shapes?.hash}`, () => loadParticles(value, shapes));
  const before = useLoaded(`${reference?.hash}.${shapes?.hash}`, async () => (reference ? loadParticles(reference, shapes) : null)).data;
  const [picked, setPicked] = useState(-1), [cut, setCut] = useState(0);
  const box = data?.content.box;
  const plane = useMemo(() => (box && cut > 0 ? new Plane(new Vector3(0, 1, 0), -cut * box.y) : null), [box, cut]);
  useEffect(() => {
    if (!data?.bodies) return;
    const weights = picked >= 0 && picked < data.table!.count ? new Float32Array(data.table!.count) : null;
    if (weights) weights[picked] = 1;
    data.bodies.weigh(weights);
  }, [data, picked]);
  if (error) return <p className="none">{error}</p>;
  return (
    <>
      <StageView key="particles" solid={data} before={reference ? before : null} plane={plane} label="Particles" onPick={hit => setPicked(hit && data?.bodies ? data.bodies.particleOf(hit.object, hit.instance) : -1)}>
        {data?.table && picked >= 0 && picked < data.table.count && <Row table={data.table} at={picked} />}
      </StageView>
      <div className="options"><span>{data?.note ?? 'Loading…'}{data && '; click one'}</span>
        <label className="wide">Cut <input type="range" min={0} max={0.98} step={0.01} value={cut} onChange={e => setCut(Number(e.target.value))} /></label></div>
    </>
  );
}

export function ShapesView({ value, node }: { value: OutputValue; node: DocNode }) {
  const reference = useReference(node, value);
  const { data, error } = useLoaded(value.hash, () => loadShapes(value));
  const before = useLoaded(String(reference?.hash), async () => (reference ? loadShapes(reference) : null)).data;
  const [picked, setPicked] = useState(-1);
  const meta = useLoaded(`${value.hash}.meta`, () => fetchJson<{ shapes: Record<string, unknown>[] | { shown: Record<string, unknown>[] } }>(value.hash, 'summary')).data;
  if (error) return <p className="none">{error}</p>;
  const list = Array.isArray(meta?.shapes) ? meta.shapes : meta?.shapes?.shown, row = list?.[picked];
  return (
    <>
      <StageView solid={data} before={reference ? before : null} label="Shapes" onPick={hit => setPicked(hit && data ? (data.content as ReturnType<typeof shapeBodies>).shapeOf(hit.object) : -1)}>
        {row && <dl className="picked">{Object.entries(row).filter(([, v]) => typeof v !== 'object').map(([k, v]) => <div key={k}><dt>{k.replace(/_/g, ' ')}</dt><dd>{typeof v === 'number' ? numberText(v) : String(v)}</dd></div>)}</dl>}
      </StageView>
      <div className="options"><span>{data?.note ?? 'Loading…'}{data && '; click one'}</span></div>
    </>
  );
}
