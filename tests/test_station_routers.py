"""Flights of the ground station through other people's routers."""

import pytest
from conftest import free_port
from routers import ROUTERS, router
from test_station import field, start_fly  # noqa: F401


@pytest.mark.parametrize("name", ROUTERS)
def test_a_flight_through_a_router(start_fly, start_vehicles, field, tmp_path, name):
    scenario, vehicles_port, ground_port = field(count=2, duration_s=8), free_port(), free_port()
    with router(name, tmp_path, vehicles_port, ground_port):
        start_vehicles(scenario, "--per-port", 2, ground_port=vehicles_port)
        run = start_fly(scenario, "--link", f"udpin:127.0.0.1:{ground_port}").end()
        assert run.status == 0, run.errors
        assert run.summary["success"] and run.summary["link"]["lost"] == 0
        assert [vehicle["mode"] for vehicle in run.summary["station"]["vehicles"]] == ["LOITER"] * 2
