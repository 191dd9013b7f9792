// How far an evaluation is, and what it does, in words.
import { secondsText } from './format';
import { keep, kept } from './kept';
import type { NodeState } from './types';

export interface Progress { done: number; total: number; share: number; doing: string; left: number; sure: boolean; canceled: number }

const deeds: Record<string, string> = {
  LoadImage: 'reading the photograph', Segment: 'finding particles', Phases: 'finding phases', EditLabels: 'correcting labels', ShapeEstimate: 'estimating shapes',
  KMatrix: 'cutting shapes at random', Unfold: 'unfolding sizes', Distribution: 'drawing sizes', Pack: 'packing particles', Anneal: 'packing particles', Tessellate: 'growing cells',
  Colorize: 'coloring particles', ResidualSynth: 'synthesizing fine detail', DetailSolid: 'synthesizing fine detail', MediaSolid: 'synthesizing the solid',
  MediaBase: 'synthesizing the solid', MediaBlock: 'synthesizing the solid',
  SolidOptimize: 'synthesizing the solid', SolidBase: 'synthesizing the solid', SolidBlock: 'synthesizing the solid', Voxelize: 'filling voxels', Section: 'cutting sections',
  View: 'drawing views', RenderSolid: 'rendering', RenderVolume: 'rendering', Measure3D: 'measuring', Compare: 'comparing with the photograph',
  TextureObserver: 'comparing with the photograph', ContactSheet: 'laying out pictures', Export: 'writing files',
};

// Seconds of nodes on two cores for the default material. They count until a node of the type has run here.
const typical: Record<string, number> = {
  LoadImage: 0.1, Segment: 9, ShapeEstimate: 60, KMatrix: 10, Unfold: 0.5, Pack: 10, Anneal: 10, Colorize: 0.1, ResidualSynth: 5, DetailSolid: 40, Voxelize: 5,
  Section: 2, View: 10, RenderSolid: 15, Compare: 0.5, TextureObserver: 10, ContactSheet: 0.1, Phases: 2, MediaSolid: 60, Measure3D: 2, Export: 0.5,
};
const learned = kept('seconds');

// Remembers how long nodes of a type take here.
export function learn(n: NodeState) {
  if (n.state !== 'computed' || !n.type || !(n.seconds > 0) || learned[n.type] === n.seconds) return;
  learned[n.type] = n.seconds;
  keep('seconds', learned);
}

const wholeOf = (n: NodeState): number | undefined => n.expected || learned[n.type] || typical[n.type];

// Seconds that a node still takes, by its progress if it tells that; undefined if nothing is known.
function leftOf(n: NodeState, now: number): number | undefined {
  const whole = wholeOf(n);
  if (n.state !== 'running') return whole;
  const elapsed = n.since === undefined ? 0 : (now - n.since) / 1000;
  if (n.progress > 0.01) return (elapsed * (1 - n.progress)) / n.progress;
  return whole === undefined ? undefined : whole > elapsed ? whole - elapsed : elapsed; // what takes longer may take as long again
}

// Of the nodes that the last evaluation runs or ran.
export function progressOf(nodes: Record<string, NodeState>, now = performance.now()): Progress {
  const out: Progress = { done: 0, total: 0, share: 0, doing: '', left: 0, sure: true, canceled: 0 };
  let spent = 0, longest = -1;
  for (const [path, n] of Object.entries(nodes)) {
    const unfinished = n.state === 'waiting' || n.state === 'running';
    out.canceled += Number(n.state === 'canceled');
    if (!unfinished && !['computed', 'failed', 'skipped', 'canceled'].includes(n.state)) continue;
    ++out.total;
    if (!unfinished) {
      if (n.state === 'computed') spent += n.seconds, ++out.done;
      continue;
    }
    const left = leftOf(n, now);
    out.left += left ?? 0, out.sure &&= left !== undefined;
    if (n.state !== 'running') continue;
    spent += n.since === undefined ? 0 : (now - n.since) / 1000;
    // Of nodes that run at once, the one that takes longest is what a person waits for.
    if ((left ?? 0) > longest) longest = left ?? 0, out.doing = deeds[n.type] ?? `running ${path.split('/').pop()}`;
  }
  out.share = out.total ? (spent + out.left > 0 ? spent / (spent + out.left) : out.done / out.total) : 0;
  return out;
}

export const leftText = (p: Pick<Progress, 'left' | 'sure'>): string => {
  if (p.left < 0.5) return ''; // too short to say, or not known yet
  return `${p.sure ? 'about' : 'at least'} ${p.left < 10 ? `${Math.ceil(p.left)} s` : p.left < 90 ? `${Math.ceil(p.left / 5) * 5} s` : secondsText(Math.max(p.left, 100))}`;
};

// "finding particles, 2 of 9 nodes, about 3 min"
export const progressText = (p: Progress): string =>
  [p.doing || 'queued', `${p.done} of ${p.total} ${p.total === 1 ? 'node' : 'nodes'}`, leftText(p)].filter(Boolean).join(', ');

// A node that says that it is done, but has not ended, is finishing.
export const percentText = (n: NodeState): string => (n.progress >= 0.995 ? 'finishing' : `${Math.floor(100 * n.progress)} %`);
