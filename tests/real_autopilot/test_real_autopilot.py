"""Flies the user's own builds of real autopilots in software, from the ground to the ground; a second link is the judge.

ARDUPLANE_BIN (with ARDUPLANE_DEFAULTS), ARDUCOPTER_BIN (with ARDUCOPTER_DEFAULTS) and PX4_BUILD_DIR name the builds;
docs/real-autopilots.md says where they come from. Without them a test is skipped, and says which variable is missing.
"""

import json
import math
import os
import subprocess
import threading
import time
from pathlib import Path

import pytest
from conftest import free_port
from pymavlink import mavutil

LATITUDE_DEG, LONGITUDE_DEG, ALTITUDE_M = 39.98, 116.34, 50.0
METRES_PER_DEGREE = 111_319.5
PATIENCE_S = 600

PLANES = """
[scenario]
name = "planes"
duration_s = 45.0
control_period_s = 1.0
origin = {{ latitude_deg = 39.98, longitude_deg = 116.34, altitude_amsl_m = 50.0 }}

[flock]
expected_speed_mps = 20.0
expected_altitude_m = 50.0

[dynamics]
speed_time_constant_s = 2.0
course_time_constant_s = 1.5
speed_min_mps = 14.0
speed_max_mps = 26.0

[law]
communication_distance_m = 40.0
desired_distance_m = 40.0
safe_distance_m = 8.0
perception_distance_m = 480.0
obstacle_margin_m = 6.0

[look_ahead]
separation_m = 12.0
clearance_m = 4.0
horizon_s = 6.0

[vehicles]
count = {count}
pattern = "line"
spacing_m = 48.0

[[obstacle]]
x_m = 300.0
y_m = 10.0
radius_m = 32.0
"""

COPTERS = """
[scenario]
name = "copters"
duration_s = 25.0
origin = {{ latitude_deg = 39.98, longitude_deg = 116.34, altitude_amsl_m = 50.0 }}

[flock]
expected_speed_mps = 8.0
expected_altitude_m = 20.0

[dynamics]
speed_min_mps = 3.0
speed_max_mps = 10.0
climb_min_mps = -1.5
climb_max_mps = 2.5

[vehicles]
count = {count}
pattern = "line"
spacing_m = 12.0

[[obstacle]]
x_m = 80.0
y_m = 2.0
radius_m = 8.0
"""


def program(variable):
    path = os.environ.get(variable)
    if not path:
        pytest.skip(f"{variable} is not set: no build to fly")
    assert Path(path).exists(), f"{variable}={path}: there is no such build"
    return Path(path).resolve()


class Judge(threading.Thread):
    """Positions of one vehicle by a second link, and its last mode."""

    def __init__(self, address):
        super().__init__(daemon=True)
        self.address, self.track, self.mode, self.running = address, [], None, True
        self.start()

    def run(self):
        link = mavutil.mavlink_connection(self.address, source_system=200, retries=60)
        asked = 0.0
        while self.running:
            message = link.recv_match(type=["HEARTBEAT", "GLOBAL_POSITION_INT"], blocking=True, timeout=1)
            if link.target_system and time.time() - asked > 5:
                asked = time.time()
                link.mav.command_long_send(link.target_system, 1, 511, 0, 33, 50_000, 0, 0, 0, 0, 0)
            if message is None:
                continue
            if message.get_type() == "HEARTBEAT":
                self.mode = link.flightmode
            else:
                north = (message.lat * 1e-7 - LATITUDE_DEG) * METRES_PER_DEGREE
                east = (message.lon * 1e-7 - LONGITUDE_DEG) * METRES_PER_DEGREE * math.cos(math.radians(LATITUDE_DEG))
                self.track.append((time.time(), north, east, message.relative_alt * 1e-3))


def least_separation(judges, began, ended):
    """Between all, by linear interpolation at 20 ms."""
    least = math.inf
    steps = int((ended - began) / 0.02)
    columns = []
    for judge in judges:
        track, at, column = judge.track, 0, []
        for step in range(steps):
            when = began + 0.02 * step
            while at + 2 < len(track) and track[at + 1][0] < when:
                at += 1
            (t0, x0, y0, _), (t1, x1, y1, _) = track[at], track[at + 1]
            share = (when - t0) / (t1 - t0) if t1 > t0 else 0.0
            column.append((x0 + share * (x1 - x0), y0 + share * (y1 - y0)))
        columns.append(column)
    for one in range(len(columns)):
        for other in range(one):
            least = min(least, min(math.dist(a, b) for a, b in zip(columns[one], columns[other])))
    return least


