"""Messages and exceptions."""

from __future__ import annotations


class Diagnostic:
    """A message of the graph, the evaluator or a node.

    severity: "error", "warning" or "note". code: short and stable, for programs (docs/error-codes.md). node,
    parameter, file, line and column say where; they are empty or 0 if unknown. item: which item of the
    parameter's list, from 0, or -1. through: where the enclosing subgraphs are used, as (file, line, column).
    """

    __slots__ = ("severity", "code", "message", "hint", "node", "parameter", "item", "file", "line", "column",
                 "through", "_text")

    def __init__(self, severity, code, message, hint, node, parameter, item, file, line, column, through, text):
        self.severity, self.code, self.message, self.hint = severity, code, message, hint
        self.node, self.parameter, self.item = node, parameter, item
        self.file, self.line, self.column, self.through = file, line, column, tuple(through)
        self._text = text

    def __str__(self):
        return self._text

    def __repr__(self):
        return f"<{self.severity} {self.code}: {self._text}>"

    def __reduce__(self):
        return Diagnostic, (self.severity, self.code, self.message, self.hint, self.node, self.parameter, self.item,
                            self.file, self.line, self.column, self.through, self._text)

    def _repr_html_(self):
        from ._html import diagnostic_html
        return diagnostic_html(self)


class Error(Exception):
    """What is wrong, where, and what to do. Its fields are those of the first error; diagnostics has all."""

    def __init__(self, diagnostics):
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(str(d) for d in self.diagnostics))

    def __reduce__(self):
        return type(self), (self.diagnostics,)

    def _repr_html_(self):
        return "".join(d._repr_html_() for d in self.diagnostics)

    @property
    def _first(self):
        return self.diagnostics[0]

    @property
    def code(self):
        """Short and stable, for programs: "unknown-parameter"."""
        return self._first.code

    @property
    def message(self):
        """What is wrong."""
        return self._first.message

    @property
    def hint(self):
        """What to do; may be empty. For an exception in a node written in Python, its traceback."""
        return self._first.hint

    @property
    def node(self):
        """Name of the node, or ""."""
        return self._first.node

    @property
    def parameter(self):
        """Name of the parameter, or ""."""
        return self._first.parameter

    @property
    def file(self):
        """The graph file, or the script that built the graph."""
        return self._first.file

    @property
    def line(self):
        """Line in the file, from 1; 0 if unknown."""
        return self._first.line

    @property
    def column(self):
        """Column in the file, from 1; 0 if unknown."""
        return self._first.column


class Canceled(Exception):
    """An evaluation was canceled, by Run.cancel() or by an edit that made its nodes obsolete."""

    def __init__(self, message="the evaluation was canceled"):
        super().__init__(message)


class NodeWarning(UserWarning):
    """A problem that a node reports but that does not invalidate its result."""
