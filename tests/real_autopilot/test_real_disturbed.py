"""Real planes when something goes wrong. Builds as in test_real_autopilot.py."""

import signal
import time

from builds import free_port
from fields import PLANES, field
from flight import flock, start_flight  # noqa: F401

LOITER, GUIDED = "LOITER", "GUIDED"


def test_everything_that_can_go_wrong_in_one_flight(start_flight, flock):
    """The controller is killed and started again; then limits change, a pilot takes one, one is gone; then Ctrl-C."""
    flock.add_ardupilot("plane", 4, 60.0, free_port())
    text, _ = field(4, 1, **PLANES)
    first = start_flight(text, flock.links)
    first.wait_for("the flock flies")
    time.sleep(5)
    first.process.kill()
    first.process.wait()

    flight = start_flight(text, flock.links)
    flight.wait_for("the flock flies")
    assert "is in the air" not in flight.said(), "all flew already"
    narrow, piloted, gone, well = flock.judges
    narrow.link.mav.param_set_send(1, 1, b"AIRSPEED_MAX", 12.0, 9)
    _, line = flight.wait_for("its own limits are narrower now")
    assert "vehicle 1" in line
    piloted.command(176, 1, 12)
    _, line = flight.wait_for("is flown no more")
    assert "vehicle 2" in line and LOITER in line
    flock.kill(3)
    _, line = flight.wait_for("is lost")
    assert "vehicle 3" in line
    flight.process.send_signal(signal.SIGINT)
    flight.end()
    assert flight.status == 1 and flight.summary["interrupted"] and not flight.summary["success"]
    for judge in (narrow, piloted, well):
        judge.wait_for(LOITER)
    assert [vehicle["mode"] for vehicle in flight.summary["station"]["vehicles"]] == [LOITER, LOITER, GUIDED, LOITER]


def test_one_that_stays_on_the_ground(start_flight, flock):
    port = free_port()
    flock.add_ardupilot("plane", 2, 60.0, port)
    flock.add_ardupilot(
        "plane", 1, 60.0, port, north_m=-60.0, first_system=3, parameters=[("TKOFF_THR_MAX", 1), ("THR_MAX", 1)]
    )
    text, _ = field(3, 1, **PLANES)
    flight = start_flight(text, flock.links, "--patience", "60")
    flight.wait_for("did not leave the ground")
    flight.end()
    assert flight.status == 1 and "vehicle 3" in flight.summary["failure"]
    assert "the flock flies" not in flight.said()
    for judge in flock.judges[:2]:
        judge.wait_for(LOITER)
    assert not flock.judges[2].armed


def test_a_speed_outside_the_limits(start_flight, flock):
    flock.add_ardupilot("plane", 1, 60.0, free_port())
    text, _ = field(1, 1, **PLANES | dict(speed_mps=9.0, speeds=(8.0, 12.0)))
    flight = start_flight(text, flock.links).end()
    assert flight.status == 1 and "its least is 10 m/s" in flight.said()
    assert not flock.judges[0].armed


def test_two_places(start_flight, flock):
    port = free_port()
    flock.add_ardupilot("plane", 1, 60.0, port)
    flock.add_ardupilot("plane", 1, 60.0, port, north_m=60_000.0, first_system=2)
    text, _ = field(2, 1, **PLANES)
    flight = start_flight(text, flock.links).end()
    assert flight.status == 1 and "vehicle 2 is 60 km from the origin" in flight.said()
    assert not any(judge.armed for judge in flock.judges)
