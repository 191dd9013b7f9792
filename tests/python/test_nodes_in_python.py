"""Nodes written in Python."""

import functools
import gc
import time
import traceback
import warnings
import weakref
from typing import Annotated, Literal

import numpy as np
import pytest

import terrazzo as t

calls = []


@t.node(version=1)
def darken(image: t.Image, factor: Annotated[float, t.Range(0, 1, doc="Factor of the colors")] = 0.5,
           how: Literal["all", "red"] = "all") -> t.Image:
    """Makes an image darker."""
    calls.append(factor)
    pixels = image.pixels.copy()
    pixels[..., slice(None) if how == "all" else 0] *= factor
    t.metric("mean", pixels.mean())
    return t.image(pixels, image.pixel_size)


@t.node(version=1, outputs={"low": t.Image, "count": t.Table})
def split(images: list[t.Image], mask: t.Labels | None = None, levels: list[float] = [0.5]):
    t.warn(f"{len(images)} images")
    return {"low": images[0], "count": t.table({"n": [len(images)], "mask": [0 if mask is None else mask.count]})}


def graph(cache=False):
    g = t.Graph(cache=cache)
    return g, g.Pattern(kind="fat", width=32, height=32)


def test_it_is_a_node_like_any_other():
    g, dots = graph()
    dark = g.Darken(image=dots.image, factor=0.25)
    assert np.allclose(dark.image.value().pixels, dots.image.value().pixels * 0.25)
    assert g.run(dark).metrics["darken"]["mean"] == pytest.approx(dark.image.value().pixels.mean(), rel=1e-5)
    assert "Factor of the colors" in t.nodes.Darken.__doc__ and "source_hash" not in t.nodes.Darken.__doc__
    with pytest.raises(t.Error):
        dark["factor"] = 2
    with pytest.raises(t.Error, match="is not one of all, red"):
        dark["how"] = "blue"
    assert g.Grain(image=dark.image).image.value().width == 32


def test_several_inputs_and_outputs():
    g, dots = graph()
    with pytest.warns(t.NodeWarning, match="2 images"):
        table = g.Split(images=[dots.image, dots.image], mask=t.labels([[1, 2]])).count.value()
    assert table.rows == [(2.0, 2.0)]


def test_results_are_cached_on_disk():
    def evaluate(factor):
        g, dots = graph(cache=True)
        return g.Darken(image=dots.image, factor=factor).image.value()

    calls.clear()
    first = evaluate(0.125)
    assert evaluate(0.125) == first and calls == [0.125]
    evaluate(0.375)
    assert calls == [0.125, 0.375]


MODULE = '''
import terrazzo as t
@t.node(version={version})
def brighten(image: t.Image) -> t.Image:
    """{doc}"""
    print("called")
    return t.image(image.pixels {operation}, image.pixel_size)   # {comment}
g = t.Graph()
print(round(float(g.Brighten(image=g.Pattern(kind="fat", width=32, height=32).image).image.value().pixels.max()), 3))
'''


def test_version_and_source_are_in_the_key(script):
    def run(version=1, doc="Brightens", operation="* 2", comment="x"):
        done = script(MODULE.format(version=version, doc=doc, operation=operation, comment=comment))
        assert done.returncode == 0, done.stderr
        return "called" in done.stdout

    assert run()
    assert not run()
    assert not run(doc="Makes it brighter", comment="y")
    assert run(operation="* 3")
    assert run(version=2)
    assert not run()


def test_decorators_inside_of_a_node_are_in_the_key(script):
    def run(factor):
        done = script(f'''
import terrazzo as t
def times(factor):
    return lambda function: lambda: factor * function()
@t.node
def number() -> t.Table:
    print("called")
    @times({factor})
    def one():
        return 1
    return t.table({{"a": [one()]}})
print(t.Graph().Number().table.value()["a"][0])
''')
        assert done.returncode == 0, done.stderr
        return done.stdout

    assert (run(2), run(2), run(3)) == ("called\n2.0\n", "2.0\n", "called\n3.0\n")


def test_redefining_a_node(script):
    done = script('''
import terrazzo as t
def define(k):
    namespace = {"t": t}
    text = f"def number() -> t.Table:\\n    return t.table({{'k': [{k}]}})\\n"
    import linecache
    linecache.cache[f"cell {k}"] = (len(text), None, text.splitlines(True), f"cell {k}")
    exec(compile(text, f"cell {k}", "exec"), namespace)
    return t.node(version=1)(namespace["number"])
define(1)
g = t.Graph(cache=False)
node = g.Number()
print(node.table.value()["k"][0])
define(2)
h = t.Graph(cache=False)
print(h.Number().table.value()["k"][0], node.table.value()["k"][0])
g.check()
''')
    assert done.stdout == "1.0\n2.0 1.0\n", (done.stdout, done.stderr)


@t.node
def wrong(kind: str = "raise") -> t.Image:
    if kind == "raise":
        return broken_helper()
    if kind == "type":
        return 3
    if kind == "value":
        return t.table({})
    raise SystemExit


def broken_helper():
    raise KeyError("the user's key")


def test_errors_carry_the_users_traceback():
    g = t.Graph(cache=False)
    node = g.Wrong()
    with pytest.raises(t.Error) as e:
        node.image.value()
    assert e.value.code == "python" and e.value.node == "wrong" and "KeyError: \"the user's key\"" in e.value.message
    assert "in broken_helper" in e.value.hint and "raise KeyError" in e.value.hint
    assert isinstance(e.value.__cause__, KeyError)
    assert "broken_helper" in [f.name for f in traceback.extract_tb(e.value.__cause__.__traceback__)]
    for kind, text in (("type", "must be a Image, not a int"), ("value", "not a Table"), ("exit", "SystemExit")):
        node["kind"] = kind
        with pytest.raises(t.Error, match=text):
            node.image.value()


