import { useEffect, useMemo, useState } from 'react';

import { densities, DistributionPlot, useDistribution, type Distribution } from './distribution';
import { fetchJson, useLoaded } from './load';
import type { Kernel } from './matrix';
import { OutlinesPane, useOutlines, type Outlines } from './profiles';
import { fetchRaster } from './raster';
import { RenderedView } from './rendered';
import { loadParticles, StageView, useShapesOf, webGL } from './solids';
import { declarationOf, nearest, shownDoc, valueOf } from './states';
import { useStore, type Target } from './store';
import type { DocNode, OutputValue } from './types';

type Brush = { kind: 'profiles' | 'classes' | 'particles'; items: number[] };

// The value of a type that belongs to a node: its own, or the nearest one upstream or downstream.
function useAround(node: DocNode, type: string): { target: Target; value: OutputValue } | null {
  const doc = useStore(s => s.doc), inside = useStore(s => s.inside), types = useStore(s => s.types), nodes = useStore(s => s.nodes);
  return useMemo(() => {
    for (const p of declarationOf(node, types)?.outputs ?? []) {
      const value = valueOf(node, p.name, nodes);
      if (value?.type === type) return { target: { node: node.name, port: p.name }, value };
    }
    const s = { doc, inside, types, nodes };
    return nearest(node.name, type, 'up', s) ?? nearest(node.name, type, 'down', s);
  }, [node, type, doc, inside, types, nodes]);
}

const classOf = (d: Distribution, size: number) => {
  const n = d.class_edges.length - 1;
  for (let i = 0; i < n; ++i) if (size <= d.class_edges[i + 1]) return size >= d.class_edges[i] ? i : -1;
  return n - 1;
};

// The probability that a profile of class i comes from a particle of class j, which the K matrix and the densities give (Bayes). The
// matrix has classes of its own, of equal width.
function originOf(kernel: Kernel, d: Distribution): number[][] {
  const n = d.class_edges.length - 1, most = kernel.classes, density = densities(d), largest = d.class_edges[n];
  const sum = Array.from({ length: most }, (_, i) => Array.from({ length: most }, (_, j) => kernel.shapes.reduce((s, e) => s + e.probability * e.K[i][j], 0)));
  const at = (c: number) => Math.min(Math.max(Math.floor(((d.class_edges[c] + d.class_edges[c + 1]) / 2 / largest) * most), 0), most - 1);
  return Array.from({ length: n }, (_, i) => {
    const row = density.map((v, j) => Math.max(v, 0) * sum[at(i)][at(j)]), total = row.reduce((s, v) => s + v, 0);
    return row.map(v => (total > 0 ? v / total : 0));
  });
}

interface Weights { profiles: Map<number, number> | null; classes: number[] | null; particles: Float32Array | null }

// What a brush in one view means in the others, as weights from 0 to 1.
function weigh(brush: Brush | null, outlines: Outlines | null, d: Distribution | null, kernel: Kernel | null, sizes: Float32Array | null): Weights {
  if (!brush?.items.length || !d) return { profiles: null, classes: null, particles: null };
  const n = d.class_edges.length - 1, density = densities(d), total = density.reduce((s, v) => s + v, 0) || 1;
  const origin = kernel ? originOf(kernel, d) : null;
  const diameter = (area: number) => Math.sqrt((4 * area) / Math.PI), chosen = new Set(brush.items);
  const classes = new Array<number>(n).fill(0);
  if (brush.kind === 'profiles') {
    const found = new Array<number>(n).fill(0);
    for (const p of outlines?.profiles ?? []) {
      const i = chosen.has(p.index) ? classOf(d, diameter(p.area)) : -1;
      if (i >= 0 && origin) origin[i].forEach((v, j) => { found[j] += v; });
      else if (i >= 0) found[i] += 1;
    }
    // Relative to how many particles a class has, since large ones are met more often.
    found.forEach((v, j) => { classes[j] = density[j] > 0 ? v / (density[j] / total) : 0; });
    const most = Math.max(...classes, 1e-300);
    classes.forEach((v, j) => { classes[j] = v / most; });
  } else if (brush.kind === 'classes') brush.items.forEach(j => { classes[j] = 1; });
  else for (const i of brush.items) { const j = sizes ? classOf(d, sizes[i]) : -1; if (j >= 0) classes[j] = 1; }
  const profiles = new Map<number, number>();
  for (const p of outlines?.profiles ?? []) {
    const i = classOf(d, diameter(p.area));
    if (brush.kind === 'profiles') profiles.set(p.index, chosen.has(p.index) ? 1 : 0);
    else profiles.set(p.index, i < 0 ? 0 : origin ? origin[i].reduce((s, v, j) => s + v * classes[j], 0) : classes[i]);
  }
  // The likeliest ones are full, so that differences can be seen.
  const likeliest = Math.max(...profiles.values(), 1e-300);
  for (const [index, weight] of profiles) profiles.set(index, weight / likeliest);
  const particles = sizes && sizes.map((size, i) => (brush.kind === 'particles' ? (chosen.has(i) ? 1 : 0) : classes[classOf(d, size)] ?? 0));
  return { profiles, classes, particles };
}

