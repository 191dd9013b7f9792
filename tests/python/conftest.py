"""Tests of the Python module. `./dev test Python` builds the module and runs them."""

import os
import pathlib
import subprocess
import sys

import pytest

SOURCE = pathlib.Path(__file__).resolve().parents[2]

os.environ["TERRAZZO_PROGRESS"] = "0"
os.environ["MPLBACKEND"] = "Agg"


# AddressSanitizer keeps freed memory for a while, so the growth of a process means nothing.
needs_plain_memory = pytest.mark.skipif("libasan" in os.environ.get("LD_PRELOAD", ""), reason="AddressSanitizer keeps memory")


def resident():
    """Memory of the process in bytes."""
    with open("/proc/self/statm") as f:
        return int(f.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.fixture(autouse=True)
def own_folders(tmp_path, monkeypatch):
    """Each test has a working folder and a cache of its own."""
    work = tmp_path / "work"
    work.mkdir()
    monkeypatch.chdir(work)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


@pytest.fixture
def section():
    """The sample photograph of the repository, 80 mm wide."""
    return SOURCE / "graphs" / "samples" / "section.png"


@pytest.fixture
def script(tmp_path):
    """Runs text as a script in a fresh interpreter, and returns the finished process."""
    def run(text, timeout=120, arguments=(), **options):
        file = tmp_path / "script.py"
        file.write_text(text)
        return subprocess.run([sys.executable, str(file), *map(str, arguments)], capture_output=True, text=True, timeout=timeout, **options)
    return run
