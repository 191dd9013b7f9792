"""Writes the type stubs of the package from the registry: python3 -m terrazzo.stubs FILE.

The node types are only known at run time, so editors and mypy need this file to know them.
"""

from __future__ import annotations

import inspect
import re
import sys
import textwrap

import terrazzo as t
from terrazzo import _core
from terrazzo._nodes import argument, hidden, python_type

HEAD = '''"""Terrazzo. Written by terrazzo.stubs."""

from os import PathLike
from typing import (Any, Callable, Generic, Iterable, Iterator, Literal, Mapping, Sequence, TypeVar, overload)

import numpy as np
import numpy.typing as npt

_F64 = npt.NDArray[np.float64]
_F32 = npt.NDArray[np.float32]
_I32 = npt.NDArray[np.int32]
_Bools = npt.NDArray[np.bool_]
_Path = str | PathLike[str]
_Each = Mapping[str, "range | str | Sequence[str | float] | ParameterReference"]
_V = TypeVar("_V", bound="Value", covariant=True)
_C = TypeVar("_C", bound=Callable[..., Any])

__version__: str

class Diagnostic:
    severity: str
    code: str
    message: str
    hint: str
    node: str
    parameter: str
    item: int
    file: str
    line: int
    column: int
    through: tuple[tuple[str, int, int], ...]

class Error(Exception):
    diagnostics: tuple[Diagnostic, ...]
    @property
    def code(self) -> str: ...
    @property
    def message(self) -> str: ...
    @property
    def hint(self) -> str: ...
    @property
    def node(self) -> str: ...
    @property
    def parameter(self) -> str: ...
    @property
    def file(self) -> str: ...
    @property
    def line(self) -> int: ...
    @property
    def column(self) -> int: ...

class Canceled(Exception): ...
class NodeWarning(UserWarning): ...

class ParameterReference:
    name: str

class Output(Generic[_V]):
    graph: Graph
    node: Node
    port: str
    type: str
    reference: str
    def value(self) -> _V: ...
    def values(self) -> list[_V]: ...

class Node:
    graph: Graph
    name: str
    type: str
    outputs: list[str]
    each: dict[str, str | list[str]]
    def output(self, name: str) -> Output[Any]: ...
    def set(self, **values: Any) -> None: ...
    def __getitem__(self, parameter: str) -> Any: ...
    def __setitem__(self, parameter: str, value: Any) -> None: ...

class AnyNode(Node):
    """A node whose type is not known beforehand, as in graph["segment"]."""
    def __getattr__(self, output: str) -> Output[Any]: ...

class Run:
    done: bool
    seconds: float
    nodes: list[dict[str, Any]]
    metrics: dict[str, dict[str, float]]
    files: list[str]
    def cancel(self) -> None: ...
    def progress(self) -> dict[str, Any]: ...
    def wait(self, progress: bool | None = None) -> Run: ...
    def result(self, progress: bool | None = None) -> Run: ...
    def value(self, output: Output[_V]) -> _V: ...

class Step:
    node: str
    step: Literal["cached", "runs", "may run"]
    reasons: list[str]
    seconds: float
    bytes: int

class Plan(list[Step]): ...

class Sweep:
    varied: list[str]
    points: list[dict[str, Any]]
    values: list[Sequence[Any]]
    errors: list[Error | None]
    columns: list[str]
    def __len__(self) -> int: ...
    def __getitem__(self, column: str) -> list[Any]: ...
    def save(self, file: _Path) -> None: ...

class Parameters:
    def __getitem__(self, name: str) -> Any: ...
    def __setitem__(self, name: str, value: Any) -> None: ...
    def __iter__(self) -> Iterator[str]: ...
    def __len__(self) -> int: ...
    def __contains__(self, name: object) -> bool: ...
    def keys(self) -> Iterable[str]: ...
    def items(self) -> list[tuple[str, Any]]: ...

class Range:
    def __init__(self, min: float | None = None, max: float | None = None, *, unit: str = "", doc: str = "") -> None: ...

@overload
def node(function: _C, *, version: int = 1, name: str | None = None,
         outputs: Mapping[str, type[Value]] | None = None) -> _C: ...
@overload
def node(function: None = None, *, version: int = 1, name: str | None = None,
         outputs: Mapping[str, type[Value]] | None = None) -> Callable[[_C], _C]: ...
def metric(name: str, value: float) -> None: ...
def warn(message: str) -> None: ...
def progress(fraction: float, note: str = "") -> None: ...

def load(file: _Path, *, cache: bool | _Path = True, memory: int = 0, file_memory: int = 0, threads: int = 0,
         **parameters: Any) -> Graph: ...
def read_sweep(file: _Path) -> Sweep: ...
def reproduce(file: _Path, *, allow_read: Sequence[_Path] = (), cache: bool | _Path = True) -> Graph: ...
def image(array: npt.ArrayLike, pixel_size: float = 1.0, *, srgb: bool | None = None) -> Image: ...
def labels(array: npt.ArrayLike, pixel_size: float = 1.0, *, classes: npt.ArrayLike | None = None) -> Labels: ...
def mesh(vertices: npt.ArrayLike, triangles: npt.ArrayLike, name: str = "mesh") -> Shapes: ...
def sizes(class_edges: npt.ArrayLike, N_V: npt.ArrayLike, *, low: npt.ArrayLike | None = None,
          high: npt.ArrayLike | None = None) -> SizeDistribution: ...
def volume(grids: Any, voxel_size: float | Sequence[float] | None = None, *, name: str = "density",
           period: bool | Sequence[int] | None = None) -> Volume: ...
def table(columns: Mapping[str, Sequence[float | str] | _F64]) -> Table: ...

class cache:
    @staticmethod
    def folder() -> str: ...
    @staticmethod
    def stats(cache: _Path | None = None) -> dict[str, Any]: ...
    @staticmethod
    def collect(cache: _Path | None = None, limit: int | None = None) -> dict[str, Any]: ...
    @staticmethod
    def clear(cache: _Path | None = None) -> None: ...
    @staticmethod
    def verify(cache: _Path | None = None, *, sample: int = 0, seed: int = 1) -> dict[str, Any]: ...

class Value:
    type: str
    content: str
    def describe(self, full: bool = False) -> Any: ...
    def save(self, file: _Path) -> None: ...
'''

