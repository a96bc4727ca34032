"""The ground station: from the ground to the ground, and what it says when something goes wrong."""

import signal
import subprocess
import time

import pytest
import tlog
from conftest import Run, free_port
from controller import Controller
from ground import LOITER, RTL
from pymavlink import mavutil

SCENARIO = """
[scenario]
name = "station"
duration_s = {duration_s}
{scenario}

[flock]
expected_speed_mps = {speed_mps}
expected_altitude_m = 50.0

[vehicles]
count = {count}
pattern = "line"

[[obstacle]]
x_m = 70.0
y_m = 0.0
radius_m = 6.0

[parameters]
{parameters}
"""


@pytest.fixture
def field(tmp_path):
    """Writes a scenario of so many vehicles abreast with one obstacle before them."""

    def write(count=2, duration_s=15.0, speed_mps=10.0, scenario="", parameters=""):
        path = tmp_path / f"field-{time.monotonic_ns()}.toml"
        text = SCENARIO.format(
            count=count, duration_s=duration_s, speed_mps=speed_mps, scenario=scenario, parameters=parameters
        )
        path.write_text(text)
        return path

    return write


@pytest.fixture
def start_fly(program, tmp_path_factory):
    started = []

    def start(*options, folder=None):
        folder = folder or tmp_path_factory.mktemp("station")
        started.append(Controller(program, folder, *options))
        return started[-1]

    yield start
    for controller in started:
        controller.kill()


def events(run, weight=None):
    return [event for event in run.summary["station"]["events"] if weight in (None, event["weight"])]


def told(run, text):
    return [event for event in events(run) if text in event["text"]]


@pytest.mark.parametrize(
    "personality, flies, left",
    [("arduplane", "GUIDED", "LOITER"), ("px4", "Guided Course", "Hold"), ("generic", "GUIDED", "LOITER")],
)
def test_from_the_ground_to_a_loiter(start_fly, start_vehicles, field, personality, flies, left):
    port, scenario = free_port(), field()
    start_vehicles(scenario, "--on-ground", "--personality", personality, "--speed", 5, ground_port=port)
    run = start_fly(scenario, "--speed", 5, "--link", f"udpin:127.0.0.1:{port}").end()
    assert run.status == 0, run.errors
    summary = run.summary
    # A machine that stalls at the end flies on until it decides again.
    assert summary["success"] and summary["completed"] and 15.0 <= summary["duration_s"] < 17.0
    assert summary["min_clearance_m"] > 0 and summary["min_separation_m"] > 2
    assert summary["link"]["lost"] == 0
    assert len(told(run, f"is in the air, in {flies}")) == 2
    assert len(told(run, f"is left in {left}")) == 2
    assert [vehicle["mode"] for vehicle in summary["station"]["vehicles"]] == [left] * 2
    assert summary["station"]["separation_rests_on"]["uncertainty_m"] < 0.5
    # Side by side at the height of the flock when it begins.
    first = run.trajectory[:2]
    assert all(abs(row["altitude_m"] - 50) < 3 and abs(row["speed_mps"] - 10) < 2 for row in first)


