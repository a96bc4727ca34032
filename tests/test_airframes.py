"""Airframes: what vehicles fly like, and how parameters follow."""

import subprocess
import time

import pytest
from ground import FAILED
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from test_parameters import read, write

ACCEPTED = mavlink.MAV_RESULT_ACCEPTED
NAMES = ["AIRSPEED_MIN", "AIRSPEED_CRUISE", "AIRSPEED_MAX", "TECS_CLMB_MAX", "TECS_SINK_MAX", "WP_LOITER_RAD"]
PX4_NAMES = ["FW_AIRSPD_MIN", "FW_AIRSPD_TRIM", "FW_AIRSPD_MAX", "FW_T_CLMB_MAX", "FW_T_SINK_MAX", "NAV_LOITER_RAD"]


def values(craft, names=NAMES):
    return [round(read(craft, name).param_value, 3) for name in names]


def test_vehicles_of_a_count_are_stock_planes(start_vehicles):
    craft = start_vehicles("--count", 1).connect()[0]
    assert values(craft) == [10, 22, 30, 5, 5, 80]
    assert round(read(craft, "ROLL_LIMIT_DEG").param_value) == 65
    assert abs(craft.sample().speed_mps - 22) < 0.1
    assert craft.change_speed(28) == ACCEPTED
    assert craft.change_speed(31) == FAILED


def test_a_stock_px4_plane_has_its_own_speeds(start_vehicles):
    craft = start_vehicles("--count", 1, "--personality", "px4").connect()[0]
    assert values(craft, PX4_NAMES) == [10, 15, 20, 3, 2, 80]
    assert abs(craft.sample().speed_mps - 15) < 0.1


def test_the_papers_five_and_scenarios_stay_as_they_are(start_vehicles, scenario):
    for vehicles in (start_vehicles(), start_vehicles(scenario()), start_vehicles("--count", 2, "--airframe", "paper")):
        craft = vehicles.connect()[0]
        assert values(craft)[:1] + values(craft)[2:] == [5, 15, 6, 6, 60]


def test_the_papers_five_fly_as_planes_when_told(start_vehicles):
    vehicles = start_vehicles("--airframe", "plane")
    assert [row["speed_mps"] for row in vehicles.rows] == [22] * 5


def test_a_file_of_ones_own(start_vehicles, tmp_path):
    path = tmp_path / "glider.toml"
    path.write_text("[airframe]\ncruise_speed_mps = 16\nspeed_min_mps = 9\nspeed_max_mps = 24\nloiter_radius_m = 55\n")
    craft = start_vehicles("--count", 1, "--airframe", path).connect()[0]
    assert values(craft) == [9, 16, 24, 5, 5, 55]


def test_a_table_in_a_scenario_which_dynamics_changes(start_vehicles, scenario):
    path = scenario()
    path.write_text(
        'airframe = { base = "plane", speed_max_mps = 40 }\n' + path.read_text() + "\n[dynamics]\nspeed_min_mps = 8\n"
    )
    craft = start_vehicles(path).connect()[0]
    assert values(craft) == [8, 22, 40, 5, 5, 80]


def test_it_cruises_within_limits_that_a_scenario_narrows(start_vehicles, scenario, program):
    path = scenario()
    narrow = 'airframe = "plane"\n' + path.read_text() + "\n[dynamics]\nspeed_min_mps = 8\nspeed_max_mps = 12\n"
    path.write_text(narrow)
    assert values(start_vehicles(path).connect()[0])[:3] == [8, 12, 12]
    path.write_text(narrow.replace("[autopilot]\n", "[autopilot]\ncruise_speed_mps = 22\n"))
    refused = subprocess.run([program, "vehicles", path], capture_output=True, text=True, timeout=30)
    assert refused.returncode == 2 and "must be a number from 8 to 12" in refused.stderr


def test_a_parameter_file_says_which_plane_it_is(start_vehicles, tmp_path):
    path = tmp_path / "jet.parm"
    path.write_text("AIRSPEED_MIN 25\nAIRSPEED_MAX 80\nAIRSPEED_CRUISE 40\nTECS_CLMB_MAX 12\nROLL_LIMIT_DEG 70\n")
    craft = start_vehicles("--count", 1, "--defaults", path).connect()[0]
    assert values(craft)[:4] == [25, 40, 80, 12]
    assert abs(craft.sample().speed_mps - 40) < 0.1
    assert craft.change_speed(79) == ACCEPTED


def test_climb_follows_its_parameter(start_vehicles):
    craft = start_vehicles("--count", 1, "--speed", 5).connect()[0]
    assert write(craft, "TECS_CLMB_MAX", 2).param_value == 2
    assert craft.change_altitude(150) == ACCEPTED
    climbs = [sample.climb_mps for sample in craft.samples(10)]
    assert 1.9 < max(climbs) < 2.01


@pytest.mark.parametrize(
    ("airframe", "words"),
    [
        (
            "plan",
            'airframe "plan": file not found: must be "paper", "plane", "px4-plane" or a file with a table [airframe]',
        ),
        ("[airframe]\nspeed = 3\n", ":2: "),
        ('[airframe]\nbase = "jet"\n', 'airframe.base = "jet": must be "paper", "plane", "px4-plane"'),
    ],
)
def test_what_is_wrong_with_an_airframe_is_told(program, tmp_path, airframe, words):
    if airframe.startswith("["):
        path = tmp_path / "own.toml"
        path.write_text(airframe)
        airframe = str(path)
    done = subprocess.run(
        [program, "vehicles", "--count", "1", "--airframe", airframe], capture_output=True, text=True, timeout=20
    )
    assert done.returncode == 2
    assert words in done.stderr, done.stderr


def test_the_clock_of_all_vehicles_follows_sim_speedup(start_vehicles):
    one, other = start_vehicles("--count", 2).connect()
    assert read(one, "SIM_SPEEDUP").param_value == 1
    assert write(one, "SIM_SPEEDUP", 20).param_value == 20
    assert read(other, "SIM_SPEEDUP").param_value == 20
    began, first = time.monotonic(), other.sample().t_s
    while other.sample().t_s < first + 40:
        pass
    # Forty seconds of the vehicle would take forty of the clock.
    assert time.monotonic() - began < 20
    while one.link.recv_match():
        pass  # what it has not read yet leaves no room for an answer
    assert write(one, "SIM_SPEEDUP", 500).param_value == 20
    assert one.text().text == "SIM_SPEEDUP 500 is outside [0.01, 100]"
