"""Calls with random arguments: results or exceptions of Python, never the end of the process."""

import pytest

CALLS = '''
import collections, os, random, sys, warnings
import numpy as np
import terrazzo as t
warnings.simplefilter("ignore")
r = random.Random(int(sys.argv[1]))
TETRAHEDRON = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
picture = t.image(np.random.default_rng(1).random((24, 24, 3)), 0.1)
labels = t.labels(np.pad(np.ones((8, 8), int), 8), 0.1)
h = t.Graph(cache=False)
VALUES = [picture, labels, t.mesh(*TETRAHEDRON), t.sizes([1, 2, 4], [0.01, 0.02]), t.table({"a": [1, 2], "b": ["x", "y"]}),
          t.volume(np.ones((4, 5, 6)), 0.1), h.Segment(image=picture, labels=labels).profiles.value(),
          h.KMatrix(shapes=t.mesh(*TETRAHEDRON), orientations=20).kmatrix.value()]
g = t.Graph(cache=False, memory=1 << 22)

class Strange:
    def __index__(self): raise OSError
    def __float__(self): return float("nan")
    def __len__(self): return -1
    def __iter__(self):
        g.Pattern()
        yield 1
    def __fspath__(self): return "x"
    def __array__(self, *a, **k): return np.zeros((2, 2, 3))

def array():
    dtype = r.choice([np.float64, np.float32, np.int8, np.uint64, bool, complex, "U3", ">f4", object, "M8[s]"])
    a = np.ones([r.randrange(5) for _ in range(r.randrange(5))], dtype).T
    return a[::-1] if a.ndim and r.random() < 0.5 else a

def node():
    return r.choice(g.nodes) if len(g) else None

def output():
    n = node()
    return r.choice([getattr(n, p["name"]) for p in t._core.node_type(n.type)["outputs"]] or [None]) if n is not None else None

ATOMS = [None, True, 0, 1, -1, 2**40, 2**80, 0.5, float("nan"), float("inf"), "", "a", "a.b", "\\udc80", "\\0", "${x}", b"x", "auto", "#808080",
         "pattern", "pattern.image", ".", [], [1, 2, 3], (1, "a"), {}, {"a": [1, 2]}, {"pattern.seed": [1, 2]}, range(3), range(0), g, t, t.Image,
         np.float32(2), np.array(3), len] + VALUES

def thing():
    return r.choice([array, Strange, node, output] + [lambda: r.choice(ATOMS)] * 8)()

def things(most):
    return [thing() for _ in range(r.randrange(most + 1))]

def member(owner, *without):
    """Calls or reads any member of an object."""
    a = getattr(owner, r.choice([m for m in dir(owner) if m not in ("__class__", "__dict__", "__init__", "__new__", *without)]))
    a = a(*things(3)) if callable(a) else a
    if isinstance(a, t.Run):
        a.cancel()
        a.wait(False)

FUNCTIONS = [getattr(t, name) for name in t.__all__ if callable(getattr(t, name)) and name != "Graph"]
NODES = ["Pattern", "Grain", "Segment", "KMatrix", "Distribution", "Palette", "Unfold", "ContactSheet", "Export", "MixShapes", "Compare", "Voxelize"]

def add():
    info = t._core.node_type(r.choice(list(t.nodes)))
    names = [p["name"] for p in info["inputs"] + info["parameters"]] + ["name", "each", "other"]
    getattr(g, info["type"])(**{r.choice(names): thing() for _ in range(r.randrange(5))})

def evaluate():
    info = t._core.node_type(r.choice(NODES))
    fitting = {p["name"]: [v for v in VALUES if v.type in p["types"]] for p in info["inputs"]}
    run = g.start(getattr(g, info["type"])(**{name: r.choice(v) for name, v in fitting.items() if v}))
    if r.random() < 0.5:
        run.cancel()
    run.wait(False)

def edit():
    n = node()
    if len(g) > 20:
        del g[n.name]
    g.rename(n, r.choice(["q", "pattern", "a"]))
    n["seed"] = thing()

def sweep():
    g.sweep({r.choice(["pattern.seed", "grain.noise", "a"]): thing()}, thing(), jobs=r.choice([1, 2]))

def show():
    r.choice([g.to_yaml, g.explain, g.draw, g._repr_html_, lambda: g.save("x.yaml", arrays="arrays"), lambda: t.load("x.yaml", cache=False)])()

STEPS = [add, evaluate, edit, sweep, show, lambda: r.choice(FUNCTIONS)(*things(3)), lambda: member(r.choice(VALUES)), lambda: member(node()),
         lambda: member(g, "_cache", "_threads", *t.nodes)]
count = collections.Counter()
for _ in range(int(sys.argv[2])):
    try:
        r.choice(STEPS)()
        count["done"] += 1
    except Exception as e:
        count[type(e).__name__] += 1
        if isinstance(e, (RuntimeError, SystemError)):  # as pybind11 raises where nobody checked
            raise
print(count["done"] > 100, count["Error"] > 100)
'''


@pytest.mark.parametrize("seed", range(4))
def test_random_calls(seed, script):
    done = script(CALLS, arguments=(seed, 1500))
    assert (done.returncode, done.stdout, done.stderr) == (0, "True True\n", ""), done.stderr[-3000:]
