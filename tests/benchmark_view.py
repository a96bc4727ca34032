"""Measures the live view: `python tests/benchmark_view.py`, after `cargo build --release --bins --examples`.

Frames a second of the page in a browser without a GPU, what the page's server costs, how soon a log of 100 MB plays,
and whether a page that does not read makes a flight late. What an abort takes is printed by
tests/browser/test_abort.py. Needs playwright and a browser, as tests/browser does.
"""

import math
import os
import socket
import struct
import subprocess
import sys
import tempfile
import time
from datetime import datetime
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "browser"))
from chromium import NAMES, OPTIONS, address_in, until
from playwright.sync_api import sync_playwright
from pymavlink.dialects.v20 import ardupilotmega as mavlink

RELEASE = Path(__file__).parent.parent / "target/release"
TICKS_PER_S = os.sysconf("SC_CLK_TCK")
MEASURED_S = 10


def thread_s(pid, name):
    """Seconds of a core that the threads of a name have taken."""
    total = 0
    for stat in Path(f"/proc/{pid}/task").glob("*/stat"):
        words = stat.read_text().rsplit(")", 1)
        if words[0].endswith(name):
            total += sum(map(int, words[1].split()[11:13]))
    return total / TICKS_PER_S


def measure(address, pid, browser, name):
    """Frames a second, and what the server costs with this page."""
    page = browser.new_page(viewport={"width": 1280, "height": 720})
    page.add_init_script(
        "window.received = 0; const Socket = WebSocket; window.WebSocket = class extends Socket { "
        "constructor(...words) { super(...words);"
        " this.addEventListener('message', ({data}) => { window.received += data.byteLength ?? data.length; }); } };"
    )
    page.goto(address)
    until(page, "columba.stage.frames > 10")
    time.sleep(3)
    idle = page.evaluate("[columba.stage.frames, received, performance.now()]"), thread_s(pid, "live-view")
    time.sleep(MEASURED_S)
    done = page.evaluate("[columba.stage.frames, received, performance.now()]"), thread_s(pid, "live-view")
    span_s = (done[0][2] - idle[0][2]) / 1000
    frames, received = ((done[0][k] - idle[0][k]) / span_s for k in (0, 1))
    share = (done[1] - idle[1]) / span_s
    painter = page.evaluate("columba.stage.painter.name")
    print(
        f"{name} ({painter}), load {os.getloadavg()[0]:.1f}: {frames:.0f} frames/s, {received / 1e6:.2f} MB/s,"
        f" the page's server {100 * share:.1f} % of a core"
    )
    page.close()


def server_alone(pid, name):
    before = thread_s(pid, "live-view")
    time.sleep(MEASURED_S)
    print(f"{name}: the page's server {10 * (thread_s(pid, 'live-view') - before):.1f} % of a core")


def stuck(address):
    """A page that opens its connection and reads nothing."""
    host, port = address.split("//")[1].split("/")[0].split(":")
    connection = socket.create_connection((host, int(port)))
    connection.sendall(
        f"GET /live HTTP/1.1\r\nHost: {host}:{port}\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n"
        "Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
    )
    return connection


def late_ticks(pages):
    """A run of 500 by the clock, with or without three pages of which one does not read: the program's own words."""
    with tempfile.TemporaryDirectory() as folder:
        field = Path(folder) / "field.toml"
        field.write_text(
            '[scenario]\nname = "late"\nduration_s = 12.0\n'
            "[flock]\nexpected_speed_mps = 10.0\nexpected_altitude_m = 50.0\n"
            '[vehicles]\ncount = 500\npattern = "grid"\n'
        )
        words = [RELEASE / "columba", "run", field, "--speed", "1", "--no-report", "--out", Path(folder) / "run"]
        log = Path(folder) / "log.txt"
        run = subprocess.Popen(
            [*words, "--view"] if pages else words,
            stdout=subprocess.DEVNULL,
            stderr=log.open("w"),
            env={**os.environ, "RUST_LOG": "columba::flying=debug"},
        )
        readers = []
        if pages:
            while "live view: " not in log.read_text():
                time.sleep(0.05)
            address = address_in(log.read_text())
            readers = [stuck(address), *(drained(address) for _ in range(2))]
        run.wait()
        errors = log.read_text()
        for reader in readers:
            reader.close() if isinstance(reader, socket.socket) else reader.kill()
        # A tick is told when it is over: by then half a second has passed for each before it.
        ticks = [line.split()[0] for line in errors.splitlines() if " tick " in line or "tick=" in line]
        times = [datetime.fromisoformat(time.rstrip("Z")).timestamp() for time in ticks]
        late_ms = sorted(1000 * (time - times[0] - 0.5 * index) for index, time in enumerate(times))
        earliest = late_ms[0] if late_ms else 0.0
        late_ms = late_ms or [float("nan")]
        name = "with three pages, one of which does not read" if pages else "without a page"
        print(
            f"run of 500 {name}: {len(times)} ticks, late by {late_ms[len(late_ms) // 2] - earliest:.0f} ms in "
            f"the median,"
            f" {late_ms[-1] - earliest:.0f} ms at most"
        )


