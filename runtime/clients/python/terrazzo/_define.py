"""Nodes written in Python."""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
import types
import typing

from . import _core
from ._nodes import nodes, register


class Range:
    """Limits and documentation of a parameter: level: Annotated[float, Range(0, 1, unit="mm", doc="Threshold")]."""

    def __init__(self, min=None, max=None, *, unit="", doc=""):
        self.min, self.max, self.unit, self.doc = min, max, unit, doc


_kinds = {bool: "bool", int: "int", float: "number", str: "text"}
_lists = {int: "ints", float: "numbers", str: "texts"}


def _value_type(annotation):
    return annotation.__name__ if isinstance(annotation, type) and issubclass(annotation, _core.Value) else None


def _optional(annotation):
    """The type in `X | None`, or None."""
    if typing.get_origin(annotation) in (typing.Union, types.UnionType):
        rest = [a for a in typing.get_args(annotation) if a is not type(None)]
        if len(rest) == 1 and len(rest) < len(typing.get_args(annotation)):
            return rest[0]
    return None


def _snake(name):
    return re.sub(r"(?<=[a-z0-9])([A-Z])", r"_\1", name).lower()


def _camel(name):
    return "".join(part[:1].upper() + part[1:] for part in name.split("_"))


def _source(function):
    """The source without comments and documentation, so that changing those keeps the cache.

    Decorators stay: those below @node are part of the function that runs.
    """
    try:
        text = textwrap.dedent(inspect.getsource(function))
    except (OSError, TypeError):
        raise ValueError(f"the source of {function.__name__} cannot be read, so its results cannot be cached; "
                         "define it in a file or in a notebook") from None
    tree = ast.parse(text)
    for item in ast.walk(tree):
        if isinstance(item, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
            if ast.get_docstring(item) is not None:
                item.body = item.body[1:] or [ast.Pass()]
    return ast.unparse(tree)


def _parameter(function, name, annotation, default):
    limits = Range()
    if typing.get_origin(annotation) is typing.Annotated:
        for extra in annotation.__metadata__:
            if isinstance(extra, Range):
                limits = extra
        annotation = annotation.__origin__
    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)
    choices = []
    if origin is typing.Literal:
        kind, choices = "choice", [str(a) for a in arguments]
    elif origin in (list, tuple) and arguments and arguments[0] in _lists:
        kind = _lists[arguments[0]]
    elif annotation in _kinds:
        kind = _kinds[annotation]
    else:
        raise TypeError(f"{function.__name__}: the parameter '{name}' has the type {annotation}; use bool, int, float, "
                        "str, a Literal of words, a list of these, or a value such as terrazzo.Image")
    return {"name": name, "kind": kind, "doc": limits.doc or f"Parameter {name}", "unit": limits.unit,
            "choices": choices, "min": limits.min, "max": limits.max,
            "default": None if default is inspect.Parameter.empty else default}


def _define(function, version, name, outputs):
    if not isinstance(version, int) or version < 1:
        raise ValueError("the version of a node is a whole number of at least 1")
    if not isinstance(function, types.FunctionType):
        raise TypeError(f"a node is a function that is written with def, not a {type(function).__name__}")
    if function.__code__.co_freevars:
        raise ValueError(f"{function.__name__} uses the variables {', '.join(function.__code__.co_freevars)} of the "
                         "function around it, which no key can contain; pass them as parameters")
    type_name = name or _camel(function.__name__)
    hints = typing.get_type_hints(function, include_extras=True)
    inputs, parameters = [], []
    for p in inspect.signature(function).parameters.values():
        if p.kind not in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY):
            raise TypeError(f"{function.__name__}: '{p}' cannot be an input or a parameter")
        if p.name not in hints:
            raise TypeError(f"{function.__name__}: '{p.name}' needs a type")
        annotation = hints[p.name]
        plain = _optional(annotation)
        base = plain or annotation
        many = typing.get_origin(base) is list and _value_type(typing.get_args(base)[0])
        kind = many or _value_type(base)
        if kind:
            if (plain is not None) != (p.default is None):
                raise TypeError(f"{function.__name__}: an optional input is written '{p.name}: {kind} | None = None'")
            inputs.append({"name": p.name, "type": kind, "doc": f"Input {p.name}", "optional": plain is not None,
                           "many": bool(many)})
        else:
            parameters.append(_parameter(function, p.name, annotation, p.default))
    if outputs is None:
        kind = _value_type(hints.get("return"))
        if not kind:
            raise TypeError(f"{function.__name__} must return a value such as terrazzo.Image; for several outputs, pass "
                            "outputs={'image': terrazzo.Image, …} to the decorator and return a dictionary")
        outputs = {_snake(kind): hints["return"]}
    ports = []
    for port, kind in outputs.items():
        if not _value_type(kind):
            raise TypeError(f"{function.__name__}: the output '{port}' is no type of values")
        ports.append({"name": port, "type": _value_type(kind), "doc": f"Output {port}"})
    source = _core.hash_text(f"{function.__module__}.{type_name} {version}\n{_source(function)}")
    _core.define_node(type_name, version, inspect.getdoc(function) or f"The function {function.__name__} in Python",
                      inputs, ports, parameters, source, function)
    register(type_name)
    return function


def node(function=None, *, version=1, name=None, outputs=None):
    """Makes a function a node type: @terrazzo.node(version=1).

    Parameters whose types are values (terrazzo.Image, Labels, …) are inputs, the others parameters, which need
    types: bool, int, float, str, Literal of words, or lists; Annotated with terrazzo.Range gives limits. The
    function returns a value; with `outputs`, a dictionary of values by name. graph.Name(…) adds the node; the
    function itself stays callable. `name`: the node type; by default the function's in CamelCase.

    Results are cached by inputs, parameters, the version and the function's source. Functions and data that it
    uses from elsewhere are not in the key: raise the version when they change. Calls hold the GIL, so
    two nodes never run Python code at the same moment.
    """
    if function is not None:
        return _define(function, version, name, outputs)
    return lambda f: _define(f, version, name, outputs)
