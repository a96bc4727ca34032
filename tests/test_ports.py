"""Ports that other people's tools expect, and lines other than UDP: TCP clients, PX4's partners, multicast."""

import os
import socket
import subprocess
import time
from collections import Counter

import pytest
from ground import GUIDED, Craft
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from test_parameters import read, write

PATIENCE_S = 10
COMMAND = mavlink.MAV_CMD_REQUEST_MESSAGE


def address(row, protocol, index=0):
    """Where a vehicle listens."""
    return [link["address"] for link in row["links"] if link["protocol"] == protocol][index]


def connect(text):
    return mavutil.mavlink_connection(text, source_system=255)


def heard(link, kind="HEARTBEAT", patience_s=PATIENCE_S, system=1):
    deadline = time.monotonic() + patience_s
    while (left := deadline - time.monotonic()) > 0:
        message = link.recv_match(type=kind, blocking=True, timeout=left)
        if message is not None and message.get_srcSystem() == system:
            return message
    return None


def ask(link, message_id, system=1):
    link.mav.command_long_send(system, 1, COMMAND, 0, message_id, 0, 0, 0, 0, 0, 0)


@pytest.fixture
def ardupilot(start_vehicles):
    """Two vehicles with ArduPilot's ports, any that are free."""
    return start_vehicles("--count", 2, "--ports", "ardupilot", ground_port=0)


def free_instance(udp, tcp, stride):
    """An instance whose ports are free; another program may still take them."""
    for instance in range(100 + os.getpid() % 300, 900):
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as one, socket.socket() as other:
            try:
                one.bind(("127.0.0.1", udp + stride * instance))
                if tcp:
                    other.bind(("127.0.0.1", tcp + stride * instance))
                return instance
            except OSError:
                continue
    raise RuntimeError("no free ports")


def test_without_a_scenario_vehicles_are_where_the_autopilots_simulator_starts(start_vehicles):
    for ports, place in (("ardupilot", (-35.363262, 149.165237)), ("px4", (47.397742, 8.545594))):
        row = start_vehicles("--count", 1, "--ports", ports, "--personality", "arduplane", ground_port=0).rows[0]
        assert (row["latitude_deg"], row["longitude_deg"]) == pytest.approx(place, abs=1e-4)


def test_a_tcp_client_hears_it_at_once_and_is_obeyed(ardupilot):
    link = connect("tcp:" + address(ardupilot.rows[0], "tcp"))
    assert heard(link), "nobody has said anything"
    assert heard(link, "GLOBAL_POSITION_INT")
    link.mav.command_long_send(1, 1, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, GUIDED, 0, 0, 0, 0, 0)
    assert heard(link, "COMMAND_ACK").result == mavlink.MAV_RESULT_ACCEPTED
    link.close()


def test_each_vehicle_has_three_tcp_ports_and_each_of_them_several_clients(ardupilot):
    links = [connect("tcp:" + address(ardupilot.rows[1], "tcp", port)) for port in (0, 1, 2, 0)]
    assert all(heard(link, system=2) for link in links)
    ask(links[1], mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION, 2)
    assert heard(links[1], "AUTOPILOT_VERSION", system=2)
    assert not heard(links[3], "AUTOPILOT_VERSION", patience_s=0.3, system=2), "an answer is for who asks"
    for link in links:
        link.close()


def test_bytes_come_in_any_pieces(ardupilot):
    host, port = address(ardupilot.rows[0], "tcp").rsplit(":", 1)
    link = connect(f"tcp:{host}:{port}")
    assert heard(link)
    request = mavlink.MAVLink_command_long_message(
        1, 1, COMMAND, 0, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION, 0, 0, 0, 0, 0, 0
    )
    for byte in request.pack(link.mav):
        link.port.send(bytes([byte]))
    assert heard(link, "AUTOPILOT_VERSION")
    # Two and a half frames, and then the rest.
    frames = b"".join(request.pack(link.mav) for _ in range(3))
    link.port.send(frames[:-20])
    assert heard(link, "AUTOPILOT_VERSION") and heard(link, "AUTOPILOT_VERSION")
    link.port.send(frames[-20:])
    assert heard(link, "AUTOPILOT_VERSION")
    link.close()


def test_a_client_that_comes_back_is_heard_again(ardupilot):
    for _ in range(3):
        link = connect("tcp:" + address(ardupilot.rows[0], "tcp"))
        assert heard(link)
        link.close()


def test_a_client_that_stops_reading_stalls_nobody(start_vehicles):
    """A client with a small buffer asks for all it can get, and never reads; another is served all the while."""
    vehicles = start_vehicles("--count", 1, "--ports", "ardupilot", "--speed", 20, ground_port=0)
    host, port = address(vehicles.rows[0], "tcp").rsplit(":", 1)
    idle = socket.socket()
    idle.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    idle.connect((host, int(port)))
    encoder = mavlink.MAVLink(None, srcSystem=254)
    for message_id in (mavlink.MAVLINK_MSG_ID_ATTITUDE, mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT):
        request = mavlink.MAVLink_command_long_message(
            1, 1, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 0, message_id, 12_500, 0, 0, 0, 0, 0
        )
        idle.send(request.pack(encoder))
    link = connect("tcp:" + address(vehicles.rows[0], "tcp", 1))
    first = heard(link, "SYSTEM_TIME").time_boot_ms
    # 200 vehicle seconds of 160 messages a second are megabytes.
    while (now := heard(link, "SYSTEM_TIME").time_boot_ms) < first + 200_000:
        assert now >= first
    vehicles.stop()
    assert vehicles.errors == "", "it kept up with the clock"
    idle.close()
    link.close()