def log_of(path, vehicles=20, size=100e6):
    """Writes a log as a ground station does: heartbeats, attitudes, positions of vehicles in circles."""
    began_us, at_s, written = 1_600_000_000_000_000, 0.0, 0
    senders = [mavlink.MAVLink(None, srcSystem=index + 1, srcComponent=1) for index in range(vehicles)]
    with path.open("wb") as log:
        while written < size:
            for index, sender in enumerate(senders):
                turn, ms = 0.1 * at_s + index, round(1000 * at_s)
                lat, lon = round(473e6 + 3e3 * index + 1e3 * math.cos(turn)), round(85e6 + 1e3 * math.sin(turn))
                messages = [
                    mavlink.MAVLink_attitude_message(ms, 0.1, 0.1, math.sin(turn), 0, 0, 0),
                    mavlink.MAVLink_global_position_int_message(ms, lat, lon, 550_000, 50_000, 0, 1000, 0, 0),
                    mavlink.MAVLink_vfr_hud_message(20, 20, 90, 50, 100, 0),
                ]
                if round(10 * at_s) % 10 == 0:
                    messages.append(mavlink.MAVLink_heartbeat_message(1, 3, 217, 15, 4, 3))
                for message in messages:
                    sender.seq = (sender.seq + 1) % 256
                    record = struct.pack(">Q", began_us + round(1e6 * at_s)) + message.pack(sender)
                    log.write(record)
                    written += len(record)
            at_s += 0.1


def playback(browser):
    """From the start of the program until a log of 100 MB plays, until all is read; and how long a scrub takes."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "flight.tlog"
        log_of(path)
        path.read_bytes()
        page = browser.new_page(viewport={"width": 1280, "height": 720})
        began = time.monotonic()
        viewer = subprocess.Popen([RELEASE / "columba", "view", path], stderr=subprocess.PIPE, text=True)
        address = address_in(viewer.stderr.readline())
        served_s = time.monotonic() - began
        page.goto(address)
        until(page, "columba.player.isRecording && columba.stage.frames > 0 && columba.player.now > 0")
        plays_s = time.monotonic() - began
        early = page.evaluate("document.getElementById('connection').textContent")
        until(page, "document.getElementById('connection').textContent === 'recording'")
        whole_s = time.monotonic() - began
        scrub = (
            "(() => { const from = performance.now(); columba.player.seek(columba.player.end * PART);"
            " columba.stage.draw(performance.now()); return performance.now() - from; })()"
        )
        scrubs = sorted(page.evaluate(scrub.replace("PART", str(part))) for part in (0.1, 0.9, 0.5, 0.3, 0.7))
        print(
            f"a log of 100 MB, load {os.getloadavg()[0]:.1f}: served after {served_s:.2f} s,"
            f" plays after {plays_s:.2f} s ({early}), read after {whole_s:.2f} s;"
            f" a scrub takes {scrubs[2]:.0f} ms, {scrubs[-1]:.0f} at most"
        )
        viewer.kill()
        page.close()


def drained(address):
    """A page that reads, as a process of its own."""
    code = (
        f"import sys; sys.path[:0] = [{str(Path(__file__).parent)!r}]; import benchmark_view\n"
        f"socket = benchmark_view.stuck({address!r})\n"
        "while socket.recv(1 << 20): pass"
    )
    return subprocess.Popen([sys.executable, "-c", code])


def main():
    path = next(filter(None, (os.environ.get("CHROMIUM_BIN"), *map(__import__("shutil").which, NAMES))))
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=OPTIONS)
        for vehicles in (200, 10_000):
            example = subprocess.Popen(
                [RELEASE / "examples/1_many_vehicles", str(vehicles)], stdout=subprocess.PIPE, text=True
            )
            address = example.stdout.readline().strip()
            server_alone(example.pid, f"{vehicles} vehicles, no page")
            measure(address, example.pid, browser, f"{vehicles} vehicles, as the page chooses")
            measure(address.replace("#", "?webgl#"), example.pid, browser, f"{vehicles} vehicles, WebGL")
            example.kill()
        playback(browser)
        browser.close()
    for _ in range(3):
        late_ticks(False)
        late_ticks(True)


if __name__ == "__main__":
    main()
