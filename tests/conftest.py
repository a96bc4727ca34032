"""Fixtures: the built program, vehicles on free ports with connections to them, whole runs."""

import os

os.environ["MAVLINK20"] = "1"  # pymavlink reads it when it is imported

import json
import socket
import subprocess
from pathlib import Path

import pyarrow.parquet
import pytest

pytest.register_assert_rewrite("pytest_columba")
from ground import Craft  # noqa: E402
from pytest_columba import Fleet  # noqa: E402

pytest_plugins = ["pytest_columba"]

PROJECT = Path(__file__).resolve().parent.parent
RUN_PATIENCE_S = 60.0

SCENARIO = """
[scenario]
name = "test"
duration_s = 10.0

[flock]
expected_speed_mps = 10.0
expected_altitude_m = 50.0

[vehicles]
count = {count}
pattern = "line"

[autopilot]
{autopilot}
"""


@pytest.fixture(scope="session")
def columba_program():
    """The built program, by its path; of that name for the plugin's sake."""
    # Whole, for tests that run elsewhere.
    path = Path(os.environ.get("COLUMBA_BIN", PROJECT / "target/release/columba")).resolve()
    assert path.exists(), f"{path} is not built: cargo build --release, or set COLUMBA_BIN"
    return path


@pytest.fixture(scope="session")
def program(columba_program):
    return columba_program


def bind():
    """A UDP socket on a free port of loopback."""
    bound = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    bound.bind(("127.0.0.1", 0))
    return bound


def free_port():
    with bind() as bound:
        return bound.getsockname()[1]


@pytest.fixture
def scenario(tmp_path):
    """Writes a small scenario and gives its path: so many vehicles abreast, no obstacles, and [autopilot] as asked."""

    def write(count=1, **autopilot):
        path = tmp_path / "scenario.toml"
        lines = "\n".join(f"{key} = {json.dumps(value)}" for key, value in autopilot.items())
        path.write_text(SCENARIO.format(count=count, autopilot=lines))
        return path

    return write


class Vehicles(Fleet):
    """`columba vehicles`, to which our own ground station connects."""

    def connect(self):
        return super().connect(to=Craft)


@pytest.fixture
def start_vehicles(program):
    """Starts `columba vehicles` with the options given; ends it after the test, and expects a clean end."""
    started, sinks = [], []

    def start(*options, ground_port=None):
        if ground_port is None:
            # Bound and never read: what vehicles send unasked must not reach another test.
            sinks.append(bind())
            ground_port = sinks[-1].getsockname()[1]
        started.append(Vehicles(program, *options, ground_port=ground_port))
        return started[-1]

    yield start
    for vehicles in started:
        vehicles.stop()
    for sink in sinks:
        sink.close()


@pytest.fixture
def craft(start_vehicles, scenario):
    """One vehicle in the air at 10 m/s, north, 50 m, five times as fast as the clock, and a connection to it."""
    return start_vehicles(scenario(), "--speed", 5).connect()[0]


class Run:
    """The folder of a run."""

    def __init__(self, folder, status, errors=""):
        self.folder, self.status, self.errors = folder, status, errors

    @property
    def summary(self):
        return json.loads((self.folder / "summary.json").read_text())

    @property
    def trajectory_bytes(self):
        return (self.folder / "trajectory.parquet").read_bytes()

    @property
    def trajectory(self):
        """The rows of trajectory.parquet, as dictionaries."""
        return pyarrow.parquet.read_table(self.folder / "trajectory.parquet").to_pylist()

    @property
    def tlog(self):
        return self.folder / "flight.tlog"


@pytest.fixture(scope="session")
def fly(program, tmp_path_factory):
    """Runs `columba COMMAND ...` to its end in a folder of its own."""

    def run(command, *options, report=False):
        folder = tmp_path_factory.mktemp(command)
        words = [program, command, *options, "--quiet", "--out", folder, *([] if report else ["--no-report"])]
        done = subprocess.run([str(word) for word in words], stderr=subprocess.PIPE, text=True, timeout=RUN_PATIENCE_S)
        return Run(folder, done.returncode, done.stderr)

    return run


@pytest.fixture(scope="session")
def flown(fly):
    """The paper's flight in lockstep over UDP, with its report."""
    run = fly("run", "--seed", 7, report=True)
    assert run.status == 0, run.errors
    return run
