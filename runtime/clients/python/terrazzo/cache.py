"""The disk cache, as `terrazzo cache` shows it."""

from __future__ import annotations

from . import _core
from ._paths import path_text

__all__ = ["clear", "collect", "folder", "stats", "verify"]


def folder():
    """The folder that graphs use unless they name another one."""
    return _core.default_cache()


def _named(cache):
    return folder() if cache is None else path_text(cache)


def stats(cache=None):
    """Number and size of the entries: a dictionary with folder, bytes, limit, values, value_bytes, records,
    record_bytes, values_in_records (small values, which have no file), seconds (computing time of all records) and
    types (count of all values and bytes of those with files, by type)."""
    return _core.cache_stats(_named(cache))


def collect(cache=None, limit=None):
    """Removes leftover files and, above `limit` bytes, the least valuable entries. Returns what was removed."""
    return _core.cache_collect(_named(cache), _core.cache_limit if limit is None else int(limit))


def verify(cache=None, *, sample=0, seed=1):
    """Reads and checks every entry, and removes damaged ones. Recomputes `sample` records, chosen by `seed`, and
    removes those whose results differ. Ctrl-C stops it.

    Returns a dictionary: numbers of `values` and `records` read, of those `recomputed` and `skipped` (other
    versions, missing inputs, written files), and lists of those that are `damaged` and `differing`.
    """
    return _core.cache_verify(_named(cache), int(sample), int(seed))


def clear(cache=None):
    """Removes all entries."""
    _core.cache_clear(_named(cache))
