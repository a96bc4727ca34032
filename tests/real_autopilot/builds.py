"""Starts the user's own builds of autopilots in software, each instance in a folder of its own.

ARDUPLANE_BIN (with ARDUPLANE_DEFAULTS), ARDUCOPTER_BIN (with ARDUCOPTER_DEFAULTS) and PX4_BUILD_DIR name the builds;
docs/real-autopilots.md says where they come from. REAL_PX4_PARAMETERS="SIH_KDV=0.2 ..." changes parameters of PX4.
"""

import math
import os
import socket
import subprocess
from pathlib import Path

import pytest
from second_link import SecondLink

LATITUDE_DEG, LONGITUDE_DEG, ALTITUDE_M = 39.98, 116.34, 50.0
METRES_PER_DEGREE = 111_319.490_793


def build(variable):
    """The path that a variable names; without it the test is skipped, and says so."""
    path = os.environ.get(variable)
    if not path:
        pytest.skip(f"{variable} is not set: no build to fly")
    assert Path(path).exists(), f"{variable}={path}: there is no such build"
    return Path(path).resolve()


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bound:
        bound.bind(("127.0.0.1", 0))
        return bound.getsockname()[1]


def first_instance():
    """Ports follow from the number of an instance: each worker of pytest has its own."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "gw0")
    return 10 + 20 * int(worker.removeprefix("gw"))


def speedup():
    """REAL_SPEEDUP: so many seconds of the simulated clock in one of the wall clock (default 1)."""
    return float(os.environ.get("REAL_SPEEDUP", "1"))


def homes(count, spacing_m, north_m=0.0):
    """Places in a row from west to east, the middle of the row at the origin."""
    for index in range(count):
        east_m = (index - 0.5 * (count - 1)) * spacing_m
        longitude = LONGITUDE_DEG + east_m / METRES_PER_DEGREE / math.cos(math.radians(LATITUDE_DEG))
        yield LATITUDE_DEG + north_m / METRES_PER_DEGREE, longitude


class Flock:
    """Running instances: the links of the controller, and a second link to each as the judge."""

    def __init__(self, folder):
        self.folder, self.links, self.judges, self.processes = folder, [], [], []

    def _spawn(self, words, environment=None):
        folder = self.folder / f"vehicle-{len(self.processes) + 1}"
        folder.mkdir(parents=True)
        log = (folder / "output").open("w")
        words = [str(word) for word in words]
        self.processes.append(
            subprocess.Popen(words, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        )

    def add_ardupilot(self, vehicle, count, spacing_m, port, north_m=0.0, first_system=1, parameters=(), tcp=False):
        """`plane` or `copter`: telemetry to a UDP port, or at its own TCP port; judges at its second TCP port."""
        binary = build({"plane": "ARDUPLANE_BIN", "copter": "ARDUCOPTER_BIN"}[vehicle])
        defaults = os.environ.get({"plane": "ARDUPLANE_DEFAULTS", "copter": "ARDUCOPTER_DEFAULTS"}[vehicle])
        files = [defaults] if defaults else []
        if parameters:
            own = self.folder / f"parameters-{len(self.processes)}.parm"
            own.write_text("".join(f"{name} {value}\n" for name, value in parameters))
            files.append(str(own))
        for index, (latitude, longitude) in enumerate(homes(count, spacing_m, north_m)):
            instance = first_instance() + len(self.processes)
            words = [
                binary, "--model", {"plane": "plane", "copter": "quad"}[vehicle], "--speedup", f"{speedup():g}",
                f"-I{instance}", "--sysid", first_system + index, "--wipe",
                "--home", f"{latitude:.7f},{longitude:.7f},{ALTITUDE_M},0",
            ]  # fmt: skip
            words += [] if tcp else ["--serial0", f"udpclient:127.0.0.1:{port}"]
            words += ["--defaults", ",".join(files)] if files else []
            self._spawn(words)
            self.links += [f"tcp:127.0.0.1:{5760 + 10 * instance}"] if tcp else []
            self.judges.append(SecondLink(f"tcp:127.0.0.1:{5762 + 10 * instance}", first_system + index))
        if not tcp and (link := f"udpin:127.0.0.1:{port}") not in self.links:
            self.links.append(link)

    def add_px4(self, vehicle, count, spacing_m, parameters=()):
        """`quad` or `plane`, with the simulator that PX4 has built in. Its offboard link is the controller's, its
        ground station's link the judge's."""
        directory = build("PX4_BUILD_DIR")
        own = {"SDLOG_MODE": "-1"} | {"quad": {}, "plane": {"SIH_F_T_MAX": "9", "MIS_TAKEOFF_ALT": "60"}}[vehicle]
        own |= dict(pair.split("=") for pair in os.environ.get("REAL_PX4_PARAMETERS", "").split()) | dict(parameters)
        for latitude, longitude in homes(count, spacing_m):
            instance = first_instance() + len(self.processes)
            environment = {name: value for name, value in os.environ.items() if not name.startswith("PX4_")} | {
                "PX4_SIM_MODEL": {"quad": "sihsim_quadx", "plane": "sihsim_airplane"}[vehicle],
                "PX4_SIM_SPEED_FACTOR": f"{speedup():g}",
                "PX4_HOME_LAT": f"{latitude:.7f}",
                "PX4_HOME_LON": f"{longitude:.7f}",
                "PX4_HOME_ALT": str(ALTITUDE_M),
                **{f"PX4_PARAM_{name}": value for name, value in own.items()},
            }
            self._spawn([directory / "bin/px4", "-i", instance, "-d", directory / "etc"], environment)
            # From the tenth instance on the offboard links of all go to one port: the station speaks first.
            self.links.append(f"udpout:127.0.0.1:{14580 + instance}")
            self.judges.append(SecondLink(f"udpout:127.0.0.1:{18570 + instance}", instance + 1))

    def kill(self, number):
        """Ends the vehicle of this number, from one, as if it were gone."""
        self.processes[number - 1].kill()

    def close(self):
        for judge in self.judges:
            judge.running = False
        for process in self.processes:
            process.kill()
        for process in self.processes:
            process.wait()
