"""Real planes through routers, by TCP as SITL offers it, and beside Columba's own vehicles. Builds as in
test_real_autopilot.py."""

import pytest
from builds import ALTITUDE_M, LATITUDE_DEG, LONGITUDE_DEG, free_port, speedup
from fields import PLANES, field
from flight import flock, start_flight  # noqa: F401
from routers import ROUTERS, router
from second_link import SecondLink
from test_real_autopilot import check

SHORT = PLANES | dict(duration_s=45.0)

OWN = """
[scenario]
name = "own"
duration_s = 60.0
origin = {{ latitude_deg = {latitude}, longitude_deg = {longitude}, altitude_amsl_m = {altitude} }}
[flock]
expected_speed_mps = 20.0
expected_altitude_m = 50.0
[[vehicle]]
x_m = -60.0
y_m = {y_m}
altitude_m = 50.0
speed_mps = 20.0
course_deg = 0.0
"""


@pytest.mark.parametrize("name", ROUTERS)
def test_planes_through_a_router(start_flight, flock, tmp_path, name):
    vehicles_port, ground_port = free_port(), free_port()
    with router(name, tmp_path, vehicles_port, ground_port):
        flock.add_ardupilot("plane", 3, 60.0, vehicles_port)
        text, circles = field(3, 1, **SHORT)
        check(start_flight(text, [f"udpin:127.0.0.1:{ground_port}"]), flock, circles, 8.0, "LOITER")


def test_planes_by_tcp(start_flight, flock):
    flock.add_ardupilot("plane", 2, 60.0, None, tcp=True)
    text, circles = field(2, 1, **SHORT)
    check(start_flight(text, flock.links), flock, circles, 8.0, "LOITER")


def test_planes_beside_vehicles_of_columba(start_flight, start_vehicles, flock, tmp_path):
    port = free_port()
    flock.add_ardupilot("plane", 3, 60.0, port)
    for system, y_m in ((4, -30.0), (5, 30.0)):
        path = tmp_path / f"own-{system}.toml"
        path.write_text(OWN.format(latitude=LATITUDE_DEG, longitude=LONGITUDE_DEG, altitude=ALTITUDE_M, y_m=y_m))
        words = ("--on-ground", "--airframe", "plane", "--param", f"MAV_SYSID={system}", "--speed", speedup())
        row = start_vehicles(path, *words, ground_port=port).rows[0]
        flock.judges.append(SecondLink(f"udpout:{row['address']}", system))
    text, circles = field(5, 1, **SHORT)
    check(start_flight(text, flock.links), flock, circles, 8.0, "LOITER")
