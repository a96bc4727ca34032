"""ArduPilot's own plane tests against `columba vehicles`: their bodies as they are, from a checkout of ArduPilot.

Only the start of the simulator is another: `columba vehicles` in the place of its process. The tests read and set
parameters of a real ArduPlane: they come from a file that a ground station has saved of one. docs/compatibility.md says
how to run this.
"""

import argparse
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import traceback

os.environ["MAVLINK20"] = "1"  # pymavlink reads it when it is imported


class TooLong(BaseException):
    """A test has not ended in time."""


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--ardupilot", required=True, help="checkout of ArduPilot")
    parser.add_argument("--parameters", required=True, help="all parameters of an ArduPlane, as a ground station saves")
    parser.add_argument("--program", default="target/release/columba")
    parser.add_argument("--instance", type=int, default=0, help="of the ports, as ArduPilot's -I")
    parser.add_argument("--speed", type=float, default=10, help="vehicle seconds for each second of the clock")
    parser.add_argument("--timeout", type=int, default=240, help="seconds for each test")
    parser.add_argument("--out", default="arduplane.jsonl", help="results, a line of JSON for each test")
    parser.add_argument("--logs", default="arduplane-logs", help="folder for what the tests print")
    parser.add_argument("tests", nargs="+", help="names, as LOITER")
    return parser.parse_args()


class Vehicles:
    """What takes the place of ArduPilot's simulator."""

    def __init__(self, settings, folder, spawn, whole_path):
        self.settings, self.folder, self.spawn, self.whole_path = settings, folder, spawn, whole_path
        self.asked = []

    def start(
        self, binary, home, model=None, defaults_filepath=None, param_defaults=None, customisations=(), wipe=False, **_
    ):
        """The arguments of ArduPilot's util.start_SITL."""
        if customisations or model not in (None, "plane", "plane-elevrev"):
            self.asked.append(f"{model} {list(customisations)}")
        files = defaults_filepath or []
        files = [self.whole_path(file) for file in (files if isinstance(files, list) else [files])]
        if param_defaults:
            with tempfile.NamedTemporaryFile("w", delete=False, suffix=".parm", dir=self.folder) as file:
                file.writelines(f"{name} {value}\n" for name, value in param_defaults.items())
            files.append(file.name)
        latitude, longitude, altitude, heading = home.split(",")
        start = os.path.join(self.folder, "start.txt")
        with open(start, "w") as file:
            file.write(f"1=0,0,0,{heading}\n")
        state = os.path.join(self.folder, "state")
        if wipe:
            shutil.rmtree(state, ignore_errors=True)
        words = [
            "vehicles", "--ports", "ardupilot", "--instance", self.settings.instance, "--ground-port", 0, "--on-ground",
            "--airframe", "plane", "--swarm", start, "--speed", self.settings.speed, "--state-folder", state,
            "--set", f"scenario.origin.latitude_deg={latitude}", "--set", f"scenario.origin.longitude_deg={longitude}",
            "--set", f"scenario.origin.altitude_amsl_m={altitude}",
        ]  # fmt: skip
        for file in [self.settings.parameters, *files]:
            words += ["--defaults", file]
        child = self.spawn(self.settings.program, [str(word) for word in words], encoding="utf-8", timeout=30)
        child.expect("127.0.0.1")
        return child


def run(settings, name):
    """One test; what became of it."""
    folder = tempfile.mkdtemp(prefix="arduplane-")
    os.environ["BUILDLOGS"] = folder
    os.chdir(folder)
    sys.path.insert(0, os.path.join(settings.ardupilot, "Tools", "autotest"))
    import arduplane
    import pexpect
    import vehicle_test_suite
    from pysim import util

    vehicles = Vehicles(settings, folder, pexpect.spawn, util.reltopdir)
    util.start_SITL = vehicles.start
    instance = settings.instance

    class Suite(arduplane.AutoTestPlane):
        def autotest_connection_string_to_ardupilot(self):
            return f"tcp:127.0.0.1:{5760 + 10 * instance}"

        def adjust_ardupilot_port(self, port):
            return port + 10 * instance

        def sitl_rcin_port(self, offset=0):
            return 5501 + offset + 10 * instance

    def too_long(*_):
        raise TooLong

    signal.signal(signal.SIGALRM, too_long)
    signal.alarm(settings.timeout)
    row = {"test": name, "passed": False}
    suite = Suite(binary="columba", speedup=int(settings.speed), sup_binaries=[])
    began_s = time.monotonic()
    try:
        suite.init()
        suite.set_rc_default()
        result = suite.run_one_test(vehicle_test_suite.Test(getattr(suite, name)))
        row |= {"passed": bool(result.passed), "why": repr(getattr(result, "exception", None))[:300]}
    except TooLong:
        row["why"] = f"took longer than {settings.timeout} s"
    except Exception as error:
        traceback.print_exc()
        row["why"] = f"start: {error!r}"[:300]
    signal.alarm(0)
    if suite.sitl is not None:
        suite.sitl.close(force=True)
    return row | {"wall_s": round(time.monotonic() - began_s), "asked": vehicles.asked}


def main():
    settings = arguments()
    for name in ("ardupilot", "parameters", "program", "out", "logs"):
        setattr(settings, name, os.path.abspath(getattr(settings, name)))
    os.makedirs(settings.logs, exist_ok=True)
    if len(settings.tests) == 1:
        with open(os.path.join(settings.logs, f"{settings.tests[0]}.txt"), "w") as log:
            os.dup2(log.fileno(), 1)
            row = run(settings, settings.tests[0])
        line = json.dumps(row)
        with open(settings.out, "a") as out:
            out.write(line + "\n")
        print(line, file=sys.stderr, flush=True)
        # ArduPilot's threads do not end by themselves.
        os._exit(0 if row["passed"] else 1)
    options = ("ardupilot", "parameters", "program", "instance", "speed", "timeout", "out", "logs")
    words = [word for option in options for word in (f"--{option}", str(getattr(settings, option)))]
    passed = 0
    for test in settings.tests:
        try:
            command = [sys.executable, os.path.abspath(__file__), *words, test]
            done = subprocess.run(command, timeout=settings.timeout + 90)
            passed += done.returncode == 0
        except subprocess.TimeoutExpired:
            print(f"{test} hangs", file=sys.stderr)
    print(f"{passed} of {len(settings.tests)} pass", file=sys.stderr)


if __name__ == "__main__":
    main()
