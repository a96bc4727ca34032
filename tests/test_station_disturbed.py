"""The ground station when something goes wrong: a vehicle that stays on the ground, refuses, or has a double; a machine
that stalls; a link that loses."""

import signal
import threading
import time
from collections import Counter

import pytest
from conftest import free_port
from ground import ACCEPTED, FAILED, GUIDED
from proxy import LossyProxy
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from test_station import field, one, start_fly, told  # noqa: F401

TAKEOFF = 13


def test_one_that_stays_on_the_ground_is_named_and_the_others_wait_near_home(start_fly, start_vehicles, field, one):
    port, scenario = free_port(), field(count=2)
    start_vehicles(one(-6.0), "--on-ground", "--speed", 10, ground_port=port)
    dead = ("--param", "MAV_SYSID=9", "--param", "SIM_ENGINE_FAIL=1")
    start_vehicles(one(6.0), "--on-ground", *dead, "--speed", 10, ground_port=port)
    run = start_fly(scenario, "--speed", 10, "--link", f"udpin:127.0.0.1:{port}", "--patience", 100).end()
    assert run.status == 1
    assert "vehicle 2 did not leave the ground in 100 s" in run.errors
    assert told(run, "is in the air") and told(run, "is left in LOITER"), "vehicle 1"
    assert not told(run, "the flock flies")
    # 100 s at 10 m/s would be a kilometre.
    first = run.trajectory[0]
    assert first["vehicle"] == 1 and max(abs(first["x_m"]), abs(first["y_m"])) < 500


def test_one_that_falls_silent_in_its_take_off_is_lost_and_not_on_the_ground(start_fly, start_vehicles, one):
    port, scenario = free_port(), one(0.0)
    vehicles = start_vehicles(scenario, "--on-ground", "--speed", 5, ground_port=port)
    controller = start_fly(scenario, "--speed", 5, "--link", f"udpin:127.0.0.1:{port}", "--patience", 40)
    vehicles.connect()[0].wait(["HEARTBEAT"], lambda beat: beat.custom_mode == TAKEOFF)
    vehicles.process.send_signal(signal.SIGSTOP)
    try:
        controller.wait_for("is lost: nothing of its position for")
    finally:
        vehicles.process.send_signal(signal.SIGCONT)
    run = controller.end()
    assert run.status == 1 and "did not leave the ground" not in run.errors


def test_one_that_is_not_ready_is_named_and_nobody_is_armed(start_fly, start_vehicles, field, one):
    port = free_port()
    start_vehicles(one(-6.0), "--on-ground", "--speed", 10, ground_port=port)
    blind = ("--param", "MAV_SYSID=9", "--param", "SIM_GPS1_ENABLE=0")
    start_vehicles(one(6.0), "--on-ground", *blind, "--speed", 10, ground_port=port)
    run = start_fly(field(count=2), "--speed", 10, "--link", f"udpin:127.0.0.1:{port}", "--patience", 30).end()
    assert run.status == 1 and "vehicle 2 is not ready after 30 s" in run.errors, run.errors
    assert "vehicle 1 is not ready" not in run.errors
    assert not any(vehicle["armed"] for vehicle in run.summary["station"]["vehicles"])


class Stubborn(threading.Thread):
    """An ArduPlane of a few lines that flies north, east of the field, and refuses some commands. What its pilot
    wishes counts more than some modes that it is ordered into."""

    def __init__(self, port, *refused, wishes=()):
        super().__init__(daemon=True)
        self.link = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=1, source_component=1)
        self.refused, self.wishes, self.orders = refused, dict(wishes), Counter()
        self.mode, self.running, self.began = GUIDED, True, time.monotonic()
        self.start()

    def run(self):
        due = heart = self.began
        while self.running:
            now = time.monotonic()
            if now >= due:
                due += 0.1
                self.tell_position(now - self.began)
            if now >= heart:
                heart += 0.5
                self.link.mav.heartbeat_send(1, 3, 0xD9, self.mode, 4)
                self.link.mav.extended_sys_state_send(0, 2)
                self.link.mav.home_position_send(399_800_000, 1_163_412_000, 50_000, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0)
            if message := self.link.recv_match(type=["COMMAND_LONG", "COMMAND_INT"], blocking=True, timeout=0.02):
                self.obey(message)

    def tell_position(self, since_s):
        north_m = 10.0 * since_s
        lat = 399_800_000 + int(north_m / 111_319.5 * 1e7)
        stamp = int(1e3 * since_s) + 10_000
        self.link.mav.global_position_int_send(stamp, lat, 1_163_412_000, 100_000, 50_000, 1000, 0, 0, 0)

    def obey(self, message):
        if message.command in self.refused:
            self.link.mav.command_ack_send(message.command, FAILED)
            return
        if message.command == 176:
            asked = int(message.param2)
            self.orders[asked] += 1
            self.mode = self.wishes.get(asked, asked)
        self.link.mav.command_ack_send(message.command, ACCEPTED)

    def close(self):
        self.running = False
        self.join()
        self.link.close()


@pytest.mark.parametrize(
    "refused, says", [(43000, "refuses the speed in GUIDED: FAILED"), (176, "was not seen to end as it should")]
)
def test_one_that_refuses_a_command_is_named(start_fly, field, refused, says):
    port = free_port()
    stubborn = Stubborn(port, refused)
    try:
        run = start_fly(field(count=1, duration_s=8), "--link", f"udpin:127.0.0.1:{port}").end()
    finally:
        stubborn.close()
    assert run.status == 1 and run.summary["completed"], run.errors
    assert f"vehicle 1 {says}" in run.summary["failure"] and len(told(run, says)) == 1


