// Loads the picture of a node when it is selected, while the page still draws the selection: that takes as long as the server does.
import { fetchRaster } from './raster';
import { declarationOf, previewOf, shownDoc, valueOf } from './states';
import { useStore } from './store';

let last: string | null = null;

export const loadAhead = () => useStore.subscribe(s => {
  if (s.selected === last) return;
  last = s.selected;
  const node = !s.pinned && shownDoc(s)?.nodes.find(n => n.name === s.selected), port = node && declarationOf(node, s.types)?.outputs[0]?.name;
  if (!node || !port || s.extra || previewOf(node, port, s.nodes)) return;
  const value = valueOf(node, port, s.nodes);
  // The viewer asks for the same, and shows the error if there is one.
  if (value && ['Image', 'Labels'].includes(value.type)) fetchRaster(value.hash, 'pixels', 0).catch(() => {});
});
