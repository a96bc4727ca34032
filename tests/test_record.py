"""What a run leaves behind: the log, the trajectory and the summary tell of one flight."""

import itertools
import math
import tomllib

import pyarrow.parquet
import pytest
import tlog
from conftest import PROJECT

# Vehicles report at 10 Hz: the nearest moment lies within half of that of a sample.
NEAREST_S = 0.05
COLUMNS = [
    "t_s", "vehicle", "x_m", "y_m", "altitude_m", "speed_mps", "course_rad", "climb_mps",
    "speed_setpoint_mps", "course_setpoint_rad", "altitude_setpoint_m",
    "alpha_formation", "alpha_obstacle", "alpha_velocity",
]  # fmt: skip


@pytest.fixture(scope="module")
def tracks(flown):
    return tlog.tracks(flown.tlog)


@pytest.fixture(scope="module")
def obstacles():
    return tomllib.loads((PROJECT / "config/paper.toml").read_text())["obstacle"]


def test_the_folder_holds_what_the_readme_says(flown):
    for name in ("summary.json", "trajectory.parquet", "flight.tlog", "report.html"):
        assert (flown.folder / name).stat().st_size > 1000
    figures = {path.suffix for path in (flown.folder / "figures").iterdir()}
    assert figures == {".svg", ".png"}
    assert not list(flown.folder.rglob("*.tmp"))


def test_every_vehicle_reports_ten_times_a_second_for_the_whole_flight(flown, tracks):
    assert sorted(tracks) == [1, 2, 3, 4, 5]
    for track in tracks.values():
        assert sorted(track) == list(range(0, 42_001, 100))


def test_the_smallest_separation_is_that_of_the_log(flown, tracks):
    least_m, whose = math.inf, None
    for one, other in itertools.combinations(sorted(tracks), 2):
        for time, at in tracks[one].items():
            there = tracks[other][time]
            distance_m = math.dist((at.x_m, at.y_m), (there.x_m, there.y_m))
            if distance_m < least_m:
                closing_mps = math.dist(tlog.velocity(at), tlog.velocity(there))
                least_m, whose = distance_m, (one, other)
    # Between samples vehicles come nearer than at them, by no more than they close in on each other.
    summary = flown.summary
    assert 0 <= least_m - summary["min_separation_m"] + 1e-4 <= closing_mps * NEAREST_S + 1e-3
    assert list(whose) == summary["min_separation_vehicles"]


def test_the_smallest_clearance_is_that_of_the_log(flown, tracks, obstacles):
    def clearance_m(at):
        return min(math.dist((at.x_m, at.y_m), (o["x_m"], o["y_m"])) - o["radius_m"] for o in obstacles)

    least_m, vehicle, at = min(
        (clearance_m(at), vehicle, at.t_s) for vehicle, track in tracks.items() for at in track.values()
    )
    summary = flown.summary
    assert 0 <= least_m - summary["min_clearance_m"] + 1e-4 <= 15 * NEAREST_S
    assert vehicle == summary["min_clearance_vehicle"]
    assert at == pytest.approx(summary["min_clearance_at_s"], abs=2 * NEAREST_S)


def test_the_flight_is_without_collision_and_over_the_field(flown):
    summary = flown.summary
    assert summary["success"] and summary["completed"] and not summary["interrupted"]
    assert (summary["obstacle_collisions"], summary["vehicle_collisions"]) == (0, 0)
    assert summary["passed_last_obstacle"] == summary["vehicles"] == 5
    assert summary["duration_s"] == 42


def test_the_trajectory_has_its_columns_and_every_tick(flown):
    table = pyarrow.parquet.read_table(flown.folder / "trajectory.parquet")
    assert table.column_names == COLUMNS
    assert table["vehicle"].to_pylist() == [1, 2, 3, 4, 5] * 85
    assert table["t_s"].to_pylist() == [0.5 * tick for tick in range(85) for _ in range(5)]
    assert all(table[name].null_count == 0 for name in COLUMNS)


def test_the_trajectory_is_the_log_at_every_tick(flown, tracks):
    for row in flown.trajectory:
        at = tracks[row["vehicle"]][round(1000 * row["t_s"])]
        # Positions and climb are the very numbers of the wire; speed and course are made of its velocity.
        assert (row["x_m"], row["y_m"], row["altitude_m"], row["climb_mps"]) == (
            at.x_m,
            at.y_m,
            at.altitude_m,
            at.climb_mps,
        )
        assert (row["speed_mps"], row["course_rad"]) == pytest.approx((at.speed_mps, at.course_rad), abs=1e-9)


def test_the_setpoints_are_those_of_the_log(flown):
    stamped = {
        (message.target_system, message.time_boot_ms): message
        for message in tlog.messages(flown.tlog)
        if message.get_type() == "SET_POSITION_TARGET_LOCAL_NED" and message.get_srcSystem() == tlog.GROUND
    }
    rows = [row for row in flown.trajectory if row["t_s"] < 42]
    assert len(stamped) == len(rows) == 84 * 5
    for row in rows:
        sent = stamped[row["vehicle"], round(1000 * row["t_s"])]
        speed_mps, course_rad = row["speed_setpoint_mps"], row["course_setpoint_rad"]
        velocity = speed_mps * math.cos(course_rad), speed_mps * math.sin(course_rad)
        assert (sent.vx, sent.vy, -sent.z) == pytest.approx((*velocity, row["altitude_setpoint_m"]), abs=1e-4)


def test_the_log_runs_forward_in_simulated_time(flown):
    times = [message._timestamp for message in tlog.messages(flown.tlog)]
    assert times == sorted(times)
    assert times[-1] - times[0] == pytest.approx(42, abs=0.5)
