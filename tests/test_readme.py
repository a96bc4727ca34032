"""The README's blocks and those of the plugin's page, run as they are printed, in the order of the page, in a fresh
folder."""

import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import time

import pytest
from conftest import PROJECT

README = (PROJECT / "README.md").read_text()
PLUGIN = (PROJECT / "tests/plugin/README.md").read_text()

# A command that runs on by itself is ended with Ctrl-C after so long, s; what it printed until then has to be in order.
PATIENCE_S = {"vehicles": 2, "fly": 6, "compare": 6, "suites": 6}
ENDS_S = 60
# Not run: they build and test the project, which is what is going on here.
OURS = ("cargo ", "scripts/test")
# Other vehicles may have the README's ports for a moment: other tests, or somebody on this machine.
BUSY_PATIENCE_S = 60


def section(page, heading):
    """A section of a page, without those beside it."""
    after = page.split(f"\n{heading}\n")[1]
    level = heading.split(" ")[0]
    return re.split(rf"\n#{{1,{len(level)}}} ", after)[0]


def blocks(text):
    """Every block of code with its language, in order."""
    return re.findall(r"^```(\w+)\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def block(text, language):
    """The one block of code in a language."""
    (code,) = [code for of, code in blocks(text) if of == language]
    return code


def commands(code):
    """The lines of a shell block that are run, without their comments."""
    lines = [re.sub(r"\s+#.*", "", line) for line in code.splitlines()]
    return [line for line in lines if line and not line.startswith(OURS)]


@pytest.fixture
def clone(program, tmp_path):
    """A folder that has what a clone of the project has after `cargo build --release`, and nothing that a test
    wrote."""
    for name in ("config", "tests", "docs"):
        (tmp_path / name).symlink_to(PROJECT / name)
    (tmp_path / "target/release").mkdir(parents=True)
    (tmp_path / "target/release/columba").symlink_to(program)
    return tmp_path


class Shell:
    """Runs lines in a folder, with `columba` on the PATH and this Python before all others."""

    def __init__(self, folder, program, **environment):
        self.folder = folder
        tools = folder / ".tools"
        tools.mkdir()
        (tools / "columba").symlink_to(program)
        for name in ("python", "python3"):
            (tools / name).write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} "$@"\n')
            (tools / name).chmod(0o755)
        (tools / "pip").write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m pip "$@"\n')
        (tools / "pip").chmod(0o755)
        path = f"{tools}:{os.environ['PATH']}"
        self.environment = {
            name: value for name, value in os.environ.items() if not name.startswith(("COLUMBA", "PYTEST"))
        }
        self.environment |= {"PATH": path, **environment}

    def start(self, line):
        return subprocess.Popen(
            ["bash", "-c", f"exec {line}" if line.startswith("columba ") else line],
            cwd=self.folder, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        )  # fmt: skip

    def run(self, line):
        """Runs a line to its end, or ends it with Ctrl-C; gives what it printed, its status, and whether it was
        ended."""
        words = line.split()
        patience_s = PATIENCE_S.get(words[1] if words[0] == "columba" else "", ENDS_S)
        if "--speed" in words:
            patience_s = 3
        until = time.monotonic() + BUSY_PATIENCE_S
        while True:
            done, ended = self.start(line), False
            try:
                out, err = done.communicate(timeout=patience_s)
            except subprocess.TimeoutExpired:
                ended = True
                done.send_signal(signal.SIGINT)
                out, err = done.communicate(timeout=ENDS_S)
            if "busy" not in err or time.monotonic() > until:
                return out, err, done.returncode, ended
            time.sleep(0.5)

    def check(self, line):
        """Runs a line, and expects success, or a Ctrl-C that was understood."""
        out, err, status, ended = self.run(line)
        understood = (status == 1 and "interrupted" in err) or status == -signal.SIGINT
        assert status == 0 or (ended and understood), f"{line}: status {status}\n{out}\n{err}"
        return out


@pytest.fixture
def shell(clone, program):
    return Shell(clone, program)


def test_the_papers_flight(shell):
    *good, literal = commands(block(section(README, "### Fly the paper's flight"), "sh"))
    said = [shell.check(line) for line in good]
    # The page names the folders, and how the last flight ends.
    assert "report: runs/paper/report.html" in said[0] and "report: runs/second/report.html" in said[1]
    out, err, status, _ = shell.run(literal)
    assert status == 1 and "entered obstacle" in err
    assert "report: runs/paper-2/report.html" in out and "runs/paper is not empty and was kept" in out


def test_watching_in_real_time(shell):
    watching = section(README, "### Watch it in real time")
    alone, viewed, two = [commands(code) for language, code in blocks(watching) if language == "sh"]
    for line in alone + viewed:
        shell.check(line)
    prepare, vehicles, fly = two
    shell.check(prepare)
    until = time.monotonic() + BUSY_PATIENCE_S
    while (first := shell.start(vehicles)).poll() is None:
        time.sleep(0.5)
        if first.poll() is None:
            break
        assert time.monotonic() < until, first.communicate()
    try:
        shell.check(fly)
    finally:
        first.send_signal(signal.SIGINT)
        assert first.wait(timeout=ENDS_S) == 0
    assert (shell.folder / "runs/paper/summary.json").exists()


