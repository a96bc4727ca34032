"""What a vehicle says of itself, and how often."""

import math

import pytest
from ground import ACCEPTED, DENIED, FAILED
from pymavlink.dialects.v20 import ardupilotmega as mavlink

EARTH_RADIUS_M = 6_378_137.0
EARTH_ECCENTRICITY_SQUARED = 6.69437999014e-3


def test_heartbeat_is_that_of_an_armed_arduplane_in_guided(craft):
    heartbeat = craft.wait(["HEARTBEAT"])
    assert heartbeat.type == mavlink.MAV_TYPE_FIXED_WING
    assert heartbeat.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    assert heartbeat.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
    assert heartbeat.system_status == mavlink.MAV_STATE_ACTIVE
    assert craft.link.flightmode == "GUIDED"


@pytest.mark.parametrize(
    ("kind", "interval_ms"),
    [("LOCAL_POSITION_NED", 100), ("ATTITUDE", 100), ("GLOBAL_POSITION_INT", 200), ("SYSTEM_TIME", 1000)],
)
def test_stamped_messages_come_at_their_rates_without_drift(craft, kind, interval_ms):
    stamps = [message.time_boot_ms for message in craft.collect([kind], 4)]
    assert len(stamps) >= 4
    assert stamps == [stamps[0] + interval_ms * index for index in range(len(stamps))]
    assert stamps[0] % interval_ms == 0


def test_messages_without_a_stamp_come_at_their_rates(craft):
    kinds = ["HEARTBEAT", "SYS_STATUS", "SYSTEM_TIME", "VFR_HUD"]
    craft.wait(["SYSTEM_TIME"])
    heard = [message.get_type() for message in craft.collect(kinds, 5)]
    seconds = heard.count("SYSTEM_TIME")
    last = len(heard) - 1 - heard[::-1].index("SYSTEM_TIME")
    heard = heard[: last + 1]
    assert seconds == 5
    assert [heard.count(kind) for kind in ("HEARTBEAT", "SYS_STATUS", "VFR_HUD")] == [5, 5, 4 * 5]


def test_home_and_the_landed_state_come_unasked(craft):
    craft.wait(["HOME_POSITION"])
    heard = [message.get_type() for message in craft.collect(["HOME_POSITION", "EXTENDED_SYS_STATE"], 8)]
    assert heard.count("HOME_POSITION") == pytest.approx(4, abs=1)
    assert heard.count("EXTENDED_SYS_STATE") == pytest.approx(16, abs=1)


def test_a_rate_can_be_asked_for(craft):
    assert craft.set_rate(mavlink.MAVLINK_MSG_ID_VFR_HUD, 20) == ACCEPTED
    assert craft.set_rate(mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED, 50) == ACCEPTED
    craft.sample()
    stamps = [message.time_boot_ms for message in craft.collect(["LOCAL_POSITION_NED"], 2)]
    assert {after - before for before, after in zip(stamps, stamps[1:])} == {20}
    assert 38 <= len(craft.collect(["VFR_HUD"], 2)) <= 42


@pytest.mark.parametrize(
    ("message_id", "interval_us", "result"),
    [
        (mavlink.MAVLINK_MSG_ID_VFR_HUD, 50_000, ACCEPTED),
        (mavlink.MAVLINK_MSG_ID_SCALED_IMU, -1, ACCEPTED),
        (12_999, 0, FAILED),
    ],
    ids=["one that comes", "one that does not", "one that nobody knows"],
)
def test_an_interval_is_told(craft, message_id, interval_us, result):
    assert craft.set_rate(mavlink.MAVLINK_MSG_ID_VFR_HUD, 20) == ACCEPTED
    for command, params in {
        mavlink.MAV_CMD_GET_MESSAGE_INTERVAL: (message_id,),
        mavlink.MAV_CMD_REQUEST_MESSAGE: (mavlink.MAVLINK_MSG_ID_MESSAGE_INTERVAL, message_id),
    }.items():
        craft.link.mav.command_long_send(craft.system, 1, command, 0, *params, *[0] * (7 - len(params)))
        told = craft.wait(["MESSAGE_INTERVAL"])
        assert (told.message_id, told.interval_us) == (message_id, interval_us)
        assert craft.acknowledged(command) == result


