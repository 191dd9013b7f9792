"""Sweeps: one graph at many settings."""

from __future__ import annotations

import os

from . import _core
from ._errors import Error
from ._graph import Run, _target


class Sweep:
    """The results of a sweep, a point for each combination; the last parameter varies fastest.

    points: a dictionary for each point: the varied values, `status` ("done" or "failed"), `seconds`, and every
    metric as NODE.METRIC. values: for each point, the values of the targets that are outputs. errors: the
    Error of each point, or None.
    """

    def __init__(self, varied):
        self.varied = varied
        self.points, self.values, self.errors = [], [], []

    def __len__(self):
        return len(self.points)

    @property
    def columns(self):
        """The names of all columns, in the order of sweep.csv."""
        known = dict.fromkeys(self.varied + ["status", "seconds"])
        for name in sorted({k for p in self.points for k in p} - set(known)):
            known[name] = None
        return list(known)

    def __getitem__(self, column):
        """A column as a list; None where a point lacks it."""
        if column not in self.columns:
            raise KeyError(column)
        return [point.get(column) for point in self.points]

    def _repr_html_(self):
        from ._html import table_html
        rows = [[p.get(c, "") for c in self.columns] for p in self.points]
        return table_html(self.columns, rows)

    def __repr__(self):
        return f"<Sweep of {len(self)} points over {', '.join(self.varied)}>"


def _set(graph, target, value):
    node, dot, parameter = target.rpartition(".")
    if dot:
        graph[node][parameter] = value
    else:
        graph.parameters[target] = value


def _get(graph, target):
    """What restores the present value: a value, or None for a default."""
    node, dot, parameter = target.rpartition(".")
    if dot:
        return graph._written_parameter(node, parameter)
    return graph.parameters[target]


def _points(vary):
    points = [()]
    for target, values in vary.items():
        values = list(values)
        if not values:
            raise ValueError(f"there are no values for '{target}'")
        points = [point + ((target, value),) for point in points for value in values]
    return points


def sweep(graph, vary, targets, out, progress):
    if not vary:
        raise ValueError("vary names no parameter")
    points = _points(vary)
    before = {target: _get(graph, target) for target in vary}
    outputs = [t for t in targets if isinstance(t, _core.Output) or isinstance(t, str) and "." in t]
    result = Sweep(list(vary))
    try:
        for point in points:  # errors of any point are found before the first one runs
            for target, value in point:
                _set(graph, target, value)
            graph.check()
        for number, point in enumerate(points, 1):
            for target, value in point:
                _set(graph, target, value)
            folder = os.path.join(os.fspath(out), f"point-{number:03}")
            run = Run(graph, targets, folder)
            error = None
            try:
                run.result(progress)
            except Error as e:
                error = e
            row = dict(point)
            row["status"] = "failed" if error else "done"
            row["seconds"] = run.seconds
            for node, metrics in run.metrics.items():
                for name, value in metrics.items():
                    row[f"{node}.{name}"] = value
            result.points.append(row)
            result.errors.append(error)
            result.values.append([None if error else run.value(o) for o in outputs])
            if run.files:
                run._core.write_report(folder)
    finally:
        for target, value in before.items():
            _set(graph, target, value)
    return result
