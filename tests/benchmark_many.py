"""Measures many vehicles, for docs/performance.md: python tests/benchmark_many.py, with the program built or in
COLUMBA_BIN.

Every figure is of one run; nothing here is a test.
"""

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

os.environ["MAVLINK20"] = "1"
sys.path += [str(Path(__file__).parent), str(Path(__file__).parent / "plugin")]

from ground import Craft, connection
from lists import Lists
from test_clients import work

PROGRAM = os.environ.get("COLUMBA_BIN", str(Path(__file__).parent.parent / "target/release/columba"))


class Vehicles:
    """`columba vehicles` while it runs."""

    def __init__(self, *options):
        command = [PROGRAM, "vehicles", "--json", "--vehicle-port", 0, "--ground-port", 0, *options]
        start = time.monotonic()
        self.process = subprocess.Popen([str(word) for word in command], stdout=subprocess.PIPE, text=True)
        self.rows = json.loads(self.process.stdout.readline())["vehicles"]
        self.ready_s = time.monotonic() - start

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGINT)
        self.process.wait()

    def memory_mb(self):
        lines = Path(f"/proc/{self.process.pid}/status").read_text().splitlines()
        return int(next(line for line in lines if line.startswith("VmRSS")).split()[1]) / 1024

    def processor_s(self):
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().split()
        return (int(fields[13]) + int(fields[14])) / os.sysconf("SC_CLK_TCK")


def start_up():
    print("| vehicles | ports | ready after | memory | of one core, alone |\n|---|---|---|---|---|")
    for count, per_port in [(1, 1), (200, 1), (200, 200), (1000, 1), (1000, 250), (10_000, 250)]:
        with Vehicles("--count", count, "--per-port", per_port) as vehicles:
            ports = len({row["port"] for row in vehicles.rows})
            # Its first second is the start.
            time.sleep(1)
            before = vehicles.processor_s()
            time.sleep(5)
            share = (vehicles.processor_s() - before) / 5
            print(f"| {count} | {ports} | {vehicles.ready_s:.2f} s | {vehicles.memory_mb():.0f} MB | {share:.0%} |")


def parameters():
    print("\n| all parameters of 200 vehicles through one port | parameters | seconds | questions |\n|---|---|---|---|")
    for loss in (0, 0.3):
        with Vehicles("--count", 200, "--per-port", 200, "--loss", loss) as vehicles:
            link = connection(vehicles.rows[0]["address"])
            lists = Lists(link, [row["system_id"] for row in vehicles.rows])
            seconds = lists.fetch(patience_s=300)
            link.close()
            total = sum(len(found) for found in lists.found.values())
            print(f"| {loss:.0%} lost each way | {total} | {seconds:.1f} s | {lists.requests} |")


def client(row, barrier, times):
    barrier.wait()
    start = time.monotonic()
    work(row, {})
    times.put(time.monotonic() - start)


def clients(count=50):
    print(f"\n| {count} clients, a process each, at once | least, median, most |\n|---|---|")
    for loss in (0, 0.3):
        with Vehicles("--count", count, "--loss", loss) as vehicles:
            barrier, times = multiprocessing.Barrier(count), multiprocessing.Queue()
            processes = [multiprocessing.Process(target=client, args=(row, barrier, times)) for row in vehicles.rows]
            for process in processes:
                process.start()
            seconds = sorted(times.get() for _ in processes)
            for process in processes:
                process.join()
            told = ", ".join(f"{value:.1f} s" for value in (seconds[0], seconds[count // 2], seconds[-1]))
            print(f"| parameters, ten items up and down, telemetry; {loss:.0%} lost each way | {told} |")


def speeds():
    print("\n| 200 vehicles, times the clock | reached | of one core |\n|---|---|---|")
    for speed in (1, 10, 50, 100):
        with Vehicles("--count", 200, "--speed", speed) as vehicles:
            craft = Craft(vehicles.rows[0])
            first, start, before = craft.sample().t_s, time.monotonic(), vehicles.processor_s()
            while time.monotonic() - start < 5:
                last = craft.sample().t_s
            seconds = time.monotonic() - start
            craft.close()
            share = (vehicles.processor_s() - before) / seconds
            print(f"| {speed} | {(last - first) / seconds:.1f} | {share:.0%} |")


if __name__ == "__main__":
    start_up()
    parameters()
    clients()
    speeds()
