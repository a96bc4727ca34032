"""Other people's clients, as they are: each connects, reads all parameters, uploads a mission, flies it, and comes
home.

dronekit and MAVSDK are among the tests' requirements. MAVProxy (pip install MAVProxy) and mavlink-routerd are not: a
test whose program is not on the PATH is skipped, and says which.
"""

import importlib
import math
import shutil
import subprocess
import sys
import time

import pytest
from conftest import free_port
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink

SPEED = 10
PATIENCE_S = 60.0
METRES_PER_DEGREE = 111_319.5
RADIUS_M = 20
HOME = 39.98, 116.34
WAYPOINTS = ((200, 0), (300, 150), (200, 300), (0, 300), (-150, 200), (-150, 50), (-300, -100), (-450, 0))


def place(north_m, east_m):
    lat, lon = HOME
    return lat + north_m / METRES_PER_DEGREE, lon + east_m / METRES_PER_DEGREE / math.cos(math.radians(lat))


def mission():
    """Take-off, eight waypoints and a landing: command, params 1 to 4, latitude, longitude, height above home."""
    heights = (60,) * 7 + (25,)
    return [
        (mavlink.MAV_CMD_NAV_TAKEOFF, (12, 0, 0, 0), *place(0, 0), 50),
        *((mavlink.MAV_CMD_NAV_WAYPOINT, (0, RADIUS_M, 0, 0), *place(*at), z) for at, z in zip(WAYPOINTS, heights)),
        (mavlink.MAV_CMD_NAV_LAND, (0, 0, 0, 0), *place(0, 0), 0),
    ]


def package(name):
    """The package, or a test skipped for want of it."""
    return pytest.importorskip(name, reason=f"{name} is not installed")


def until(holds, what, patience_s=PATIENCE_S):
    deadline = time.monotonic() + patience_s
    while not holds():
        if time.monotonic() > deadline:
            raise TimeoutError(what)
        time.sleep(0.02)


@pytest.fixture
def address(start_vehicles, scenario):
    """Where a vehicle listens that stands on the ground, ten times as fast as the clock."""
    vehicles = start_vehicles(scenario(on_ground=True, setpoint_timeout_s=0), "--speed", SPEED)
    return vehicles.rows[0]["address"]


def test_dronekit_flies_a_mission_and_guides_it(address):
    dronekit = package("dronekit")
    vehicle = dronekit.connect(f"udpout:{address}", wait_ready=True, timeout=PATIENCE_S)
    try:
        vehicle.parameters["RTL_ALTITUDE"] = 60
        assert vehicle.parameters["RTL_ALTITUDE"] == 60
        commands = vehicle.commands
        commands.download()
        commands.wait_ready(timeout=PATIENCE_S)
        assert vehicle.home_location.lat == pytest.approx(HOME[0], abs=1e-4)
        commands.clear()
        frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
        for command, params, lat, lon, height in mission():
            commands.add(dronekit.Command(0, 0, 0, frame, command, 0, 1, *params, lat, lon, height))
        commands.upload()
        commands.download()
        commands.wait_ready(timeout=PATIENCE_S)
        assert commands.count == len(mission())

        until(lambda: vehicle.is_armable, "is_armable")
        vehicle.mode = dronekit.VehicleMode("AUTO")
        vehicle.armed = True
        until(lambda: vehicle.armed, "armed")
        reached = []
        vehicle.add_message_listener("MISSION_ITEM_REACHED", lambda _, __, message: reached.append(message.seq))
        until(lambda: not vehicle.armed, "landed and disarmed")
        assert [seq for seq in dict.fromkeys(reached) if 2 <= seq <= 9] == list(range(2, 10))

        vehicle.mode = dronekit.VehicleMode("TAKEOFF")
        until(lambda: vehicle.mode.name == "TAKEOFF", "TAKEOFF")
        vehicle.armed = True
        until(lambda: vehicle.location.global_relative_frame.alt > 40, "in the air")
        vehicle.mode = dronekit.VehicleMode("GUIDED")
        until(lambda: vehicle.mode.name == "GUIDED", "GUIDED")
        vehicle.simple_goto(dronekit.LocationGlobalRelative(*place(200, 200), 80))
        until(lambda: vehicle.location.global_relative_frame.alt > 78, "where it was sent")
        vehicle.mode = dronekit.VehicleMode("RTL")
        until(lambda: vehicle.mode.name == "RTL", "RTL")
    finally:
        vehicle.close()


