import { NodeResizer, type Node, type NodeProps } from '@xyflow/react';
import { memo, useEffect, useState } from 'react';

import { arrange, useStore } from './store';
import type { Note } from './types';

export type NoteNode = Node<{ index: number; note: Note }, 'note'>;

export const changeNote = (index: number, change: Partial<Note>) =>
  arrange({ notes: (useStore.getState().arrangement.notes ?? []).map((n, k) => (k === index ? { ...n, ...change } : n)) });
export const removeNotes = (gone: number[]) => arrange({ notes: (useStore.getState().arrangement.notes ?? []).filter((_, k) => !gone.includes(k)) });
export const addNote = (note: Note) => arrange({ notes: [...(useStore.getState().arrangement.notes ?? []), note] });

// A text on the canvas, or a frame with a title behind nodes.
export const NoteCard = memo(function NoteCard({ data: { index, note }, selected, width, height }: NodeProps<NoteNode>) {
  const [text, setText] = useState(note.text);
  useEffect(() => setText(note.text), [note.text]);
  const commit = () => { if (text !== note.text) changeNote(index, { text }); };
  return (
    <div className={note.frame ? 'frame' : 'note'} style={{ width: width ?? note.width, height: height ?? note.height }}>
      <NodeResizer isVisible={selected} minWidth={80} minHeight={40} onResizeEnd={(_, p) => changeNote(index, { x: p.x, y: p.y, width: p.width, height: p.height })} />
      {note.frame
        ? <input className="nodrag" value={text} aria-label="Title of the frame" placeholder="Frame" onChange={e => setText(e.target.value)} onBlur={commit} onKeyDown={e => { e.stopPropagation(); if (e.key === 'Enter') e.currentTarget.blur(); }} />
        : <textarea className="nodrag nowheel" value={text} aria-label="Note" placeholder="Note" onChange={e => setText(e.target.value)} onBlur={commit} onKeyDown={e => e.stopPropagation()} />}
    </div>
  );
});
