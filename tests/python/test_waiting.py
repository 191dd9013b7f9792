"""Interrupts, threads, forks, exits, progress."""

import io
import os
import pty
import select
import subprocess
import sys
import threading
import time

import pytest

import terrazzo as t
from conftest import needs_plain_memory

# A graph that computes for minutes.
LONG = """
import os, signal, sys, threading, time, warnings
import terrazzo as t
def long_graph():
    g = t.Graph(cache=False)
    exemplar = g.Pattern(kind="marble", width=128, height=128)
    return g, g.SolidOptimize(exemplar=exemplar.image, size=512, name="solid")
"""


def test_sigint_stops_the_run_and_not_the_interpreter(script):
    done = script(LONG + """
g, solid = long_graph()
threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
start = time.monotonic()
try:
    solid.volume.value()
except KeyboardInterrupt:
    print("interrupted", time.monotonic() - start < 20)
solid["size"] = 16
print(solid.volume.value().resolution)
""")
    assert done.stdout == "interrupted True\n(16, 16, 16)\n", done.stderr
    assert done.returncode == 0


def test_an_uncaught_sigint_ends_as_in_any_program(script):
    done = script(LONG + """
g, solid = long_graph()
threading.Timer(1.0, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
solid.volume.value()
""")
    assert done.returncode == -2 and "KeyboardInterrupt" in done.stderr


def test_other_signal_handlers_run_while_waiting(script):
    done = script(LONG + """
class Stop(Exception): pass
def handler(number, frame): raise Stop
signal.signal(signal.SIGALRM, handler)
signal.setitimer(signal.ITIMER_REAL, 1)
g, solid = long_graph()
try:
    g.run()
except Stop:
    print("stopped")
""")
    assert done.stdout == "stopped\n", done.stderr


def test_other_threads_run_while_one_waits():
    g = t.Graph(cache=False)
    solid = g.SolidOptimize(exemplar=g.Pattern(width=64, height=64).image, size=32)
    run = g.start(solid)
    counted = 0
    waiting = threading.Thread(target=run.wait)
    waiting.start()
    while not run.done:
        counted += 1
        time.sleep(0)
    waiting.join()
    assert counted > 100
    assert run.result().value(solid.volume).resolution == (32, 32, 32)


def test_cancel():
    g = t.Graph(cache=False)
    g.SolidOptimize(exemplar=g.Pattern(width=128, height=128).image, size=512)
    run = g.start()
    assert not run.done
    run.cancel()
    with pytest.raises(t.Canceled):
        run.result()
    assert run.done and "cancelled" in {n["status"] for n in run.nodes}


def test_an_edit_stops_what_it_makes_obsolete():
    g = t.Graph(cache=False)
    exemplar = g.Pattern(width=128, height=128)
    solid = g.SolidOptimize(exemplar=exemplar.image, size=512)
    run = g.start(solid)
    solid["size"] = 16
    assert solid.volume.value().resolution == (16, 16, 16)
    with pytest.raises(t.Canceled):
        run.result()


def test_an_edit_keeps_what_it_does_not_touch():
    g = t.Graph(cache=False)
    solid = g.SolidOptimize(exemplar=g.Pattern(width=64, height=64).image, size=32)
    run = g.start(solid)
    g.Pattern(name="other")
    g.check()
    assert run.result().value(solid.volume).resolution == (32, 32, 32)


