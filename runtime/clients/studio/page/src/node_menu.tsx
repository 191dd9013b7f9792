// What the right mouse button offers for a node.
import { Menu, menuAt, type MenuItem } from './menu';
import { shownDoc } from './states';
import { bypass, change, enter, isLocked, post, useStore } from './store';

// Puts the cursor into the name of the selected node.
export function rename(name: string) {
  useStore.setState({ selected: name });
  setTimeout(() => document.querySelector<HTMLInputElement>('.inspector input.name')?.select(), 50);
}

// `chosen`: all nodes that are selected, with this one.
interface Props { menu: { name: string; x: number; y: number }; chosen: string[]; close: () => void; duplicate: (name: string) => void; remove: (name: string) => void }

export function NodeMenu({ menu: { name, x, y }, chosen, close, duplicate, remove }: Props) {
  const node = useStore(s => shownDoc(s)?.nodes.find(n => n.name === name)), locked = useStore(isLocked);
  if (!node) return null;
  const items: MenuItem[] = [
    ...(node.graph ? [{ label: 'Open', keys: 'Enter', act: () => void enter(name) }] : []),
    ...(node.graph && !locked ? [{ label: 'Copy into this graph', act: () => void change('/api/expand', { node: name.split('/').pop() }) }] : []),
    { label: 'Run to here', act: () => void post('/api/run', { targets: [name] }) },
    { label: 'Show variants', act: () => useStore.setState({ drawer: 'variants' as const }) },
    ...(locked ? [] : [
      { label: 'Rename', keys: 'F2', act: () => rename(name) },
      { label: 'Duplicate', keys: 'Ctrl+D', act: () => duplicate(name) },
      ...(node.graph ? [] : [{ label: node.bypass ? 'Bypass no longer' : 'Bypass', keys: 'Ctrl+B', act: () => bypass([name]) }]),
      { label: 'Make a subgraph', keys: 'Ctrl+G', act: () => useStore.setState({ grouping: chosen }) },
      { label: 'Remove', keys: 'Delete', act: () => remove(name) },
    ]),
  ];
  return <Menu label={`Node ${name}`} items={items} at={menuAt(x, y, items.length)} close={close} />;
}
