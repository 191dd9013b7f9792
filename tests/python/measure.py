"""Measures what docs/results/python.md states: ./dev python tests/python/measure.py [EVALUATIONS]"""

import ctypes
import gc
import os
import statistics
import sys
import time

START = time.perf_counter(), time.process_time()
import terrazzo as t  # noqa: E402

IMPORT = time.perf_counter() - START[0], time.process_time() - START[1]


def resident():
    with open("/proc/self/statm") as f:
        return int(f.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def microseconds(call, count=2000, repetitions=7):
    """Medians of the repetitions' mean times, as text: on the clock, and of CPU, which other programs change less."""
    clock, cpu = [], []
    for _ in range(repetitions):
        start = time.perf_counter(), time.process_time()
        for _ in range(count):
            call()
        clock.append((time.perf_counter() - start[0]) / count * 1e6)
        cpu.append((time.process_time() - start[1]) / count * 1e6)
    return f"{statistics.median(clock):.2f} µs, CPU {statistics.median(cpu):.2f} µs"


def main():
    print(f"load of the machine {os.getloadavg()[0]:.1f}, {os.cpu_count()} cores")
    print(f"import {IMPORT[0]:.2f} s, CPU {IMPORT[1]:.2f} s")
    section = os.path.join(os.path.dirname(__file__), "..", "..", "graphs", "samples", "section.png")
    g = t.Graph(cache=False)
    picture = g.Pattern(width=512, height=512)
    image = picture.image.value()
    print(f"a cached value, 512² pixels: {microseconds(picture.image.value)}")
    photo = g.LoadImage(path=section, pixel_size=0.1).image
    photo.value()
    print(f"a cached value whose file is checked: {microseconds(photo.value)}")
    print(f"a view, image.pixels: {microseconds(lambda: image.pixels)}")
    print(f"a field, image.width: {microseconds(lambda: image.width)}")

    h = t.Graph(cache=False)
    source = h.Pattern()
    adding = microseconds(lambda: h.Grain(image=source.image, seed=3), 100, 5)
    print(f"a call, h.Grain(image=source.image, seed=3): {adding}")
    print(f"a parameter, source['seed'] = 2: {microseconds(lambda: source.__setitem__('seed', 2))}")

    def evaluate():
        picture["seed"] = evaluate.seed = evaluate.seed + 1
        return picture.image.value()

    evaluate.seed = 1
    picture.set(width=16, height=16)
    print(f"an evaluation after an edit, 16² pixels: {microseconds(evaluate, 200, 5)}")

    measure_memory(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)


def measure_memory(count):
    """Growth of the process over many evaluations: of different results, and of the same ones computed again."""
    for title, size, seeds, memory in (("different results of 64² pixels", 64, count + 10**6, 1 << 24),
                                       ("results of 32² pixels, of which 100 differ", 32, 100, 1)):
        g = t.Graph(cache=False, memory=memory)
        picture = g.Pattern(width=size, height=size)

        def step(k, picture=picture, seeds=seeds):
            picture["seed"] = k % seeds + 1
            return picture.image.value().pixels[0, 0, 0]

        for k in range(1000):  # fills the store
            step(k)
        before, start = trimmed(), time.perf_counter()
        for k in range(1000, 1000 + count):
            step(k)
        print(f"{count} {title}: {time.perf_counter() - start:.1f} s, the process grew by "
              f"{(trimmed() - before) / 1e6:.2f} MB ({before / 1e6:.0f} MB before)")


def trimmed():
    """Resident memory after unused memory was returned to the system."""
    gc.collect()
    ctypes.CDLL("libc.so.6").malloc_trim(0)
    return resident()


if __name__ == "__main__":
    main()