GRAPH = '''
class Graph:
    name: str
    doc: str
    def __init__(self, name: str = "", *, doc: str = "", cache: bool | _Path = True, memory: int = 0,
                 file_memory: int = 0, threads: int = 0) -> None: ...
    @property
    def nodes(self) -> list[AnyNode]: ...
    @property
    def parameters(self) -> Parameters: ...
    @property
    def outputs(self) -> dict[str, Output[Any]]: ...
    @property
    def file(self) -> str: ...
    def __getitem__(self, name: str) -> AnyNode: ...
    def __delitem__(self, name: str) -> None: ...
    def __contains__(self, name: object) -> bool: ...
    def __iter__(self) -> Iterator[AnyNode]: ...
    def __len__(self) -> int: ...
    def __getattr__(self, output: str) -> Any: ...
    def rename(self, node: Node | str, name: str) -> None: ...
    def parameter(self, name: str, type: str, default: Any = None, *, doc: str = "", unit: str = "",
                  min: float | None = None, max: float | None = None, choices: Sequence[str] = (),
                  keywords: Sequence[str] = ()) -> ParameterReference: ...
    def reference(self, name: str) -> ParameterReference: ...
    def output(self, name: str, output: Output[Any] | Node | None) -> None: ...
    def input(self, name: str, output: Output[Any] | Node | None) -> None: ...
    def subgraph(self, file: _Path, *, name: str | None = None, **values: Any) -> AnyNode: ...
    def save(self, file: _Path, *, flat: bool = False, arrays: _Path | None = None) -> None: ...
    def to_yaml(self, folder: _Path = ".", *, flat: bool = False) -> str: ...
    def check(self) -> list[Diagnostic]: ...
    def start(self, *targets: Node | Output[Any] | str, out: _Path = "out") -> Run: ...
    def run(self, *targets: Node | Output[Any] | str, out: _Path = "out", progress: bool | None = None) -> Run: ...
    def explain(self, *targets: Node | Output[Any] | str, out: _Path = "out") -> Plan: ...
    def sweep(self, vary: Mapping[str, Iterable[Any]], *targets: Node | Output[Any] | str,
              out: _Path = "out", jobs: int = 1,
              progress: bool | None = None) -> Sweep: ...
    def draw(self, format: Literal["svg", "dot", "mermaid"] = "svg") -> str: ...
'''

