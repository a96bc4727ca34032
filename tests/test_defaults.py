"""Parameter files: `columba vehicles --defaults`, as autopilots and ground stations write them."""

import json
import struct
import subprocess

import pytest
from conftest import PROJECT
from lists import Lists
from pymavlink import mavparm
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from test_parameters import read, write

# As a plane has them: more than the vehicles know, in no order, with what ArduPilot's own loader takes.
PLANE = """# a plane
THR_MIN 0
THR_MAX\t75
FLTMODE1,10
RC1_MIN=1000.000000
BRD_SERIAL_NUM 42 @READONLY
WP_LOITER_RAD 80  # m
MAV_SYSID 1
STAT_RUNTIME 1234
"""


@pytest.fixture
def parameter_file(tmp_path):
    def write_file(text, name="plane.parm"):
        path = tmp_path / name
        path.write_text(text)
        return path

    return write_file


def refusal(program, *options):
    done = subprocess.run([program, "vehicles", *map(str, options)], capture_output=True, text=True, timeout=60)
    assert done.returncode == 2
    return done.stderr


def test_a_client_lists_reads_and_sets_them(start_vehicles, scenario, parameter_file):
    craft = start_vehicles(scenario(), "--defaults", parameter_file(PLANE)).connect()[0]
    lists = Lists(craft.link, [craft.system])
    lists.fetch()
    found = lists.found[craft.system]
    by_name = {value.param_id: value.param_value for value in found.values()}
    assert sorted(found) == list(range(len(by_name))) and {value.param_count for value in found.values()} == {
        len(by_name)
    }
    assert (by_name["THR_MAX"], by_name["FLTMODE1"], by_name["RC1_MIN"], by_name["WP_LOITER_RAD"]) == (75, 10, 1000, 80)
    assert by_name["STAT_RUNTIME"] < 1000, "what the vehicle counts itself is its own"
    assert read(craft, "THR_MIN").param_value == 0
    # A whole number, as in an ArduPlane; in a file without types its name says so.
    assert write(craft, "THR_MIN", 12.5).param_value == 12
    kept = read(craft, "THR_MIN")
    assert (kept.param_value, kept.param_type) == (12, mavlink.MAV_PARAM_TYPE_INT8)
    assert read(craft, "RC1_MIN").param_type == mavlink.MAV_PARAM_TYPE_INT16
    write(craft, "BRD_SERIAL_NUM", 7)
    assert craft.text().text == "Param write denied (BRD_SERIAL_NUM)"


