"""Telemetry logs of other makes, written as strangers write them: each is a list of records, a time and a frame.

What was found in logs that others published is here too, made anew: a fix that never came, a companion computer and a
camera under the vehicle's own system id, MAVLink 1, a link's number in the lowest bits of the time.
"""

import math
import random
import struct
import subprocess

import pytest
from chromium import address_in, browser, open_page, until  # noqa: F401 (fixtures)
from pymavlink.dialects.v10 import ardupilotmega as mavlink1
from pymavlink.dialects.v20 import ardupilotmega as mavlink2

BEGAN_US = 1_600_000_000_000_000
SECONDS = 30
HOME = 473_000_000, 85_000_000


class Writer:
    """Writes records with the dialects of pymavlink, MAVLink 1 or 2."""

    def __init__(self, path):
        self.path, self.records, self.senders = path, [], {}

    def put(self, at_s, system, message, component=1, version=2, low_bits=0):
        module = {1: mavlink1, 2: mavlink2}[version]
        key = system, component, version
        sender = self.senders.setdefault(key, module.MAVLink(None, srcSystem=system, srcComponent=component))
        frame = message(module).pack(sender)
        sender.seq = (sender.seq + 1) % 256
        self.raw(at_s, bytes(frame), low_bits)

    def raw(self, at_s, frame, low_bits=0):
        time_us = BEGAN_US + round(at_s * 1e6)
        self.records.append((time_us & ~3 | low_bits, frame))

    def done(self, join=lambda records: b"".join(struct.pack(">Q", at) + frame for at, frame in records)):
        self.path.write_bytes(join(self.records))
        return self.path


def heartbeat(kind=1, autopilot=3, base_mode=217, mode=15):
    return lambda module: module.MAVLink_heartbeat_message(kind, autopilot, base_mode, mode, 4, 3)


def position(at_s, north_m=0.0, lat_lon=HOME):
    lat = lat_lon[0] + round((north_m + 10 * at_s) / 111_319.5 * 1e7) if lat_lon[0] else 0
    return lambda module: module.MAVLink_global_position_int_message(
        round(1000 * at_s), lat, lat_lon[1], 550_000, 50_000, 1000, 0, 0, 0
    )


def local(at_s, north_m=0.0):
    north_m += 10 * at_s
    return lambda module: module.MAVLink_local_position_ned_message(round(1000 * at_s), north_m, 5, -40, 10, 0, 0)


def attitude(at_s):
    return lambda module: module.MAVLink_attitude_message(round(1000 * at_s), 0.1, 0, math.sin(at_s), 0, 0, 0)


def fly(log, system=1, version=2, tell=position, end_s=SECONDS, **options):
    """A vehicle that flies north at 10 m/s, as its ground station writes it: 5 positions a second."""
    for tenth in range(0, 10 * end_s, 2):
        at_s = tenth / 10
        if tenth % 10 == 0:
            log.put(at_s, system, heartbeat(), version=version, **options)
        log.put(at_s, system, tell(at_s, 20.0 * system), version=version, **options)
        log.put(at_s, system, attitude(at_s), version=version, **options)


def sorted_by_time(log):
    log.records.sort(key=lambda record: record[0])
    return log


def qgroundcontrol(log):
    """A PX4, QGroundControl's own heartbeats between, and messages of a dialect that nobody here knows."""
    known = random.Random(1)
    for tenth in range(0, 10 * SECONDS, 2):
        at_s = tenth / 10
        if tenth % 10 == 0:
            log.put(at_s, 255, heartbeat(kind=6, autopilot=8, base_mode=192, mode=0), component=190)
            log.put(at_s, 1, heartbeat(kind=2, autopilot=12, base_mode=157, mode=4 << 16 | 3 << 24))
        payload = bytes(known.randrange(256) for _ in range(20))
        unknown = (50_123).to_bytes(3, "little")
        head = struct.pack("<BBBBBBB3s", 0xFD, len(payload), 0, 0, tenth % 256, 1, 1, unknown)
        log.raw(at_s, head + payload + b"\x12\x34")
        log.put(at_s, 1, position(at_s))


def companions(log):
    """A companion computer, a camera and a gimbal under the vehicle's own system id, an ADS-B receiver beside."""
    fly(log)
    for second in range(SECONDS):
        for component, kind, autopilot in ((191, 18, 8), (100, 30, 8), (154, 26, 8), (156, 27, 8), (194, 18, 0)):
            log.put(second + 0.01, 1, heartbeat(kind=kind, autopilot=autopilot, mode=0), component=component)
        log.put(second + 0.02, 255, heartbeat(kind=6, autopilot=8, mode=0), component=190)
    sorted_by_time(log)


def mixed(log):
    """A vehicle that begins with MAVLink 1 and goes over to 2, as ArduPilot does when it hears that; another stays."""
    fly(log, system=1, version=1, end_s=10)
    for tenth in range(100, 10 * SECONDS, 2):
        if tenth % 10 == 0:
            log.put(tenth / 10, 1, heartbeat())
        log.put(tenth / 10, 1, position(tenth / 10, 20.0))
    fly(log, system=7, version=1)
    sorted_by_time(log)