def test_one_whose_limits_become_narrower_is_told(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(count=2, duration_s=20)
    vehicles = start_vehicles(scenario, "--speed", 4, ground_port=port)
    controller = start_fly(scenario, "--speed", 4, "--link", f"udpin:127.0.0.1:{port}")
    controller.wait_for("the flock flies")
    narrow = vehicles.connect()[1]
    # The greatest speed is never below that of cruising.
    narrow.set_parameter("AIRSPEED_CRUISE", 8.0)
    narrow.set_parameter("AIRSPEED_MAX", 8.0)
    line = controller.wait_for("is asked for 8.0 m/s")
    assert "vehicle 2" in line
    run = controller.end()
    assert [vehicle["mode"] for vehicle in run.summary["station"]["vehicles"]] == ["LOITER"] * 2


def test_a_machine_that_stalls_is_told_and_nobody_is_called_lost_for_it(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(count=2, duration_s=30)
    start_vehicles(scenario, "--speed", 2, ground_port=port)
    controller = start_fly(scenario, "--speed", 2, "--link", f"udpin:127.0.0.1:{port}")
    controller.wait_for("the flock flies")
    controller.process.send_signal(signal.SIGSTOP)
    time.sleep(4)
    controller.process.send_signal(signal.SIGCONT)
    controller.wait_for("this machine stalled for")
    run = controller.end()
    assert run.summary["completed"]
    assert not told(run, "is lost") and not told(run, "is stale")
    assert not told(run, "is flown no more")
    assert [vehicle["mode"] for vehicle in run.summary["station"]["vehicles"]] == ["LOITER"] * 2


def test_what_a_link_loses_is_counted(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(count=2, duration_s=10)
    start_vehicles(scenario, "--speed", 2, ground_port=port)
    options = ("--speed", 2, "--link", f"udpin:127.0.0.1:{port}", "--loss", 0.1)
    run = start_fly(scenario, *options).end()
    link = run.summary["link"]
    assert link["impairment_lost"] > 10 and link["lost"] > 0
    assert link["links"][0]["counters"]["impairment_lost"] == link["impairment_lost"]
    assert run.summary["completed"] and not told(run, "is lost")


def test_a_double_that_comes_up_in_flight_changes_nothing(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(count=1, duration_s=20)
    start_vehicles(scenario, "--speed", 2, ground_port=port)
    controller = start_fly(scenario, "--speed", 2, "--link", f"udpin:127.0.0.1:{port}")
    controller.wait_for("the flock flies")
    double = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=1, source_component=1)
    try:
        for step in range(40):
            double.mav.heartbeat_send(1, 3, 0x51, 0, 3)  # disarmed, in MANUAL
            double.mav.global_position_int_send(
                1000 + 100 * step, 400_000_000, 1_164_000_000, 90_000, 40_000, 0, 0, 0, 0
            )
            if step == 20:
                controller.wait_for("another autopilot speaks with its system id")
            time.sleep(0.05)
    finally:
        double.close()
    run = controller.end()
    assert run.status == 0, run.errors
    assert len(told(run, "another autopilot")) == 1
    # The double is some ten kilometres away.
    assert all(abs(row["x_m"]) < 1000 for row in run.trajectory)


def test_gaps_in_what_routers_pass_on_are_no_losses(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(count=1, duration_s=10)
    start_vehicles(scenario, "--speed", 2, ground_port=port)
    controller = start_fly(scenario, "--speed", 2, "--link", f"udpin:127.0.0.1:{port}")
    controller.wait_for("the flock flies")
    other = mavutil.mavlink_connection(f"udpout:127.0.0.1:{port}", source_system=200)
    try:
        for _ in range(5):
            other.mav.seq = (other.mav.seq + 40) % 256
            other.mav.heartbeat_send(6, 8, 0, 0, 0)
    finally:
        other.close()
    run = controller.end()
    assert run.status == 0 and run.summary["link"]["lost"] == 0, run.errors


class Overtaking(LossyProxy):
    """Loses nothing; but a heartbeat with another mode overtakes the one before it, which comes again behind it."""

    def __init__(self, ground_port):
        super().__init__(ground_port, 0.0)
        self.last, self.overtaken = {}, 0

    def forward(self, link, datagram, to):
        super().forward(link, datagram, to)
        beats = [message for message in self.messages(datagram) if message.get_type() == "HEARTBEAT"]
        if to != self.ground or not beats:
            return
        system, mode = beats[-1].get_srcSystem(), beats[-1].custom_mode
        before, was = self.last.get(system, (None, mode))
        if was != mode:
            self.overtaken += 1
            super().forward(link, before, to)
        self.last[system] = (datagram, mode)

    def messages(self, datagram):
        return mavlink.MAVLink(None).parse_buffer(datagram) or []


def test_a_heartbeat_that_was_overtaken_is_no_pilot(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(duration_s=5)
    with Overtaking(port) as link:
        start_vehicles(scenario, "--on-ground", "--speed", 5, ground_port=link.port)
        run = start_fly(scenario, "--speed", 5, "--link", f"udpin:127.0.0.1:{port}").end()
    assert link.overtaken > 0 and run.summary["link"]["repeated"] > 0
    assert run.status == 0, run.errors
    assert not told(run, "by others")