def test_the_interval_of_an_unknown_message_is_not_set(craft):
    assert craft.set_rate(12_999, 1) == DENIED
    assert craft.text().text == "Message 12999 is not available"


def test_system_time_runs_with_the_time_since_boot(craft):
    first, *_, last = craft.collect(["SYSTEM_TIME"], 3)
    assert last.time_unix_usec - first.time_unix_usec == 1000 * (last.time_boot_ms - first.time_boot_ms)
    assert first.time_unix_usec > 1.7e15


def test_local_and_global_positions_agree(craft):
    craft.setpoint(14.0, math.radians(40), 65.0)
    origin = craft.request(mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN, "GPS_GLOBAL_ORIGIN")
    messages = craft.collect(["LOCAL_POSITION_NED", "GLOBAL_POSITION_INT"], 12)
    local = {m.time_boot_ms: m for m in messages if m.get_type() == "LOCAL_POSITION_NED"}
    pairs = [
        (local[m.time_boot_ms], m)
        for m in messages
        if m.get_type() == "GLOBAL_POSITION_INT" and m.time_boot_ms in local
    ]
    assert len(pairs) >= 40
    for near, far in pairs:
        north_m, east_m = metres(origin, far)
        # A unit of GLOBAL_POSITION_INT is 1.1 cm; the plane tangent at the origin is good for the rest at 200 m.
        assert math.dist((near.x, near.y), (north_m, east_m)) < 0.03
        assert far.alt / 1e3 - origin.altitude / 1e3 == pytest.approx(-near.z, abs=0.005)
        assert far.relative_alt / 1e3 == pytest.approx(-near.z, abs=0.002)
        assert (far.vx / 1e2, far.vy / 1e2, far.vz / 1e2) == pytest.approx((near.vx, near.vy, near.vz), abs=0.006)
    assert max(math.hypot(near.x, near.y) for near, _ in pairs) > 100


def metres(origin, place):
    """North and east of the origin, by the radii of curvature of WGS-84 there."""
    sine = math.sin(math.radians(origin.latitude / 1e7))
    squash = 1 - EARTH_ECCENTRICITY_SQUARED * sine**2
    meridian_m = EARTH_RADIUS_M * (1 - EARTH_ECCENTRICITY_SQUARED) / squash**1.5
    parallel_m = EARTH_RADIUS_M / math.sqrt(squash) * math.sqrt(1 - sine**2)
    return (
        meridian_m * math.radians((place.lat - origin.latitude) / 1e7),
        parallel_m * math.radians((place.lon - origin.longitude) / 1e7),
    )


def test_attitude_and_hud_tell_of_the_same_flight(craft):
    craft.setpoint(12.0, math.radians(25), 50.0)
    settled = craft.samples(15)[-1]
    attitude, hud = craft.wait(["ATTITUDE"]), craft.wait(["VFR_HUD"])
    assert attitude.yaw == pytest.approx(settled.course_rad, abs=1e-3)
    assert (attitude.roll, attitude.pitch) == pytest.approx((0, 0), abs=1e-3)
    assert hud.heading == 25
    assert (hud.groundspeed, hud.airspeed) == pytest.approx((12, 12), abs=1e-3)
    assert hud.alt == pytest.approx(50 + 50, abs=0.01)
    assert hud.climb == pytest.approx(0, abs=1e-3)


def test_it_banks_into_a_turn(craft):
    assert craft.change_heading(90) == ACCEPTED
    turning = craft.wait(["ATTITUDE"], lambda attitude: attitude.yawspeed > 0.2)
    # A coordinated turn: tan(roll) = V * yaw rate / g, with the paper's g of 10 m/s2.
    assert math.tan(turning.roll) == pytest.approx(10 * turning.yawspeed / 10, rel=0.02)
