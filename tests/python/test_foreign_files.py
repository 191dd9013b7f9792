"""Files of other programs: each is read right, or refused with an error that says what would work.

With `-s`, prints the tables of docs/results/robustness.md.
"""

import collections
import os

import numpy as np
import pytest

import terrazzo as t
from conftest import SOURCE
from foreign import dicom, ebsd, labels, meshes, pictures, reports, stacks, tables, volumes

SAMPLES = [sample for module in (ebsd, volumes, dicom, stacks, pictures, labels, tables, meshes)
           for sample in module.SAMPLES]
REPORTS = SOURCE.parent / "shared" / "data" / "reports"
needs_reports = pytest.mark.skipif(not REPORTS.is_dir(), reason="needs the files from public bug reports")


def difference(name, found, right, tolerance):
    """Says where two values differ; empty if they do not."""
    if isinstance(right, str):
        return "" if found == right else f"{name} is {found} instead of {right}"
    if np.shape(found) != np.shape(right):
        return f"{name} has the shape {np.shape(found)} instead of {np.shape(right)}"
    same = np.isclose(found, right, 1e-6, tolerance)
    if same.all():
        return ""
    first = tuple(map(int, np.argwhere(~same)[0]))
    found, right = np.asarray(found)[first], np.asarray(right)[first]
    return f"{(~same).sum()} of {same.size} {name} are wrong; {first} is {found} instead of {right}"


def outcome_of(path, read, parameters, right, tolerance):
    """"right", "clear error", or what is wrong."""
    try:
        found = read(path, **parameters)
    except t.Error as e:
        if e.code != right:
            return f"{e.code}: {e.message}"
        named = any(file.name in e.message for file in path.parent.iterdir())
        return "clear error" if named and e.hint else f"unclear error: {e.message} ({e.hint})"
    if isinstance(right, str):
        return f"read without the error {right}"
    wrong = [difference(name, found[name], value, tolerance) for name, value in right.items()]
    return "; ".join(filter(None, wrong)) or "right"


@pytest.fixture(scope="module")
def counts():
    """Outcomes by kind. Prints them at the end."""
    by_kind = collections.defaultdict(collections.Counter)
    yield by_kind
    print("\n\n| kind | samples | right | clear error | wrong |\n|---|---|---|---|---|")
    total = sum(by_kind.values(), collections.Counter())
    for kind, found in [*by_kind.items(), ("all", total)]:
        right, refused, samples = found["right"], found["clear error"], sum(found.values())
        print(f"| {kind} | {samples} | {right} | {refused} | {samples - right - refused} |")


@pytest.fixture(scope="module")
def lines():
    """Lines of the table of reports. Prints them at the end."""
    rows = []
    yield rows
    print("\n\n| file | what it is | outcome |\n|---|---|---|")
    print("\n".join(rows))


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda s: f"{s.kind}, {s.name}")
def test_sample(sample, tmp_path, counts):
    path = sample.write(tmp_path)  # skips the test if a module that writes such files is missing
    outcome = outcome_of(path, sample.read, sample.parameters, sample.right, sample.tolerance)
    counts[sample.kind]["wrong" if outcome not in ("right", "clear error") else outcome] += 1
    if outcome not in ("right", "clear error"):
        pytest.fail(outcome)


@needs_reports
@pytest.mark.parametrize("report", reports.REPORTS, ids=lambda r: r.name)
def test_report(report, lines):
    path = REPORTS / report.name
    right = report.right(path) if callable(report.right) else report.right
    outcome = outcome_of(path, report.read, report.parameters, right, report.tolerance)
    code = f": `{report.right}`" if isinstance(report.right, str) else ""
    lines.append(f"| `{report.name}` | {report.what} | {outcome}{code} |")
    if outcome not in ("right", "clear error"):
        pytest.fail(outcome)


@needs_reports
def test_every_report_is_in_the_table():
    named = {report.name.split("/")[0] for report in reports.REPORTS}
    assert set(os.listdir(REPORTS)) <= named | {"plain.png"}