def test_ardupilots_own_ports_and_telemetry(run):
    instance = free_instance(14_550, 5_760, 10)
    link = connect(f"udpin:127.0.0.1:{14_550 + 10 * instance}")
    second = connect(f"udpin:127.0.0.1:{14_560 + 10 * instance}")
    options = ["--count", "2", "--ports", "ardupilot", "--instance", str(instance)]
    run(*options)
    assert heard(link) and heard(second, system=2)
    ask(link, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
    assert heard(link, "AUTOPILOT_VERSION"), "who listens for telemetry is answered"
    by_tcp = connect(f"tcp:127.0.0.1:{5_760 + 10 * (instance + 1)}")
    assert heard(by_tcp, system=2)
    for each in (by_tcp, link, second):
        each.close()


@pytest.fixture
def run(program):
    """Starts `columba vehicles` without the ports that other fixtures choose; ends it after the test."""
    started = []

    def start(*options):
        started.append(subprocess.Popen([program, "vehicles", "--json", *options], stdout=subprocess.PIPE, text=True))
        assert started[-1].stdout.readline(), "it has not started"

    yield start
    for process in started:
        process.terminate()
        assert process.wait(10) == 0
        process.stdout.close()


def test_a_px4s_first_sender_is_its_partner(run):
    """As measured on a real one: the first that sends gets everything, later ones are obeyed and not answered."""
    instance = free_instance(14_580, None, 1)
    run("--count", "1", "--personality", "px4", "--ports", "px4", "--instance", str(instance))
    first = connect(f"udpout:127.0.0.1:{14_580 + instance}")
    first.mav.heartbeat_send(6, 8, 0, 0, 0)
    assert heard(first) and heard(first, "LOCAL_POSITION_NED")
    later = connect(f"udpout:127.0.0.1:{14_580 + instance}")
    ask(later, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
    assert heard(first, "AUTOPILOT_VERSION"), "the partner has the answer"
    assert not heard(later, patience_s=1.5), "the later one has nothing"
    # The other link has a partner of its own.
    ground = connect(f"udpout:127.0.0.1:{18_570 + instance}")
    ground.mav.heartbeat_send(6, 8, 0, 0, 0)
    assert heard(ground)


def test_a_px4_sends_to_the_api_port_unasked(run):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind(("127.0.0.1", 14_549))
        except OSError:
            pytest.skip("UDP 14549, the last of PX4's API ports, is taken")
    instance = free_instance(14_580, None, 1)
    link = connect("udpin:127.0.0.1:14549")
    run("--count", "1", "--personality", "px4", "--ports", "px4", "--instance", str(instance))
    assert heard(link)
    link.close()


def test_each_link_of_a_px4_has_the_rates_of_its_simulator(run):
    """Hz of `px4-rc.mavlink`: of a companion computer, and of a ground station."""
    instance = free_instance(14_580, None, 1)
    run("--count", "1", "--personality", "px4", "--ports", "px4", "--instance", str(instance))
    expected = {14_580: {"ATTITUDE": 100, "HIGHRES_IMU": 50, "SYS_STATUS": 5}, 18_570: {"ATTITUDE": 50, "VFR_HUD": 4}}
    for port, rates in expected.items():
        link = connect(f"udpout:127.0.0.1:{port + instance}")
        link.mav.heartbeat_send(6, 8, 0, 0, 0)
        times, counts = [], Counter()
        while not times or times[-1] - times[0] < 2000:
            message = heard(link, list(rates))
            assert message, "it has fallen silent"
            counts[message.get_type()] += 1
            if message.get_type() == "ATTITUDE":
                times.append(message.time_boot_ms)
        assert {name: counts[name] / 2 for name in rates} == pytest.approx(rates, rel=0.1, abs=1)
        link.close()


def test_the_multicast_group_hears_all_vehicles_and_is_heard(start_vehicles):
    try:
        link = connect("mcast:")
    except OSError as error:
        pytest.skip(f"no route to a multicast group: {error}")
    vehicles = start_vehicles("--count", 2, "--multicast", ground_port=0)
    assert heard(link, system=1) and heard(link, system=2)
    ask(link, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION, 2)
    assert heard(link, "AUTOPILOT_VERSION", system=2)
    by_udp = vehicles.connect()[1]
    assert write(by_udp, "WP_LOITER_RAD", 77).param_value == 77
    link.close()


def test_ports_that_are_taken_or_contradict_are_told(program):
    instance = free_instance(14_550, 5_760, 10)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 5_760 + 10 * instance))
        taken.listen()
        refused = subprocess.run(
            [program, "vehicles", "--ports", "ardupilot", "--instance", str(instance)], capture_output=True, text=True
        )
        assert refused.returncode == 2
        assert f"cannot bind TCP 127.0.0.1:{5_760 + 10 * instance}: the port is busy" in refused.stderr
    for words, fault in [
        (["--vehicle-port", "14600"], "--vehicle-port 14600: must be 0 or left out: link.ports and link.instance say"),
        (["--per-port", "2"], "--per-port 2: must be 1: link.ports gives each vehicle its own ports"),
        (["--instance", "6000"], "--instance 6000: must be a whole number from 0 to 5000"),
    ]:
        refused = subprocess.run([program, "vehicles", "--ports", "px4", *words], capture_output=True, text=True)
        assert (refused.returncode, fault in refused.stderr) == (2, True), refused.stderr


def test_a_stranger_who_asks_an_arduplane_for_22_metres_a_second_gets_them(ardupilot):
    craft = Craft({**ardupilot.rows[0]})
    assert read(craft, "AIRSPEED_CRUISE").param_value == 22
    assert craft.change_speed(25) == mavlink.MAV_RESULT_ACCEPTED
