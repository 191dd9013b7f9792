"""Graph."""

from __future__ import annotations

import operator
import os

from . import _core
from ._paths import path_text
from ._run import Plan, Run, Step, _target

__all__ = ["Graph", "load"]


def _cache_folder(cache):
    if cache is False or cache is None:
        return ""
    if cache is True:
        return _core.default_cache()
    return path_text(cache)


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
        for what, n, most in (("threads", threads, 1024), ("memory", memory, 2**63), ("file_memory", file_memory, 2**63)):
            if not 0 <= operator.index(n) <= most:
                raise ValueError(f"{what} must be from 0 to {most}, not {n}")
        self._cache = _cache_folder(cache)
        self._threads = threads
        self._warned = set()  # warnings that were given: keys of results, and texts
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
        return self._add_subgraph(path_text(file), values)

    # --- files

    @property
    def file(self):
        """The file that the graph was loaded from, or ""."""
        return self._file()

    def save(self, file, *, flat=False, arrays=None):
        """Writes a graph file. Paths are relative to its folder.

        A loaded graph keeps its text and comments wherever nothing changed. flat: write every node that would
        be evaluated, without subgraphs, repetitions and parameters of the graph, and with changes inside of
        subgraphs. arrays: a folder, relative to the file's, for the arrays that the graph contains; the saved
        graph loads them from there. Raises Error "not-savable" without `flat` if there are such changes, and
        without `arrays` if there are arrays.
        """
        stand_ins = {}
        if arrays is not None:
            from ._array_files import write_arrays
            stand_ins = write_arrays(self, os.path.join(os.path.dirname(os.path.abspath(file)), path_text(arrays)))
        self._save(path_text(file), flat, stand_ins)

    def to_yaml(self, folder=".", *, flat=False):
        """The text that save() writes to a file in this folder."""
        return self._text(path_text(folder), flat)

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
        return Plan(Step(*step) for step in self._explain([_target(t) for t in targets], path_text(out)))

    def sweep(self, vary, *targets, out="out", jobs=1, progress=None):
        """Runs the graph for every combination of values, and returns a Sweep.

        vary: values by "NODE.PARAMETER" or graph parameter, such as {"segment.split": [0.3, 0.5]}. Shared work
        runs once. targets: what each point evaluates; outputs among them are kept as values. Each point
        writes its files and its report.json to a folder below `out`. jobs: the number of points to run at a
        time; they share the threads.
        """
        from ._sweep import sweep
        return sweep(self, vary, targets, out, jobs, progress)

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
    graph._open(path_text(file))
    for name, value in parameters.items():
        graph._set_parameter(name, value)
    graph.check()
    return graph
