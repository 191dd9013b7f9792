// Where nodes are: in the arrangement beside the graph. Of the insides of subgraphs, the browser remembers it.
import { arrange, useStore } from './store';
import type { Arrangement } from './types';

export type Places = Record<string, { x: number; y: number }>;

const key = (file: string) => `terrazzo.places.${file}`;

function stored(file: string): Places {
  try {
    return JSON.parse(localStorage.getItem(key(file)) ?? '{}') as Places;
  } catch {
    return {};
  }
}

const own = (file: string) => useStore.getState().doc?.file === file;

export const writtenPlaces = (at: Places): NonNullable<Arrangement['places']> =>
  Object.fromEntries(Object.entries(at).map(([n, { x, y }]) => [n, [Math.round(x), Math.round(y)]]));
export const placesOf = (written: Arrangement['places'] = {}): Places => Object.fromEntries(Object.entries(written).map(([n, [x, y]]) => [n, { x, y }]));

export const readPlaces = (file: string): Places => (own(file) ? placesOf(useStore.getState().arrangement.places) : stored(file));

// `group`: see arrange().
export function keepPlaces(file: string, at: Places, group = '') {
  if (own(file)) arrange({ places: writtenPlaces(at) }, group);
  else localStorage.setItem(key(file), JSON.stringify(at));
}
