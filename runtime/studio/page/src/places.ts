// Where nodes are: in the arrangement beside the graph. Of graphs that belong to the program, and of insides of subgraphs, the browser
// remembers it.
import { arrange, useStore } from './store';

export type Places = Record<string, { x: number; y: number }>;

const key = (file: string) => `terrazzo.places.${file}`;

function stored(file: string): Places {
  try {
    return JSON.parse(localStorage.getItem(key(file)) ?? '{}') as Places;
  } catch {
    return {};
  }
}

const beside = (file: string) => {
  const { doc } = useStore.getState();
  return doc && doc.file === file && !doc.read_only;
};

export function readPlaces(file: string): Places {
  const own = beside(file) ? useStore.getState().arrangement.places : undefined;
  return own ? Object.fromEntries(Object.entries(own).map(([n, [x, y]]) => [n, { x, y }])) : stored(file);
}

export function keepPlaces(file: string, at: Places) {
  if (!beside(file)) return localStorage.setItem(key(file), JSON.stringify(at));
  localStorage.removeItem(key(file));
  arrange({ places: Object.fromEntries(Object.entries(at).map(([n, { x, y }]) => [n, [Math.round(x), Math.round(y)]])) });
}

export function forgetPlaces(file: string) {
  localStorage.removeItem(key(file));
  if (beside(file)) arrange({ places: {} });
}
