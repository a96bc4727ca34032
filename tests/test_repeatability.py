"""The same seed gives the same flight, byte by byte, however it is flown."""

import multiprocessing

import pytest


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