def test_the_frames_of_the_log_have_times_of_their_own(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(duration_s=5)
    start_vehicles(scenario, "--speed", 5, ground_port=port)
    run = start_fly(scenario, "--speed", 5, "--link", f"udp:127.0.0.1:{port}").end()
    assert run.status == 0, run.errors
    times = [message._timestamp for message in tlog.messages(run.tlog) if message.get_type() == "GLOBAL_POSITION_INT"]
    assert len(set(times)) > 0.4 * len(times), "two vehicles' datagrams come nearly together"


def test_a_speed_that_a_vehicle_cannot_fly_ends_it_before_anybody_is_armed(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(speed_mps=7.0)
    start_vehicles(field(parameters="AIRSPEED_MIN = 9.0"), "--on-ground", "--speed", 10, ground_port=port)
    run = start_fly(scenario, "--speed", 10, "--link", f"udpin:127.0.0.1:{port}").end()
    assert run.status == 1
    assert "cannot fly the expected speed of 7 m/s: its least is 9 m/s" in run.errors
    assert not any(vehicle["armed"] for vehicle in run.summary["station"]["vehicles"])


def test_an_origin_elsewhere_ends_it_before_anybody_is_armed(start_fly, start_vehicles, field):
    port, here = free_port(), field()
    there = field(scenario="origin = { latitude_deg = -35.36, longitude_deg = 149.16, altitude_amsl_m = 584.0 }")
    start_vehicles(here, "--on-ground", "--speed", 10, ground_port=port)
    run = start_fly(there, "--speed", 10, "--link", f"udpin:127.0.0.1:{port}").end()
    assert run.status == 1
    assert "km from the origin" in run.errors and "--origin home" in run.errors


def test_a_dry_run_commands_nobody(start_fly, start_vehicles, field):
    port, scenario = free_port(), field()
    start_vehicles(scenario, "--on-ground", "--speed", 10, ground_port=port)
    run = start_fly(scenario, "--speed", 10, "--link", f"udpin:127.0.0.1:{port}", "--dry-run").end()
    assert run.status == 0, run.errors
    assert told(run, "all are ready; the nearest two are") and told(run, "a dry run")
    kinds = {(message.get_type(), getattr(message, "command", None)) for message in tlog.messages(run.tlog)}
    assert ("COMMAND_LONG", 400) not in kinds and ("COMMAND_LONG", 176) not in kinds


def test_who_is_killed_is_lost_and_the_others_go_on(start_fly, start_vehicles, field, tmp_path):
    port, scenario = free_port(), field(count=2, duration_s=30)
    start_vehicles(field(count=1), "--speed", 2, ground_port=port)
    other = start_vehicles(field(count=1), "--param", "MAV_SYSID=7", "--speed", 2, ground_port=port)
    controller = start_fly(scenario, "--speed", 2, "--link", f"udpin:127.0.0.1:{port}")
    controller.wait_for("the flock flies")
    other.stop()
    assert "vehicle 2" in controller.wait_for("is lost")
    run = controller.end()
    assert run.status == 1
    # First stale, unless this machine was itself too slow to see that.
    assert told(run, "is stale") or told(run, "this machine stalled")
    assert "vehicle 2 is lost" in run.errors
    summary = run.summary
    assert summary["completed"] and not summary["success"]
    assert [vehicle["system_id"] for vehicle in summary["station"]["vehicles"]] == [1, 7]
    # Nothing is recorded as flown that was not heard.
    last = [row for row in run.trajectory if row["vehicle"] == 2][-1]
    assert last["x_m"] != last["x_m"]


def test_ctrl_c_leaves_nobody_in_guided(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(duration_s=60)
    vehicles = start_vehicles(scenario, "--speed", 2, ground_port=port)
    controller = start_fly(scenario, "--speed", 2, "--link", f"udpin:127.0.0.1:{port}", "--at-end", "return")
    controller.wait_for("the flock flies")
    controller.process.send_signal(signal.SIGINT)
    run = controller.end()
    assert run.status == 1 and "interrupted" in run.errors
    assert run.summary["interrupted"]
    assert [craft.mode() for craft in vehicles.connect()] == [RTL, RTL]


def test_a_killed_controller_leaves_its_record_and_another_picks_the_flight_up(
    start_fly, start_vehicles, field, program
):
    port, scenario = free_port(), field(duration_s=20)
    start_vehicles(scenario, "--speed", 2, ground_port=port)
    options = (scenario, "--speed", 2, "--link", f"udpin:127.0.0.1:{port}")
    controller = start_fly(*options)
    controller.wait_for("the flock flies")
    deadline = time.monotonic() + 30
    journal = controller.folder / "flight.journal"
    while journal.read_text().count('"tick"') < 5:
        assert time.monotonic() < deadline
        time.sleep(0.05)
    controller.kill()
    recovered = subprocess.run([program, "recover", controller.folder, "--quiet"], capture_output=True, text=True)
    assert recovered.returncode == 0, recovered.stderr
    run = Run(controller.folder, 0)
    assert run.summary["failure"].startswith("recovered") and len(run.trajectory) >= 10
    assert (controller.folder / "report.html").exists()
    assert sum(1 for _ in tlog.messages(run.tlog)) > 20
    again = start_fly(*options, "--force", folder=controller.folder).end()
    assert again.status == 0, again.errors
    assert not told(again, "is in the air"), "it flew already"
    assert (controller.folder / "flight.journal.1").exists()


def test_the_operator_pauses_resumes_drops_takes_and_aborts(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(count=2, duration_s=120)
    vehicles = start_vehicles(scenario, "--speed", 3, ground_port=port)
    controller = start_fly(scenario, "--speed", 3, "--link", f"udpin:127.0.0.1:{port}")
    controller.wait_for("the flock flies")
    first, second = vehicles.connect()

    def until(craft, mode):
        craft.wait(
            ["HEARTBEAT"], lambda message: message.get_srcSystem() == craft.system and message.custom_mode == mode
        )

    controller.say("pause")
    until(first, LOITER), until(second, LOITER)
    controller.say("resume")
    until(first, 15), until(second, 15)
    controller.say("drop 2")
    until(second, LOITER)
    controller.say("take 2")
    until(second, 15)
    controller.say("nonsense")
    controller.wait_for("must be pause, resume, abort")
    controller.say("abort")
    run = controller.end()
    assert run.status == 1 and "aborted by the operator" in run.errors
    until(first, LOITER), until(second, LOITER)


ONE = """
[scenario]
name = "one"
duration_s = 10.0

[flock]
expected_speed_mps = 10.0
expected_altitude_m = 50.0

[[vehicle]]
x_m = 0.0
y_m = {y_m}
altitude_m = 50.0
speed_mps = 10.0
course_deg = 0.0
"""


@pytest.fixture
def one(tmp_path):
    def write(y_m):
        path = tmp_path / f"one-{y_m}.toml"
        path.write_text(ONE.format(y_m=y_m))
        return path

    return write


def test_two_autopilots_of_one_system_id_are_a_fault_before_anybody_is_armed(start_fly, start_vehicles, one):
    port = free_port()
    for y_m in (0.0, 30.0):
        start_vehicles(one(y_m), "--on-ground", "--speed", 5, ground_port=port)
    run = start_fly(one(0.0), "--speed", 5, "--link", f"udpin:127.0.0.1:{port}").end()
    assert run.status == 1 and "two autopilots speak with system id 1" in run.errors
    assert not any(vehicle["armed"] for vehicle in run.summary["station"]["vehicles"])


def test_a_mixed_flock_from_the_ground(start_fly, start_vehicles, field, one):
    port, scenario = free_port(), field(count=2)
    start_vehicles(one(-6.0), "--on-ground", "--speed", 10, ground_port=port)
    start_vehicles(
        one(6.0), "--on-ground", "--personality", "generic", "--param", "MAV_SYSID=9", "--speed", 10, ground_port=port
    )
    run = start_fly(scenario, "--speed", 10, "--link", f"udpin:127.0.0.1:{port}").end()
    assert run.status == 0, run.errors
    kinds = [(vehicle["system_id"], vehicle["autopilot"]) for vehicle in run.summary["station"]["vehicles"]]
    assert kinds == [(1, "ArduPlane"), (9, "Columba")]


def test_the_operator_speaks_by_messages_too(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(count=1, duration_s=120)
    start_vehicles(scenario, "--speed", 2, ground_port=port)
    controller = start_fly(scenario, "--speed", 2, "--link", f"udpin:127.0.0.1:{port}")
    controller.wait_for("the flock flies")
    operator = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=252)
    try:
        for command, param, text in [(193, 0, "paused by the operator"), (193, 1, "resumed"), (31010, 1, "is left in")]:
            operator.mav.command_long_send(255, 190, command, 0, param, 0, 0, 0, 0, 0, 0)
            assert operator.recv_match(type="COMMAND_ACK", blocking=True, timeout=10).result == 0
            controller.wait_for(text)
    finally:
        operator.close()
    run = controller.end()
    assert run.status == 1 and "aborted by the operator" in run.errors


def test_a_full_disk_does_not_end_the_flight(start_fly, start_vehicles, field, tmp_path):
    port, scenario = free_port(), field(count=1, duration_s=5)
    folder = tmp_path / "full"
    folder.mkdir()
    (folder / "flight.tlog").symlink_to("/dev/full")
    start_vehicles(scenario, "--speed", 5, ground_port=port)
    options = (scenario, "--speed", 5, "--link", f"udpin:127.0.0.1:{port}", "--force")
    run = start_fly(*options, folder=folder).end()
    assert run.status == 1 and "the record cannot be written any more" in run.errors
    assert run.summary["completed"] and run.summary["station"]["vehicles"][0]["mode"] == "LOITER"


def test_wrong_links_are_told_with_the_right_spelling(program):
    def refusal(link):
        done = subprocess.run([program, "fly", "--link", link], capture_output=True, text=True, timeout=30)
        assert done.returncode == 2
        return done.stderr

    assert "must be udpin:127.0.0.1:14550" in refusal("udpn:127.0.0.1:14550")
    assert "for example tcp:127.0.0.1:5760" in refusal("tcp:127.0.0.1")
