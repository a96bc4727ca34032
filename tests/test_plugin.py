"""The pytest plugin of tests/plugin, as somebody's tests use it."""

import subprocess
import sys

import pytest
from conftest import PROJECT
from pytest_columba import Fleet

THEIRS = """
def test_three_answer(columba_vehicles):
    vehicles = columba_vehicles(3)
    assert sorted(vehicle.system_id for vehicle in vehicles) == [1, 2, 3]
    assert len({vehicle.address for vehicle in vehicles}) == 3
    for vehicle in vehicles:
        position = vehicle.link.recv_match(type="LOCAL_POSITION_NED", blocking=True, timeout=5)
        assert position.get_srcSystem() == vehicle.link.target_system == vehicle.system_id


def test_two_fleets_are_apart(columba_vehicles):
    one, other = columba_vehicles(), columba_vehicles(2, "--speed", 5)
    assert one[0].address not in [vehicle.address for vehicle in other]


def test_a_fleet_starts_anew(columba_fleet):
    fleet = columba_fleet(2)
    before = fleet.process.pid
    vehicles = fleet.restart()
    assert fleet.process.pid != before and [vehicle.row for vehicle in vehicles] == fleet.rows


def test_a_group_is_ready(columba_vehicles):
    third = columba_vehicles(3, "--per-port", 3)[2]
    assert third.link.target_system == third.system_id == 3


def test_that_fails(columba_vehicles):
    columba_vehicles(1)
    assert False, "on purpose"
"""


def readme():
    """The tests of the plugin's own page."""
    page = (PROJECT / "tests/plugin/README.md").read_text()
    return page.split("```python\n")[1].split("```")[0]


def test_tests_of_somebody_else_have_vehicles(program, tmp_path):
    (tmp_path / "conftest.py").write_text('pytest_plugins = ["pytest_columba"]\n')
    (tmp_path / "pytest_columba.py").write_bytes((PROJECT / "tests/plugin/pytest_columba.py").read_bytes())
    (tmp_path / "test_theirs.py").write_text(THEIRS)
    (tmp_path / "test_readme.py").write_text(readme())
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", tmp_path],
        env={"COLUMBA_BIN": str(program), "PATH": "/usr/bin:/bin", "PYTHONPATH": str(tmp_path)},
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert "6 passed" in done.stdout and "1 failed" in done.stdout and "error" not in done.stdout, done.stdout


def test_why_vehicles_did_not_start_is_told(program):
    with pytest.raises(RuntimeError, match="status 2: columba: nowhere.toml: file not found"):
        Fleet(program, "nowhere.toml")
