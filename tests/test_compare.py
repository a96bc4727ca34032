"""`columba compare`: the same results on any number of threads and after any interruption, and those of single
flights."""

import json
import re
import signal
import subprocess
import time

import pyarrow.parquet
import pytest
from conftest import PROJECT, RUN_PATIENCE_S

CONTENDERS = """
[[contender]]
name = "MSLPIO"

[[contender]]
name = "MPIO, near"
[contender.look_ahead]
horizon_s = 1.5
[contender.optimizer]
algorithm = "mpio"
"""
REPEATED = ["flights.parquet", "table.md", "table.json"]
WALL_TIMES = {"solve_us_p50", "solve_us_p99", "wall_s", "real_time_factor"}


@pytest.fixture(scope="module")
def contenders(tmp_path_factory):
    path = tmp_path_factory.mktemp("contenders") / "few.toml"
    path.write_text(CONTENDERS)
    return path


@pytest.fixture(scope="module")
def command(program, contenders):
    """The words of a comparison into a folder: two contenders, the paper's flight, some seeds."""

    def words(folder, *options, seeds="1..6"):
        given = [program, "compare", "--contenders", contenders, "--seeds", seeds, "--out", folder, *options]
        return [str(word) for word in given]

    return words


def compare(words, status=0):
    done = subprocess.run(words, capture_output=True, text=True, timeout=RUN_PATIENCE_S)
    assert done.returncode == status, done.stderr
    return done


@pytest.fixture(scope="module")
def compared(command, tmp_path_factory):
    """A comparison on one thread."""
    folder = tmp_path_factory.mktemp("compared")
    compare(command(folder, "--threads", 1))
    return folder


def rows(folder, name="flights.parquet"):
    return pyarrow.parquet.read_table(folder / name).to_pylist()


def names(value):
    """Every name in a JSON value, but for those of figures, which flights.parquet has as well."""
    if isinstance(value, list):
        return set().union(*map(names, value))
    if isinstance(value, dict):
        return set(value) | set().union(
            *(names(inner) for name, inner in value.items() if name not in ("medians", "paper"))
        )
    return set()


def test_every_column_and_every_name_is_explained(compared):
    explained = (PROJECT / "docs/compare.md").read_text()
    columns = set(rows(compared)[0]) | set(rows(compared, "timings.parquet")[0])
    table = json.loads((compared / "table.json").read_text())
    missing = [name for name in columns | names(table) - {"version"} if f"`{name}`" not in explained]
    assert not missing


def test_the_contenders_of_the_documentation_fly(program, tmp_path):
    (text,) = re.findall(r"```toml\n(.*?)```", (PROJECT / "docs/compare.md").read_text(), re.DOTALL)
    path = tmp_path / "settings.toml"
    path.write_text(text)
    compare([str(program), "compare", "--contenders", str(path), "--seeds", "2", "--out", str(tmp_path / "out")])
    assert [row["contender"] for row in rows(tmp_path / "out")[::2]] == re.findall(r'name = "(.*)"', text)


def test_two_threads_write_the_same_bytes(command, compared, tmp_path):
    compare(command(tmp_path, "--threads", 2))
    for name in REPEATED:
        assert (tmp_path / name).read_bytes() == (compared / name).read_bytes(), name


def test_rows_are_in_the_order_of_contenders_and_seeds(compared):
    flights, timings = rows(compared), rows(compared, "timings.parquet")
    order = [(name, seed) for name in ("MSLPIO", "MPIO, near") for seed in range(1, 7)]
    for table in (flights, timings):
        assert [(row["contender"], row["seed"]) for row in table] == order
        assert {row["scenario"] for row in table} == {"paper"}
    assert not WALL_TIMES & flights[0].keys()
    assert all(row["solve_us_p50"] > 0 and row["solve_us_p99"] > 0 and row["wall_s"] > 0 for row in timings)


def test_a_row_is_the_flight_that_run_flies(fly, compared):
    run = fly("run", "--transport", "memory", "--seed", 4)
    (row,) = [row for row in rows(compared) if row["seed"] == 4 and row["contender"] == "MSLPIO"]
    summary = run.summary
    shared = (summary.keys() & row.keys()) - WALL_TIMES
    assert {"success", "speed_convergence_s", "min_separation_m", "min_clearance_m", "flock_radius_m"} <= shared
    assert {name: row[name] for name in shared} == {name: summary[name] for name in shared}
    assert [row["min_separation_vehicle_a"], row["min_separation_vehicle_b"]] == summary["min_separation_vehicles"]