def test_a_field_of_your_own_flies(shell):
    of_your_own = section(README, "### Fly a field of your own")
    (shell.folder / "mine.toml").write_text(block(of_your_own, "toml"))
    check, run = commands(block(of_your_own, "sh"))
    assert "mine.toml: good" in shell.check(check)
    assert "past the last obstacle: 8 of 8" in shell.check(run)
    assert (shell.folder / "runs/mine/report.html").exists()


def test_the_script_steers_a_vehicle(start_vehicles, tmp_path):
    address = start_vehicles("--speed", 5).rows[0]["address"]
    script = tmp_path / "script.py"
    script.write_text(
        block(section(README, "### Vehicles for a controller of your own"), "python").replace(
            "127.0.0.1:14600", address
        )
    )
    said = subprocess.run([sys.executable, script], check=True, capture_output=True, text=True, timeout=30).stdout
    assert "mode GUIDED" in said
    assert "COMMAND_ACK {command : 43002, result : 0" in said
    first, *_, last = [list(map(float, numbers)) for numbers in re.findall(r"s: (\S+) m north, (\S+) m east", said)]
    # A vehicle that flew north has gone as far east as north, but for the turn.
    assert last[1] - first[1] > 0.6 * (last[0] - first[0]) > 0


def test_vehicles_of_every_kind_start(shell):
    for line in commands(block(section(README, "### Vehicles for a controller of your own"), "sh")):
        shell.check(line)


def test_vehicles_in_your_own_tests(shell):
    in_tests = section(README, "### Vehicles in your own tests")
    copy, run = [commands(code) for language, code in blocks(in_tests) if language == "sh"]
    for line in copy:
        shell.check(line)
    (shell.folder / "my/tests/test_mine.py").write_text(block(in_tests, "python"))
    for line in run:
        assert "passed" in (out := shell.check(line)) or "pytest my/tests" not in line, out


def test_the_plugins_page(shell):
    install, copy, run = [commands(code) for language, code in blocks(PLUGIN) if language == "sh"]
    (pip, export) = install
    for line in copy:
        shell.check(line)
    (shell.folder / "my/tests/test_mine.py").write_text(block(PLUGIN, "python"))
    (line,) = run
    assert "2 passed" in shell.check(f"{export}; {line}")

    # With pip, in an environment of its own, no line in a conftest is needed.
    for name in ("pytest_columba.py", "conftest.py"):
        (shell.folder / "my/tests" / name).unlink()
    shutil.copytree(
        PROJECT / "tests/plugin",
        shell.folder / "plugin",
        ignore=shutil.ignore_patterns("build", "*.egg-info", "__pycache__"),
    )
    site = shell.folder / "site"
    out, err, status, _ = shell.run(pip.replace("./tests/plugin", f"./plugin --no-deps --target {site}"))
    if status and "setuptools" in err:
        pytest.skip(f"pip cannot build the plugin here, for want of setuptools or a network: {err.splitlines()[-1]}")
    assert status == 0, f"{out}\n{err}"
    assert "2 passed" in shell.check(f"{export}; PYTHONPATH={site} {line}")


def test_comparisons(shell):
    (shell.folder / "mine.toml").write_text(block(section(README, "### Fly a field of your own"), "toml"))
    for line in commands(block(section(README, "### Compare optimisers and settings"), "sh")):
        shell.check(line)


def test_measuring_optimisers_and_a_bad_link(shell):
    for heading in ("### Measure optimisers", "### Try a bad link"):
        for line in commands(block(section(README, heading), "sh")):
            shell.check(line)


def test_every_shell_block_is_run_by_a_test_above():
    """A block that is added to the page is added here, too."""
    headings = re.findall(r"^##+ .*$", README, re.MULTILINE)
    with_blocks = [
        heading
        for heading in headings
        if any(of == "sh" and commands(code) for of, code in blocks(section(README, heading)))
    ]
    assert [heading for heading in with_blocks if heading.startswith("### ")] == [
        "### Fly the paper's flight",
        "### Watch it in real time",
        "### Fly a field of your own",
        "### Vehicles for a controller of your own",
        "### Vehicles in your own tests",
        "### Compare optimisers and settings",
        "### Measure optimisers",
        "### Try a bad link",
    ]
    assert [heading for heading in with_blocks if not heading.startswith("### ")] == ["## Use"]


def test_every_name_of_the_summary_is_explained(flown):
    assert names(README[README.index("`summary.json` holds") :].split("## Exit status")[0]) == sorted(flown.summary)


def test_every_counter_of_the_link_is_explained(flown):
    page = (PROJECT / "docs/mavlink.md").read_text()
    assert names(section(page, "## Counters of a link")) == sorted(flown.summary["link"])


def names(text):
    """The names in the first column of a table."""
    return sorted(
        re.findall(r"`(\w+)`", "".join(line.split("|")[1] for line in text.splitlines() if line.startswith("|")))
    )
