"""The README's examples, run as they stand."""

import re
import subprocess
import sys

from conftest import PROJECT

README = (PROJECT / "README.md").read_text()


def block(language):
    """The one block of code in a language."""
    (code,) = re.findall(rf"```{language}\n(.*?)```", README, re.DOTALL)
    return code


def test_the_field_of_your_own_flies(program, fly, tmp_path):
    scenario = tmp_path / "mine.toml"
    scenario.write_text(block("toml"))
    subprocess.run([program, "check", scenario], check=True)
    run = fly("run", scenario)
    assert run.status == 0, run.errors
    assert run.summary["passed_last_obstacle"] == run.summary["vehicles"] == 8


def test_the_script_steers_a_vehicle(start_vehicles, tmp_path):
    address = start_vehicles("--speed", 5).rows[0]["address"]
    script = tmp_path / "script.py"
    script.write_text(block("python").replace("127.0.0.1:14600", address))
    said = subprocess.run([sys.executable, script], check=True, capture_output=True, text=True, timeout=30).stdout
    assert "mode GUIDED" in said
    assert "COMMAND_ACK {command : 43002, result : 0" in said
    first, *_, last = [list(map(float, numbers)) for numbers in re.findall(r"s: (\S+) m north, (\S+) m east", said)]
    # A vehicle that flew north has gone as far east as north, but for the turn.
    assert last[1] - first[1] > 0.6 * (last[0] - first[0]) > 0


def test_every_name_of_the_summary_is_explained(flown):
    table = README[README.index("`summary.json` holds") :].split("## Exit status")[0]
    explained = re.findall(r"`(\w+)`", "".join(line.split("|")[1] for line in table.splitlines() if line.startswith("|")))
    assert sorted(explained) == sorted(flown.summary)