// Profiles, size classes and particles in one view. A profile names no particle, but its size says which classes it may come from.
export function LinkedView({ node }: { node: DocNode }) {
  const profiles = useAround(node, 'Profiles'), sizes = useAround(node, 'SizeDistribution'), matrix = useAround(node, 'KMatrix'), bodies = useAround(node, 'Particles');
  const owner = useStore(s => shownDoc(s)?.nodes.find(n => n.name === bodies?.target.node)), shapes = useShapesOf(owner ?? node, bodies?.value);
  const outlines = useOutlines(profiles?.value).data, distribution = useDistribution(sizes?.value).data;
  const kernel = useLoaded(String(matrix?.value.hash), async () => (matrix ? fetchJson<Kernel>(matrix.value.hash, 'json') : null)).data;
  const solid = useLoaded(`${bodies?.value.hash}.${shapes?.hash}`, async () => (bodies && webGL ? loadParticles(bodies.value, shapes) : null));
  const photo = useStore(s => (profiles ? nearest(profiles.target.node, 'Image', 'up', s)?.value.hash : undefined));
  const under = useLoaded(String(photo), async () => (photo ? fetchRaster(photo, 'pixels', 0) : null)).data;
  const [brush, setBrush] = useState<Brush | null>(null), [hovered, setHovered] = useState(-1);
  const table = solid.data?.table;
  const particleSizes = useMemo(() => (table ? Float32Array.from({ length: table.count }, (_, i) => table.size(i)) : null), [table]);
  const weights = useMemo(() => weigh(brush, outlines, distribution, kernel, particleSizes), [brush, outlines, distribution, kernel, particleSizes]);
  useEffect(() => { solid.data?.bodies?.weigh(weights.particles); }, [solid.data, weights]);
  const drawable = outlines && outlines.window[0] > 0 && outlines.profiles.some(p => p.points.length);
  const said = !brush?.items.length ? 'Drag a rectangle over profiles, or click a profile, a bar or a particle.'
    : brush.kind === 'profiles' ? `${brush.items.length} profiles: bars and particles by how likely they made them` + (kernel ? '' : ' (without a K matrix: of equal size)')
      : brush.kind === 'classes' ? `${brush.items.length} size ${brush.items.length === 1 ? 'class' : 'classes'}: profiles by how likely they come from there` : `particle ${brush.items[0] + 1}: profiles by how likely they come from its size class`;
  return (
    <>
      <div className="linked" onKeyDown={e => { if (e.key === 'Escape') setBrush(null); }}>
        <div className="pane">{drawable ? <OutlinesPane data={outlines} under={under} weights={weights.profiles} chosen={hovered} choose={setHovered} brush={items => setBrush({ kind: 'profiles', items })} />
          : <p className="none">There are no outlines of profiles here.</p>}</div>
        <div className="pane">{distribution ? <DistributionPlot data={distribution} weights={weights.classes} choose={(c, more) => setBrush(b => ({ kind: 'classes', items: more && b?.kind === 'classes' ? [...b.items, c] : [c] }))} />
          : <p className="none">There is no size distribution here.</p>}</div>
        <div className="pane">{!webGL && bodies ? <RenderedView value={bodies.value} shapes={shapes} /> : solid.data ? <StageView solid={solid.data} label="Particles" onPick={hit => {
          const i = hit && solid.data?.bodies ? solid.data.bodies.particleOf(hit.object, hit.instance) : -1;
          setBrush(i >= 0 ? { kind: 'particles', items: [i] } : null);
        }} /> : <p className="none">{solid.error || (!bodies ? 'There are no particles here.' : 'Loading…')}</p>}</div>
      </div>
      <div className="options"><span>{said}</span>{brush && brush.items.length > 0 && <button onClick={() => setBrush(null)}>Show all</button>}</div>
    </>
  );
}
