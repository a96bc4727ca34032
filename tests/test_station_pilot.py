"""A pilot who takes over a vehicle keeps the vehicle, whatever the ground station is about to order."""

import signal
import time

import tlog
from conftest import free_port
from ground import ACCEPTED, CRUISE, LOITER
from test_station import field, one, start_fly, told  # noqa: F401
from test_station_disturbed import TAKEOFF, Stubborn


def start(start_fly, start_vehicles, scenario, *options, speed=2):
    """The flight, and its vehicles."""
    port = free_port()
    vehicles = start_vehicles(scenario, *options, "--speed", speed, ground_port=port)
    return start_fly(scenario, "--speed", speed, "--link", f"udpin:127.0.0.1:{port}"), vehicles


def until(craft, mode):
    craft.wait(["HEARTBEAT"], lambda beat: beat.get_srcSystem() == craft.system and beat.custom_mode == mode)


def test_one_that_a_pilot_takes_over_is_released_and_named(start_fly, start_vehicles, field):
    port, scenario = free_port(), field(count=3, duration_s=40)
    vehicles = start_vehicles(scenario, "--speed", 2, ground_port=port)
    controller = start_fly(scenario, "--speed", 2, "--link", f"udpin:127.0.0.1:{port}")
    controller.wait_for("the flock flies")
    pilot = vehicles.connect()[1]
    pilot.set_mode(CRUISE)
    line = controller.wait_for("is flown no more")
    assert "vehicle 2" in line and "CRUISE" in line
    run = controller.end()
    assert run.status == 1 and "vehicle 2" in run.errors
    assert pilot.mode() == CRUISE, "it is left to the pilot"
    modes = [vehicle["mode"] for vehicle in run.summary["station"]["vehicles"]]
    assert modes == ["LOITER", "CRUISE", "LOITER"]
    # No command to it from then on, but questions.
    released = told(run, "is flown no more")[0]["at_s"]
    start = None
    for message in tlog.messages(run.tlog):
        start = start or message._timestamp
        if message.get_srcSystem() == 255 and message.get_type() in ("COMMAND_INT", "COMMAND_LONG"):
            late = (message._timestamp - start) * 2 - released > 1.0
            if late and message.target_system == 2:
                assert message.command in (511, 512), message


def test_a_pilot_who_takes_over_in_a_pause_keeps_the_vehicle(start_fly, start_vehicles, field):
    controller, vehicles = start(start_fly, start_vehicles, field(count=2, duration_s=120))
    controller.wait_for("the flock flies")
    pilot = vehicles.connect()[1]
    controller.say("pause")
    controller.wait_for("paused by the operator")
    until(pilot, LOITER)
    assert pilot.set_mode(CRUISE) == ACCEPTED
    line = controller.wait_for("is flown no more")
    assert "vehicle 2" in line and "CRUISE" in line
    for verb in ("resume", "abort"):
        controller.say(verb)
    run = controller.end()
    assert pilot.mode() == CRUISE, "it is left to the pilot"
    assert "vehicle 1: was brought" not in run.errors
    assert [vehicle["mode"] for vehicle in run.summary["station"]["vehicles"]] == ["LOITER", "CRUISE"]


def test_a_station_that_stalls_in_a_pause_does_not_take_the_vehicle_from_its_pilot(start_fly, start_vehicles, field):
    controller, vehicles = start(start_fly, start_vehicles, field(count=2, duration_s=120))
    controller.wait_for("the flock flies")
    pilot = vehicles.connect()[1]
    controller.say("pause")
    controller.wait_for("paused by the operator")
    # The order is out; that it is followed is not heard, nor what the pilot does.
    controller.process.send_signal(signal.SIGSTOP)
    until(pilot, LOITER)
    assert pilot.set_mode(CRUISE) == ACCEPTED
    time.sleep(1.0)
    controller.process.send_signal(signal.SIGCONT)
    assert "CRUISE" in controller.wait_for("is flown no more", 20)
    controller.say("abort")
    controller.end()
    assert pilot.mode() == CRUISE


def test_a_pilot_who_takes_over_on_the_way_back_from_a_pause_keeps_the_vehicle(start_fly, field):
    port = free_port()
    # It is to follow again, and goes where its pilot wishes.
    stubborn = Stubborn(port)
    controller = start_fly(field(count=1, duration_s=120), "--link", f"udpin:127.0.0.1:{port}")
    try:
        controller.wait_for("the flock flies")
        controller.say("pause 1")
        controller.wait_for("paused by the operator")
        deadline = time.monotonic() + 10
        while stubborn.mode != LOITER:
            assert time.monotonic() < deadline
            time.sleep(0.05)
        stubborn.wishes[15] = CRUISE
        controller.say("resume 1")
        assert "CRUISE" in controller.wait_for("is flown no more", 20)
        run = controller.end()
    finally:
        stubborn.close()
    assert stubborn.mode == CRUISE and run.status == 1


def test_a_pilot_who_takes_over_at_the_end_keeps_the_vehicle(start_fly, field):
    port = free_port()
    stubborn = Stubborn(port, wishes={LOITER: CRUISE})
    try:
        run = start_fly(field(count=1, duration_s=5), "--link", f"udpin:127.0.0.1:{port}").end()
    finally:
        stubborn.close()
    assert stubborn.orders[LOITER] == 1, "it is not ordered again"
    assert stubborn.mode == CRUISE and run.status == 1
    assert "vehicle 1: was brought into CRUISE by others" in run.errors


def test_a_pilot_who_takes_over_in_a_take_off_keeps_the_vehicle(start_fly, start_vehicles, field):
    controller, vehicles = start(start_fly, start_vehicles, field(count=2), "--on-ground", speed=4)
    pilot = vehicles.connect()[1]
    until(pilot, TAKEOFF)
    pilot.wait(["GLOBAL_POSITION_INT"], lambda place: place.relative_alt > 8_000)
    assert pilot.set_mode(CRUISE) == ACCEPTED
    line = controller.wait_for("is flown no more", 60)
    assert "vehicle 2" in line and "CRUISE" in line
    run = controller.end()
    assert pilot.mode() == CRUISE
    assert run.status == 1 and told(run, "is left in LOITER"), "vehicle 1 flies on"