class Unprintable(Exception):
    def __str__(self):
        raise Unprintable


@t.node
def unprintable(kind: str = "file") -> t.Table:
    if kind == "file":
        open("caf\udce9.png")  # a name that is not UTF-8
    raise Unprintable


def test_messages_that_cannot_be_shown():
    g = t.Graph(cache=False)
    node = g.Unprintable()
    with pytest.raises(t.Error, match="FileNotFoundError.*caf") as e:
        node.table.value()
    assert e.value.code == "python" and 'open("caf' in e.value.hint
    node["kind"] = "other"
    with pytest.raises(t.Error, match="Unprintable: its message cannot be shown") as e:
        node.table.value()
    assert "raise Unprintable" in e.value.hint and isinstance(e.value.__cause__, Unprintable)


@t.node
def reporting(fraction: float = 0.5, value: float = 1) -> t.Table:
    t.progress(fraction)
    t.warn("\udc80")
    t.metric("m", value)
    return t.table({"a": [fraction]})


def test_reports_from_inside():
    g = t.Graph(cache=False)
    node = g.Reporting()
    with pytest.warns(t.NodeWarning, match="reporting: .*udc80"):
        assert g.run(node).metrics["reporting"]["m"] == 1
    node["fraction"] = 1.5
    with pytest.raises(t.Error, match="progress is from 0 to 1, not 1.5"):
        node.table.value()


runs = []


@t.node
def waiting(others: int = 1) -> t.Table:
    """Waits until so many other nodes of the run are done."""
    for _ in range(6000):
        if runs and runs[-1].progress()["done"] >= others:
            return t.table({"done": [1]})
        time.sleep(0.01)
    return t.table({"done": [0]})


def test_other_nodes_run_beside_a_node_in_python():
    g = t.Graph(cache=False, threads=2)
    others = [g.Grain(image=g.Pattern(kind="fat", width=64, height=64, seed=k).image) for k in range(5)]
    node = g.Waiting(others=10)
    runs.append(g.start(node, *others))
    assert runs[-1].result().value(node.table)["done"][0] == 1


def test_an_exception_is_kept_only_by_its_run():
    g = t.Graph(cache=False)
    node = g.Holding(number=-1)
    for k in range(3):
        node["number"] = k
        run = g.start(node)
        for _ in range(2):  # the cause is there whenever the run is asked
            with pytest.raises(t.Error) as e:
                run.result()
            assert isinstance(e.value.__cause__, KeyError)
        del run, e
        gc.collect()
    assert not [held() for held in holders if held() is not None]


class Big:
    pass


holders = []


@t.node
def holding(number: int = 0) -> t.Table:
    big = Big()
    holders.append(weakref.ref(big))
    raise KeyError(number)


def test_declarations_that_cannot_work():
    with pytest.raises(TypeError, match="needs a type"):
        @t.node
        def a(x) -> t.Image: ...
    with pytest.raises(TypeError, match="must return a value"):
        @t.node
        def b(x: t.Image): ...
    with pytest.raises(TypeError, match="has the type"):
        @t.node
        def c(x: dict = {}) -> t.Image: ...
    with pytest.raises(TypeError, match="cannot be an input"):
        @t.node
        def d(*x: t.Image) -> t.Image: ...
    with pytest.raises(ValueError, match="version"):
        @t.node(version=0)
        def e() -> t.Image: ...
    with pytest.raises(t.Error, match="has a node type Segment already"):
        @t.node
        def segment(image: t.Image) -> t.Labels: ...
    for function in (functools.lru_cache(broken_helper), functools.partial(broken_helper), Big):
        with pytest.raises(TypeError, match="written with def"):
            t.node(function)
    outer = 3
    with pytest.raises(ValueError, match="variables outer"):
        @t.node
        def f() -> t.Table:
            return t.table({"a": [outer]})
    with pytest.raises(t.Error, match="works only inside"):
        t.metric("a", 1)


def test_many_calls_at_once():
    g = t.Graph(cache=False, threads=4)
    nodes = [g.Alone(number=k) for k in range(40)]
    run = g.run(*nodes)
    assert [run.value(node.table)["number"][0] for node in nodes] == list(range(40))
    assert sorted(numbers) == list(range(40))


numbers = []


@t.node
def alone(number: int = 0) -> t.Table:
    sum(k * k for k in range(20_000))
    numbers.append(number)
    return t.table({"number": [number]})


def test_a_node_can_evaluate_another_graph():
    g = t.Graph(cache=False)
    assert g.Inner().table.value()["width"][0] == 16


@t.node
def inner() -> t.Table:
    g = t.Graph(cache=False)
    return t.table({"width": [g.Pattern(width=16, height=16).image.value().width]})


def test_canceling_stops_python_code(script):
    done = script('''
import os, signal, threading, time
import terrazzo as t
@t.node
def endless() -> t.Table:
    while True:
        time.sleep(0.01)
g = t.Graph(cache=False)
g.Endless()
threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
try:
    g.run()
except KeyboardInterrupt:
    print("stopped")
''', timeout=30)
    assert done.stdout == "stopped\n", done.stderr


def test_warnings_are_given_once_for_a_result():
    @t.node(version=1)
    def fussy(level: int = 1) -> t.Table:
        t.warn(f"level {level}")
        return t.table({"level": [level]})

    g = t.Graph(cache=False)
    table = g.Fussy(name="fussy").table
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(3):
            table.value()
            g.run()
        g["fussy"]["level"] = 2
        table.value()
        g["fussy"]["level"] = 1
        table.value()
    assert [str(w.message) for w in caught] == ["fussy: level 1", "fussy: level 2"]
