"""Sweeps: one graph at many settings."""

from __future__ import annotations

import collections.abc
import csv
import io
import itertools
import os

from . import _core
from ._errors import Error
from ._paths import path_text
from ._progress import drawing
from ._run import Run, until_exit


class PointValues(collections.abc.Sequence):
    """The values of one point, as a list that reads each from the cache when it is asked for.

    A value that the cache has dropped is computed again.
    """

    def __init__(self, kept):
        self._kept = kept

    def __len__(self):
        return len(self._kept)

    def __getitem__(self, index):
        if isinstance(index, slice):
            return PointValues(self._kept[index])
        kept = self._kept[index]
        if isinstance(kept, list):  # of a repeated node
            return [until_exit(element.value) for element in kept]
        return None if kept is None else until_exit(kept.value)

    def __eq__(self, other):
        if not isinstance(other, (PointValues, list, tuple)):
            return NotImplemented
        return list(self) == list(other)

    __hash__ = None

    def __repr__(self):
        return f"<{len(self)} values>"

    def __reduce__(self):  # processes share no cache in memory
        return list, (list(self),)


class Sweep:
    """The results of a sweep, a point for each combination; the last parameter varies fastest.

    points: a dictionary for each point: the varied values, `status` ("done" or "failed"), `seconds`, and every
    metric as NODE.METRIC. values: for each point, the values of the targets that are outputs, or None if the point
    failed. They are read from the cache when they are asked for, so a sweep may have more than fit in memory.
    errors: the Error of each point, or None.
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

    def save(self, file):
        """Writes the points as a table like sweep.csv of `terrazzo sweep`."""
        out = io.StringIO()
        rows = csv.writer(out, lineterminator="\n")
        rows.writerow(["point"] + self.columns)
        for number, point in enumerate(self.points, 1):
            rows.writerow([_folder(number)] + [point.get(c, "") for c in self.columns])
        _core.write_text(path_text(file), out.getvalue())

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
    most = 100_000
    points = [()]
    for target, values in vary.items():
        values = list(itertools.islice(values, most + 1))
        if not values:
            raise ValueError(f"there are no values for '{target}'")
        if len(points) * len(values) > most:
            raise ValueError(f"the sweep has more than {most:,} points")
        points = [point + ((target, value),) for point in points for value in values]
    return points


def _folder(number):
    return f"point-{number:03}"


class _Points:
    """Starts the points of a sweep in order, `jobs` at a time, and collects their results in order."""

    def __init__(self, graph, points, targets, out, jobs):
        self._graph, self._points, self._targets, self._out, self._jobs = graph, points, targets, out, jobs
        self._threads = max(1, (graph._threads or os.cpu_count() or 1) // jobs)
        self._next = 0
        self.started = []

    def start_more(self):
        while self._next < len(self._points) and sum(not run.done for run in self.started) < self._jobs:
            for target, value in self._points[self._next]:
                _set(self._graph, target, value)
            self._next += 1
            folder = os.path.join(self._out, _folder(self._next))
            # Later points edit the graph, which must not cancel this one.
            self.started.append(Run(self._graph, self._targets, folder, apart=self._threads))

    def first(self, progress):
        """The next run in order, when it is done."""
        self.start_more()
        run = self.started[0]
        draw = drawing(run._core, progress)

        def tick(end):
            if draw is not None:
                draw(end)
            self.start_more()

        try:
            run._core.wait(tick)
        finally:
            if draw is not None:
                draw.clear()
        return self.started.pop(0)

    def stop(self):
        for run in self.started:
            run.cancel()
        for run in self.started:
            run._core.wait(None)


def sweep(graph, vary, targets, out, jobs, progress):
    if not vary:
        raise ValueError("vary names no parameter")
    if jobs < 1:
        raise ValueError(f"jobs must be at least 1; it is {jobs}")
    points = _points(vary)
    before = {target: _get(graph, target) for target in vary}
    outputs = [t for t in targets if isinstance(t, _core.Output) or isinstance(t, str) and "." in t]
    result = Sweep(list(vary))
    runs = _Points(graph, points, targets, path_text(out), jobs)
    try:
        for point in points:  # errors of any point are found before the first one runs
            for target, value in point:
                _set(graph, target, value)
            graph.check()
        for point in points:
            run = runs.first(progress)
            error = None
            try:
                run.result(False)
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
            result.values.append(PointValues([None if error else run._keep(o) for o in outputs]))
    finally:
        runs.stop()
        for target, value in before.items():
            _set(graph, target, value)
    return result


def _cell(text):
    """A cell of sweep.csv: a number if it is one, None if it is empty."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text or None


def read_sweep(file):
    """The results of `terrazzo sweep`: its output folder, or a sweep.csv. Returns a Sweep without values.

    Numbers are numbers, empty cells None. A point that was not run has the status "not run". Raises Error
    "sweep-file" if the file is no such table.
    """
    file = path_text(file)
    if os.path.isdir(file):
        file = os.path.join(file, "sweep.csv")
    if os.path.exists(file) and not os.path.isfile(file):
        _wrong(file, "it is not a regular file")
    try:
        with open(file, newline="", encoding="utf-8") as text:
            rows = list(csv.reader(text))
    except (UnicodeDecodeError, csv.Error) as e:
        _wrong(file, str(e))
    header = rows[0] if rows else []
    if header[:1] != ["point"] or "status" not in header or header[header.index("status"):][1:2] != ["seconds"]:
        _wrong(file, "its first line does not have the columns point, status and seconds")
    result = Sweep(header[1:header.index("status")])
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(header):
            _wrong(file, f"line {number} has {len(row)} cells instead of {len(header)}")
        cells = {name: cell if name == "status" else _cell(cell) for name, cell in zip(header, row)}
        del cells["point"]
        result.points.append({name: cell for name, cell in cells.items() if cell is not None})
        result.values.append([])
        result.errors.append(None)
    return result


def _wrong(file, why):
    _core.raise_error("sweep-file", f"'{file}' is not a table of a sweep: {why}",
                      "name the output folder of `terrazzo sweep`, or its sweep.csv", "", "")
