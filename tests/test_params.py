"""Ours answers what a real autopilot answers to commands by their params (`params.py`): types, masks, frames.

`reference/params-arduplane.json` is what a real one said. What ours says otherwise is here, each with its reason, which
docs/mavlink.md gives too.
"""

import json
from fnmatch import fnmatchcase
from pathlib import Path

import pytest
from params import play
from pymavlink import mavutil

FOLDER = Path(__file__).parent
PAGE = " ".join((FOLDER.parent / "docs/mavlink.md").read_text().split())
KNOWN = {
    "arduplane": {
        "Terrain is as high as home": ["ground int 179 frame 1[01],*"],
        "PROTOCOL_VERSION, CURRENT_MODE, ALTITUDE, ODOMETRY, PING and WIND_COV are answered.": ["ground long 519 1"],
        "A calibration of the compass is never under way": ["ground long 42425 0"],
    },
}


def recorded(personality, where):
    answers = json.loads((FOLDER / f"reference/params-{personality}.json").read_text())["answers"]
    return {label: answer for answer, labels in answers.items() for label in labels if label.startswith(where)}


def reason(personality, label):
    by = KNOWN[personality].items()
    return next((words for words, labels in by if any(fnmatchcase(label, known) for known in labels)), None)


@pytest.mark.parametrize("personality, where", [("arduplane", "ground"), ("arduplane", "air")])
def test_params_are_answered_as_by_the_real_autopilot(personality, where, start_vehicles):
    stands = ["--on-ground"] if where == "ground" else []
    vehicles = start_vehicles("--count", 1, "--personality", personality, "--airframe", "plane", *stands)
    link = mavutil.mavlink_connection(f"udpout:{vehicles.rows[0]['address']}", source_system=255, source_component=190)
    ours = play(link, where)
    link.close()
    real = recorded(personality, where)
    differing = {label: (answer, ours[label]) for label, answer in real.items() if ours[label] != answer}
    print(f"{personality}, {where}: {len(real) - len(differing)} of {len(real)} answers are the same")
    unexplained = {label: pair for label, pair in differing.items() if not reason(personality, label)}
    assert not unexplained


@pytest.mark.parametrize("personality", KNOWN)
def test_each_reason_is_in_the_page(personality):
    assert not [words for words in KNOWN[personality] if words not in PAGE]