PARTS = {"Mesh": {"vertices": "_F64", "triangles": "_I32"},
         "Shape": {"name": "str", "mesh": "Mesh"},
         "SizeDistributionEntry": {"shape": "int", "cls": "int"},
         "KMatrixEntry": {}, "Stroke": {"area": "bool", "parts": "list[_F64]"}, "DetailPhase": {}}
LISTS = {"SizeDistribution.entries": "SizeDistributionEntry", "KMatrix.entries": "KMatrixEntry",
         "Strokes.strokes": "Stroke", "Detail.phases": "DetailPhase"}
METHODS = {
    "Profiles": ["def contour(self, index: int) -> _F64: ..."],
    "Shapes": ["def __getitem__(self, index: int) -> Shape: ...", "def __iter__(self) -> Iterator[Shape]: ..."],
    "Table": ["def __getitem__(self, column: str) -> Any: ...", "def to_dict(self) -> dict[str, Any]: ...",
              "def to_numpy(self) -> _F64: ...", "def to_pandas(self) -> Any: ..."],
    "Volume": ["def origin(self, name: str) -> tuple[int, int, int]: ...",
               "def dense(self, name: str) -> npt.NDArray[Any]: ...", "def to_pyopenvdb(self) -> list[Any]: ..."],
}
PLAIN = {"width": "int", "height": "int", "sections": "int", "count": "int", "class_count": "int", "classes": "int",
         "window": "tuple[float, float]", "box": "tuple[float, float, float]", "columns": "list[str]",
         "rows": "list[tuple[float | str, ...]]", "grids": "list[str]", "resolution": "tuple[int, int, int]",
         "size": "int", "name": "str", "cls": "int"}


def _type_of(owner, name, doc):
    if f"{owner}.{name}" in LISTS:
        return f"list[{LISTS[f'{owner}.{name}']}]"
    if name in PARTS.get(owner, {}):
        return PARTS[owner][name]
    for start, kind in (("float32", "_F32"), ("float64", "_F64"), ("int32", "_I32"), ("bool (n)", "_Bools")):
        if doc.startswith(start):
            return kind
    if name in ("color", "binder_color"):
        return "_F32"
    if owner == "Shape" and name == "size":
        return "float"
    return PLAIN.get(name, "float")


def _quoted(text):
    text = " ".join(text.split()).replace("\\", "\\\\").replace('"""', "'''")
    return f'"""{text}{" " if text.endswith(chr(34)) else ""}"""'


def _value_class(name, base):
    cls = getattr(_core, name)
    out = [f"class {name}{base}:", f"    {_quoted(cls.__doc__ or name)}"]
    for field, member in sorted(vars(cls).items()):
        if isinstance(member, property) and not field.startswith("_"):
            doc = member.__doc__ or ""
            out += ["    @property", f"    def {field}(self) -> {_type_of(name, field, doc)}:", f"        {_quoted(doc)}",
                    "        ..."]
    if hasattr(cls, "__len__"):
        out.append("    def __len__(self) -> int: ...")
    if name in ("Image", "Labels"):
        out.append("    def __array__(self, dtype: Any = None, copy: bool | None = None) -> npt.NDArray[Any]: ...")
    out += ["    " + m for m in METHODS.get(name, [])]
    return out + [""]


