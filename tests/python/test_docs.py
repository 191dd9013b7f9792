"""The examples of docs/python.md run, and their types are right."""

import os
import re
import subprocess
import sys

import pytest

from conftest import SOURCE

TEXT = (SOURCE / "docs" / "python.md").read_text()
EXAMPLES = re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL)
# What each example prints, or a part of it.
PRINTED = ["90 % interval", "5 to run", "bad-value pattern width 4", "[", "[", "profiles", "1 0."]


def test_every_example_is_tested():
    assert len(EXAMPLES) == len(PRINTED)
    assert len(EXAMPLES[0].strip().splitlines()) <= 10


@pytest.mark.parametrize("number", range(len(PRINTED)))
def test_example(number, script):
    os.symlink(SOURCE / "graphs", "graphs")
    done = script(EXAMPLES[number], timeout=600)
    assert done.returncode == 0, done.stderr
    assert PRINTED[number] in done.stdout, done.stdout
    if number == 0:
        rows = [[float(x) for x in re.findall(r"[\d.]+", line)] for line in done.stdout.splitlines()]
        assert len(rows) >= 5
        for low, high, n, _, least, most in rows:
            assert low < high and least <= n * 1.001 and n <= most * 1.001 + 1e-5
        # The truth of the sample, graphs/samples/section_N_V.csv, is 0.0134 per mm³ above 1.5 mm.
        assert 0.25 * 0.0134 < sum(row[2] for row in rows if row[0] > 1.5) < 4 * 0.0134
    if number == 4:
        assert open("profiles.png", "rb").read(4) == b"\x89PNG"
        counts = [int(n) for n in re.findall(r"\d+", done.stdout)]
        assert len(counts) == 5 and counts == sorted(set(counts), reverse=True)  # the plot shows something


def mypy(file, *options):
    return subprocess.run(["/usr/bin/mypy", "--strict", "--python-executable", sys.executable, *options, str(file)],
                          capture_output=True, text=True, timeout=600)


def test_the_examples_pass_mypy(tmp_path):
    for number, example in enumerate(EXAMPLES):
        (tmp_path / f"example_{number}.py").write_text(example)
    # The stubs of Matplotlib in Debian are incomplete; numpy and terrazzo are checked.
    (tmp_path / "mypy.ini").write_text("[mypy]\n[mypy-matplotlib.*]\nignore_missing_imports = True\n"
                                       "follow_imports = skip\n")
    done = mypy(tmp_path, "--config-file", str(tmp_path / "mypy.ini"))
    assert done.returncode == 0, done.stdout + done.stderr


def test_mypy_finds_mistakes(tmp_path):
    file = tmp_path / "wrong.py"
    file.write_text("""\
import terrazzo as t
g = t.Graph()
photo = g.LoadImage(path="a.png", pixel_size=0.1)
g.LoadImage(pth="a.png")
g.Segment(image=photo.image, split="much")
g.Unfold(profiles=photo.image)
photo.imag
g.Pattern(kind="fatt")
area: str = g.Segment(image=photo.image).profiles.value().area
g.Segment(image=photo.image).profiles.value().aera
""")
    done = mypy(file)
    errors = [re.match(r"[^:]*:(\d+): error", line) for line in done.stdout.splitlines()]
    lines = sorted({int(error[1]) for error in errors if error})
    assert lines == [4, 5, 6, 7, 8, 9, 10], done.stdout
