"""A pytest plugin: simulated MAVLink vehicles for your tests, as many as you like, on free ports.

    def test_they_answer(columba_vehicles):
        for vehicle in columba_vehicles(3):
            assert vehicle.link.recv_match(type="ATTITUDE", blocking=True, timeout=5)

Install this folder with pip; or copy this file beside your conftest.py and import the fixtures there:

    from pytest_columba import columba_fleet, columba_program, columba_vehicles

It needs pymavlink, and the program: COLUMBA_BIN, or `columba` on the PATH. README.md beside it describes the rest.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from typing import Any

os.environ.setdefault("MAVLINK20", "1")  # pymavlink reads it when it is imported

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink

READY_PATIENCE_S = 10.0
END_PATIENCE_S = 10.0


def connection(address: str, source_system: int = 255, source_component: int = 190) -> Any:
    """A pymavlink connection to a vehicle's address, which hears that address alone.

    Without this a socket hears whoever sends to its port, such as the vehicles of a test before, which had a client
    there.
    """
    link = mavutil.mavlink_connection(
        f"udpout:{address}", source_system=source_system, source_component=source_component
    )
    host, port = address.rsplit(":", 1)
    link.port.connect((host, int(port)))
    return link


class Vehicle:
    """One vehicle: where it is to be found, and a connection that has heard it."""

    def __init__(self, row: dict[str, Any]) -> None:
        #: Its row of the table that `columba vehicles --json` prints; docs/mavlink.md describes every field.
        self.row = row
        self.system_id: int = row["system_id"]
        self.component_id: int = row["component_id"]
        self.address: str = row["address"]
        #: A pymavlink connection of system 255, component 190; `link.target_system` is the vehicle.
        self.link = connection(self.address)
        self._wait_until_ready()

    def _wait_until_ready(self) -> None:
        """A vehicle answers whoever speaks to its port; what is sent before it listens is lost, so it is said again."""
        until = time.monotonic() + READY_PATIENCE_S
        while time.monotonic() < until:
            self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
            again = time.monotonic() + 0.5
            while (left := again - time.monotonic()) > 0:
                heard = self.link.recv_match(type="HEARTBEAT", blocking=True, timeout=left)
                # Others may stand behind the same port.
                if heard is not None and heard.get_srcSystem() == self.system_id:
                    self.link.target_system, self.link.target_component = self.system_id, self.component_id
                    return
        raise TimeoutError(f"the vehicle at {self.address} has not answered for {READY_PATIENCE_S:.0f} s")

    def close(self) -> None:
        self.link.close()


class Fleet:
    """`columba vehicles` with the options given, on free ports unless they say otherwise."""

    def __init__(self, program: str | os.PathLike[str], *options: object, ground_port: int = 0) -> None:
        words = [program, "vehicles", "--json", "--vehicle-port", 0, "--ground-port", ground_port, *options]
        self._command = [str(word) for word in words]
        self.vehicles: list[Any] = []
        self._connect_to: Callable[[dict[str, Any]], Any] = Vehicle
        self._start()

    def _start(self) -> None:
        self._errors = tempfile.TemporaryFile("w+")
        self.process = subprocess.Popen(self._command, stdout=subprocess.PIPE, stderr=self._errors, text=True)
        # The table comes when every port is open.
        table = self.process.stdout.readline()
        if not table:
            raise RuntimeError(f"columba vehicles ended with status {self.process.wait()}: {self.errors}")
        #: A row for each vehicle, as `columba vehicles --json` prints them.
        self.rows: list[dict[str, Any]] = json.loads(table)["vehicles"]

    @property
    def errors(self) -> str:
        """What the program has said to standard error."""
        self._errors.seek(0)
        return self._errors.read().strip()

    def connect(self, to: Callable[[dict[str, Any]], Any] = Vehicle) -> list[Any]:
        """A connection to each vehicle, once it is ready."""
        self._connect_to = to
        self.vehicles = [to(row) for row in self.rows]
        return self.vehicles

    def restart(self) -> list[Any]:
        """Ends it and starts it anew with the same options; gives new connections, for the ports are new too.

        What is set on board is gone, unless the options name a `--state-folder`.
        """
        self.stop()
        self._start()
        return self.connect(self._connect_to)

    def stop(self) -> None:
        """Ends it as Ctrl-C does; that it ends cleanly is part of the test. A second time does nothing."""
        try:
            self._end()
        finally:
            for vehicle in self.vehicles:
                vehicle.close()
            self.vehicles = []

    def _end(self) -> None:
        if self.process.stdout.closed:
            return
        self.process.stdout.close()
        self.process.send_signal(signal.SIGINT)
        try:
            status = self.process.wait(timeout=END_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        assert status == 0, f"columba vehicles ended with status {status}: {self.errors}"


@pytest.fixture(scope="session")
def columba_program() -> str:
    """The program's path; override this fixture where yours is elsewhere."""
    program = os.environ.get("COLUMBA_BIN") or shutil.which("columba")
    if not program or not os.path.isfile(program):
        pytest.fail(f"there is no program at {program or 'columba on the PATH'}: set COLUMBA_BIN to it", pytrace=False)
    return os.path.abspath(program)


@pytest.fixture
def columba_fleet(columba_program: str) -> Iterator[Callable[..., Fleet]]:
    """Starts vehicles and connects to them, as `columba_vehicles` does, and gives the Fleet: `vehicles`, `rows`,
    `restart()`, `stop()`, `process`, `errors`."""
    fleets: list[Fleet] = []

    def start(count: int | None = 1, *options: object, ground_port: int = 0) -> Fleet:
        how_many = [] if count is None else ["--count", count]
        fleets.append(Fleet(columba_program, *how_many, *options, ground_port=ground_port))
        fleets[-1].connect()
        return fleets[-1]

    yield start
    faults = []
    for fleet in fleets:
        # One that does not end cleanly must not keep the others.
        try:
            fleet.stop()
        except (AssertionError, subprocess.TimeoutExpired) as fault:
            faults.append(str(fault))
    assert not faults, "; ".join(faults)


@pytest.fixture
def columba_vehicles(columba_fleet: Callable[..., Fleet]) -> Callable[..., list[Vehicle]]:
    """Starts vehicles and connects to them: columba_vehicles(3), columba_vehicles(2, "--speed", 5),
    columba_vehicles(None, "mine.toml").

    Gives a list of Vehicle. Each call is a process of its own; all of them end after the test.
    """
    return lambda count=1, *options: columba_fleet(count, *options).vehicles
