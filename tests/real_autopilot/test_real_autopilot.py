"""Flies the user's own builds of real autopilots in software, from the ground to the ground; a second link judges.

builds.py names the variables; without a build its tests are skipped, and say so. REAL_SEEDS=1..10 flies each field
with these seeds (0 is the paper's own), REAL_SPEEDUP=4 at four times the clock.
"""

import os

import pytest
from builds import LATITUDE_DEG, LONGITUDE_DEG, free_port, speedup
from fields import COPTERS, PLANES, PX4_PLANES, PX4_QUADS, field
from flight import flock, start_flight  # noqa: F401
from second_link import least_distances

RATE_HZ = 9.5
TOLD_WITHIN_M = 0.3


def seeds():
    first, _, last = os.environ.get("REAL_SEEDS", "1").partition("..")
    return range(int(first), int(last or first) + 1)


def judged(flight, flock, circles):
    """What the second link saw between the first and the last tick."""
    began, _ = flight.wait_for("the flock flies")
    ended = began + flight.summary["duration_s"] / speedup()
    origin = (LATITUDE_DEG, LONGITUDE_DEG)
    return least_distances(flock.judges, circles, origin, began, ended, 0.02 / speedup())


def check(flight, flock, circles, safe_distance_m, mode, is_lossy=False):
    """All that a clean flight must be; over a lossy link frames are lost, and fewer positions come."""
    flight.wait_for("the flock flies")
    flight.end()
    summary = flight.summary
    separation, clearance, seen = judged(flight, flock, circles)
    rates = flight.position_rates_hz()
    told = {name: summary[f"min_{name}_m"] for name in ("separation", "clearance")}
    print(
        f"FIGURES status {flight.status} separation {told['separation']:.2f} told {separation:.2f} judged, clearance "
        f"{told['clearance']:.2f} told {clearance:.2f} judged, seen {seen:.3f}, lost {summary['link']['lost']}, "
        f"rates {' '.join(f'{rate:.2f}' for _, rate in sorted(rates.items()))}, "
        f"modes {[judge.mode for judge in flock.judges]}"
    )
    assert flight.status == 0, flight.said()
    assert summary["success"] and (is_lossy or summary["link"]["lost"] == 0)
    assert clearance > 0 and separation >= safe_distance_m and seen > 0.98
    assert abs(separation - told["separation"]) <= TOLD_WITHIN_M
    assert abs(clearance - told["clearance"]) <= TOLD_WITHIN_M
    assert len(rates) >= len(flock.judges) and min(rates.values()) >= RATE_HZ * (0.8 if is_lossy else 1.0)
    for judge in flock.judges:
        judge.wait_for(mode if isinstance(mode, str) else mode[judge.system])
        assert judge.armed


@pytest.mark.parametrize("seed", seeds())
def test_five_arduplanes(start_flight, flock, seed):
    flock.add_ardupilot("plane", 5, 60.0, free_port())
    text, circles = field(5, seed, **PLANES)
    check(start_flight(text, flock.links), flock, circles, 8.0, "LOITER")


@pytest.mark.parametrize("bank_deg", [65, 35])
@pytest.mark.parametrize("seed", seeds())
def test_planes_that_decide_twice_a_second(start_flight, flock, seed, bank_deg):
    """With their own limit of bank and with a narrow one: the station takes it from the vehicles."""
    flock.add_ardupilot("plane", 5, 60.0, free_port(), parameters=[("ROLL_LIMIT_DEG", bank_deg)])
    text, circles = field(5, seed, **PLANES | dict(period_s=0.5))
    check(start_flight(text, flock.links), flock, circles, 8.0, "LOITER")


@pytest.mark.parametrize("seed", seeds())
def test_planes_over_a_bad_link(start_flight, flock, seed):
    """A tenth is lost and all else comes 150 to 250 ms late, both ways."""
    flock.add_ardupilot("plane", 5, 60.0, free_port())
    link = dict(loss=0.1, delay_ms=150 / speedup(), jitter_ms=100 / speedup())
    text, circles = field(5, seed, **PLANES | dict(period_s=0.5, link=link))
    check(start_flight(text, flock.links), flock, circles, 8.0, "LOITER", is_lossy=True)


@pytest.mark.parametrize("seed", seeds())
def test_three_arducopters(start_flight, flock, seed):
    flock.add_ardupilot("copter", 3, 20.0, free_port())
    text, circles = field(3, seed, **COPTERS)
    check(start_flight(text, flock.links), flock, circles, 2.0, "BRAKE")


@pytest.mark.parametrize("seed", seeds())
def test_five_px4_quads(start_flight, flock, seed):
    flock.add_px4("quad", 5, 20.0)
    text, circles = field(5, seed, **PX4_QUADS)
    check(start_flight(text, flock.links), flock, circles, 2.0, "LOITER")


@pytest.mark.parametrize("seed", seeds())
def test_three_px4_planes(start_flight, flock, seed):
    flock.add_px4("plane", 3, 60.0)
    text, circles = field(3, seed, **PX4_PLANES)
    check(start_flight(text, flock.links), flock, circles, 5.0, "LOITER")


def test_homes_300_m_apart_are_told_so(start_flight, flock):
    flock.add_ardupilot("plane", 2, 300.0, free_port())
    text, _ = field(2, 1, **PLANES)
    flight = start_flight(text, flock.links, "--dry-run").end()
    assert flight.status == 0, flight.said()
    _, line = flight.wait_for("the nearest two are")
    assert abs(float(line.split("the nearest two are")[1].split()[0]) - 300.0) < 2.0, line
