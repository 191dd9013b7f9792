"""Graph and Run."""

from __future__ import annotations

import os
import sys
import warnings

from . import _core
from ._errors import Canceled, NodeWarning
from ._progress import Drawing, wanted

__all__ = ["Graph", "Run", "load"]


def _cache_folder(cache):
    if cache is False or cache is None:
        return ""
    if cache is True:
        return _core.default_cache()
    return os.fspath(cache)


_exiting = False


def end_all_runs():
    """Cancels everything when the interpreter exits."""
    global _exiting
    _exiting = True
    _core.end_all_runs()


class Run:
    """An evaluation: started by Graph.start, or done by Graph.run.

    Threads compute it. wait() waits for it, result() returns when it is done and raises what went wrong.
    """

    def __init__(self, graph, targets, out):
        self._graph = graph
        self._core = _core.RunCore(graph, [_target(t) for t in targets], os.fspath(out))
        self._warned = False

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
        draw = None
        if progress or (progress is None and wanted(sys.stderr)):
            draw = Drawing(self._core)
        try:
            self._core.wait(draw)
        finally:
            if draw is not None:
                draw.clear()
        return self

    def result(self, progress=None):
        """Waits, and raises Error if a node failed or Canceled if nodes were canceled."""
        self.wait(progress)
        if not self._warned:
            self._warned = True
            self._warn()
        self._core.raise_errors()
        if self._core.canceled():
            if _exiting:
                raise SystemExit  # ends a daemon thread without a traceback
            raise Canceled()
        return self

    def _warn(self):
        level = 1
        frame = sys._getframe()
        package = os.path.dirname(__file__)
        while frame is not None and os.path.dirname(frame.f_code.co_filename) == package:
            frame, level = frame.f_back, level + 1
        for node in self._core.nodes():
            for text in node["warnings"]:
                warnings.warn(f"{node['name']}: {text}", NodeWarning, stacklevel=level)
            if node["saved"] is not None:
                warnings.warn(str(node["saved"]), NodeWarning, stacklevel=level)
        trouble = self._core.trouble() or self._graph._write_trouble()
        if trouble:
            warnings.warn(trouble, NodeWarning, stacklevel=level)

    def value(self, output):
        """The value of an output that this run evaluated."""
        return self._core.value(_target(output))

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


class Parameters:
    """The parameters of a graph: graph.parameters["photo"] = "granite.jpg"."""

    def __init__(self, graph):
        self._graph = graph

    def _all(self):
        return {p["name"]: p for p in self._graph._parameters()}

    def __getitem__(self, name):
        known = self._all()
        if name not in known:
            raise KeyError(name)
        return known[name]["value"]

    def __setitem__(self, name, value):
        self._graph._set_parameter(name, value)

    def __iter__(self):
        return iter(self._all())

    def __len__(self):
        return len(self._all())

    def __contains__(self, name):
        return name in self._all()

    def keys(self):
        return self._all().keys()

    def items(self):
        return [(name, p["value"]) for name, p in self._all().items()]

    def __repr__(self):
        return repr(dict(self.items()))


