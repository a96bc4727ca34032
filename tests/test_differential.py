"""The differential run: the same scenes against a real ArduPlane and against ours give the same answers.

With COLUMBA_ARDUPLANE (the program, built for simulation) and COLUMBA_ARDUPLANE_DEFAULTS (its parameter file) the
real one is asked now; without, its answers are those in `reference/arduplane.json`. To make that file anew:

    COLUMBA_ARDUPLANE=.../arduplane COLUMBA_ARDUPLANE_DEFAULTS=.../plane.parm python tests/test_differential.py
"""

import json
import os
import re
import subprocess
import tempfile
from contextlib import contextmanager
from fnmatch import fnmatchcase
from pathlib import Path

os.environ["MAVLINK20"] = "1"  # pymavlink reads it when it is imported

# The scenes register themselves.
import command_scenes  # noqa: F401
import kind_scenes  # noqa: F401
import option_scenes  # noqa: F401
import pilot_scenes  # noqa: F401
import plan_scenes  # noqa: F401
import pytest
import scenes  # noqa: F401
from differences import KNOWN
from differential import SCENES, play
from ground import connection
from pymavlink import mavutil

RECORDING = Path(__file__).parent / "reference/arduplane.json"
PAGE = Path(__file__).parent.parent / "docs/mavlink.md"
HOME = "39.98,116.34,0,0"
SPEED = 10
# Ours keeps up with more, on a machine that has nothing else to do.
OUR_SPEED = 40


@contextmanager
def real_arduplane(folder):
    """Starts the real one in a folder of its own, and gives a connection to it."""
    link = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=255, source_component=190)
    program, defaults = (
        Path(os.environ[name]).resolve() for name in ("COLUMBA_ARDUPLANE", "COLUMBA_ARDUPLANE_DEFAULTS")
    )
    command = [
        program,
        "--model",
        "plane",
        "--speedup",
        SPEED,
        # Ports of its own, where several tests run at once.
        "--instance",
        re.sub(r"\D", "", os.environ.get("PYTEST_XDIST_WORKER", "0")),
        "--sysid",
        1,
        "--home",
        HOME,
        "--defaults",
        defaults,
        "--wipe",
    ]
    command += [
        "--serial0",
        f"udpclient:127.0.0.1:{link.port.getsockname()[1]}",
        "--serial1",
        "none",
        "--serial2",
        "none",
    ]
    with open(Path(folder) / "log", "w") as log:
        process = subprocess.Popen(
            [str(word) for word in command], cwd=folder, stdout=log, stderr=log, stdin=subprocess.DEVNULL
        )
        try:
            yield link
        finally:
            link.close()
            process.kill()
            process.wait()


def record():
    """Plays all scenes with the real one: its answers, and in the head what they are."""
    answers, version = {}, None
    for name in SCENES:
        with tempfile.TemporaryDirectory() as folder, real_arduplane(folder) as link:
            answers[name] = play(name, link)
            version = link.messages.get("AUTOPILOT_VERSION", version)
        print(f"{name}: {len(answers[name])} steps", flush=True)
    number = ".".join(str(version.flight_sw_version >> shift & 255) for shift in (24, 16, 8))
    commit = bytes(version.flight_custom_version).decode()
    head = {
        "what": "what a real ArduPlane answers to tests/scenes.py and tests/plan_scenes.py",
        "version": f"ArduPlane {number}-dev ({commit})",
        "started as": f"arduplane --model plane --speedup {SPEED} --sysid 1 --home {HOME} --defaults plane.parm --wipe",
        "made by": "COLUMBA_ARDUPLANE=arduplane COLUMBA_ARDUPLANE_DEFAULTS=plane.parm python "
        "tests/test_differential.py",
    }
    return {"head": head, "scenes": answers}


@pytest.fixture
def reference(tmp_path):
    """What the real one answers in a scene: asked now, or recorded."""

    def answers(name):
        if "COLUMBA_ARDUPLANE" in os.environ:
            with real_arduplane(tmp_path) as link:
                return play(name, link)
        recording = json.loads(RECORDING.read_text())
        print(f"compared with the recording of {recording['head']['version']}")
        return recording["scenes"][name]

    return answers


@pytest.fixture
def ours(start_vehicles, scenario):
    """What our vehicle answers in a scene."""

    def answers(name, speed):
        vehicles = start_vehicles(scenario(on_ground=True, setpoint_timeout_s=0), "--speed", speed)
        link = connection(vehicles.rows[0]["address"])
        link.mav.heartbeat_send(6, 8, 0, 0, 0)
        try:
            return play(name, link)
        finally:
            link.close()

    return answers


def differ(real, our):
    """Whether a step's answers differ. Of words only this counts: where the real one warns, ours does."""
    silent = [{key: value for key, value in step.items() if key != "warned"} for step in (real, our)]
    return silent[0] != silent[1] or (real.get("warned", False) and not our.get("warned", False))


def known(name):
    """The patterns of a scene's steps that are known to differ."""
    return [pattern for patterns in KNOWN.values() for pattern in patterns.get(name, [])]


@pytest.mark.parametrize("name", SCENES)
def test_ours_answers_as_the_real_one_does(name, reference, ours):
    real = reference(name)
    fault = compare(name, real, ours(name, OUR_SPEED))
    if fault:
        # On a busy machine a vehicle that is so fast has gone on before the client has read what it said.
        print(f"at speed {OUR_SPEED}: {fault}")
        fault = compare(name, real, ours(name, SPEED))
    assert not fault, fault


def compare(name, real, our):
    """What differs and is not known to, or is known to and does not; nothing if all is as it should be."""
    if list(real) != list(our):
        return f"steps {list(real)} and {list(our)}"
    different = {step for step in real if differ(real[step], our[step])}
    expected = {step for step in different for pattern in known(name) if fnmatchcase(step, pattern)}
    unlisted = {step: {"real": real[step], "ours": our[step]} for step in real if step in different - expected}
    over = [pattern for pattern in known(name) if not any(fnmatchcase(step, pattern) for step in different)]
    return (unlisted and json.dumps(unlisted, indent=1)) or (over and f"no longer different: {over}") or ""


def test_the_page_lists_every_known_difference():
    page = " ".join(PAGE.read_text().split())
    assert not [reason for reason in KNOWN if reason not in page]


if __name__ == "__main__":
    RECORDING.write_text(json.dumps(record(), indent=1) + "\n")
