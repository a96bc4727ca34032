"""USER_1 with param 1 = 1: one vehicle as it was when the program started, without a restart."""

from ground import ACCEPTED, GUIDED, LOITER, UNSUPPORTED
from pymavlink.dialects.v20 import ardupilotmega as mavlink
from test_parameters import read, write


def reset(craft, keeps=0):
    return craft.command_int(mavlink.MAV_CMD_USER_1, 1, keeps)


def test_one_vehicle_is_reset_and_the_other_flies_on(start_vehicles, scenario):
    one, other = start_vehicles(scenario(2), "--speed", 5).connect()
    start = one.sample()
    write(one, "WP_LOITER_RAD", 33)
    one.command_int(mavlink.MAV_CMD_DO_SET_MODE, 1, LOITER)
    before = one.samples(10)[-1]
    assert reset(one) == ACCEPTED
    assert one.text().text == "Reset to the start"
    after = one.sample()
    assert after.t_s >= before.t_s and abs(after.x_m - start.x_m) < 20 and abs(after.y_m - start.y_m) < 1
    assert (one.mode(), read(one, "WP_LOITER_RAD").param_value) == (GUIDED, 60)
    while (seen := other.sample()).t_s < after.t_s:
        pass  # what came meanwhile
    assert seen.x_m > 100


def test_the_state_folder_follows_and_param_2_keeps(start_vehicles, scenario, tmp_path):
    craft = start_vehicles(scenario(), "--state-folder", tmp_path).connect()[0]
    kept = tmp_path / "vehicle-1.parm"
    write(craft, "RTL_RADIUS", 44)
    assert kept.read_text() == "RTL_RADIUS 44\n"
    assert reset(craft, keeps=1) == ACCEPTED
    assert read(craft, "RTL_RADIUS").param_value == 44
    assert kept.read_text() == "RTL_RADIUS 44\n"
    assert reset(craft) == ACCEPTED
    assert read(craft, "RTL_RADIUS").param_value == 0
    assert kept.read_text() == ""


def test_any_other_param_is_unsupported_as_by_an_arduplane(craft):
    assert craft.command_int(mavlink.MAV_CMD_USER_1) == UNSUPPORTED
