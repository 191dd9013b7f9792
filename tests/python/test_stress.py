"""Many things at once: threads that edit and evaluate one graph, signals, forks and exits at any moment."""

import random
import threading

import numpy as np

import terrazzo as t


def test_threads_do_everything_to_one_graph(tmp_path):
    g = t.Graph(cache=tmp_path / "cache", memory=1 << 18)
    base = g.Pattern(kind="fat", width=24, height=24)
    end = g.Grain(image=base.image, name="end")
    g.output("end", end)
    done, errors = [], []

    def at(r):
        return g[r.choice(g._names())]

    def add(r):
        g.Grain(image=r.choice([base.image, at(r)]), seed=r.randrange(5), **({"name": f"n{r.randrange(6)}"} if r.random() < .5 else {}))

    def array(r):
        end.set(image=t.image(np.full((8, 8, 3), r.randrange(5) / 5)))

    def values(r):
        image = end.image.value()
        assert np.isfinite(image.pixels).all() and len(t.image(image.pixels).content) > 10

    def start(r):
        run = g.start(*([at(r)] if r.random() < .5 else []), out=tmp_path / "out")
        if r.random() < .5:
            run.cancel()
        run.progress(), run.wait(), run.nodes, repr(run)

    def sweep(r):
        s = g.sweep({"pattern.seed": [r.randrange(5), r.randrange(5)]}, end.image, jobs=r.randrange(1, 3), out=tmp_path / "out")
        s.values[0][0], s.columns

    def remove(r):
        node = at(r)
        if node.name not in ("pattern", "end"):
            del g[node.name]

    def rename(r):
        node = at(r)
        if node.name not in ("pattern", "end"):
            g.rename(node, f"n{r.randrange(6)}")

    steps = [add, array, values, start, sweep, remove, lambda r: end.set(image=base.image),
             lambda r: base.set(seed=r.randrange(20)), lambda r: end.__setitem__("seed", r.randrange(20)), lambda r: g.run(),
             rename,
             lambda r: g.to_yaml(flat=r.random() < .5), lambda r: str(g.explain()), lambda r: g.draw("svg"),
             lambda r: (repr(at(r)), dir(at(r)), g.nodes), lambda r: g.check(),
             lambda r: g.save(tmp_path / f"{r.randrange(3)}.yaml", arrays="arrays"), lambda r: g["none"]]
    # What other threads may cause: nodes that are gone, taken or in use, and runs that an edit made obsolete.
    allowed = {"unknown-node", "in-use", "duplicate-key", "not-savable", "cycle", "wrong-type", "not-evaluated", "unknown-port",
               "missing-input", "bad-name", "unreadable-image", "no-file"}

    def work(seed):
        r = random.Random(seed)
        for _ in range(40):
            step = r.choice(steps)
            try:
                step(r)
            except t.Canceled:
                pass
            except t.Error as e:
                if e.code not in allowed:
                    errors.append((step, e))
            except Exception as e:  # noqa: BLE001
                errors.append((step, e))
            done.append(step)

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(6)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(300)
    assert not errors and len(done) == 240, errors[:3]
    end.set(image=base.image, seed=3)
    base["seed"] = 4
    h = t.Graph(cache=False)
    assert end.image.value() == h.Grain(image=h.Pattern(kind="fat", width=24, height=24, seed=4).image, seed=3).image.value()


def test_exceptions_of_signal_handlers_at_any_moment(script):
    done = script("""
import signal
import terrazzo as t
class Stop(BaseException): pass
armed = False
def handler(number, frame):
    if armed: raise Stop
signal.signal(signal.SIGALRM, handler)
g = t.Graph(cache=False, memory=1 << 16)
base = g.Pattern(kind="fat", width=64, height=64)
end = g.Grain(image=base.image)
stopped = 0
for k in range(300):
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.0002 + (k * 37 % 100) * 1e-4)
        armed = True
        base["seed"] = k + 1
        end.image.value().pixels.sum()
        g.run(end); g.explain(); g.to_yaml(); t.image(end.image.value().pixels).content
        armed = False
    except Stop:
        stopped += 1
    armed = False
base["seed"] = 5
h = t.Graph(cache=False)
print(stopped > 20, end.image.value() == h.Grain(image=h.Pattern(kind="fat", width=64, height=64, seed=5).image).image.value())
""")
    assert done.stdout == "True True\n", (done.stdout, done.stderr)


DAEMONS = """
import os, random, sys, threading, time
import terrazzo as t
@t.node
def slow(number: int = 0) -> t.Table:
    time.sleep(0.002)
    return t.table({"a": [number]})
def work(seed):
    r = random.Random(seed)
    g = t.Graph(cache=False, memory=1)
    image = g.Pattern(kind="fat", width=64, height=64)
    table = g.Slow()
    sweep = None
    while True:
        image["seed"] = r.randrange(1000)
        table["number"] = r.randrange(1000)
        run = g.start()
        run.wait()
        sweep = g.sweep({"pattern.seed": [1, 2]}, image.image, jobs=2)
        sweep.values[0][0], image.image.value()
threads = [threading.Thread(target=work, args=(k,), daemon=True) for k in range(4)]
for thread in threads:
    thread.start()
"""


def test_exits_at_any_moment(script):
    for wait in (0.05, 0.13, 0.3, 0.5, 0.9):
        done = script(DAEMONS + f"time.sleep({wait})\nprint('end')\nsys.exit(3)\n")
        assert (done.stdout, done.stderr, done.returncode) == ("end\n", "", 3)


def test_forks_at_any_moment(script):
    done = script(DAEMONS + """
import warnings
warnings.simplefilter("ignore")
value = t.image([[0.25, 0.5]])
bad = []
for k in range(12):
    time.sleep(0.03 + 0.01 * k)
    child = os.fork()
    if child == 0:
        ok = value.pixels.max() == 0.5 and t.labels([[1, 2]]).count == 2
        try:
            t.Graph(cache=False).Pattern().image.value()
            ok = False
        except t.Error as e:
            ok = ok and e.code == "forked"
        os._exit(0 if ok else 1)
    end = time.monotonic() + 60
    while time.monotonic() < end:
        pid, status = os.waitpid(child, os.WNOHANG)
        if pid: break
        time.sleep(0.01)
    else:
        os.kill(child, 9); os.waitpid(child, 0); status = "hung"
    if status: bad.append(status)
print(bad)
""")
    assert (done.stdout, done.returncode) == ("[]\n", 0), (done.stdout, done.stderr)
