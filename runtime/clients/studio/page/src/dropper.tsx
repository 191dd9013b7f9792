import { colorAt } from './color';
import type { Pen } from './pen';
import type { Raster } from './raster';
import { useStore } from './store';

// The color field that waits for a color picked from a picture.
export interface Dropper { title: string; take: (color: string) => void }

const end = () => useStore.setState({ dropper: null });

// A button that takes a color from the picture in the viewer, again and again until it ends.
export function DropperButton({ title, take }: Dropper) {
  const on = useStore(s => s.dropper?.title === title);
  return <button className="dropper" aria-pressed={on} title={`${title}: click a color in the picture`} aria-label={title}
    onClick={() => (on ? end() : useStore.setState({ dropper: { title, take }, tool: null }))}>
    <svg viewBox="0 0 16 16" width="13" height="13" aria-hidden="true"><path d="M13.6 2.4a2 2 0 0 0-2.9 0L9 4.1l-.8-.8-1 1 .9.9-5 5V12l-1 1 1 1 1-1h1.8l5-5 .9.9 1-1-.8-.8 1.7-1.7a2 2 0 0 0 0-3zM5.3 12H4v-1.3l4.9-4.9 1.3 1.3z" fill="currentColor" /></svg></button>;
}

export function useDropper(raster: Raster | null | undefined): Pen | null {
  const dropper = useStore(s => s.dropper);
  if (!dropper || !raster) return null;
  return { least: 1, most: 1, freehand: false, shape: 'points', leave: end, done: ([p]) => { dropper.take(colorAt(raster, p)); end(); } };
}