class Graph(_core.Graph):
    """A graph of nodes. Every node type is a method: graph.Segment(image=photo.image) adds a node.

    name, doc: of the graph, for its file.
    cache: the folder of the disk cache. True: the one that the program uses. False: results stay in memory.
    memory: bytes of values to keep in memory in addition to those in use; 0: 2 GiB.
    file_memory: bytes that loading one file may take; 0: all available memory.
    threads: number of threads; 0: one per core.
    """

    def __init__(self, name="", *, doc="", cache=True, memory=0, file_memory=0, threads=0):
        self._cache = _cache_folder(cache)
        super().__init__(self._cache, memory, file_memory, threads)
        if name or doc:
            self._set_name(name, doc)

    # --- contents

    @property
    def name(self):
        """Name of the graph."""
        return self._name()[0]

    @name.setter
    def name(self, name):
        self._set_name(name, self._name()[1])

    @property
    def doc(self):
        """Description of the graph."""
        return self._name()[1]

    @doc.setter
    def doc(self, doc):
        self._set_name(self._name()[0], doc)

    @property
    def nodes(self):
        """The nodes, in the order of the file."""
        return [self._node(name) for name in self._names()]

    def __getitem__(self, name):
        """A node by name. "asset/pack" is the node `pack` of the subgraph `asset`."""
        return self._node(name)

    def __contains__(self, name):
        return name in self._names()

    def __delitem__(self, name):
        self._remove(name)

    def __len__(self):
        return len(self._names())

    def __iter__(self):
        return iter(self.nodes)

    def rename(self, node, name):
        """Renames a node. Wires follow."""
        self._rename(_target(node), name)

    @property
    def parameters(self):
        """The graph's own parameters with their values, to read and to set."""
        return Parameters(self)

    def parameter(self, name, type, default=None, *, doc="", unit="", min=None, max=None, choices=(), keywords=()):
        """Declares a parameter of the graph, and returns a reference to it for parameters of nodes.

        type: path, int, number, bool, text, choice, color, numbers, ints or texts.
        """
        self._add_parameter(name, type, default, doc, unit, min, max, list(choices), list(keywords))
        return self._parameter_reference(name)

    def reference(self, name):
        """A reference to a declared parameter, as the value of a node's parameter."""
        if name not in self.parameters:
            raise KeyError(name)
        return self._parameter_reference(name)

    @property
    def outputs(self):
        """The graph's outputs by name."""
        return {name: self._output_at(reference) for name, reference in self._ports(True)}

    def output(self, name, output):
        """Names an output of the graph. None removes it."""
        self._set_port(True, name, "" if output is None else self._own(output).reference)

    def input(self, name, output):
        """Names an input: a graph that uses this one may replace the value of `output`. None removes it."""
        self._set_port(False, name, "" if output is None else self._own(output).reference)

    def _own(self, output):
        if isinstance(output, _core.Node):
            output = self._output_at(output.name)
        if not isinstance(output, _core.Output) or output.graph is not self:
            raise TypeError("expected an output of a node of this graph")
        return output

    def subgraph(self, file, *, name=None, **values):
        """Adds another graph file as a node. Values are its parameters and inputs."""
        values["name"] = name
        return self._add_subgraph(os.fspath(file), values)

    # --- files

    @property
    def file(self):
        """The file that the graph was loaded from, or ""."""
        return self._file()

    def save(self, file):
        """Writes a graph file. Paths are relative to its folder.

        A loaded graph keeps its text and comments wherever nothing changed. Raises Error "not-savable" if the
        graph contains arrays.
        """
        self._save(os.fspath(file))

    def to_yaml(self, folder="."):
        """The text that save() writes to a file in this folder."""
        return self._text(os.fspath(folder))

    # --- evaluation

    def check(self):
        """Checks the whole graph. Raises Error with everything that is wrong; returns warnings and notes."""
        return self._link()

    def start(self, *targets, out="out"):
        """Starts an evaluation and returns it as a Run at once.

        targets: nodes, outputs or names; by default the graph's outputs, the nodes that write files, and nodes
        without consumers. out: the folder of written files.
        """
        return Run(self, targets, out)

    def run(self, *targets, out="out", progress=None):
        """Evaluates and waits. Raises Error if a node fails; the others still run."""
        return self._finish(self.start(*targets, out=out).result(progress))

    def _evaluate(self, output):
        return self._finish(self.start(output).result()).value(output)

    def _finish(self, run):
        if self._cache and self._written() != self._tended:
            self._tended = self._written()
            _core.cache_tend(self._cache)
        return run

    _tended = 0

    def explain(self, *targets, out="out"):
        """What a run would compute, and why, without computing anything: a Plan."""
        return Plan(Step(*step) for step in self._explain([_target(t) for t in targets], os.fspath(out)))

    def sweep(self, vary, *targets, out="out", progress=None):
        """Runs the graph for every combination of values, and returns a Sweep.

        vary: values by "NODE.PARAMETER" or graph parameter, such as {"segment.split": [0.3, 0.5]}. Shared work
        runs once. targets: what each point evaluates; outputs among them are kept as values. Each point
        writes its files and its report.json to a folder below `out`.
        """
        from ._sweep import sweep
        return sweep(self, vary, targets, out, progress)

    # --- display

    def draw(self, format="svg"):
        """A drawing as text: "svg", "dot" or "mermaid"."""
        return self._draw(format)

    def _repr_html_(self):
        from ._html import graph_html
        return graph_html(self)

    def __repr__(self):
        name = self.name or os.path.basename(self.file) or "unnamed"
        return f"<Graph {name!r} of {len(self)} nodes>"

    def __getattr__(self, name):
        # Only for names that the class lacks: outputs of the graph.
        if not name.startswith("_"):
            for known, reference in self._ports(True):
                if known == name:
                    return self._output_at(reference)
            if name[:1].isupper():
                _core.Graph._add(self, name, {})  # raises the error with the nearest name
        raise AttributeError(f"the graph has no output '{name}', and there is no method of that name")

    def __dir__(self):
        return list(super().__dir__()) + [name for name, _ in self._ports(True)]

    def __reduce__(self):
        raise TypeError("a graph cannot be pickled; save it, and load it in the other process")

    def __copy__(self):
        raise TypeError("a graph cannot be copied; save it, and load it again")

    def __deepcopy__(self, memo):
        return self.__copy__()


def load(file, *, cache=True, memory=0, file_memory=0, threads=0, **parameters):
    """Loads a graph file and sets its parameters: t.load("aggregate.yaml", photo="granite.jpg").

    Checks all of it and raises Error with everything that is wrong. See Graph for the other arguments.
    """
    graph = Graph(cache=cache, memory=memory, file_memory=file_memory, threads=threads)
    graph._open(os.fspath(file))
    for name, value in parameters.items():
        graph._set_parameter(name, value)
    graph.check()
    return graph
