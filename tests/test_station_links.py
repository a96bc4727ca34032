"""Serial lines, TCP and signed links of the ground station, with vehicles of ours behind them."""

import os
import pty
import select
import socket
import threading
import time
import tty

import pytest
from conftest import bind, free_port
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from test_station import field, start_fly, told  # noqa: F401

KEY = bytes(range(32))
BYTES_PER_S = 5760  # 57,600 baud


class Line:
    """A serial line as a pseudo-terminal, with vehicles behind it, as slow as a radio of 57,600 baud."""

    def __init__(self, vehicle_port):
        self.master, self.slave = pty.openpty()
        tty.setraw(self.master), tty.setraw(self.slave)
        self.name = os.ttyname(self.slave)
        self.udp = bind()
        self.vehicles = ("127.0.0.1", vehicle_port)
        self.dropped = self.carried = 0
        self.running = True
        self.threads = [threading.Thread(target=self.up, daemon=True), threading.Thread(target=self.down, daemon=True)]
        [thread.start() for thread in self.threads]

    def up(self):
        while self.running:
            if select.select([self.master], [], [], 0.2)[0]:
                try:
                    self.udp.sendto(os.read(self.master, 1024), self.vehicles)
                except OSError:
                    time.sleep(0.05)

    def down(self):
        """A radio holds a little back, and drops what it cannot hold."""
        budget, last = 0.0, time.monotonic()
        while self.running:
            if not select.select([self.udp], [], [], 0.2)[0]:
                continue
            data = self.udp.recv(4096)
            now = time.monotonic()
            budget = min(budget + (now - last) * BYTES_PER_S, 2048.0)
            last = now
            if budget < len(data):
                self.dropped += len(data)
                continue
            budget -= len(data)
            self.carried += len(data)
            os.write(self.master, data)

    def close(self):
        self.running = False
        [thread.join() for thread in self.threads]


def test_two_vehicles_on_a_serial_line(start_fly, start_vehicles, field):
    scenario = field(duration_s=12)
    vehicles = start_vehicles(scenario, "--per-port", 2, ground_port=None)
    line = Line(vehicles.rows[0]["port"])
    try:
        controller = start_fly(scenario, "--link", f"{line.name},57600")
        controller.wait_for("the flock flies")
        dropped, carried = line.dropped, line.carried
        controller.wait_for("is left in LOITER")
        dropped, carried = line.dropped - dropped, line.carried - carried
        run = controller.end()
    finally:
        line.close()
    assert run.status == 0, run.errors
    link = run.summary["link"]["links"][0]
    assert link["link"] == f"serial:{line.name}:57600"
    assert link["overflows"] == 0
    # The vehicles' own streams before they were silenced may have been too much; the flight was not.
    assert run.summary["min_separation_m"] > 2
    # Rates are lowered on purpose: in flight the line drops nothing, and is far from full.
    assert dropped == 0, f"{dropped} bytes that the line could not carry"
    assert carried < 0.8 * BYTES_PER_S * run.summary["duration_s"]
    assert told(run, "streams that are not needed are silenced")
    assert run.summary["station"]["separation_rests_on"]["sample_gap_s"] < 0.5


class Tcp:
    """What stands before vehicles as a TCP port, as SITL has one; it can drop its client."""

    def __init__(self, vehicle_port):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.port = self.listener.getsockname()[1]
        self.vehicles = ("127.0.0.1", vehicle_port)
        self.client, self.connections, self.running = None, 0, True
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        udp = bind()
        while self.running:
            try:
                self.client, _ = self.listener.accept()
            except OSError:
                return
            self.connections += 1
            client = self.client
            while self.running:
                try:
                    for ready in select.select([client, udp], [], [], 0.2)[0]:
                        if ready is udp:
                            client.sendall(udp.recv(4096))
                        elif data := client.recv(4096):
                            udp.sendto(data, self.vehicles)
                        else:
                            raise OSError("closed")
                except (OSError, ValueError):
                    break

    def drop(self):
        self.client.shutdown(socket.SHUT_RDWR)

    def close(self):
        self.running = False
        self.listener.close()


def test_a_tcp_link_that_breaks_in_flight_is_made_again(start_fly, start_vehicles, field):
    scenario = field(duration_s=15)
    vehicles = start_vehicles(scenario, "--per-port", 2)
    before = Tcp(vehicles.rows[0]["port"])
    try:
        controller = start_fly(scenario, "--link", f"tcp://127.0.0.1:{before.port}")
        controller.wait_for("the flock flies")
        before.drop()
        controller.wait_for("is down")
        run = controller.end()
    finally:
        before.close()
    assert before.connections >= 2
    assert run.status == 0, run.errors
    assert run.summary["completed"]


