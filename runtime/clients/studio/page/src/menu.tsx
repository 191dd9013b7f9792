// Menus of things to do, for mouse and keyboard.
import { useEffect, useRef, useState, useSyncExternalStore, type KeyboardEvent } from 'react';

// Whether the window is at most so wide: what has no room in a bar is in a menu then.
export function useNarrow(width: number): boolean {
  const query = window.matchMedia(`(max-width: ${width}px)`);
  return useSyncExternalStore(tell => { query.addEventListener('change', tell); return () => query.removeEventListener('change', tell); }, () => query.matches);
}

export interface MenuItem { label: string; keys?: string; act: () => void }
export interface MenuAt { left?: number; right?: number; top?: number; bottom?: number }

// Where a menu fits that belongs to a point.
export const menuAt = (x: number, y: number, items: number): MenuAt => ({
  ...(x > window.innerWidth - 260 ? { right: window.innerWidth - x } : { left: x }), ...(y + 30 * items > window.innerHeight ? { bottom: window.innerHeight - y } : { top: y }),
});

export function Menu({ label, items, at, close }: { label: string; items: MenuItem[]; at: MenuAt; close: () => void }) {
  const menu = useRef<HTMLDivElement>(null);
  useEffect(() => menu.current?.querySelector('button')?.focus(), []);
  const key = (e: KeyboardEvent) => {
    const all = [...menu.current!.querySelectorAll('button')], now = all.indexOf(document.activeElement as HTMLButtonElement);
    if (e.key === 'Escape') close();
    else if (e.key === 'ArrowDown') all[(now + 1) % all.length].focus();
    else if (e.key === 'ArrowUp') all[(now + all.length - 1) % all.length].focus();
    else return;
    e.preventDefault(), e.stopPropagation();
  };
  return (
    <div className="menu" role="menu" aria-label={label} ref={menu} style={at} onKeyDown={key} onBlur={e => { if (!e.currentTarget.contains(e.relatedTarget)) close(); }}>
      {items.map(i => <button key={i.label} type="button" role="menuitem" onClick={() => { close(); i.act(); }}>{i.label}{i.keys && <kbd>{i.keys}</kbd>}</button>)}
    </div>
  );
}

export function MenuButton({ label, items, text = '⋮' }: { label: string; items: MenuItem[]; text?: string }) {
  const [at, setAt] = useState<MenuAt | null>(null);
  const button = useRef<HTMLButtonElement>(null);
  const open = () => {
    const r = button.current!.getBoundingClientRect(), low = r.bottom + 30 * items.length > window.innerHeight;
    setAt({ right: window.innerWidth - r.right, ...(low ? { bottom: window.innerHeight - r.top } : { top: r.bottom }) });
  };
  return (
    <>
      <button ref={button} type="button" className={text === '⋮' ? 'dots' : ''} aria-haspopup="menu" aria-expanded={!!at} aria-label={label} title={label} onClick={() => (at ? setAt(null) : open())}>{text}</button>
      {at && <Menu label={label} items={items} at={at} close={() => { setAt(null); button.current?.focus(); }} />}
    </>
  );
}

// The right mouse button opens the menu of a row, except in fields of text, which have the browser's.
export const openMenu = (e: React.MouseEvent<HTMLElement>) => {
  if ((e.target as HTMLElement).closest('input, select')) return;
  e.preventDefault();
  e.currentTarget.querySelector<HTMLButtonElement>('.dots')?.click();
};