def test_mavsdk_flies_a_mission(address):
    mavsdk = package("mavsdk")
    if not hasattr(mavsdk, "Mavsdk"):
        pytest.skip("mavsdk is older than 4")
    action, info, mission_raw, param, telemetry = (
        importlib.import_module(f"mavsdk.plugins.{name}")
        for name in ("action", "info", "mission_raw", "param", "telemetry")
    )
    configuration = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION)
    with mavsdk.Mavsdk(configuration) as station:
        station.add_any_connection(f"udpout://{address}")
        system = station.first_autopilot(PATIENCE_S)
        assert system is not None
        assert info.Info(system).get_version().flight_sw_major == 4
        parameters = param.Param(system)
        everything = parameters.get_all_params()
        assert everything.int_params and everything.float_params
        parameters.set_param_float("RTL_ALTITUDE", 60)
        assert parameters.get_param_float("RTL_ALTITUDE") == 60

        seen = telemetry.Telemetry(system)
        until(lambda: seen.health().is_armable and seen.health().is_home_position_ok, "is_armable")
        items = [
            mission_raw.MissionItem(
                seq, 3, command, int(seq == 0), 1, *params, round(lat * 1e7), round(lon * 1e7), height, 0
            )
            for seq, (command, params, lat, lon, height) in enumerate([mission()[0], *mission()])
        ]
        plans, does = mission_raw.MissionRaw(system), action.Action(system)
        plans.upload_mission(items)
        assert [item.command for item in plans.download_mission()][1:] == [item.command for item in items][1:]
        does.arm()
        plans.start_mission()
        until(lambda: seen.in_air(), "in the air")
        until(lambda: plans.mission_progress().current == len(items) - 1, "the last item")
        until(lambda: not seen.armed(), "landed and disarmed")


@pytest.mark.parametrize("personality", ["px4", "generic"])
def test_mavsdk_flies_by_its_own_missions_and_setpoints(start_vehicles, scenario, personality):
    mavsdk = package("mavsdk")
    if not hasattr(mavsdk, "Mavsdk"):
        pytest.skip("mavsdk is older than 4")
    action, mission_plans, offboard, param, telemetry = (
        importlib.import_module(f"mavsdk.plugins.{name}")
        for name in ("action", "mission", "offboard", "param", "telemetry")
    )
    described = scenario(on_ground=True, personality=personality, setpoint_timeout_s=0)
    address = start_vehicles(described, "--speed", SPEED).rows[0]["address"]
    configuration = mavsdk.Configuration.create_with_component_type(mavsdk.ComponentType.GROUND_STATION)
    with mavsdk.Mavsdk(configuration) as station:
        station.add_any_connection(f"udpout://{address}")
        system = station.first_autopilot(PATIENCE_S)
        assert system is not None
        assert param.Param(system).get_all_params().float_params
        seen, does = telemetry.Telemetry(system), action.Action(system)
        until(lambda: seen.health_all_ok(), "health_all_ok")
        assert seen.home().latitude_deg == pytest.approx(HOME[0], abs=1e-4)

        plans = mission_plans.Mission(system)
        nan = float("nan")
        plans.upload_mission(
            mission_plans.MissionPlan(
                [
                    mission_plans.MissionItem(
                        *place(*at), 60, nan, True, nan, nan, mission_plans.MissionItem.CameraAction.NONE,
                        nan, nan, RADIUS_M, nan, nan, mission_plans.MissionItem.VehicleAction.NONE,
                    )
                    for at in (*WAYPOINTS, (-300, 0), (-150, 0))
                ]
            )
        )  # fmt: skip
        # Its own default for an unknown autopilot is 2.5 m.
        does.set_takeoff_altitude(40)
        does.arm()
        does.takeoff()
        until(lambda: seen.position().relative_altitude_m > 30, "in the air")
        plans.start_mission()
        until(plans.is_mission_finished, "the end of the mission")
        assert (plans.mission_progress().current, plans.mission_progress().total) == (10, 10)

        leads = offboard.Offboard(system)
        leads.set_velocity_ned(offboard.VelocityNedYaw(5, 10, 0, 0))
        leads.start()
        until(lambda: abs(seen.velocity_ned().east_m_s - 10) < 0.2, "the velocity that was asked for")
        leads.stop()
        does.return_to_launch()
        until(lambda: math.hypot(seen.position_velocity_ned().position.north_m, 0) < 200, "near home")
        does.land()
        until(lambda: not seen.in_air() and not seen.armed(), "landed and disarmed")


