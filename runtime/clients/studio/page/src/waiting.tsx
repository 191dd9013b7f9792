import { useEffect, useState } from 'react';

import { progressOf, progressText, type Progress } from './progress';
import { useStore } from './store';

// The progress of the evaluation, twice a second: nodes send their own much more often.
export function useProgress(): Progress {
  const running = useStore(s => s.run.running), doc = useStore(s => s.doc?.file);
  const [progress, setProgress] = useState(() => progressOf(useStore.getState().nodes));
  useEffect(() => {
    const look = () => setProgress(progressOf(useStore.getState().nodes));
    look();
    if (!running) return;
    const timer = setInterval(look, 500);
    return () => clearInterval(timer);
  }, [running, doc]);
  return progress;
}

// What the material waits for, under its picture.
export function Waiting() {
  const running = useStore(s => s.run.running), progress = useProgress();
  if (!running || !progress.total) return null;
  const text = progressText(progress);
  return (
    <div className="waiting">
      <p>{text[0].toUpperCase() + text.slice(1)}</p>
      <div className="share" role="progressbar" aria-label="Progress of the evaluation" aria-valuemin={0} aria-valuemax={100} aria-valuenow={Math.round(100 * progress.share)}>
        <i style={{ width: `${100 * Math.min(progress.share, 0.99)}%` }} /></div>
    </div>
  );
}
