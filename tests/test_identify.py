"""columba identify: what a vehicle answers its setpoints by, from a log and from a flight of steps."""

import subprocess


def identify(program, *arguments, timeout=60):
    return subprocess.run([program, "identify", *map(str, arguments)], capture_output=True, text=True, timeout=timeout)


def test_a_log_without_steps_says_what_is_missing(program, scenario, tmp_path):
    """A flight in lockstep has setpoints at every tick: nothing is at rest before any of them."""
    subprocess.run([program, "run", scenario(), "-o", tmp_path / "run", "-q", "--no-report"], timeout=60, check=False)
    done = identify(program, "--tlog", tmp_path / "run" / "flight.tlog", "-o", tmp_path)
    assert done.returncode == 1, done.stderr
    assert "not known" in done.stdout or "no vehicle in it" in done.stderr


def test_what_is_no_log_is_told(program, tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("no frames here, but many letters of a text that is long enough to be one\n")
    for log in (path, tmp_path / "missing.tlog"):
        done = identify(program, "--tlog", log)
        assert done.returncode == 2
        assert "--tlog" in done.stderr, done.stderr


def test_single_vehicles_have_airframes_of_their_own(start_vehicles, scenario):
    path = scenario()
    path.write_text(path.read_text() + '\n[[airframes]]\nvehicles = "1"\nairframe = "px4-plane"\n')
    from test_airframes import values

    assert values(start_vehicles(path).connect()[0]) == [10, 15, 20, 3, 2, 80]


def test_vehicles_that_are_none_are_told(program, scenario):
    path = scenario()
    path.write_text(path.read_text() + '\n[[airframes]]\nvehicles = "1-90"\nairframe = "plane"\n')
    done = subprocess.run([program, "check", path], capture_output=True, text=True, timeout=20)
    assert done.returncode == 2
    assert 'airframes[1]: vehicles = "1-90": must be numbers and ranges' in done.stderr, done.stderr