def test_many_threads_on_one_graph():
    g = t.Graph(cache=False)
    dots = g.Pattern(kind="fat", width=64, height=64)
    grain = g.Grain(image=dots.image)
    errors = []

    def work(seed):
        try:
            for k in range(20):
                try:
                    grain["seed"] = seed * 100 + k
                    grain.image.value()
                except t.Canceled:  # another thread edited the graph
                    pass
        except Exception as e:  # noqa: BLE001
            errors.append(e)

    threads = [threading.Thread(target=work, args=(seed,)) for seed in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not errors
    assert grain.image.value().width == 64


def test_exit_during_a_run(script):
    done = script(LONG + """
g, solid = long_graph()
run = g.start()
time.sleep(0.5)
print("end")
""")
    assert (done.stdout, done.stderr, done.returncode) == ("end\n", "", 0)


def test_exit_during_a_run_that_nothing_refers_to(script):
    done = script(LONG + """
g, solid = long_graph()
g.start()  # nobody keeps the run, which stops it
daemon = threading.Thread(target=lambda: long_graph()[0].run(), daemon=True)
daemon.start()
time.sleep(0.5)
""")
    assert (done.stderr, done.returncode) == ("", 0)


def test_exit_during_a_node_in_python(script):
    done = script(LONG + """
@t.node(version=1)
def slow(seconds: float = 60.0) -> t.Table:
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        time.sleep(0.01)
    return t.table({"a": [1]})
g = t.Graph(cache=False)
g.Slow()
run = g.start()
time.sleep(0.5)
""")
    assert (done.stderr, done.returncode) == ("", 0)


def test_fork(script):
    done = script(LONG + """
warnings.simplefilter("ignore")
g = t.Graph(cache=False)
dots = g.Pattern(width=32, height=32)
child = os.fork()   # before the first evaluation, a child can evaluate
if child == 0:
    ok = dots.image.value().width == 32
    os._exit(0 if ok else 1)
print(os.waitpid(child, 0)[1])
value = dots.image.value()
solid = long_graph()
run = solid[0].start()
child = os.fork()
if child == 0:
    ok = value.pixels.shape == (32, 32, 3)
    try:
        g.run()
        ok = False
    except t.Error as e:
        ok = ok and e.code == "forked" and "spawn" in e.hint
    del run, solid, g, dots   # nothing waits for threads that do not exist here
    print("child", ok, flush=True)
    sys.exit(0)
print(os.waitpid(child, 0)[1], flush=True)
run.cancel()
""")
    assert done.stdout.split("\n")[:3] == ["0", "child True", "0"], (done.stdout, done.stderr)
    assert done.returncode == 0


@needs_plain_memory
def test_a_limit_of_the_address_space(script):
    done = script("""
import resource
import terrazzo as t
with open("/proc/self/statm") as f:
    used = int(f.read().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (used + 700_000_000,) * 2)  # threads get about 16 MB each
for threads in (1000, 2):
    try:
        print(t.Graph(cache=False, threads=threads).Pattern(width=16, height=16).image.value().width)
    except t.Error as e:
        print(e.code, e.hint)
""")
    assert done.stdout == "no-memory raise the limit (ulimit -v) or use fewer threads\n16\n", (done.stdout, done.stderr)


def test_progress_in_a_terminal(tmp_path):
    file = tmp_path / "script.py"
    file.write_text(LONG + """
g, solid = long_graph()
threading.Timer(2.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
try:
    g.run()
except KeyboardInterrupt:
    pass
""")
    ours, theirs = pty.openpty()
    environment = {**os.environ}
    environment.pop("TERRAZZO_PROGRESS")
    process = subprocess.Popen([sys.executable, str(file)], stderr=theirs, stdout=theirs, stdin=theirs, env=environment)
    os.close(theirs)
    text = b""
    while True:
        ready = select.select([ours], [], [], 60)[0]
        assert ready, text
        try:
            part = os.read(ours, 4096)
        except OSError:
            break
        if not part:
            break
        text += part
    assert process.wait(60) == 0
    lines = text.decode().split("\r")
    drawn = [line for line in lines if "solid" in line and "1/2" in line]
    assert len(drawn) >= 3 and "%|" in drawn[0], lines
    assert lines[-1] == "" or set(lines[-1]) <= set(" \n"), lines[-3:]  # removed at the end


def test_progress_is_text_of_one_line():
    from terrazzo._progress import Drawing, line
    text = line(3, 8, [("segment", 0.42, "tiles")], 12, 80)
    assert text == " 43%|████▎     | 3/8 [00:12<00:16] segment 42% tiles"
    assert len(line(1, 2, [("x" * 300, 0.5, "")], 5000, 80)) == 79
    assert line(0, 0, [], 0, 80).startswith("100%")

    class Closed(io.StringIO):
        def write(self, text):
            raise ValueError("I/O operation on closed file")

    class Run:
        def progress(self):
            return {"done": 0, "needed": 1, "running": []}

    drawing = Drawing(Run(), Closed())
    drawing._start -= 10
    drawing(False)
    drawing(True)


def test_warnings_of_nodes():
    g = t.Graph(cache=False)
    ball = g.Shape(kind="sphere")
    sizes = g.Distribution(shapes=ball.shapes)
    profiles = g.Section(particles=g.Anneal(distribution=sizes, shapes=ball, size=20).particles, shapes=ball).profiles
    unfold = g.Unfold(profiles=profiles, kmatrix=g.KMatrix(shapes=ball, method="analytic"), bootstrap=0)
    with pytest.warns(t.NodeWarning, match="^unfold: ") as caught:
        unfold.table.value()
    assert caught[0].filename == __file__
