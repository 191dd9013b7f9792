"""Paths that the user passes."""

from __future__ import annotations

import os

from . import _core


def path_text(path):
    """A path as text. Raises Error "bad-value" if it is not UTF-8, since graph files and messages are."""
    name = os.fsdecode(path)
    try:
        name.encode()
    except UnicodeEncodeError:
        _core.raise_error("bad-value", f"the path {ascii(name)} is not UTF-8", "rename the file or folder", "", "")
    return name
