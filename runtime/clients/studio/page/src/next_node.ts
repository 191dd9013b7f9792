// The node that an arrow key leads to.
import type { Node } from '@xyflow/react';

const directions: Record<string, [number, number]> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

// The nearest node in the direction of the key. What lies across counts double; what lies more across than along does not count,
// unless there is nothing else.
export function nextNode(nodes: Node[], from: string, key: string): string | null {
  const middle = (n: Node) => [n.position.x + (n.measured?.width ?? 0) / 2, n.position.y + (n.measured?.height ?? 0) / 2];
  const at = nodes.find(n => n.id === from), [dx, dy] = directions[key];
  if (!at) return null;
  const [x, y] = middle(at);
  const reached = nodes.filter(n => n.id !== from && n.type === 'node').map(n => {
    const [u, v] = middle(n), along = (u - x) * dx + (v - y) * dy, across = Math.abs((u - x) * dy) + Math.abs((v - y) * dx);
    return { id: n.id, along, cost: along + 2 * across + (across > along ? 1e6 : 0) };
  }).filter(n => n.along > 1);
  return reached.sort((a, b) => a.cost - b.cost)[0]?.id ?? null;
}
