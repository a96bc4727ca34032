"""Many vehicles: patterns and swarm files, networks past 250, groups behind one port, and the table that says who is
where."""

import socket
import subprocess

import pytest
from conftest import bind
from ground import Craft, connection
from pymavlink.dialects.v20 import ardupilotmega as mavlink

FIELDS = {
    "vehicle", "network", "system_id", "component_id", "address", "host", "port", "ground", "mode", "armed",
    "latitude_deg", "longitude_deg", "altitude_amsl_m", "x_m", "y_m", "altitude_m", "speed_mps", "course_rad",
}  # fmt: skip


def refused(program, *options):
    command = [program, "vehicles", "--vehicle-port", 0, "--ground-port", 0, *options]
    done = subprocess.run([str(word) for word in command], stderr=subprocess.PIPE, text=True, timeout=30)
    assert done.returncode == 2
    return done.stderr


def test_the_table_says_who_is_where(start_vehicles):
    vehicles = start_vehicles("--count", 3, "--pattern", "line")
    assert [row["vehicle"] for row in vehicles.rows] == [row["system_id"] for row in vehicles.rows] == [1, 2, 3]
    for row in vehicles.rows:
        assert set(row) >= FIELDS
        assert row["address"] == f"{row['host']}:{row['port']}"
        assert (row["network"], row["component_id"], row["mode"], row["armed"]) == (1, 1, "guided", True)
    assert len({row["port"] for row in vehicles.rows}) == 3
    for craft, row in zip(vehicles.connect(), vehicles.rows):
        place = craft.request(mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT, "GLOBAL_POSITION_INT")
        assert place.lon / 1e7 == pytest.approx(row["longitude_deg"], abs=1e-6)


def test_vehicle_251_is_system_1_of_network_2(start_vehicles, free_pair):
    sockets, first = free_pair
    rows = start_vehicles("--count", 251, "--speed", 20, ground_port=first).rows
    assert [(row["network"], row["system_id"]) for row in rows[249:]] == [(1, 250), (2, 1)]
    assert len({row["port"] for row in rows}) == 251
    grounds = [row["ground"] for row in rows]
    assert set(grounds[:250]) == {f"127.0.0.1:{first}"} and grounds[250] == f"127.0.0.1:{first + 1}"
    # Each ground port hears its own network, and no two vehicles in it with one id.
    ports = {row["port"]: row["network"] for row in rows}
    for network, ground in enumerate(sockets, start=1):
        heard = {ground.recvfrom(2048)[1][1] for _ in range(100)}
        assert heard and {ports[port] for port in heard} == {network}
    craft = Craft(rows[250])
    assert craft.system == 1
    craft.close()


@pytest.fixture
def free_pair():
    """Two sockets at neighbouring ports, and the first port."""
    for _ in range(100):
        one, other = bind(), bind()
        first = one.getsockname()[1]
        other.close()
        other = bind_at(first + 1)
        if other is not None:
            for bound in (one, other):
                bound.settimeout(10)
            yield (one, other), first
            one.close(), other.close()
            return
        one.close()
    pytest.skip("no two neighbouring ports are free")


def bind_at(port):
    bound = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        bound.bind(("127.0.0.1", port))
    except OSError:
        bound.close()
        return None
    return bound


def test_a_group_behind_one_port_is_told_apart_by_system_ids(start_vehicles):
    rows = start_vehicles("--count", 7, "--per-port", 3).rows
    ports = [row["port"] for row in rows]
    assert ports[0] == ports[1] == ports[2] != ports[3] == ports[4] == ports[5] != ports[6]
    link = connection(rows[0]["address"])
    # One for all reaches all of the group, and no others.
    link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
    heard = set()
    while heard != {1, 2, 3}:
        message = link.recv_match(type="HEARTBEAT", blocking=True, timeout=10)
        assert message is not None, f"only {heard} answer"
        heard.add(message.get_srcSystem())
    link.mav.command_long_send(2, 1, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, 12, 0, 0, 0, 0, 0)
    assert link.recv_match(type="COMMAND_ACK", blocking=True, timeout=10).get_srcSystem() == 2
    # Whom it does not have does not answer: of the two questions only the second is.
    for system in (4, 3):
        link.mav.param_request_read_send(system, 1, b"WP_RADIUS", -1)
    assert link.recv_match(type="PARAM_VALUE", blocking=True, timeout=10).get_srcSystem() == 3
    link.close()


