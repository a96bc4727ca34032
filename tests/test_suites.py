"""`columba suites`: what it writes is what others compute from it, and repeats."""

import math
import subprocess
from itertools import groupby

import pyarrow.parquet
import pytest

try:
    import numpy
    from pymoo.indicators.hv import HV
    from pymoo.indicators.igd_plus import IGDPlus
except ImportError:
    HV = None

REPEATABLE = ["fronts.parquet", "indicators.parquet", "reference-fronts.parquet", "table.md"]


SMALL = ["--population", 20, "--generations", 30, "--seeds", "4..6"]


def suites(program, folder, *options):
    command = [program, "suites", "--out", folder, *options]
    return subprocess.run([str(word) for word in command], capture_output=True, text=True)


def rows(path):
    return pyarrow.parquet.read_table(path).to_pylist()


def costs(row):
    return [row[name] for name in ("f1", "f2", "f3") if row[name] is not None]


def hypervolume(points, reference):
    """In slices along the last objective, each as thick as it is far to the next point."""
    points = sorted((p for p in points if all(x < r for x, r in zip(p, reference))), key=lambda p: p[-1])
    if len(reference) == 1:
        return reference[0] - points[0][0] if points else 0.0
    ends = [p[-1] for p in points[1:]] + [reference[-1]]
    slices = (
        (end - point[-1]) * hypervolume([p[:-1] for p in points[: i + 1]], reference[:-1])
        for i, (point, end) in enumerate(zip(points, ends))
    )
    return math.fsum(slices)


def igd_plus(points, front):
    distances = (min(math.dist(z, [max(a, b) for a, b in zip(p, z)]) for p in points) for z in front)
    return math.fsum(distances) / len(front)


def recompute(points, reference, front):
    """Both indicators by pymoo where it is installed, else by the few lines above."""
    if HV is None:
        return hypervolume(points, reference), igd_plus(points, front)
    return HV(ref_point=numpy.array(reference))(numpy.array(points)), IGDPlus(numpy.array(front))(numpy.array(points))


@pytest.fixture(scope="module")
def folder(program, tmp_path_factory):
    folder = tmp_path_factory.mktemp("suites")
    done = suites(program, folder, *SMALL)
    assert done.returncode == 0, done.stderr
    assert (folder / "table.md").read_text() in done.stdout
    return folder


def test_indicators_are_those_of_the_fronts(folder):
    print("recomputed by", "lines of our own" if HV is None else "pymoo")

    def key(row):
        return row["problem"], row["optimizer"], row["seed"]

    fronts = {k: [costs(row) for row in members] for k, members in groupby(rows(folder / "fronts.parquet"), key)}
    true_fronts = {
        problem: [costs(row) for row in points]
        for problem, points in groupby(rows(folder / "reference-fronts.parquet"), lambda row: row["problem"])
    }
    solves = rows(folder / "indicators.parquet")
    assert len(solves) == 7 * 3 * 3 and [key(row) for row in solves] == list(fronts)
    for row in solves:
        points, true_front = fronts[key(row)], true_fronts[row["problem"]]
        reference = [row["reference_point"]] * len(points[0])
        ours = row["hypervolume"], row["igd_plus"]
        assert ours == pytest.approx(recompute(points, reference, true_front), abs=1e-9, rel=1e-9), key(row)
        assert len(points) <= 20 and row["evaluations"] == 600
    assert sum(row["hypervolume"] > 0 for row in solves) > 9, "hardly anything was compared"


def test_any_number_of_threads_writes_the_same_bytes(program, folder, tmp_path):
    assert suites(program, tmp_path, *SMALL, "--threads", 1).returncode == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*REPEATABLE, "timings.parquet"])
    for name in REPEATABLE:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), name
    timings = rows(tmp_path / "timings.parquet")
    assert len(timings) == 7 * 3 * 3 and all(row["solve_us"] > 0 for row in timings)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        (["--problems", "zdt5"], "must be one of zdt1"),
        (["--optimizers", "slpio"], "must be one of mslpio"),
        (["--seeds", "9..3"], "must be how many"),
        (["--population", "7"], "must be an even number from 6"),
        (["--dimensions", "2"], "must be a whole number from 3"),
    ],
)
def test_what_cannot_be_solved_is_refused(program, tmp_path, options, word):
    refused = suites(program, tmp_path / "out", *options)
    assert refused.returncode == 2 and word in refused.stderr
    assert not (tmp_path / "out").exists()
