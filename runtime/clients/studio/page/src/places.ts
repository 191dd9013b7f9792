// Where nodes are: in the arrangement beside their graph.
import { arrange, useStore } from './store';
import type { Arrangement } from './types';

export type Places = Record<string, { x: number; y: number }>;

export const writtenPlaces = (at: Places): NonNullable<Arrangement['places']> =>
  Object.fromEntries(Object.entries(at).map(([n, { x, y }]) => [n, [Math.round(x), Math.round(y)]]));
export const placesOf = (written: Arrangement['places'] = {}): Places => Object.fromEntries(Object.entries(written).map(([n, [x, y]]) => [n, { x, y }]));

export const readPlaces = (): Places => placesOf(useStore.getState().arrangement.places);

// `group`: see arrange().
export const keepPlaces = (at: Places, group = '') => arrange({ places: writtenPlaces(at) }, group);