def test_no_two_of_a_group_get_one_system_id(start_vehicles):
    rows = start_vehicles("--count", 2, "--per-port", 2).rows
    link = connection(rows[0]["address"])
    answers = []
    for number in (2, 9):
        link.mav.param_set_send(1, 1, b"MAV_SYSID", number, mavlink.MAV_PARAM_TYPE_INT16)
        is_it = lambda message: message.get_srcSystem() == 1 and message.param_id == "MAV_SYSID"  # noqa: E731
        while not is_it(answer := link.recv_match(type="PARAM_VALUE", blocking=True, timeout=10)):
            pass
        answers.append(answer.param_value)
    assert answers == [1, 9]
    link.close()


def test_a_swarm_file_says_where_they_start(start_vehicles, program, tmp_path):
    swarm = tmp_path / "swarm.txt"
    swarm.write_text("#instance=East,North,Up,Heading\n1=20,30,0,90\n2=40,0,5,45\n")
    rows = start_vehicles("--swarm", swarm).rows
    assert [(row["x_m"], row["y_m"], row["altitude_m"] - rows[0]["altitude_m"]) for row in rows] == [
        (30, 20, 0),
        (0, 40, 5),
    ]
    assert rows[0]["course_rad"] == pytest.approx(1.5708, abs=1e-4)
    assert "--count 3: must be at most 2" in refused(program, "--swarm", swarm, "--count", 3)
    swarm.write_text("1=20,30,0,north\n")
    assert "swarm.txt:1:11: heading = north: must be a number" in refused(program, "--swarm", swarm)


def test_parameters_are_set_at_the_start_and_not_kept(start_vehicles, program, tmp_path):
    options = ("--count", 2, "--params-folder", tmp_path, "--param", "WP_LOITER_RAD=85", "--param", "RTL_RADIUS=70")
    vehicles = start_vehicles(*options)
    crafts = vehicles.connect()
    assert [read(craft, "WP_LOITER_RAD") for craft in crafts] == [85, 85]
    crafts[1].link.mav.param_set_send(2, 1, b"RTL_RADIUS", 75, mavlink.MAV_PARAM_TYPE_INT16)
    crafts[1].wait(["PARAM_VALUE"])
    vehicles.stop()
    assert (tmp_path / "vehicle-2.parm").read_text() == "RTL_RADIUS 75\n"
    crafts = start_vehicles(*options).connect()
    assert [read(craft, "RTL_RADIUS") for craft in crafts] == [70, 75]
    assert "--param WP_RADIUS=0: must be a number from 1 to 32767" in refused(program, "--param", "WP_RADIUS=0")
    assert "must be NAME=VALUE" in refused(program, "--param", "WP_RADIUS")
    assert "each vehicle's own" in refused(program, "--param", "MAV_SYSID=7")


def read(craft, name):
    craft.link.mav.param_request_read_send(craft.system, craft.component, name.encode(), -1)
    return craft.wait(["PARAM_VALUE"], lambda value: value.param_id == name).param_value


def test_a_thousand_vehicles_have_a_port_each(start_vehicles):
    vehicles = start_vehicles("--count", 1000)
    assert len({row["port"] for row in vehicles.rows}) == 1000
    assert [row["network"] for row in vehicles.rows[::250]] == [1, 2, 3, 4]
    assert Craft(vehicles.rows[999]).system == 250


def test_limits_are_named(program):
    assert "must be a whole number from 1 to 10000" in refused(program, "--count", 10001)
    assert "must be a whole number from 1 to 250" in refused(program, "--per-port", 251)
    limited = f"ulimit -n 100; exec {program} vehicles --count 200 --vehicle-port 0"
    done = subprocess.run(["bash", "-c", limited], stderr=subprocess.PIPE, text=True, timeout=30)
    assert done.returncode == 2 and "200 ports" in done.stderr and "100 open files" in done.stderr
    overlapping = [program, "vehicles", "--vehicle-port", "14540", "--count", "20"]
    done = subprocess.run([str(word) for word in overlapping], stderr=subprocess.PIPE, text=True, timeout=30)
    assert done.returncode == 2 and "telemetry goes to UDP 14550" in done.stderr