def least(log):
    """Nothing but heartbeats and positions, once a second."""
    for second in range(SECONDS):
        log.put(second, 1, heartbeat())
        log.put(second, 1, position(second))


def jumps(log):
    """The clock is set on by a year after ten seconds, and back by an hour after twenty."""
    fly(log)
    year_us, hour_us = 365 * 24 * 3600 * 10**6, 3600 * 10**6
    for index, (time_us, frame) in enumerate(log.records):
        at_s = (time_us - BEGAN_US) / 1e6
        log.records[index] = time_us + (year_us if at_s >= 10 else 0) - (hour_us if at_s >= 20 else 0), frame


LOGS = {
    "MAVLink 1": lambda log: fly(log, version=1),
    "MAVLink 1 and 2": mixed,
    "MAVProxy": lambda log: fly(log, low_bits=2),
    "QGroundControl": qgroundcontrol,
    "companions": companions,
    "heartbeats and positions": least,
    "local positions": lambda log: fly(log, tell=local),
    "system 250": lambda log: fly(log, system=250),
    "a clock that is set": jumps,
}


@pytest.fixture
def play(program, open_page):
    viewers = []

    def play(path):
        viewers.append(subprocess.Popen([program, "view", path], stderr=subprocess.PIPE, text=True))
        line = viewers[-1].stderr.readline()
        assert "live view: " in line, line
        page = open_page(address_in(line), width=800, height=600)
        until(page, "document.getElementById('connection').textContent === 'recording'")
        return page

    yield play
    for viewer in viewers:
        viewer.kill()
        viewer.communicate()


def flown_m(page, vehicle=0):
    """How far north a vehicle is at the end of what was played, from where it was first."""
    placed = f"columba.player.moments.filter((m) => {vehicle} < m.n && m.isPlaced({vehicle}))"
    return page.evaluate(f"{placed}.at(-1).x({vehicle}) - {placed}[0].x({vehicle})")


@pytest.mark.parametrize("name", LOGS)
def test_logs_of_other_makes_are_played(play, tmp_path, name):
    log = Writer(tmp_path / "their.tlog")
    LOGS[name](log)
    page = play(log.done())
    assert page.evaluate("columba.roster.systems.length") == (2 if name == "MAVLink 1 and 2" else 1)
    assert page.evaluate("columba.player.end") == pytest.approx(SECONDS, abs=1.3)
    # To the last position, which is up to a second before the end.
    assert flown_m(page) == pytest.approx(10 * SECONDS, abs=13)
    assert page.evaluate("columba.roster.modes").count("Loiter" if name == "QGroundControl" else "GUIDED") <= 1
    told = page.evaluate("columba.events.filter(({text}) => text.includes('the clock of the log jumps')).length")
    assert told == (2 if name == "a clock that is set" else 0)
    # It is played from its beginning, and can be scrubbed.
    page.evaluate("columba.player.toggle(); columba.player.seek(15)")
    until(page, "columba.player.now === 15 && Number.isFinite(columba.stage.flock.x[0])")


def test_what_lies_between_records_and_a_torn_end_cost_nothing_else(play, tmp_path):
    log, noise = Writer(tmp_path / "torn.tlog"), random.Random(7)
    fly(log)

    def torn(records):
        out = b""
        for index, (at, frame) in enumerate(records):
            if index % 10 == 5:
                out += bytes(noise.randrange(256) for _ in range(noise.randrange(60)))
            out += struct.pack(">Q", at) + (frame[:-4] if index % 50 == 25 else frame)
        return out[:-7]

    page = play(log.done(torn))
    assert flown_m(page) == pytest.approx(10 * SECONDS, abs=15)
    assert page.evaluate("columba.events.some(({text}) => /bytes are no MAVLink and were skipped/.test(text))")


def test_a_file_that_cannot_be_played_is_told_what_it_is(program, tmp_path):
    empty, text, raw, ulog = (tmp_path / name for name in ("empty.tlog", "text.tlog", "raw.tlog", "log.ulg"))
    empty.write_bytes(b"")
    text.write_text("this is a text\n" * 100)
    flight = Writer(tmp_path / "any")
    fly(flight)
    raw.write_bytes(b"".join(frame for _, frame in flight.records))
    ulog.write_bytes(b"ULog\x01\x12\x35\x01" + bytes(1000))
    without_fix, ground = Writer(tmp_path / "fix.tlog"), Writer(tmp_path / "ground.tlog")
    fly(without_fix, tell=lambda at_s, _: position(at_s, lat_lon=(0, 0)))
    for second in range(SECONDS):
        ground.put(second, 255, heartbeat(kind=6, autopilot=8), component=190)
    for path, words in {
        empty: "it has no records of MAVLink",
        text: "it has no records of MAVLink",
        raw: "MAVLink without times",
        ulog: "is a ULog",
        without_fix.done(): "GLOBAL_POSITION_INT with a fix",
        ground.done(): "no heartbeat of one is in its 30 records",
    }.items():
        done = subprocess.run([program, "view", path], capture_output=True, text=True, timeout=30)
        assert done.returncode != 0 and words in done.stderr and str(path) in done.stderr, done.stderr