@pytest.fixture
def start_ardupilot(tmp_path):
    """Starts instances of an ArduPilot build; telemetry to a UDP port, judges at their second TCP ports."""
    processes = []

    def start(binary, defaults, model, count, spacing_m, port, base=40):
        judges = []
        for index in range(count):
            folder = tmp_path / f"vehicle-{index + 1}"
            folder.mkdir()
            east = (index - 0.5 * (count - 1)) * spacing_m
            longitude = LONGITUDE_DEG + east / METRES_PER_DEGREE / math.cos(math.radians(LATITUDE_DEG))
            words = [
                binary, "--model", model, "--speedup", "1", f"-I{base + index}", "--sysid", index + 1, "--wipe",
                "--home", f"{LATITUDE_DEG},{longitude:.7f},{ALTITUDE_M},0", "--serial0", f"udpclient:127.0.0.1:{port}",
            ]  # fmt: skip
            words += ["--defaults", defaults] if defaults else []
            log = (folder / "log").open("w")
            processes.append(
                subprocess.Popen([str(word) for word in words], cwd=folder, stdout=log, stderr=log, stdin=subprocess.DEVNULL)
            )
            judges.append(Judge(f"tcp:127.0.0.1:{5762 + 10 * (base + index)}"))
        return judges

    yield start
    for process in processes:
        process.kill()
        process.wait()


def fly(columba, tmp_path, text, port, *options):
    scenario, folder = tmp_path / "field.toml", tmp_path / "run"
    scenario.write_text(text)
    words = [columba, "fly", scenario, "--link", f"udpin:127.0.0.1:{port}", "--out", folder, "--no-report", *options]
    began = time.time()
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=PATIENCE_S, stdin=subprocess.DEVNULL)
    print(done.stderr)
    summary = json.loads((folder / "summary.json").read_text())
    events = summary["station"]["events"]
    start = next((event["at_s"] for event in events if event["text"] == "the flock flies"), None)
    assert start is not None, done.stderr
    return done, summary, began + start, began + start + summary["duration_s"]


def check(done, summary, judges, began, ended, safe_distance_m, mode):
    assert done.returncode == 0, done.stderr
    assert summary["success"] and summary["min_clearance_m"] > 0 and summary["link"]["lost"] == 0
    judged = least_separation(judges, began, ended)
    assert judged >= safe_distance_m
    assert abs(judged - summary["min_separation_m"]) < 0.6
    time.sleep(2)
    assert {judge.mode for judge in judges} == {mode}


def test_planes_from_the_ground_to_a_loiter(columba_program, tmp_path, start_ardupilot):
    binary, port = program("ARDUPLANE_BIN"), free_port()
    judges = start_ardupilot(binary, os.environ.get("ARDUPLANE_DEFAULTS"), "plane", 5, 60.0, port)
    check(*_flown(columba_program, tmp_path, PLANES.format(count=5), port, judges), 8.0, "LOITER")


def test_copters_from_the_ground_to_a_brake(columba_program, tmp_path, start_ardupilot):
    binary, port = program("ARDUCOPTER_BIN"), free_port()
    judges = start_ardupilot(binary, os.environ.get("ARDUCOPTER_DEFAULTS"), "quad", 3, 20.0, port, base=50)
    check(*_flown(columba_program, tmp_path, COPTERS.format(count=3), port, judges), 2.0, "BRAKE")


def _flown(columba, tmp_path, text, port, judges):
    done, summary, began, ended = fly(columba, tmp_path, text, port)
    return done, summary, judges, began, ended


def test_px4_multicopters_from_the_ground_to_hold(columba_program, tmp_path):
    build = program("PX4_BUILD_DIR")
    processes = []
    try:
        for index in range(3):
            folder = tmp_path / f"px4-{index + 1}"
            folder.mkdir()
            east = (index - 1) * 12.0
            longitude = LONGITUDE_DEG + east / METRES_PER_DEGREE / math.cos(math.radians(LATITUDE_DEG))
            environment = {
                **os.environ,
                "PX4_SIM_MODEL": "sihsim_quadx",
                "PX4_HOME_LAT": str(LATITUDE_DEG),
                "PX4_HOME_LON": f"{longitude:.7f}",
                "PX4_HOME_ALT": str(ALTITUDE_M),
                "PX4_PARAM_SDLOG_MODE": "-1",
                "PX4_PARAM_SIH_KDV": "0.2",
            }
            log = (folder / "log").open("w")
            words = [build / "bin/px4", "-i", index, "-d", build / "etc"]
            processes.append(
                subprocess.Popen([str(word) for word in words], cwd=folder, env=environment, stdout=log, stderr=log, stdin=subprocess.DEVNULL)
            )
        scenario, folder = tmp_path / "field.toml", tmp_path / "run"
        scenario.write_text(COPTERS.format(count=3))
        links = [word for index in range(3) for word in ("--link", f"udpin:127.0.0.1:{14540 + index}")]
        words = [columba_program, "fly", scenario, *links, "--out", folder, "--no-report"]
        done = subprocess.run([str(word) for word in words], capture_output=True, text=True, timeout=PATIENCE_S, stdin=subprocess.DEVNULL)
        assert done.returncode == 0, done.stderr
    finally:
        for process in processes:
            process.kill()
            process.wait()
