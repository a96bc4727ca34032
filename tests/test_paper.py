"""docs/paper.md: its tables are what its own commands give.

All of them take ten minutes (scripts/paper --check); here fly the two that would notice a change of the letter or of the default.
"""

import os
import re
import subprocess
import sys

import pytest
from conftest import PROJECT

PAGE = (PROJECT / "docs/paper.md").read_text()


@pytest.mark.parametrize("folder", ["preset-literal", "default"])
def test_tables_are_what_their_command_gives(program, folder):
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
