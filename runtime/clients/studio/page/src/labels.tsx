import { useEffect, useMemo, useState } from 'react';

import { colorAt } from './color';
import { useDropper } from './dropper';
import type { Pen } from './pen';
import { colorsOf, phaseHint, phaseOf, phasePen, PhaseStrokes, PhaseTools } from './phases';
import { fetchRaster, PanZoom, Picture } from './raster';
import { shownDoc } from './states';
import { isLocked, useStore } from './store';
import { correct, setBinder, tools, usable } from './tools';
import type { DocNode, OutputValue } from './types';
import { Sections } from './images';
import { useLoaded, useNearest } from './load';

function Tools({ node }: { node: DocNode }) {
  const tool = useStore(s => s.tool);
  const choose = (name: string) => useStore.setState(s => ({ tool: s.tool === name ? null : name }));
  useEffect(() => {
    const key = (e: KeyboardEvent) => {
      if (e.ctrlKey || e.metaKey || e.altKey || !(e.target instanceof HTMLElement) || e.target.closest('input, textarea, select, dialog, [role=dialog], [role=menu]')) return;
      const found = tools.find(t => t.key === e.key && usable(t, node));
      if (found) choose(found.name), e.preventDefault();
      else if (e.key === 'Escape') useStore.setState({ tool: null });
    };
    window.addEventListener('keydown', key);
    return () => window.removeEventListener('keydown', key);
  }, [node]);
  return (
    <div className="pens" role="toolbar" aria-label="Corrections">
      {tools.map(t => (
        <button key={t.name} aria-pressed={tool === t.name} disabled={!usable(t, node)} title={`${t.hint} (${t.key.toUpperCase()})`} onClick={() => choose(t.name)}>{t.title}</button>
      ))}
    </div>
  );
}

// Labels over the picture that they were found in, and tools to correct them. Without labels, the picture alone.
export function LabelsView({ value, node }: { value?: OutputValue; node: DocNode }) {
  const [section, setSection] = useState(0), [opacity, setOpacity] = useState(0.55);
  const [radius, setRadius] = useState(4);
  const name = useStore(s => s.tool), doc = useStore(shownDoc), locked = useStore(isLocked);
  const base = useNearest(node.name, 'Image');
  const labels = useLoaded(`${value?.hash}.${section}`, async () => (value ? {
    colors: await fetchRaster(value.hash, 'pixels', section), ids: await fetchRaster(value.hash, 'ids', section),
  } : null));
  const under = useLoaded(`${base?.value.hash}.${section}`, async () => (base ? fetchRaster(base.value.hash, 'pixels', section) : null));
  const colors = useMemo(() => colorsOf(labels.data), [labels.data]);
  const data = labels.data, photo = under.data, dropper = useDropper(photo);
  const fits = !data || (photo && data.ids.fullWidth === photo.fullWidth);
  const size = data?.ids ?? photo;
  if (!size) return <p className="none">{labels.error || under.error || 'There is no result yet.'}</p>;
  const editable = !locked && ['Segment', 'EditLabels'].includes(node.type);
  const tool = editable ? tools.find(t => t.name === name && usable(t, node)) : undefined;
  const leave = () => useStore.setState({ tool: null });
  const factor = size.fullWidth / size.width;
  const taught = node.type === 'Phases' && !locked && section === 0 ? doc : null, phase = taught ? phaseOf(name, node, taught) : -1;
  const pen: Pen | null = dropper ?? (taught && phase >= 0 ? phasePen(node, taught, phase, radius, factor) : tool ? {
    ...tool.pen, leave,
    done: points => {
      if (tool.name !== 'binder') return void correct(node, tool.name, points.map(([x, y]) => [x * factor, y * factor]), section);
      if (photo) void setBinder(node, colorAt(photo, points[0])).then(leave);
    },
  } : null);
  const ids = data && new Int32Array(data.ids.data);
  return (
    <>
      {editable && <Tools node={node} />}
      {taught && <PhaseTools node={node} doc={taught} colors={colors} radius={radius} setRadius={setRadius} />}
      <PanZoom width={size.width} height={size.height} pen={pen} hover={(x, y) => {
        if (dropper || tool?.name === 'binder') return photo ? `${dropper ? 'color' : 'binder'} ${colorAt(photo, [x, y])}` : '';
        const id = ids ? ids[y * size.width + x] : 0;
        return `${x}, ${y}   ${id ? `profile ${id}` : 'binder'}`;
      }}>
        {fits && photo && <Picture raster={photo} />}
        {data && <Picture raster={data.colors} opacity={fits && photo ? (dropper || tool?.name === 'binder' ? 0 : opacity) : 1} />}
        {taught && phase >= 0 && <PhaseStrokes node={node} doc={taught} colors={colors} width={size.width} height={size.height} factor={factor} />}
      </PanZoom>
      <div className="options">
        {tool ? <span>{tool.hint}</span> : phase >= 0 ? <span>{phaseHint(node)}</span> : <>
          <Sections count={size.sections} section={section} set={setSection} />
          {fits && data && <label>Labels <input type="range" min={0} max={1} step={0.05} value={opacity} onChange={e => setOpacity(Number(e.target.value))} /></label>}</>}
      </div>
    </>
  );
}
