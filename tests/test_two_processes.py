"""Vehicles and controller as two programs: through a bad network in lockstep, and in real time."""

import math

import pytest
import tlog
from conftest import bind, free_port
from proxy import LossyProxy


@pytest.mark.parametrize("loss", [0.0, 0.2])
def test_in_lockstep_through_a_proxy_the_flight_is_that_of_a_run(fly, flown, start_vehicles, loss):
    ground_port = free_port()
    with LossyProxy(ground_port, loss) as proxy:
        start_vehicles("--lockstep", ground_port=proxy.port)
        run = fly("fly", "--lockstep", "--seed", 7, "--ground-port", ground_port)
        lost_share = proxy.lost / (proxy.lost + proxy.passed)
    assert run.status == 0, run.errors
    assert run.trajectory_bytes == flown.trajectory_bytes
    assert lost_share == pytest.approx(loss, abs=0.05)


def test_in_real_time_the_flock_flies_what_the_controller_says(fly, start_vehicles):
    ground_port = free_port()
    start_vehicles("--speed", 5, ground_port=ground_port)
    run = fly("fly", "--speed", 5, "--duration", 10, "--ground-port", ground_port)
    assert run.status == 0, run.errors
    summary = run.summary
    assert (summary["transport"], summary["duration_s"]) == ("real-time", 10)
    assert summary["wall_s"] > 0.9
    assert summary["obstacle_collisions"] == summary["vehicle_collisions"] == 0
    # In every acknowledgement of a guided command: accepted.
    acks = [message for message in tlog.messages(run.tlog) if message.get_type() == "COMMAND_ACK"]
    assert len(acks) > 5 * 10
    assert {ack.result for ack in acks} == {0}
    rows = run.trajectory
    assert len(rows) == 5 * 21
    for first, last in zip(rows[:5], rows[-5:]):
        assert 80 < math.dist((first["x_m"], first["y_m"]), (last["x_m"], last["y_m"])) < 130


def test_somebody_looks_on_while_the_controller_speaks_first(fly, start_vehicles, scenario):
    """Telemetry goes to a ground station; the controller, at a port of its own, speaks to the vehicles, and arms
    them."""
    with bind() as onlooker:
        vehicles = start_vehicles(scenario(armed=False), "--speed", 10, ground_port=onlooker.getsockname()[1])
        port = vehicles.rows[0]["port"]
        run = fly("fly", scenario(), "--speed", 10, "--vehicle-port", port, "--ground-port", free_port())
        assert run.status == 0, run.errors
        assert len(onlooker.recv(2048)) > 0
    positions = [message for message in tlog.messages(run.tlog) if message.get_type() == "LOCAL_POSITION_NED"]
    assert (positions[0].x, positions[0].vx) == (0, 0), "it did not wait to be armed"
    assert positions[-1].x > 50


def test_one_program_in_real_time(fly):
    run = fly("run", "--speed", 10, "--duration", 10, "--vehicle-port", 0)
    assert run.status == 0, run.errors
    assert (run.summary["transport"], run.summary["duration_s"]) == ("real-time", 10)


def test_a_controller_without_vehicles_says_who_is_silent(fly):
    run = fly("fly", "--speed", 10, "--ground-port", free_port())
    assert run.status == 1
    assert "no telemetry" in run.errors and "vehicles 1, 2, 3, 4, 5" in run.errors