class Proxy:
    """MAVProxy without a terminal, told what to do by its standard input; `said` is all that it has printed."""

    def __init__(self, address, folder):
        self.printed = folder / "printed"
        command = [sys.executable, shutil.which("mavproxy.py"), f"--master=udpout:{address}", "--streamrate=4"]
        with open(self.printed, "w") as output:
            self.process = subprocess.Popen(
                command, cwd=folder, stdin=subprocess.PIPE, stdout=output, stderr=subprocess.STDOUT, text=True
            )

    @property
    def said(self):
        return self.printed.read_text(errors="replace")

    def tell(self, command, until_said):
        """One command; until it has printed what is expected, since then."""
        start = len(self.said)
        print(command, file=self.process.stdin, flush=True)
        until(lambda: until_said in self.said[start:], f"{until_said!r} after {command!r} in {self.said[start:]!r}")


@pytest.fixture
def proxy(address, tmp_path):
    if shutil.which("mavproxy.py") is None:
        pytest.skip("mavproxy.py is not on the PATH")
    started = Proxy(address, tmp_path)
    yield started
    started.process.kill()
    started.process.wait()


def test_mavproxy_flies_a_mission_within_a_fence(proxy, tmp_path):
    until(lambda: "Saved" in proxy.said, "all parameters")
    items = [(mavlink.MAV_CMD_NAV_WAYPOINT, (0, 0, 0, 0), *HOME, 0), *mission()]
    corners = [place(north_m, east_m) for north_m, east_m in ((-700, -700), (-700, 700), (700, 700), (700, -700))]
    fence = [(mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, (4, 0, 0, 0), *corner, 0) for corner in corners]
    for name, plan in (("mission.txt", items), ("fence.txt", fence)):
        rows = [
            "\t".join(str(field) for field in (seq, 0, 3, command, *params, lat, lon, height, 1))
            for seq, (command, params, lat, lon, height) in enumerate(plan)
        ]
        (tmp_path / name).write_text("\n".join(["QGC WPL 110", *rows, ""]))
    proxy.tell("wp load mission.txt", "TYPE_MISSION: ACCEPTED")
    proxy.tell("fence load fence.txt", "TYPE_FENCE: ACCEPTED")
    proxy.tell("wp list", f"Saved {len(items)} waypoints")
    proxy.tell("fence enable", "DO_FENCE_ENABLE: ACCEPTED")
    proxy.tell("arm throttle", "ARMED")
    proxy.tell("mode AUTO", "DISARMED")
    assert [f"waypoint {seq}" in proxy.said for seq in range(2, len(items))] == [True] * (len(items) - 2)


def test_clients_meet_behind_mavlink_router(address, tmp_path):
    program = shutil.which("mavlink-routerd")
    if program is None:
        pytest.skip("mavlink-routerd is not on the PATH")
    host, port = address.split(":")
    ground = free_port()
    configuration = tmp_path / "router.conf"
    configuration.write_text(
        f"[General]\nTcpServerPort = 0\n[UdpEndpoint vehicle]\nMode = Normal\nAddress = {host}\nPort = {port}\n"
        f"[UdpEndpoint ground]\nMode = Server\nAddress = 127.0.0.1\nPort = {ground}\n"
    )
    router = subprocess.Popen([program, "-c", configuration], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        links = [
            mavutil.mavlink_connection(f"udpout:127.0.0.1:{ground}", source_system=system) for system in (255, 254)
        ]
        for link in links:
            first = None
            while first is None:
                link.mav.heartbeat_send(mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0)
                first = link.recv_match(type="HEARTBEAT", blocking=True, timeout=0.5)
        for link in links:
            link.mav.param_request_list_send(1, 1)
            value = link.recv_match(type="PARAM_VALUE", blocking=True, timeout=PATIENCE_S)
            indices = {value.param_index}
            while len(indices) < value.param_count:
                indices.add(link.recv_match(type="PARAM_VALUE", blocking=True, timeout=PATIENCE_S).param_index)
            link.mav.command_long_send(1, 1, mavlink.MAV_CMD_DO_SET_MODE, 0, 1, 13, 0, 0, 0, 0, 0)
            assert link.recv_match(type="COMMAND_ACK", blocking=True, timeout=PATIENCE_S).result == 0
    finally:
        router.terminate()
        router.wait()
        for link in links:
            link.close()
