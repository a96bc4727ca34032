"""A pytest plugin: simulated MAVLink vehicles for your tests, as many as you like, on free ports.

    def test_they_answer(columba_vehicles):
        for vehicle in columba_vehicles(3):
            assert vehicle.link.wait_heartbeat(timeout=5)

Copy this file beside your conftest.py and say `pytest_plugins = ["pytest_columba"]` there, or install this folder with pip.
It needs pymavlink, and the program: COLUMBA_BIN, or `columba` on the PATH.
"""

import json
import os
import shutil
import signal
import subprocess
import tempfile
import time

os.environ.setdefault("MAVLINK20", "1")  # pymavlink reads it when it is imported

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink

READY_PATIENCE_S = 10.0
END_PATIENCE_S = 10.0


class Vehicle:
    """One vehicle: where it is to be found, and a connection that has heard it."""

    def __init__(self, row):
        self.system_id = row["system_id"]
        self.component_id = row["component_id"]
        self.address = row["address"]
        #: A pymavlink connection of system 255, component 190; `link.target_system` is the vehicle.
        self.link = mavutil.mavlink_connection(f"udpout:{self.address}", source_system=255, source_component=190)
        self._wait_until_ready()

    def _wait_until_ready(self):
        """A vehicle answers whoever speaks to its port; what is sent before it listens is lost, so it is said again."""
        until = time.monotonic() + READY_PATIENCE_S
        while time.monotonic() < until:
            self.link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
            if self.link.recv_match(type="HEARTBEAT", blocking=True, timeout=0.5):
                self.link.target_system, self.link.target_component = self.system_id, self.component_id
                return
        raise TimeoutError(f"the vehicle at {self.address} has not answered for {READY_PATIENCE_S:.0f} s")

    def close(self):
        self.link.close()


class Fleet:
    """`columba vehicles` with the options given, on free ports unless they say otherwise; `rows` is its table of vehicles."""

    def __init__(self, program, *options, ground_port=0):
        command = [program, "vehicles", "--json", "--vehicle-port", 0, "--ground-port", ground_port, *options]
        self._errors = tempfile.TemporaryFile("w+")
        self.process = subprocess.Popen(
            [str(word) for word in command], stdout=subprocess.PIPE, stderr=self._errors, text=True
        )
        table = self.process.stdout.readline()
        if not table:
            raise RuntimeError(f"columba vehicles ended with status {self.process.wait()}: {self.errors}")
        self.rows = json.loads(table)["vehicles"]
        self.vehicles = []

    @property
    def errors(self):
        """What the program has said to standard error."""
        self._errors.seek(0)
        return self._errors.read().strip()

    def connect(self, to=Vehicle):
        """A connection to each vehicle, once it is ready."""
        self.vehicles = [to(row) for row in self.rows]
        return self.vehicles

    def stop(self):
        """Ends it as Ctrl-C does; that it ends cleanly is part of the test."""
        for vehicle in self.vehicles:
            vehicle.close()
        self.process.send_signal(signal.SIGINT)
        try:
            status = self.process.wait(timeout=END_PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        assert status == 0, f"columba vehicles ended with status {status}: {self.errors}"


@pytest.fixture(scope="session")
def columba_program():
    """The program's path; override this fixture where yours is elsewhere."""
    program = os.environ.get("COLUMBA_BIN") or shutil.which("columba")
    assert program, "there is no columba on the PATH: set COLUMBA_BIN to the program"
    return os.path.abspath(program)


@pytest.fixture
def columba_vehicles(columba_program):
    """Starts vehicles and connects to them: columba_vehicles(3), columba_vehicles(2, "--speed", 5), columba_vehicles(None, "mine.toml").

    Gives a list of Vehicle. Each call is a process of its own; all of them end after the test.
    """
    fleets = []

    def start(count=1, *options):
        number = [] if count is None else ["--count", count]
        fleets.append(Fleet(columba_program, *number, *options))
        return fleets[-1].connect()

    yield start
    for fleet in fleets:
        fleet.stop()