def test_the_table_sums_up_the_rows(compared):
    flights = [row for row in rows(compared) if row["contender"] == "MPIO, near"]
    table = json.loads((compared / "table.json").read_text())
    (standing,) = [each for each in table["scenarios"][0]["contenders"] if each["contender"] == "MPIO, near"]
    assert standing["flights"] == len(flights) == 6
    assert standing["successes"] == sum(row["success"] for row in flights)
    assert standing["least_separation_m"] == min(row["min_separation_m"] for row in flights)
    radii = sorted(row["flock_radius_m"] for row in flights)
    # Of six values the 95 % interval of the median is all of them.
    expected = {"median": pytest.approx((radii[2] + radii[3]) / 2), "interval_95": [radii[0], radii[5]]}
    assert standing["medians"]["flock_radius_m"] == expected
    assert standing["paper"] == {"speed_convergence_s": "never", "course_convergence_s": 35.15}


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGKILL], ids=["ctrl-c", "killed"])
def test_an_interrupted_comparison_goes_on_and_ends_the_same(command, tmp_path, sign):
    seeds = "1..30"
    whole, halves = tmp_path / "whole", tmp_path / "halves"
    compare(command(whole, seeds=seeds))

    process = subprocess.Popen(command(halves, "--threads", 1, seeds=seeds), stderr=subprocess.PIPE, text=True)
    journal = halves / "journal.jsonl"
    wait_until(lambda: journal.exists() and journal.read_bytes().count(b"\n") >= 5)
    process.send_signal(sign)
    _, errors = process.communicate(timeout=RUN_PATIENCE_S)
    flown = journal.read_bytes()
    count = flown.count(b"\n")
    assert 5 <= count < 60
    assert not (halves / "flights.parquet").exists()
    if sign == signal.SIGINT:
        assert process.returncode == 1
        assert f"{count} of 60 flights" in errors and "goes on from there" in errors

    said = compare(command(halves, seeds=seeds)).stdout
    assert f"{count} of 60 are in" in said
    after = journal.read_bytes()
    assert after.startswith(flown)
    keys = [json.loads(line)["key"] for line in after.splitlines() if line.endswith(b"}")]
    assert len(keys) == len(set(keys)) == 60
    for name in REPEATED:
        assert (halves / name).read_bytes() == (whole / name).read_bytes(), name


def wait_until(holds):
    deadline = time.monotonic() + RUN_PATIENCE_S
    while not holds():
        assert time.monotonic() < deadline, "nothing is flown"
        time.sleep(0.01)


def test_two_into_one_folder_are_refused(command, tmp_path):
    process = subprocess.Popen(command(tmp_path, "--threads", 1, seeds="1..1000"), stderr=subprocess.DEVNULL)
    try:
        wait_until(lambda: (tmp_path / "journal.jsonl").exists() and (tmp_path / "journal.jsonl").stat().st_size > 0)
        assert "another comparison is writing into this folder" in compare(command(tmp_path), status=2).stderr
    finally:
        process.kill()
        process.wait()


@pytest.mark.parametrize(
    "text, told",
    [
        (
            '[[contender]]\nname = "a"\n[contender.law]\nformation_gain = -1',
            'bad.toml:4: contender "a": law.formation_gain = -1',
        ),
        ('[[contender]]\nname = "a"\nlok_ahead.horizon_s = 1', 'bad.toml:3: contender "a": lok_ahead: unknown key'),
        ('[[contender]]\nname = "a"\n[[contender]]\nname = "a"', "bad.toml:4: contender[2].name"),
        ("[[contender]]\nlaw.formation_gain = 1", "bad.toml:1: contender[1]: the key name is missing"),
        ("name = 3", "bad.toml:1: name: unknown key"),
        ("[[contender]", "bad.toml:1: "),
        ("", "bad.toml: no contender"),
    ],
)
def test_a_bad_file_of_contenders_is_refused(program, tmp_path, text, told):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    folder = tmp_path / "out"
    said = compare([str(program), "compare", "--contenders", str(path), "--out", str(folder)], status=2)
    assert f"columba: {tmp_path}/{told}" in said.stderr and not said.stdout
    assert not folder.exists()
