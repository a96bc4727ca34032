"""docs/paper.md: its tables and figures are what its own commands give.

All of them take ten minutes (scripts/paper --check); here fly the two that would notice a change of the letter or of
the default.
"""

import os
import re
import subprocess
import sys

import pytest
from conftest import PROJECT

PAGE = (PROJECT / "docs/paper.md").read_text()


@pytest.mark.parametrize("folder", ["preset-literal", "default"])
def test_tables_and_figures_are_what_their_command_gives(program, folder):
    environment = {**os.environ, "COLUMBA_BIN": str(program)}
    checked = subprocess.run(
        [sys.executable, PROJECT / "scripts/paper", "--check", folder], env=environment, capture_output=True, text=True
    )
    assert checked.returncode == 0, checked.stderr


def test_every_table_is_there_and_has_a_command():
    tables = re.findall(r"<!-- table ([\w-]+), [^>]* -->\n(.*?)<!-- end -->", PAGE, re.DOTALL)
    assert len(tables) > 20
    for folder, table in tables:
        assert re.search(rf"^columba compare .*-o compare/{folder}\b", PAGE, re.MULTILINE), folder
        assert table.startswith(("| contender", "| measure", "None.")), (folder, table)


def test_every_figure_is_there_has_a_command_and_stands_before_the_tables_of_its_comparison():
    figures = re.findall(r"!\[([^\]]+)\]\((paper/([\w-]+)/[\w-]+\.svg)\)", PAGE)
    assert len(figures) > 10
    assert len(figures) == PAGE.count("![")
    for words, path, folder in figures:
        assert (PROJECT / "docs" / path).read_text().startswith("<svg"), path
        assert len(words) > 10, f"{path}: says nothing to a reader who does not see it"
        assert re.search(rf"^columba compare .*-o compare/{folder}\b", PAGE, re.MULTILINE), folder
    kept = {f"paper/{path.relative_to(PROJECT / 'docs/paper')}" for path in (PROJECT / "docs/paper").rglob("*.*")}
    assert kept == {path for _, path, _ in figures}
    with_figures = {folder for _, _, folder in figures}
    assert with_figures >= {"preset-literal", "preset-paper", "preset-paper-random", "default", "default-random"}
    for folder in with_figures:
        assert PAGE.find(f"](paper/{folder}/") < PAGE.find(f"<!-- table {folder},"), folder
