import { shownTarget } from './follow';
import { useStore } from './store';

// The canvases of a picture on each other, in their full resolution.
function joined(canvases: HTMLCanvasElement[]): HTMLCanvasElement {
  const out = document.createElement('canvas');
  out.width = Math.max(...canvases.map(c => c.width)), out.height = Math.max(...canvases.map(c => c.height));
  const draw = out.getContext('2d')!;
  for (const c of canvases) {
    draw.globalAlpha = Number(c.style.opacity || 1);
    draw.drawImage(c, 0, 0, out.width, out.height);
  }
  return out;
}

// Downloads what a viewer shows as a PNG, named after the material and the node.
function save(canvases: HTMLCanvasElement[]) {
  const s = useStore.getState(), stem = s.doc?.file.split('/').pop()?.replace(/\.ya?ml$/, '') ?? 'material', node = shownTarget(s)?.node.replace(/\//g, '_') ?? 'picture';
  if (!canvases.length) return;
  joined(canvases).toBlob(blob => {
    if (!blob) return;
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob), link.download = `${stem}_${node}.png`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10000);
  });
}

export function SavePicture({ canvases }: { canvases: () => HTMLCanvasElement[] }) {
  return <button className="keep" title="Save this picture as PNG" aria-label="Save this picture" onPointerDown={e => e.stopPropagation()} onDoubleClick={e => e.stopPropagation()} onClick={() => save(canvases())}>
    <svg viewBox="0 0 16 16" width="14" height="14" aria-hidden="true"><path d="M8 2v8m-3-3 3 3 3-3M3 13h10" fill="none" stroke="currentColor" strokeWidth="1.5" /></svg></button>;
}
