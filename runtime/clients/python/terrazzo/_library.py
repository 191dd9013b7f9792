"""Graph files as functions."""

from __future__ import annotations

import inspect
import os

from . import _core
from ._graph import Graph, load
from ._nodes import Default, python_type


def graphs_folder():
    """The folder of the graphs that are installed with Terrazzo."""
    here = os.path.dirname(os.path.abspath(__file__))
    for folder in (os.path.join(here, "..", "graphs"),
                   os.path.join(_core.library_folder(), "..", "..", "..", "share", "terrazzo", "graphs"),
                   "/usr/share/terrazzo/graphs"):
        if os.path.isdir(folder):
            return os.path.realpath(folder)
    raise FileNotFoundError("the graphs of Terrazzo are not installed beside the module")


class Library:
    """The graphs of graphs/library as functions: library.aggregate(photo="granite.jpg").

    A call loads the graph, sets its parameters, and returns the Graph. If an argument is an output of a graph,
    the call adds the library's graph to that graph instead, as one node, and returns the Node.
    """

    def __init__(self, folder):
        self._folder = os.path.join(graphs_folder(), folder)

    def __dir__(self):
        return sorted(f[:-5] for f in os.listdir(self._folder) if f.endswith(".yaml"))

    def __iter__(self):
        return iter(dir(self))

    def __getattr__(self, name):
        file = os.path.join(self._folder, name + ".yaml")
        if name.startswith("_") or not os.path.isfile(file):
            raise AttributeError(f"there is no graph '{name}' in {self._folder}; there are {', '.join(dir(self))}")
        function = graph_function(file)
        self.__dict__[name] = function
        return function


def graph_function(file):
    """A function that loads a graph file, or uses it inside of another graph."""
    info = _core.describe_graph_file(file)

    def use(*, name=None, cache=True, **values):
        for value in values.values():
            first = value[0] if isinstance(value, (list, tuple)) and value else value
            if isinstance(first, (_core.Output, _core.Node)):
                return first.graph.subgraph(file, name=name, **values)
        given = {k: v for k, v in values.items() if isinstance(v, _core.Value)}
        if given:
            graph = Graph(cache=cache)
            return graph.subgraph(file, name=name, **values)
        return load(file, cache=cache, **values)

    keyword = inspect.Parameter.KEYWORD_ONLY
    parameters, seen = [], set()
    for p in info["parameters"]:
        seen.add(p["name"])
        value = p.get("default")
        default = inspect.Parameter.empty if value is None else Default(repr(value))
        annotation = python_type(p)
        port = next((i for i in info["inputs"] if i["name"] == p["name"]), None)
        if port:
            annotation += " | " + " | ".join(port["types"])
        parameters.append(inspect.Parameter(p["name"], keyword, default=default, annotation=annotation))
    for port in info["inputs"]:
        if port["name"] not in seen:
            parameters.append(inspect.Parameter(port["name"], keyword, default=Default("None"),
                                                annotation=" | ".join(port["types"])))
    parameters += [inspect.Parameter("name", keyword, default=None, annotation="str | None"),
                   inspect.Parameter("cache", keyword, default=True)]
    stem = os.path.splitext(os.path.basename(file))[0]
    use.__name__ = use.__qualname__ = stem
    use.__module__ = "terrazzo.library"
    use.__signature__ = inspect.Signature(parameters, return_annotation="Graph")
    lines = [info["doc"], "", "Outputs"]
    lines += [f"  {o['name']}: {o['types'][0]}. {o['doc']}" for o in info["outputs"]]
    lines += ["", "Parameters"]
    for p in info["parameters"]:
        unit = f" {p['unit']}" if p["unit"] else ""
        lines.append(f"  {p['name']}: {p['kind']}; default {p.get('default', 'none')}{unit}. {p['doc']}")
    if info["inputs"]:
        lines += ["", "Inputs, which replace what the graph loads itself"]
        lines += [f"  {i['name']}: {' or '.join(i['types'])}" for i in info["inputs"]]
    use.__doc__ = "\n".join(lines)
    return use


library = Library("library")
materials = Library("materials")