def test_what_the_vehicles_do_not_use_is_named_in_one_line(program, parameter_file):
    many = "".join(f"SERVO{index}_MIN 1000\n" for index in range(1, 13))
    options = ["--defaults", str(parameter_file(many)), "--vehicle-port", "0", "--ground-port", "0", "--json"]
    with subprocess.Popen(
        [program, "vehicles", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as running:
        running.stdout.readline()
        running.terminate()
        errors = running.stderr.read()
    names = ", ".join(f"SERVO{index}_MIN" for index in range(1, 9))
    assert errors == f"columba: kept for clients and not used by the vehicles: {names} and 4 more\n"


def listed(craft):
    lists = Lists(craft.link, [craft.system])
    lists.fetch()
    found = lists.found[craft.system]
    assert sorted(found) == list(range(len(found))) and {value.param_count for value in found.values()} == {len(found)}
    by_name = {value.param_id: value for value in found.values()}
    assert len(by_name) == len(found), "each once"
    return by_name


def recorded(autopilot, file="stock.params"):
    """Names, values and types of the stock autopilot, as they were recorded."""
    path = PROJECT / "crates/sim-vehicle/src/firmware" / autopilot / file
    rows = [line.split("\t") for line in path.read_text().splitlines() if not line.startswith("#")]
    return {name: (float(value), int(kind)) for _, _, name, value, kind in rows}


@pytest.mark.parametrize("how", [("--ports", "ardupilot"), ("--stock-parameters",)])
def test_an_arduplane_has_all_parameters_of_the_real_one(start_vehicles, how):
    craft = start_vehicles("--count", 1, *how, ground_port=0).connect()[0]
    found, real = listed(craft), recorded("arduplane")
    assert len(real) == 1401 and not set(real) - set(found)
    own = set(listed(start_vehicles("--count", 1, ground_port=0).connect()[0]))
    for name in set(real) - own:
        assert (found[name].param_value, found[name].param_type) == (pytest.approx(real[name][0]), real[name][1]), name
    assert {"THR_MIN", "RC1_MIN", "GPS_AUTO_SWITCH", "BATT2_MONITOR"} <= set(real) - own
    assert write(craft, "GPS_AUTO_SWITCH", 2).param_value == 2
    assert write(craft, "THR_MIN", 300).param_value == 127, "as much as the type has room for"
    assert [read(craft, name).param_value for name in ("GPS_AUTO_SWITCH", "THR_MIN")] == [2, 127]


def test_an_arduplane_has_parameters_that_it_does_not_list(start_vehicles, parameter_file):
    """Those of what is switched off: a client that knows a name reads and sets it."""
    options = ("--ports", "ardupilot", "--defaults", parameter_file("RNGFND1_MIN 2\n"))
    craft = start_vehicles("--count", 1, *options, ground_port=0).connect()[0]
    found, unlisted = listed(craft), recorded("arduplane", "unlisted.params")
    assert len(unlisted) == 1683
    assert set(unlisted) & set(found) == {"RNGFND1_MIN"}, "a file's are listed"
    for name in ("OSD1_ALTITUDE_EN", "BATT2_CAPACITY", "CHUTE_ALT_MIN", "RNGFND2_MIN"):
        answer = read(craft, name)
        assert (answer.param_value, answer.param_type) == (pytest.approx(unlisted[name][0]), unlisted[name][1])
        assert (answer.param_index, answer.param_count) == (65535, len(found))
    assert read(craft, "RNGFND1_MIN").param_value == 2
    assert write(craft, "OSD1_ALTITUDE_EN", 1).param_value == 1
    assert read(craft, "OSD1_ALTITUDE_EN").param_value == 1
    assert set(listed(craft)) == set(found)


def test_a_px4_has_all_parameters_of_the_real_one(start_vehicles):
    craft = start_vehicles("--count", 1, "--stock-parameters", "--personality", "px4", ground_port=0).connect()[0]
    found, real = listed(craft), recorded("px4")
    assert len(real) == 972 and not set(real) - set(found)
    own = set(listed(start_vehicles("--count", 1, "--personality", "px4", ground_port=0).connect()[0]))
    for name in set(real) - own:
        value, kind = found[name].param_value, found[name].param_type
        if kind == mavlink.MAV_PARAM_TYPE_INT32:
            # The bytes of an integer may be those of no number.
            value = struct.unpack("<i", struct.pack("<f", value))[0]
        assert (value, kind) == (pytest.approx(real[name][0]), real[name][1]), name
    before = read(craft, "_HASH_CHECK")
    craft.link.mav.param_set_send(craft.system, 1, b"FW_P_TC", 0.5, mavlink.MAV_PARAM_TYPE_REAL32)
    craft.wait(["PARAM_VALUE"], lambda value: value.param_id == "FW_P_TC" and value.param_value == 0.5)
    after = read(craft, "_HASH_CHECK")
    bits = [struct.pack("<f", value.param_value) for value in (before, after)]
    assert bits[0] != bits[1] and before.param_count == after.param_count == len(found)


def test_the_table_counts_the_parameters_that_are_not_used_and_files_are_named_as_ever(program, parameter_file):
    options = ["--count", "1", "--vehicle-port", "0", "--ground-port", "0", "--json", "--stock-parameters"]
    options += ["--defaults", str(parameter_file("THR_MIN 3\nRTL_RADIUS 70\n")), "--param", "THR_MAX=90"]
    with subprocess.Popen(
        [program, "vehicles", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as running:
        table = json.loads(running.stdout.readline())
        running.terminate()
        errors = running.stderr.read()
    assert errors == "columba: kept for clients and not used by the vehicles: THR_MIN, THR_MAX\n"
    assert 1250 < table["vehicles"][0]["inert_parameters"] < 1401
    assert "there is no real autopilot" in refusal(program, "--stock-parameters", "--personality", "generic")


def test_older_names_are_taken_over_as_arduplane_does_and_named(program, start_vehicles, scenario, parameter_file):
    older = parameter_file(
        "TRIM_ARSPD_CM 1250\nALT_HOLD_RTL 8000\nRST_SWITCH_CH 7\nSYSID_MYGCS 254\nSR0_EXTRA1 4\n", "older.parm"
    )
    craft = start_vehicles(scenario(), "--defaults", older).connect()[0]
    expected = {"AIRSPEED_CRUISE": 12.5, "RTL_ALTITUDE": 80, "RC7_OPTION": 96, "MAV_GCS_SYSID": 254}
    assert {name: read(craft, name).param_value for name in expected} == expected
    craft.link.mav.param_request_read_send(craft.system, 1, b"TRIM_ARSPD_CM", -1)
    assert craft.text().text == "No parameter TRIM_ARSPD_CM: it is AIRSPEED_CRUISE now"
    options = ["--airframe", "plane", "--defaults", str(older), "--vehicle-port", "0", "--ground-port", "0", "--json"]
    with subprocess.Popen(
        [program, "vehicles", *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as running:
        running.stdout.readline()
        running.terminate()
        errors = running.stderr.read()
    assert errors == (
        "columba: older names, taken over: TRIM_ARSPD_CM (AIRSPEED_CRUISE), ALT_HOLD_RTL (RTL_ALTITUDE), "
        "RST_SWITCH_CH (RC7_OPTION), SYSID_MYGCS (MAV_GCS_SYSID)\n"
        "columba: older names, not taken over: SR0_EXTRA1 (MAV1_EXTRA1)\n"
    )


def test_several_vehicles_keep_their_own_system_ids(start_vehicles, scenario, parameter_file):
    vehicles = start_vehicles(scenario(2), "--defaults", parameter_file(PLANE))
    assert [row["system_id"] for row in vehicles.rows] == [1, 2]
    second = vehicles.connect()[1]
    write(second, "THR_MAX", 50)
    assert [read(craft, "THR_MAX").param_value for craft in vehicles.connect()] == [75, 50]


def test_the_last_file_and_the_flag_go_before(start_vehicles, scenario, parameter_file):
    first = parameter_file("RTL_RADIUS 70\nTHR_MIN 1\nTHR_MAX 75\n", "first.parm")
    second = parameter_file("@include third.parm\nRTL_RADIUS 71\n", "second.parm")
    parameter_file("THR_MIN 3\n", "third.parm")
    options = ["--defaults", first, "--defaults", second, "--param", "THR_MAX=60", "--param", "WP_LOITER_RAD=90"]
    craft = start_vehicles(scenario(), *options).connect()[0]
    names = ["RTL_RADIUS", "THR_MIN", "THR_MAX", "WP_LOITER_RAD"]
    assert [read(craft, name).param_value for name in names] == [71, 3, 60, 90]


def test_a_scenario_names_files_beside_it(start_vehicles, scenario, parameter_file):
    parameter_file("THR_MIN 4\nRTL_RADIUS 72\n", "own.parm")
    path = scenario()
    path.write_text(path.read_text() + '\n[parameters]\nfiles = ["own.parm"]\nRTL_RADIUS = 73\n')
    craft = start_vehicles(path).connect()[0]
    assert [read(craft, name).param_value for name in ("THR_MIN", "RTL_RADIUS")] == [4, 73]


def test_a_px4_has_qgroundcontrols_file_with_its_types(start_vehicles, scenario, parameter_file):
    text = (
        "# Onboard parameters\n1\t1\tCAL_ACC0_ID\t16777217\t6\n1\t1\tFW_P_TC\t0.400000005960464478\t9\n"
        "1\t1\tNAV_LOITER_RAD\t90.0\t9\n"
    )
    craft = start_vehicles(scenario(personality="px4"), "--defaults", parameter_file(text, "px4.params")).connect()[0]
    whole = read(craft, "CAL_ACC0_ID")
    assert (struct.pack("<f", whole.param_value), whole.param_type) == (
        struct.pack("<i", 16777217),
        mavlink.MAV_PARAM_TYPE_INT32,
    )
    real = read(craft, "FW_P_TC")
    assert (real.param_value, real.param_type) == (pytest.approx(0.4), mavlink.MAV_PARAM_TYPE_REAL32)
    assert read(craft, "NAV_LOITER_RAD").param_value == 90


def test_what_is_set_survives_in_the_state_folder(start_vehicles, scenario, parameter_file, tmp_path):
    folder, path = tmp_path / "state", parameter_file(PLANE)
    vehicles = start_vehicles(scenario(), "--defaults", path, "--state-folder", folder)
    craft = vehicles.connect()[0]
    write(craft, "THR_MIN", 8)
    vehicles.stop()
    assert (folder / "vehicle-1.parm").read_text() == "THR_MIN 8\n"
    craft = start_vehicles(scenario(), "--defaults", path, "--state-folder", folder).connect()[0]
    assert [read(craft, name).param_value for name in ("THR_MIN", "THR_MAX")] == [8, 75]


def test_faults_are_told_by_file_and_line(program, parameter_file, tmp_path):
    bad = parameter_file("THR_MIN 0\nWP_RADIUS 0\nAIRSPEED_MAX 99\n", "bad.parm")
    errors = refusal(program, "--defaults", bad)
    assert f"{bad}:2: WP_RADIUS = 0: must be a number from 1 to 32767\n" in errors
    assert f"{bad}:3: AIRSPEED_MAX = 99: must be a number from " in errors
    assert f'{bad}:1: expected NAME VALUE, found "THR_MIN none"' in refusal(
        program, "--defaults", parameter_file("THR_MIN none\n", "bad.parm")
    )
    missing = tmp_path / "none.parm"
    assert f"{missing}: file not found" in refusal(program, "--defaults", missing)
    assert "--param THR_MIN=3: must be the name of a parameter that the vehicle has" in refusal(
        program, "--param", "THR_MIN=3"
    )
    state = tmp_path / "state"
    state.mkdir()
    (state / "vehicle-1.parm").write_text("# hand-made\nTHR_MIN 3\n")
    assert f"{state}/vehicle-1.parm:2: No parameter THR_MIN" in refusal(
        program, "--state-folder", state, "--vehicle-port", 0, "--ground-port", 0
    )


def test_mavutil_loads_and_saves_what_it_reads(start_vehicles, scenario, parameter_file, tmp_path):
    """pymavlink's own files, there and back."""
    craft = start_vehicles(scenario(), "--defaults", parameter_file(PLANE)).connect()[0]
    lists = Lists(craft.link, [craft.system])
    lists.fetch()
    saved = mavparm.MAVParmDict()
    for value in lists.found[craft.system].values():
        saved[value.param_id] = value.param_value
    saved.save(str(tmp_path / "saved.parm"))
    again = start_vehicles(scenario(), "--defaults", tmp_path / "saved.parm").connect()[0]
    assert [read(again, name).param_value for name in ("THR_MAX", "WP_LOITER_RAD")] == [75, 80]
