"""Memory does not grow with the number of evaluations. docs/results/python.md has ten thousand."""

import gc
import tracemalloc

import numpy as np

import terrazzo as t
from conftest import needs_plain_memory, resident

pytestmark = needs_plain_memory


def grows(step, warm_up, count):
    """Growth of Python's objects and of the process over `count` steps, in bytes."""
    for k in range(warm_up):
        step(k)
    gc.collect()
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0], resident()
    for k in range(warm_up, warm_up + count):
        step(k)
    gc.collect()
    after = tracemalloc.get_traced_memory()[0], resident()
    tracemalloc.stop()
    return after[0] - before[0], after[1] - before[1]


def test_evaluations():
    g = t.Graph(cache=False, memory=1 << 20)
    picture = g.Pattern(width=64, height=64)

    def step(k):
        picture["seed"] = k + 1
        picture.image.value().pixels.sum()

    python, process = grows(step, 100, 500)
    assert python < 200_000  # 500 values of 48 kB would be 24 MB
    assert process < 16_000_000


def test_evaluations_that_find_everything_cached():
    g = t.Graph(cache=False)
    grain = g.Grain(image=g.Pattern(width=16, height=16))

    python, process = grows(lambda k: g.run(grain), 200, 2000)
    assert python < 100_000
    assert process < 8_000_000  # an arena of TBB for each would be 14 MB


def test_cached_values_and_errors():
    g = t.Graph(cache=False)
    picture = g.Pattern(width=64, height=64)

    def step(k):
        picture.image.value().pixels.sum()
        try:
            g.Pattern(kind="wrong")
        except t.Error:
            pass
        repr(picture), dir(picture), picture["seed"], g.to_yaml()

    python, process = grows(step, 200, 2000)
    assert python < 100_000
    assert process < 8_000_000


def test_graphs_and_arrays():
    def step(k):
        g = t.Graph(cache=False)
        image = t.image(np.full((64, 64, 3), k % 100 / 100))
        grain = g.Grain(image=image)
        assert grain.image.value().pixels.shape == (64, 64, 3)
        g.check()

    python, process = grows(step, 20, 150)
    assert python < 100_000
    assert process < 20_000_000  # 150 times 100 kB would be 15 MB for the values alone
