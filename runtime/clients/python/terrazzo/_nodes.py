"""Node types of the registry as functions, with signatures and documentation."""

from __future__ import annotations

import inspect
import keyword
import textwrap

from . import _core
from ._graph import Graph

hidden = "source_hash"  # the parameter of nodes written in Python that Python sets


class Default:
    """A default in a signature, written as in the reference."""

    def __init__(self, text):
        self._text = text

    def __repr__(self):
        return self._text


def python_type(parameter):
    """The Python type of a parameter's values, as text."""
    kinds = {"bool": "bool", "int": "int", "number": "float", "text": "str", "path": "str | PathLike[str]",
             "output path": "str", "ints": "int | Sequence[int]", "numbers": "float | Sequence[float]",
             "texts": "str | Sequence[str]", "color": "str | Sequence[float]"}
    words = list(parameter["keywords"])
    if parameter["kind"] == "choice":
        return "Literal[" + ", ".join(map(repr, parameter["choices"] + words)) + "]"
    kind = kinds[parameter["kind"]]
    if words and "str" not in kind:
        kind += " | Literal[" + ", ".join(map(repr, words)) + "]"
    return kind


def argument(name):
    """The name of an input or a parameter as a keyword argument: `class` is class_."""
    return name + "_" if keyword.iskeyword(name) else name


def _default(type_name, parameter):
    value = parameter.get("default")
    if value is None:
        return inspect.Parameter.empty
    if parameter["kind"] == "color" and isinstance(value, list):
        return Default(repr(_core.default_text(type_name, parameter["name"])))
    return Default(repr(value))


def _signature(info, first):
    """`first`: the leading positional parameters."""
    only = inspect.Parameter.KEYWORD_ONLY
    out = list(first)
    shared = {p["name"]: p for p in info["parameters"]}
    for port in info["inputs"]:
        types = " | ".join(port["types"]) or "Any"
        kind = f"list[{types}]" if port["many"] else types
        if port["name"] in shared:  # outputs and values go to the input, everything else to the parameter
            kind += " | " + python_type(shared[port["name"]])
        default = Default("None") if port["optional"] else inspect.Parameter.empty
        out.append(inspect.Parameter(argument(port["name"]), only, default=default, annotation=kind))
    for p in info["parameters"]:
        if p["name"] != hidden and p["name"] not in {port["name"] for port in info["inputs"]}:
            out.append(inspect.Parameter(argument(p["name"]), only, default=_default(info["type"], p),
                                         annotation=python_type(p)))
    out.append(inspect.Parameter("name", only, default=None, annotation="str | None"))
    out.append(inspect.Parameter("each", only, default=None, annotation="dict[str, Any] | None"))
    return inspect.Signature(out, return_annotation="Node")


def _wrapped(text, indent):
    return textwrap.fill(text, 100, initial_indent=indent, subsequent_indent=indent)


def documentation(info):
    """The text of the reference page of a node type."""
    out = [_wrapped(info["doc"], "")]
    if info["source"]:
        out += ["", _wrapped("Source: " + info["source"], "")]
    for title, ports in (("Inputs", info["inputs"]), ("Outputs", info["outputs"])):
        if ports:
            out += ["", title]
        for p in ports:
            kind = " or ".join(p["types"]) or "any"
            out.append(f"  {p['name']}: {kind}{', a list' if p['many'] else ''}{', optional' if p['optional'] else ''}")
            out.append(_wrapped(p["doc"], "      "))
    shown = [p for p in info["parameters"] if p["name"] != hidden]
    if shown:
        out += ["", "Parameters"]
    for p in shown:
        default = "required" if p.get("default") is None else f"default {_core.default_text(info['type'], p['name'])}"
        limits = _core.range_text(info["type"], p["name"])
        facts = [p["kind"], default + (f" {p['unit']}" if p["unit"] else "")] + ([limits] if limits else [])
        out.append(f"  {argument(p['name'])}: {'; '.join(facts)}")
        out.append(_wrapped(p["doc"], "      "))
    out += ["", "  name: the node's name in the graph; by default the type's name in lower case.",
            "  each: repeats the node: {'k': range(4)} for four nodes whose parameters contain '${k}'."]
    return "\n".join(out)


def register(type_name):
    """Makes a node type a method of Graph, with its signature and documentation."""

    def add(graph, /, **values):
        return graph._add(type_name, values)

    info = _core.node_type(type_name)
    graph = inspect.Parameter("graph", inspect.Parameter.POSITIONAL_ONLY, annotation="Graph")
    add.__name__ = add.__qualname__ = type_name
    add.__module__ = "terrazzo.nodes"
    add.__signature__ = _signature(info, [graph])
    add.__doc__ = documentation(info)
    setattr(Graph, type_name, add)


class Nodes:
    """All node types: help(terrazzo.nodes.Anneal) shows one, dir(terrazzo.nodes) lists them."""

    def __dir__(self):
        return [name for name in _core.node_types() if not name.startswith("Given")]

    def __iter__(self):
        return iter(dir(self))

    def __getattr__(self, name):
        if name.startswith("_") or name not in _core.node_types():
            raise AttributeError(f"there is no node type '{name}'")
        return Graph.__dict__[name]


nodes = Nodes()
for _name in nodes:
    register(_name)
