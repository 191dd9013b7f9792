import { useEffect, useRef, useState } from 'react';

import { keep, kept } from './kept';

const least = 300; // pixels

// Changes the width of the panel on its right, by dragging or with the arrow keys. The browser keeps its share of the window, at first half.
export function Splitter() {
  const [share, setShare] = useState(() => Math.min(kept('panel').share || 0.5, 0.7));
  const drag = useRef(false), width = Math.round(Math.max(share * window.innerWidth, least));
  const set = (w: number) => {
    const next = Math.min(Math.max(w, least) / window.innerWidth, 0.7);
    setShare(next), keep('panel', { share: next });
  };
  useEffect(() => document.documentElement.style.setProperty('--panel-width', `max(${100 * share}vw, ${least}px)`), [share]);
  return (
    <div className="splitter" role="separator" aria-orientation="vertical" aria-label="Width of the panel" aria-valuenow={width} aria-valuemin={least} aria-valuemax={2000} tabIndex={0}
      onPointerDown={e => { drag.current = true; e.currentTarget.setPointerCapture(e.pointerId); }}
      onPointerMove={e => { if (drag.current) set(window.innerWidth - e.clientX); }}
      onPointerUp={() => { drag.current = false; }}
      onKeyDown={e => { if (e.key === 'ArrowLeft') set(width + 20); if (e.key === 'ArrowRight') set(width - 20); }} />
  );
}
