"""Progress of a run, drawn by the thread that waits: on standard error, or below the cell of a notebook."""

import html
import os
import shutil
import sys
import time

_bar = " ▏▎▍▌▋▊▉█"


def _clock(seconds):
    seconds = int(seconds)
    hours, minutes = seconds // 3600, seconds // 60 % 60
    return f"{hours}:{minutes:02}:{seconds % 60:02}" if hours else f"{minutes:02}:{seconds % 60:02}"


def line(done, needed, running, elapsed, width):
    """One line of text: nodes done, a bar, the time, and the running nodes."""
    share = (done + sum(fraction for _, fraction, _ in running)) / needed if needed else 1.0
    share = min(max(share, 0.0), 1.0)
    cells = 10
    filled = share * cells
    bar = _bar[-1] * int(filled)
    if len(bar) < cells:
        bar += _bar[int((filled - int(filled)) * 8)]
    left = f"<{_clock(elapsed * (1 - share) / share)}" if share > 0.02 and elapsed > 1 else ""
    text = f"{100 * share:3.0f}%|{bar:<{cells}}| {done}/{needed} [{_clock(elapsed)}{left}]"
    for name, fraction, note in running:
        text += f" {name} {100 * fraction:.0f}%" + (f" {note}" if note else "")
    return text[:width - 1]


def wanted(stream):
    """Whether to draw: in a terminal and in a notebook, unless TERRAZZO_PROGRESS is 0."""
    if os.environ.get("TERRAZZO_PROGRESS", "") in ("0", "1"):
        return os.environ["TERRAZZO_PROGRESS"] == "1"
    if stream is None:
        return False
    try:
        return stream.isatty() or type(stream).__module__.startswith("ipykernel")
    except (AttributeError, ValueError):
        return False


def drawing(run, progress):
    """What draws the progress of a run: None, text, or HTML in a notebook. progress: True, False, or None: if a
    person can see it."""
    if not (progress or progress is None and wanted(sys.stderr)):
        return None
    if type(sys.stderr).__module__.startswith("ipykernel"):
        return NotebookDrawing(run)
    return Drawing(run)


class NotebookDrawing:
    """Shows a bar below the cell during a run, and removes it at the end."""

    def __init__(self, run):
        self._run = run
        self._start = time.monotonic()
        self._shown = None

    def __call__(self, end):
        elapsed = time.monotonic() - self._start
        if end or elapsed < 0.5:
            return self.clear() if end else None
        from IPython.display import HTML, display

        state = self._run.progress()
        share = (state["done"] + sum(part for _, part, _ in state["running"])) / max(state["needed"], 1)
        text = html.escape(line(state["done"], state["needed"], state["running"], elapsed, 160))
        bar = HTML(f'<progress value="{min(max(share, 0.0), 1.0):.4f}"></progress> <code>{text}</code>')
        if self._shown is None:
            self._shown = display(bar, display_id=True)
        else:
            self._shown.update(bar)

    def clear(self):
        if self._shown is not None:
            from IPython.display import HTML
            self._shown.update(HTML(""))
        self._shown = None


class Drawing:
    """Redraws the line during a run, and removes it at the end. Runs of less than half a second draw nothing."""

    def __init__(self, run, stream=None):
        self._run = run
        self._stream = sys.stderr if stream is None else stream
        self._start = time.monotonic()
        self._drawn = 0

    def __call__(self, end):
        elapsed = time.monotonic() - self._start
        if end or elapsed < 0.5:
            return self.clear() if end else None
        state = self._run.progress()
        text = line(state["done"], state["needed"], state["running"], elapsed,
                    shutil.get_terminal_size((110, 24)).columns)
        self._write("\r" + text + " " * max(0, self._drawn - len(text)))
        self._drawn = len(text)

    def clear(self):
        if self._drawn:
            self._write("\r" + " " * self._drawn + "\r")
        self._drawn = 0

    def _write(self, text):
        try:
            self._stream.write(text)
            self._stream.flush()
        except (OSError, ValueError):  # closed: no progress is shown
            self._stream = _Nowhere()


class _Nowhere:
    def write(self, text):
        pass

    def flush(self):
        pass
