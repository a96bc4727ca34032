"""Ctrl-C: a run ends at once and keeps what was flown."""

import signal
import subprocess
import time

import pyarrow.parquet
import pytest
from conftest import Run, free_port
from ground import connection


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGTERM], ids=["ctrl-c", "a polite kill"])
def test_an_interrupted_run_is_on_disk(program, tmp_path, sign):
    port = free_port()
    options = ["--speed", "2", "--duration", "600", "--vehicle-port", str(port), "--out", str(tmp_path / "run")]
    process = subprocess.Popen(
        [str(program), "run", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    watch_until_s(port, 3.0)
    process.send_signal(sign)
    _, errors = process.communicate(timeout=30)

    run = Run(tmp_path / "run", process.returncode)
    assert run.status == 1
    assert "interrupted at" in errors
    summary = run.summary
    assert summary["interrupted"] and not summary["completed"] and not summary["success"]
    assert 1.0 <= summary["duration_s"] <= 60
    assert "interrupted" in summary["failure"]
    table = pyarrow.parquet.read_table(run.folder / "trajectory.parquet")
    assert table["t_s"].to_pylist()[-1] == summary["duration_s"]
    assert run.tlog.stat().st_size > 1000
    assert "</html>" in (run.folder / "report.html").read_text()
    assert not list(run.folder.rglob("*.tmp"))


def watch_until_s(port, time_s):
    """Looks on at the first vehicle's own port until it has flown so long."""
    link = connection(f"127.0.0.1:{port}", source_system=254)
    deadline = time.monotonic() + 20
    while time.monotonic() < deadline:
        link.mav.heartbeat_send(6, 8, 0, 0, 0)
        position = link.recv_match(type="LOCAL_POSITION_NED", blocking=True, timeout=0.5)
        if position is not None and position.time_boot_ms >= 1000 * time_s:
            link.close()
            return
    raise TimeoutError(f"the vehicle at port {port} did not fly for {time_s} s")
