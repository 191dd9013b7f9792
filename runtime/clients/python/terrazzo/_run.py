"""Runs and plans."""

from __future__ import annotations

import os
import sys
import threading
import warnings

from . import _core
from ._errors import Canceled, Error, NodeWarning
from ._paths import path_text
from ._progress import drawing

_exiting = False


def end_all_runs():
    """Cancels everything when the interpreter exits."""
    global _exiting
    _exiting = True
    _core.end_all_runs()


def until_exit(call, *arguments):
    """Calls a function of the extension. While the interpreter exits, nothing is evaluated any more, and other threads
    end without a traceback."""
    ends = threading.current_thread() is not threading.main_thread()
    if _exiting and ends:
        raise SystemExit
    try:
        return call(*arguments)
    except (Error, Canceled):
        if _exiting and ends:
            raise SystemExit from None
        raise


class Run:
    """An evaluation: started by Graph.start, or done by Graph.run.

    Threads compute it. wait() waits for it, result() returns when it is done and raises what went wrong.
    """

    def __init__(self, graph, targets, out, apart=None):
        if not isinstance(graph, _core.Graph):
            raise TypeError(f"a run needs a graph, not a {type(graph).__name__}")
        self._graph, self._out = graph, os.path.abspath(path_text(out))
        self._core = until_exit(_core.RunCore, graph, [_target(t) for t in targets], self._out, apart)
        self._done = False

    @property
    def done(self):
        """Whether the evaluation has ended."""
        return self._core.done()

    def cancel(self):
        """Stops the evaluation. Nodes that are done stay cached."""
        self._core.cancel()

    def progress(self):
        """A dictionary: nodes `done` of `needed`, and the `running` ones as (name, fraction, note)."""
        return self._core.progress()

    def wait(self, progress=None):
        """Waits for the end, without raising errors of nodes. Ctrl-C cancels and raises KeyboardInterrupt.

        progress: draw the progress on standard error; by default in a terminal and in a notebook.
        """
        draw = drawing(self._core, progress)
        try:
            self._core.wait(draw)
        finally:
            if draw is not None:
                draw.clear()
        return self

    def result(self, progress=None):
        """Waits, and raises Error if a node failed or Canceled if nodes were canceled.

        If the run wrote files, their report.json, from which terrazzo.reproduce works, is beside them.
        """
        return self.wait(progress)._settled(report=True)

    def _settled(self, report):
        if not self._done:
            self._done = True
            if report and self.files:
                self._core.write_report(self._out)
            self._warn()
        until_exit(self._raise)
        return self

    def _raise(self):
        self._core.raise_errors()
        if self._core.canceled():
            raise Canceled()

    def _warn(self):
        level = 1
        frame = sys._getframe()
        package = os.path.dirname(__file__)
        while frame is not None and os.path.dirname(frame.f_code.co_filename) == package:
            frame, level = frame.f_back, level + 1
        for node in self._core.nodes():
            for text in node["warnings"]:
                if (node["key"], text) in self._graph._warned:  # of a result that was cached
                    continue
                self._graph._warned.add((node["key"], text))
                warnings.warn(f"{node['name']}: {text}", NodeWarning, stacklevel=level)
            if node["saved"] is not None:
                warnings.warn(str(node["saved"]), NodeWarning, stacklevel=level)
        trouble = self._core.trouble() or self._graph._write_trouble()
        if trouble:
            warnings.warn(trouble, NodeWarning, stacklevel=level)

    def value(self, output):
        """The value of an output that this run evaluated. A repeated node gives a list."""
        return self._each(output, lambda name: until_exit(self._core.value, name))

    def _keep(self, output):
        """The same as objects with value(), which keep no value."""
        return self._each(output, self._core.keep)

    def _each(self, output, get):
        elements = self._core.elements(_target(output))
        return get(_target(output)) if elements is None else [get(element) for element in elements]

    @property
    def seconds(self):
        """Wall-clock time of the evaluation."""
        return self._core.seconds()

    @property
    def nodes(self):
        """A dictionary for each node: name, type, status, seconds, bytes, metrics, warnings, files, key, error.

        status: "computed", "memory" and "disk" (cached), "failed", "skipped" or "cancelled".
        """
        return self._core.nodes()

    @property
    def metrics(self):
        """The numbers that nodes report, by node and name: run.metrics["unfold"]["N_V"]."""
        return {node["name"]: node["metrics"] for node in self._core.nodes() if node["metrics"]}

    @property
    def files(self):
        """Files that were written, relative to the output folder."""
        return [file for node in self._core.nodes() for file in node["files"]]

    def __repr__(self):
        if not self.done:
            return "<Run, not done>"
        nodes = self._core.nodes()
        computed = sum(node["status"] == "computed" for node in nodes)
        return f"<Run of {len(nodes)} nodes: {computed} computed, {self.seconds:.2f} s>"

    def _repr_html_(self):
        from ._html import table_html
        if not self.done:
            return "<p>not done</p>"
        rows = [(n["name"], n["type"], n["status"], f"{n['seconds']:.2f}", n["bytes"]) for n in self._core.nodes()]
        return table_html(("node", "type", "status", "seconds", "bytes"), rows)


def _target(target):
    if isinstance(target, str):
        return target
    if isinstance(target, _core.Output):
        return target.reference
    if isinstance(target, _core.Node):
        return target.name
    raise TypeError(f"a target is a node, an output or a name, not {type(target).__name__}")


class Step:
    """What a run would do with one node: step is "cached", "runs" or "may run"; reasons says why."""

    __slots__ = ("node", "step", "reasons", "seconds", "bytes")

    def __init__(self, node, step, reasons, seconds, size):
        self.node, self.step, self.reasons, self.seconds, self.bytes = node, step, reasons, seconds, size

    def __repr__(self):
        return f"<{self.node}: {self.step}>"


class Plan(list):
    """The steps of a run, in order. str(plan) is what `terrazzo explain` prints."""

    def __str__(self):
        width = max([4] + [len(s.node) for s in self])
        lines = []
        for s in self:
            first, *others = s.reasons or [""]
            lines.append(f"{s.node:<{width}}  {s.step:<8}{first}".rstrip())
            lines += [" " * (width + 10) + r for r in others]
        count = {step: sum(s.step == step for s in self) for step in ("cached", "runs", "may run")}
        lines.append(f"{count['cached']} cached, {count['runs']} to run, {count['may run']} may run")
        return "\n".join(lines)

    def _repr_html_(self):
        from ._html import table_html
        return table_html(("node", "step", "why"), [(s.node, s.step, "; ".join(s.reasons)) for s in self])
