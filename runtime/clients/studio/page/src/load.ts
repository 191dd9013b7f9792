import { useEffect, useMemo, useState } from 'react';

import { isPreview, urlOf } from './raster';
import { nearest, shownDoc } from './states';
import { useStore, type Target } from './store';
import type { DocNode, OutputValue } from './types';

// Loads something for a value; keeps what was shown before until the new value is there, so that nothing flickers.
export function useLoaded<T>(key: string, load: () => Promise<T>): { data: T | null; error: string } {
  const [state, setState] = useState<{ data: T | null; error: string }>({ data: null, error: '' });
  useEffect(() => {
    let current = true;
    // A preview that cannot be loaded has given way to a newer one, or to the result.
    load().then(data => current && setState({ data, error: '' }), e => current && !isPreview(key) && setState({ data: null, error: String(e.message ?? e) }));
    return () => { current = false; };
    // eslint-disable-next-line react-hooks/exhaustive-deps
  }, [key]);
  return state;
}

export async function fetchJson<T>(hash: string, as: string): Promise<T> {
  const answer = await fetch(`${urlOf(hash)}?as=${as}`);
  if (answer.status === 204) throw new Error('there is a newer preview');
  const body = await answer.json();
  if (!answer.ok) throw new Error(body.message);
  return body as T;
}

export async function fetchBytes(hash: string, query: string): Promise<ArrayBuffer> {
  const answer = await fetch(`${urlOf(hash)}?${query}`);
  if (answer.status === 204) throw new Error('there is a newer preview');
  if (!answer.ok) throw new Error((await answer.json()).message);
  return answer.arrayBuffer();
}

// The nearest value of a type.
export function useNearest(node: string, type: string, direction: 'up' | 'down' = 'up'): { target: Target; value: OutputValue } | null {
  const doc = useStore(s => s.doc), inside = useStore(s => s.inside), types = useStore(s => s.types), nodes = useStore(s => s.nodes);
  return useMemo(() => nearest(node, type, direction, { doc, inside, types, nodes }), [node, type, direction, doc, inside, types, nodes]);
}

export const useNode = (name: string | null | undefined): DocNode | undefined => useStore(s => shownDoc(s)?.nodes.find(n => n.name === name));

// The value that results are compared with, if it has the type.
export function useReference(node: DocNode, value: OutputValue): OutputValue | null {
  return useStore(s => {
    const r = s.reference;
    if (!r) return null;
    if (r.value) return r.value.type === value.type && r.value.hash !== value.hash ? r.value : null;
    const now = Object.entries(s.nodes[node.name]?.outputs ?? {}).find(([, o]) => o.hash === value.hash)?.[0] ?? s.pinned?.port ?? s.port ?? '';
    const old = r.past?.nodes[node.name]?.outputs[now];
    return old && old.type === value.type && old.hash !== value.hash ? old : null;
  });
}
