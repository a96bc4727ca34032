"""Noise at every port: it is counted, and changes no flight."""

import random
import socket
import struct
import threading

import pytest
from conftest import free_port
from pymavlink.dialects.v20 import ardupilotmega as mavlink

FRAMES_PER_KIND = 40


def frame(message):
    """A good frame from a system that is none of ours."""
    return message.pack(mavlink.MAVLink(None, srcSystem=77, srcComponent=1))


def checksum(header_and_payload, extra):
    crc = mavlink.x25crc(header_and_payload)
    crc.accumulate(bytes([extra]))
    return struct.pack("<H", crc.crc)


def unknown_id(rng):
    """A frame with a message id that no dialect has: whether its checksum is right nobody can tell."""
    payload = rng.randbytes(rng.randrange(1, 256))
    inside = (
        struct.pack("<BBBBBB", len(payload), 0, 0, rng.randrange(256), 77, 1)
        + (0xABCDEF).to_bytes(3, "little")
        + payload
    )
    return b"\xfd" + inside + checksum(inside, rng.randrange(256))


def noise(rng):
    """Datagrams of every kind that a port may meet."""
    good = frame(mavlink.MAVLink_attitude_message(1, 0, 0, 0, 0, 0, 0))
    for _ in range(FRAMES_PER_KIND):
        yield rng.randbytes(rng.randrange(0, 1500))
        yield b"\xfd" + rng.randbytes(rng.randrange(0, 280))
        yield good[: rng.randrange(1, len(good))]
        yield good[:-2] + rng.randbytes(2)
        yield good + good[:7] + b"\xfe\xfd" + good
        yield unknown_id(rng)
        # Enum values that no dialect has, in frames that are right otherwise.
        yield frame(mavlink.MAVLink_heartbeat_message(250, 251, 255, rng.randrange(1 << 32), 252, 3))
        yield frame(mavlink.MAVLink_command_long_message(1, 1, 65_535, 0, 0, 0, 0, 0, 0, 0, 0))
        yield frame(mavlink.MAVLink_command_int_message(1, 1, 200, 43_001, 0, 0, 0, 0, 0, 0, 0, 0, 60.0))
        yield frame(mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, 99, 0xFFFF, *[float("nan")] * 11))


class Noise:
    """Sends noise to ports, over and over, until it is told to stop."""

    def __init__(self, *ports):
        self.ports, self.sent = ports, 0
        self.stopping = threading.Event()
        self.thread = threading.Thread(target=self.run, daemon=True)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.stopping.set()
        self.thread.join()

    def run(self):
        rng = random.Random(1)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as link:
            while not self.stopping.is_set():
                for datagram in noise(rng):
                    for port in self.ports:
                        try:
                            link.sendto(datagram, ("127.0.0.1", port))
                            self.sent += 1
                        except OSError:  # nobody listens there yet, or any more
                            pass
                    if self.stopping.wait(0.0005):
                        break


def test_a_run_in_noise_is_the_same_flight(fly, flown, start_vehicles):
    ground_port = free_port()
    vehicles = start_vehicles("--lockstep", ground_port=ground_port)
    with Noise(ground_port, *(row["port"] for row in vehicles.rows)) as sender:
        run = fly("fly", "--lockstep", "--seed", 7, "--ground-port", ground_port)
    assert run.status == 0, run.errors
    assert run.trajectory_bytes == flown.trajectory_bytes
    assert sender.sent > 100
    link = run.summary["link"]
    for counter in ("malformed_bytes", "bad_checksum", "unknown_message", "invalid_value"):
        assert link[counter] > 0, f"{counter} in {link}"


def test_a_vehicle_flies_on_in_noise(craft):
    with Noise(craft.port):
        first, *_, last = craft.samples(5)
    assert last.x_m - first.x_m == pytest.approx(10 * (last.t_s - first.t_s), abs=1e-2)
    assert (last.y_m, last.altitude_m, last.speed_mps) == pytest.approx((0, 50, 10), abs=1e-3)
