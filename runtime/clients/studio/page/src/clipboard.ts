import { fullName, localPlaces, useStore } from './store';
import type { Arrangement, Doc, DocNode } from './types';

// Nodes are copied as their lines in the graph file, so that other windows, and text editors, can give and take them.

function linesOf(lines: string[], node: DocNode): string {
  const indent = lines[node.line - 1].search(/\S/);
  let end = node.line;
  while (end < lines.length && (lines[end].trim() === '' || lines[end].search(/\S/) > indent)) ++end;
  return lines.slice(node.line - 1, end).join('\n').trimEnd();
}

export function textOf(doc: Doc, names: string[]): string {
  const lines = doc.text.split('\n');
  return doc.nodes.filter(n => names.includes(n.name)).map(n => linesOf(lines, n) + '\n').join('');
}

// Adds nodes under free names, as one step of undo. `places`: where copies of nodes go, by the names of these. Returns the first node's
// new name, or "".
export async function paste(text: string, places: Arrangement['places']): Promise<string> {
  const answer = await fetch('/api/paste', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify({ text, places: localPlaces(places), scope: useStore.getState().scope }) }).catch(() => null);
  const body = await answer?.json() as { names: string[]; message: string; hint: string; code: string } | undefined;
  if (answer?.ok) return body!.names[0] ? fullName(body!.names[0]) : '';
  useStore.setState({ trouble: body ?? { message: 'the server does not answer', hint: 'is terrazzo studio still running?', code: 'offline' } });
  return '';
}
