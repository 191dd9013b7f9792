// A button with a menu of things to do, for mouse and keyboard.
import { useEffect, useRef, useState, type KeyboardEvent } from 'react';

export interface MenuItem { label: string; act: () => void }

export function MenuButton({ label, items, text = '⋮' }: { label: string; items: MenuItem[]; text?: string }) {
  const [at, setAt] = useState<{ right: number; top?: number; bottom?: number } | null>(null);
  const button = useRef<HTMLButtonElement>(null), menu = useRef<HTMLDivElement>(null);
  useEffect(() => { if (at) menu.current?.querySelector('button')?.focus(); }, [at]);
  const open = () => {
    const r = button.current!.getBoundingClientRect(), low = r.bottom + 30 * items.length > window.innerHeight;
    setAt({ right: window.innerWidth - r.right, ...(low ? { bottom: window.innerHeight - r.top } : { top: r.bottom }) });
  };
  const key = (e: KeyboardEvent) => {
    if (!at) return;
    const all = [...menu.current!.querySelectorAll('button')], now = all.indexOf(document.activeElement as HTMLButtonElement);
    if (e.key === 'Escape') setAt(null), button.current?.focus();
    else if (e.key === 'ArrowDown') all[(now + 1) % all.length].focus();
    else if (e.key === 'ArrowUp') all[(now + all.length - 1) % all.length].focus();
    else return;
    e.preventDefault(), e.stopPropagation();
  };
  return (
    <span className="menu" onKeyDown={key} onBlur={e => { if (!e.currentTarget.contains(e.relatedTarget)) setAt(null); }}>
      <button ref={button} type="button" className={text === '⋮' ? 'dots' : ''} aria-haspopup="menu" aria-expanded={!!at} aria-label={label} title={label} onClick={() => (at ? setAt(null) : open())}>{text}</button>
      {at && <div role="menu" aria-label={label} ref={menu} style={at}>
        {items.map(i => <button key={i.label} type="button" role="menuitem" onClick={() => { setAt(null); button.current?.focus(); i.act(); }}>{i.label}</button>)}</div>}
    </span>
  );
}

// The right mouse button opens the menu of a row, except in fields of text, which have the browser's.
export const openMenu = (e: React.MouseEvent<HTMLElement>) => {
  if ((e.target as HTMLElement).closest('input, select')) return;
  e.preventDefault();
  e.currentTarget.querySelector<HTMLButtonElement>('.dots')?.click();
};