class Signer:
    """Stands between the station and vehicles that know no signatures: signs what they say, and passes on what is
    signed."""

    def __init__(self, station_port, vehicle_port):
        self.up = bind()
        self.down = bind()
        self.station = ("127.0.0.1", station_port)
        self.vehicles = ("127.0.0.1", vehicle_port)
        self.key, self.running = KEY, True
        self.unsigned_from_station = self.signed_from_station = 0
        self.last = None
        self.stamp = int((time.time() - 1420070400) * 1e5)
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def serve(self):
        reader = mavlink.MAVLink(None)
        reader.robust_parsing = True
        while self.running:
            for ready in select.select([self.up, self.down], [], [], 0.2)[0]:
                data = ready.recv(4096)
                if ready is self.up:
                    self.pass_on(data)
                    continue
                for message in reader.parse_buffer(data) or []:
                    if message.get_type() != "BAD_DATA":
                        self.last = self.signed(message, self.key)
                        self.up.sendto(self.last, self.station)

    def pass_on(self, data):
        while len(data) >= 12 and data[0] == 0xFD:
            length = data[1] + 12 + (13 if data[2] & 1 else 0)
            frame, data = data[:length], data[length:]
            if frame[2] & 1:
                self.signed_from_station += 1
            else:
                self.unsigned_from_station += 1
            self.down.sendto(frame, self.vehicles)

    def signed(self, message, key):
        sender = mavlink.MAVLink(None, srcSystem=message.get_srcSystem(), srcComponent=message.get_srcComponent())
        sender.seq = message.get_seq()
        sender.signing.secret_key, sender.signing.link_id = key, message.get_srcSystem()
        self.stamp = max(self.stamp + 1, int((time.time() - 1420070400) * 1e5))
        sender.signing.timestamp, sender.signing.sign_outgoing = self.stamp, True
        return message.pack(sender)

    def close(self):
        self.running = False
        self.thread.join()


@pytest.fixture
def key_file(tmp_path):
    path = tmp_path / "key"
    path.write_text(KEY.hex() + "\n")
    path.chmod(0o600)
    return path


def test_signed_links_take_nothing_that_is_unsigned_forged_or_replayed(start_fly, start_vehicles, field, key_file):
    scenario, port, other_port = field(count=1, duration_s=10), free_port(), free_port()
    vehicles = start_vehicles(scenario)
    signer = Signer(port, vehicles.rows[0]["port"])
    try:
        links = [word for number in (port, other_port) for word in ("--link", f"udpin:127.0.0.1:{number}")]
        controller = start_fly(scenario, *links, "--signing-key", key_file)
        # The station speaks to who has spoken: a first word, signed.
        for _ in range(10):
            beat = mavlink.MAVLink_heartbeat_message(1, 3, 89, 15, 4, 3)
            beat._header = mavlink.MAVLink_header(0, srcSystem=1, srcComponent=1)
            signer.up.sendto(signer.signed(beat, KEY), signer.station)
            time.sleep(0.2)
        controller.wait_for("the flock flies")
        # A stranger says that the vehicle is in MANUAL: without a signature, with another key, and as it was once said.
        lie = mavlink.MAVLink_heartbeat_message(1, 3, 81, 0, 4, 3)
        lie._header = mavlink.MAVLink_header(0, srcSystem=1, srcComponent=1)
        stranger = bind()
        # Nor does an operator's word count that is not signed: abort.
        abort = mavlink.MAVLink_command_long_message(255, 190, 31010, 0, 1, 0, 0, 0, 0, 0, 0)
        for _ in range(5):
            stranger.sendto(abort.pack(mavlink.MAVLink(None, srcSystem=252)), signer.station)
            # What one link has heard is a replay on every other.
            stranger.sendto(signer.last, ("127.0.0.1", other_port))
            plain = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
            stranger.sendto(lie.pack(plain), signer.station)
            stranger.sendto(signer.signed(lie, bytes(32)), signer.station)
            stranger.sendto(signer.last, signer.station)
        run = controller.end()
    finally:
        signer.close()
    assert run.status == 0, run.errors
    rejected = run.summary["link"]["rejected"]
    assert rejected["unsigned"] >= 10 and rejected["forged"] >= 5 and rejected["replayed"] >= 6
    assert run.summary["link"]["links"][1]["rejected"] == {"unsigned": 0, "forged": 0, "replayed": 5}
    assert signer.signed_from_station > 10 and signer.unsigned_from_station == 0


def test_a_key_that_others_may_read_is_refused(start_fly, field, key_file):
    key_file.chmod(0o644)
    run = start_fly(field(), "--signing-key", key_file).end()
    assert run.status == 2 and "chmod 600" in run.errors and KEY.hex() not in run.errors


def test_commands_that_go_unsigned_beyond_loopback_are_warned_of(start_fly, field):
    controller = start_fly(field(), "--link", f"udpin:0.0.0.0:{free_port()}")
    assert "--signing-key" in controller.wait_for("unsigned beyond this machine")
