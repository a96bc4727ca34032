"""Parameters: listed, read, written, refused, kept over a restart; over a bad link, and of two hundred vehicles at
once."""

import math
import subprocess

import pytest
from ground import FAILED, connection
from lists import Lists
from pymavlink import mavutil
from pymavlink.dialects.v20 import ardupilotmega as mavlink

INT8, INT16, REAL32 = mavlink.MAV_PARAM_TYPE_INT8, mavlink.MAV_PARAM_TYPE_INT16, mavlink.MAV_PARAM_TYPE_REAL32
NO_INDEX = 65_535


def ask(craft, name, index=-1):
    craft.link.mav.param_request_read_send(craft.system, craft.component, name.encode(), index)


def read(craft, name):
    ask(craft, name)
    return craft.wait(["PARAM_VALUE"], lambda value: value.param_id == name)


def write(craft, name, value, kind=REAL32):
    craft.link.mav.param_set_send(craft.system, craft.component, name.encode(), value, kind)
    return craft.wait(["PARAM_VALUE"], lambda value: value.param_id == name)


def test_the_list_is_whole_and_typed_as_arduplanes(craft):
    lists = Lists(craft.link, [craft.system])
    lists.fetch()
    found = lists.found[craft.system]
    by_name = {value.param_id: value for value in found.values()}
    assert sorted(found) == list(range(len(by_name)))
    assert (by_name["MAV_SYSID"].param_value, by_name["MAV_SYSID"].param_type) == (craft.system, INT16)
    assert (by_name["WP_LOITER_RAD"].param_value, by_name["WP_LOITER_RAD"].param_type) == (60, INT16)
    assert (by_name["FS_GCS_ENABL"].param_value, by_name["FS_GCS_ENABL"].param_type) == (0, INT8)
    assert (by_name["AIRSPEED_MAX"].param_value, by_name["AIRSPEED_MAX"].param_type) == (15, REAL32)


def test_pymavlinks_own_client_fetches_and_sets(craft):
    craft.link.target_system, craft.link.target_component = craft.system, craft.component
    craft.link.param_fetch_all()
    craft.wait(["PARAM_VALUE"], lambda value: value.param_index == value.param_count - 1)
    assert craft.link.param("AIRSPEED_CRUISE") == 10
    craft.link.param_set_send("RTL_ALTITUDE", 80)
    assert craft.wait(["PARAM_VALUE"]).param_value == 80


def test_a_write_is_answered_and_acts(craft):
    value = write(craft, "AIRSPEED_MAX", 12)
    assert (value.param_value, value.param_index) == (12, NO_INDEX)
    assert craft.change_speed(13) == FAILED
    assert read(craft, "AIRSPEED_MAX").param_value == 12


def test_whole_numbers_are_cut_whatever_type_is_claimed(craft):
    assert write(craft, "WP_LOITER_RAD", 44.6, INT8).param_value == 44
    assert write(craft, "WP_LOITER_RAD", 50, 0).param_value == 50, "no such type: ArduPlane does not look"


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("AIRSPEED_MAX", 16, "AIRSPEED_MAX 16 is outside [10, 15]"),
        ("AIRSPEED_MAX", math.nan, "AIRSPEED_MAX is not a finite number"),
        ("WP_LOITER_RAD", math.inf, "WP_LOITER_RAD is not a finite number"),
        ("MAV_SYSID", 0, "MAV_SYSID 0 is outside [1, 250]"),
        ("STAT_RUNTIME", 7, "Param write denied (STAT_RUNTIME)"),
    ],
)
def test_a_bad_value_is_refused_in_words_and_answered_with_the_old_one(craft, name, value, words):
    before = read(craft, name).param_value
    assert write(craft, name, value).param_value == pytest.approx(before, abs=30 if name == "STAT_RUNTIME" else 0)
    assert craft.text().text == words


def test_a_name_that_it_does_not_have_is_refused(craft):
    ask(craft, "SYSID_THISMAV")
    assert craft.wait(["PARAM_ERROR"]).error == mavlink.MAV_PARAM_ERROR_DOES_NOT_EXIST
    assert craft.text().text == "No parameter SYSID_THISMAV: it is MAV_SYSID now"


def test_what_is_set_survives_a_restart_when_asked_for(start_vehicles, scenario, tmp_path):
    folder = tmp_path / "parameters"
    first = start_vehicles(scenario(count=2), "--params-folder", folder)
    write(first.connect()[1], "RTL_RADIUS", 70)
    first.stop()
    assert [path.name for path in folder.iterdir()] == ["vehicle-2.parm"]
    again = start_vehicles(scenario(count=2), "--params-folder", folder).connect()
    assert [read(craft, "RTL_RADIUS").param_value for craft in again] == [0, 70]


def test_a_file_of_nonsense_is_named(program, scenario, tmp_path, start_vehicles):
    (tmp_path / "vehicle-1.parm").write_text("RTL_RADIUS 70\nRTL_RADIUS wide\n")
    command = [program, "vehicles", scenario(), "--vehicle-port", 0, "--ground-port", 0, "--params-folder", tmp_path]
    done = subprocess.run([str(word) for word in command], stderr=subprocess.PIPE, text=True, timeout=30)
    assert done.returncode == 2
    assert 'vehicle-1.parm:2: expected NAME VALUE, found "RTL_RADIUS wide"' in done.stderr


def test_a_list_completes_over_a_link_that_loses_a_third_each_way(start_vehicles, scenario):
    row = start_vehicles(scenario(), "--loss", 0.3).rows[0]
    link = connection(row["address"])
    Lists(link, [row["system_id"]]).fetch()
    link.close()


@pytest.mark.parametrize("loss", [0, 0.3])
def test_two_hundred_vehicles_through_one_port(start_vehicles, loss):
    rows = start_vehicles("--count", 200, "--per-port", 200, "--loss", loss).rows
    link = connection(rows[0]["address"])
    lists = Lists(link, [row["system_id"] for row in rows])
    lists.fetch()
    link.close()
    names = [sorted(value.param_id for value in found.values()) for found in lists.found.values()]
    assert len(names) == 200 and all(name == names[0] for name in names)
    own = {
        system: value.param_value
        for system, found in lists.found.items()
        for value in found.values()
        if value.param_id == "MAV_SYSID"
    }
    assert own == {row["system_id"]: row["system_id"] for row in rows}


def test_two_hundred_vehicles_through_one_link(start_vehicles, scenario):
    vehicles = start_vehicles(scenario(count=200))
    hub = Hub([(row["host"], row["port"]) for row in vehicles.rows])
    lists = Lists(hub.link, [row["system_id"] for row in vehicles.rows])
    lists.fetch()
    hub.link.close()
    assert len(lists.found) == 200


class Hub:
    """One socket that sends everything to every vehicle whose system it is for, as a router does."""

    def __init__(self, addresses):
        self.link = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=255)
        self.addresses = dict(enumerate(addresses, start=1))
        self.link.write = self.write

    def write(self, datagram):
        self.link.port.sendto(datagram, self.addresses[self.link.target_system])
