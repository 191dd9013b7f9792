"""A notebook's kernel: progress below the cell, and the interrupt button."""

import os
import queue
import sys
import time

import pytest

manager = pytest.importorskip("jupyter_client.manager")
pytest.importorskip("ipykernel")


@pytest.fixture
def kernel(monkeypatch):
    monkeypatch.delenv("TERRAZZO_PROGRESS")
    km = manager.KernelManager()
    km.kernel_spec.argv = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    km.start_kernel(env=dict(os.environ))
    client = km.client()
    client.start_channels()
    client.wait_for_ready(timeout=60)
    yield km, client
    client.stop_channels()
    km.shutdown_kernel(now=True)


def messages(client, code, on=None):
    """Runs a cell, and returns its messages. `on`: called with each."""
    # After an error, a kernel would drop requests that follow at once.
    request = client.execute(code, stop_on_error=False)
    out, end = [], time.monotonic() + 60
    while time.monotonic() < end:
        try:
            message = client.get_iopub_msg(timeout=1)
        except queue.Empty:
            continue
        if message["parent_header"].get("msg_id") != request:
            continue
        out.append((message["msg_type"], message["content"]))
        if on:
            on(*out[-1])
        if out[-1] == ("status", {"execution_state": "idle"}):
            return out
    raise AssertionError(f"the cell did not end: {out}")


def test_progress_and_interrupt(kernel):
    km, client = kernel
    start = """
import terrazzo as t
g = t.Graph(cache=False)
solid = g.SolidOptimize(exemplar=g.Pattern(kind="marble", width=128, height=128).image, size=512, name="solid")
"""
    assert not [c for kind, c in messages(client, start) if kind in ("error", "stream")]
    updates = []

    def interrupt(kind, content):
        # On a busy machine, the pattern shows its progress first.
        if kind == "update_display_data" and len(updates) < 3 and "solid" in content["data"]["text/html"]:
            updates.append(content["data"]["text/html"])
            if len(updates) == 3:
                km.interrupt_kernel()

    stopped = messages(client, "solid.volume.value()", interrupt)
    assert len(updates) == 3 and all("<progress value=" in text and "solid" in text for text in updates)
    assert [c["ename"] for kind, c in stopped if kind == "error"] == ["KeyboardInterrupt"]
    assert [c["data"]["text/html"] for kind, c in stopped if kind == "update_display_data"][-1] == ""  # removed
    assert not [c for kind, c in stopped if kind == "stream"]
    # The kernel and the graph are as before.
    shown = messages(client, "solid['size'] = 16; solid['exemplar_size'] = 64; print(solid.volume.value().resolution); t.image([[0.5]])")
    assert [c["text"] for kind, c in shown if kind == "stream"] == ["(16, 16, 16)\n"]
    assert ["image/png" in c["data"] for kind, c in shown if kind == "execute_result"] == [True]
