"""What the controller knows of the present over a bad link, and what it tells of it."""

import json
import subprocess

DELAY = ["--set", "link.delay_ms=200", "--set", "link.jitter_ms=50", "--loss", "0.2"]


def run(program, folder, *options):
    command = [program, "run", "--quiet", "--no-report", "--out", folder, *options]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=240)
    return done, json.loads((folder / "summary.json").read_text())


def test_a_bad_link_is_flown_through_and_repeats(program, tmp_path):
    flights = [run(program, tmp_path / name, "--transport", "simulated", *DELAY) for name in "ab"]
    for done, summary in flights:
        assert done.returncode == 0, done.stderr
        assert summary["transport"] == "simulated"
        present = summary["present"]
        assert present["state_error_rms_m"] < 0.5
        assert present["late_ticks"] == present["missed_ticks"] == 0
        for vehicle in present["vehicles"]:
            # 200 ms and half of the jitter each way.
            assert abs(vehicle["command_delay_s"] - 0.225) < 0.02
            assert abs(vehicle["telemetry_delay_s"] - 0.225) < 0.02
            assert vehicle["delay_spread_s"] > 0.005
    first, second = ((tmp_path / name / "trajectory.parquet").read_bytes() for name in "ab")
    assert first == second


def test_real_time_measures_the_delay_of_its_link(program, tmp_path):
    _, summary = run(program, tmp_path / "run", "--speed", "2", "--duration", "8", "--set", "link.delay_ms=100")
    present = summary["present"]
    for vehicle in present["vehicles"]:
        # 100 ms of the wall clock are 200 ms of the flight; a machine under load only adds to them.
        assert vehicle["command_delay_s"] > 0.15
        assert vehicle["telemetry_delay_s"] > 0.15
    assert present["ticks"] == 16


def test_lockstep_knows_everything_and_says_nothing(program, tmp_path):
    _, summary = run(program, tmp_path / "run", "--transport", "memory", "--duration", "2")
    assert summary["present"] is None
