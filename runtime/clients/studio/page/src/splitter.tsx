import { useEffect, useRef, useState } from 'react';

const key = 'terrazzo.width';

// Changes the width of the panel on its right, by dragging or with the arrow keys. The browser remembers it.
export function Splitter() {
  const [width, setWidth] = useState(() => Number(localStorage.getItem(key)) || 460);
  const drag = useRef(false);
  const set = (w: number) => setWidth(Math.round(Math.min(Math.max(w, 300), window.innerWidth * 0.7)));
  useEffect(() => {
    document.documentElement.style.setProperty('--panel-width', `${width}px`);
    localStorage.setItem(key, String(width));
  }, [width]);
  return (
    <div className="splitter" role="separator" aria-orientation="vertical" aria-label="Width of the panel" aria-valuenow={width} aria-valuemin={300} aria-valuemax={2000} tabIndex={0}
      onPointerDown={e => { drag.current = true; e.currentTarget.setPointerCapture(e.pointerId); }}
      onPointerMove={e => { if (drag.current) set(window.innerWidth - e.clientX); }}
      onPointerUp={() => { drag.current = false; }}
      onKeyDown={e => { if (e.key === 'ArrowLeft') set(width + 20); if (e.key === 'ArrowRight') set(width - 20); }} />
  );
}
