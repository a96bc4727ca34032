"""What the controller knows of the present over a bad link, and what it tells of it."""

import json
import pathlib
import subprocess

import pyarrow.parquet

REHEARSAL = pathlib.Path(__file__).parent.parent / "config/rehearsal.toml"
# What a controller reckons with that takes planes for Eq. 1 as printed, with other constants.
BEFORE = {
    "speed_time_constant_s": 2.0,
    "course_time_constant_s": 1.5,
    "speed_dead_time_s": 0.0,
    "course_dead_time_s": 0.0,
    "altitude_dead_time_s": 0.0,
    "course_reference_speed_mps": 0.0,
    "acceleration_max_mps2": 0.0,
    "course_step_max_deg": 180.0,
    "turn_share": 1.0,
    "lateral_overload_max": 5.0,
}
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


APART = """
[scenario]
name = "apart"
duration_s = 2.0

[flock]
expected_speed_mps = 10.0
expected_altitude_m = 50.0

[[vehicle]]
x_m = 0.0
y_m = -10.0
altitude_m = 50.0
speed_mps = 10.0
course_deg = -90.0

[[vehicle]]
x_m = 0.0
y_m = 10.0
altitude_m = 50.0
speed_mps = 10.0
course_deg = 90.0
"""


def test_vehicles_stay_at_their_starts_until_the_controller_knows_them(program, tmp_path):
    """Over a bad link that takes its time: vehicles at random places flew into each other meanwhile."""
    (tmp_path / "apart.toml").write_text(APART)
    done, _ = run(program, tmp_path / "run", tmp_path / "apart.toml", "--speed", "1", *DELAY)
    assert done.returncode == 0, done.stderr
    # They fly away from each other at 10 m/s until the first commands act.
    rows = pyarrow.parquet.read_table(tmp_path / "run/trajectory.parquet").to_pylist()
    reached_m = [abs(row["y_m"]) for row in rows if row["t_s"] == 0.5]
    assert len(reached_m) == 2
    assert all(14.0 < y_m < 16.0 for y_m in reached_m), reached_m


def test_lockstep_knows_everything_and_says_nothing(program, tmp_path):
    _, summary = run(program, tmp_path / "run", "--transport", "memory", "--duration", "2")
    assert summary["present"] is None


def test_planes_hit_what_a_controller_that_knows_them_flies_round(program, tmp_path):
    before = [word for key, value in BEFORE.items() for word in ("--set", f"dynamics.{key}={value}")]
    before += ["--set", 'law.course_law="printed"']  # without the bound on changes of a setpoint, which came later
    hits = {"known": 0, "before": 0}
    for seed in (3, 4, 5):
        for name, options in (("known", []), ("before", before)):
            folder = tmp_path / f"{name}-{seed}"
            _, summary = run(program, folder, REHEARSAL, "--transport", "memory", "--seed", seed, *options)
            assert summary["completed"]
            hits[name] += summary["obstacle_collisions"] + summary["vehicle_collisions"] > 0
    assert hits["known"] == 0 and hits["before"] >= 2, hits


def test_planes_are_not_told_left_and_right_until_they_hit_what_is_dead_ahead(program, tmp_path):
    bank_35 = ("--set", "dynamics.lateral_overload_max=0.7", "--set", "parameters.ROLL_LIMIT_DEG=34.9")
    for seed, options in ((15, bank_35), (28, bank_35), (39, ())):
        done, summary = run(program, tmp_path / str(seed), REHEARSAL, "--transport", "memory", "--seed", seed, *options)
        assert done.returncode == 0, done.stderr
        assert summary["course_setpoint_change_p99_share"] <= 1.0


def test_a_dead_time_is_foreseen_in_lockstep_as_in_memory(program, tmp_path):
    for transport in ("memory", "udp"):
        _, summary = run(program, tmp_path / transport, REHEARSAL, "--transport", transport, "--duration", "6")
        assert summary["present"]["state_error_rms_m"] < 0.5
    first, second = ((tmp_path / name / "trajectory.parquet").read_bytes() for name in ("memory", "udp"))
    assert first == second
