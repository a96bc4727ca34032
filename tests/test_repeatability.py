"""The same seed gives the same flight, byte by byte, however it is flown."""

import multiprocessing

import pytest
from conftest import PROJECT


@pytest.mark.parametrize(
    "options",
    [
        [],
        ["--threads", 1],
        ["--threads", 2],
        ["--transport", "memory"],
        ["--transport", "memory", "--threads", 2],
        ["--loss", 0.2],
    ],
    ids=["again", "one thread", "two threads", "in memory", "in memory on two threads", "a fifth lost each way"],
)
def test_the_trajectory_is_the_same(fly, flown, options):
    run = fly("run", "--seed", 7, *options)
    assert run.status == 0, run.errors
    assert run.trajectory_bytes == flown.trajectory_bytes
    judged = ["min_separation_m", "min_clearance_m", "separation_losses", "speed_convergence_s", "course_convergence_s"]
    assert {name: run.summary[name] for name in judged} == {name: flown.summary[name] for name in judged}


def test_the_loss_was_real(fly):
    link = fly("run", "--seed", 7, "--duration", 5, "--loss", 0.2).summary["link"]
    assert link["impairment_lost"] == pytest.approx(0.2 * (link["datagrams"] + link["datagrams_sent"]), rel=0.25)


def spin():
    while True:
        pass


def test_a_loaded_machine_changes_nothing(fly, flown):
    load = [multiprocessing.Process(target=spin, daemon=True) for _ in range(multiprocessing.cpu_count())]
    for process in load:
        process.start()
    try:
        run = fly("run", "--seed", 7, "--loss", 0.1)
    finally:
        for process in load:
            process.kill()
            process.join()
    assert run.status == 0, run.errors
    assert run.trajectory_bytes == flown.trajectory_bytes


def test_another_seed_is_another_flight(fly, flown):
    assert fly("run", "--seed", 8, "--transport", "memory").trajectory_bytes != flown.trajectory_bytes


def test_wind_and_gusts_repeat_too_however_it_is_flown(fly, tmp_path):
    windy = tmp_path / "windy.toml"
    air = "\n[parameters]\nSIM_WIND_SPD = 2.0\nSIM_WIND_DIR = 60\nSIM_WIND_TURB = 0.5\n"
    windy.write_text((PROJECT / "config/paper.toml").read_text() + air)
    first, again, memory = (fly("run", windy, *options) for options in ([], ["--loss", 0.2], ["--transport", "memory"]))
    assert first.status == 0, first.errors
    assert first.trajectory_bytes == again.trajectory_bytes == memory.trajectory_bytes
    assert first.summary["separation_losses"] == 0
    assert fly("run", windy, "--seed", 99, "--transport", "memory").trajectory_bytes != first.trajectory_bytes
