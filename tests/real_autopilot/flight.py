"""`columba fly` with real vehicles."""

import json
import subprocess
import threading
import time

import pytest
import tlog
from builds import Flock, speedup

PATIENCE_S = 600
RATE_AFTER_S, RATE_FOR_S = 3.0, 3.0


class Flight:
    """`columba fly` with the real vehicles; what it said, with the times at which it said so."""

    def __init__(self, program, folder, text, links, *options):
        folder.mkdir(parents=True, exist_ok=True)
        scenario, self.folder = folder / "field.toml", folder / "run"
        scenario.write_text(text)
        words = [program, "fly", scenario, "--out", self.folder, "--no-report", "--speed", speedup(), *options]
        words += [word for link in links for word in ("--link", link)]
        self.lines = []
        self.process = subprocess.Popen(
            [str(word) for word in words],
            stdin=subprocess.PIPE,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        self.changed = threading.Condition()
        self.reader = threading.Thread(target=self._read, daemon=True)
        self.reader.start()

    def _read(self):
        for line in self.process.stderr:
            with self.changed:
                self.lines.append((time.time(), line.rstrip()))
                self.changed.notify_all()
        with self.changed:
            self.lines.append((time.time(), "it has ended"))
            self.changed.notify_all()

    def wait_for(self, text, patience_s=PATIENCE_S):
        """The time and the line at which it first says a text."""
        deadline = time.monotonic() + patience_s
        with self.changed:
            while True:
                for at, line in self.lines:
                    if text in line:
                        return at, line
                assert self.lines[-1:] == [] or self.lines[-1][1] != "it has ended", self.said()
                assert self.changed.wait(deadline - time.monotonic()), f"never {text!r}: {self.said()}"

    def said(self):
        return "\n".join(line for _, line in self.lines)

    def say(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def end(self):
        self.process.stdin.close()
        self.status = self.process.wait(PATIENCE_S)
        self.reader.join()
        print(self.said())
        self.summary = json.loads((self.folder / "summary.json").read_text())
        return self

    def position_rates_hz(self):
        """Positions of each system from three to six seconds after its first heartbeat, by the log's own times."""
        first, counts = {}, {}
        for message in tlog.messages(self.folder / "flight.tlog"):
            system, at = message.get_srcSystem(), message._timestamp * speedup()
            if message.get_type() == "HEARTBEAT" and message.get_srcComponent() == 1:
                first.setdefault(system, at)
            elif message.get_type() == "GLOBAL_POSITION_INT" and system in first:
                since = at - first[system]
                counts[system] = counts.get(system, 0) + (RATE_AFTER_S <= since < RATE_AFTER_S + RATE_FOR_S)
        return {system: count / RATE_FOR_S for system, count in counts.items()}


@pytest.fixture
def flock(tmp_path):
    running = Flock(tmp_path)
    yield running
    running.close()


@pytest.fixture
def start_flight(columba_program, tmp_path):
    flights = []

    def start(text, links, *options):
        flights.append(Flight(columba_program, tmp_path / f"flight-{len(flights) + 1}", text, links, *options))
        return flights[-1]

    yield start
    for flight in flights:
        if flight.process.poll() is None:
            flight.process.kill()
            flight.process.wait()