def _given(types, many):
    known = [k for k in types if k in t.__all__]
    if not known or len(known) < len(types):
        base = "Output[Any] | Node | Value"
    else:
        base = " | ".join(f"Output[{k}] | {k}" for k in known) + " | Node"
    return f"Sequence[{base}] | {base}" if many else base


def _node(type_name):
    info = _core.node_type(type_name)
    cls = [f"class {type_name}Node(Node):", f"    {_quoted(info['doc'])}"]
    for port in info["outputs"]:
        kind = port["types"][0] if port["types"][0] in t.__all__ else "Value"
        cls += ["    @property", f"    def {port['name']}(self) -> Output[{kind}]:", f"        {_quoted(port['doc'])}",
                "        ..."]
    arguments = []
    for port in info["inputs"]:
        optional = " | None = None"  # a required input may be connected later with set()
        shared = "".join(" | " + python_type(p) for p in info["parameters"] if p["name"] == port["name"])
        arguments.append(f"{argument(port['name'])}: {_given(port['types'], port['many'])}{shared}{optional}")
    inputs = {port["name"] for port in info["inputs"]}
    for p in info["parameters"]:
        if p["name"] != hidden and p["name"] not in inputs:
            kind = python_type(p)
            arguments.append(f"{argument(p['name'])}: {kind} | ParameterReference | None = ...")
    arguments += ["name: str | None = None", "each: _Each | None = None"]
    lines = textwrap.wrap(", ".join(arguments), 110, break_long_words=False, break_on_hyphens=False)
    text = "\n                ".join(lines)
    doc = [_quoted(info["doc"])[3:-3]]
    for p in info["inputs"]:
        doc.append(f"{p['name']}: {p['doc']}")
    for p in info["parameters"]:
        if p["name"] == hidden:
            continue
        limits = _core.range_text(type_name, p["name"])
        facts = ", ".join(f for f in (p["unit"], limits) if f)
        doc.append(f"{p['name']}{f' ({facts})' if facts else ''}: {p['doc']}")
    doc = "\n\n        ".join(" ".join(d.split()).replace("\\", "\\\\").replace('"""', "'''") for d in doc)
    method = [f"    def {type_name}(self, *, {text}) -> {type_name}Node:", f'        """{doc}\n        """',
              "        ..."]
    return cls + [""], method


def _library(name, folder):
    out = [f"class _{name.capitalize()}:"]
    for graph in folder:
        signature = inspect.signature(getattr(folder, graph))
        arguments = [f"{p}: Any = ..." for p in signature.parameters]
        text = "\n            ".join(textwrap.wrap(", ".join(arguments), 110))
        out.append(f"    def {graph}(self, *, {text}) -> Graph: ...")
    return out + ["", f"{name}: _{name.capitalize()}", ""]


def text():
    """The text of terrazzo/__init__.pyi."""
    out = [HEAD]
    for name in PARTS:
        out += _value_class(name, "")
    for name in ("Image", "Labels", "Profiles", "SizeDistribution", "Shapes", "Particles", "Table", "KMatrix", "Strokes",
                 "Detail", "Volume"):
        out += _value_class(name, "(Value)")
    methods = []
    for name in t.nodes:
        cls, method = _node(name)
        out += cls
        methods += method
    out.append(GRAPH)
    out += methods + [""]
    out += ["class _Nodes:", "    def __iter__(self) -> Iterator[str]: ..."]
    out += [f"    {name}: Callable[..., {name}Node]" for name in t.nodes]
    out += ["", "nodes: _Nodes", ""]
    out += _library("library", t.library) + _library("materials", t.materials)
    return re.sub(r"\n{3,}", "\n\n", "\n".join(out)) + "\n"


if __name__ == "__main__":
    written = text()
    if len(sys.argv) > 1:
        with open(sys.argv[1], "w", encoding="utf-8") as file:
            file.write(written)
    else:
        sys.stdout.write(written)
