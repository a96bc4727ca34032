"""Ours answers what real autopilots answer, to every command, message and mission item (`sweep.py`).

`reference/answers-*.json` are what real ones said, on the ground and in the air. What ours says otherwise is in
`sweep_differences.py`, each with its reason, which docs/mavlink.md gives too.
"""

import json
from collections import Counter
from fnmatch import fnmatchcase
from pathlib import Path

import pytest
from pymavlink import mavutil
from sweep import play
from sweep_differences import KNOWN

FOLDER = Path(__file__).parent
PAGE = (FOLDER.parent / "docs/mavlink.md").read_text()
# Of all answers, at least so many are the same.
FLOOR = 0.97


def recorded(name):
    """Label -> answer; none for silence."""
    answers = json.loads((FOLDER / f"reference/answers-{name}.json").read_text())["answers"]
    return {
        f"{kind} {label}": None if answer == "SILENCE" else answer
        for kind, by in answers.items()
        for answer, labels in by.items()
        for label in labels
    }


def reasons(personality, label):
    return [
        reason for reason, labels in KNOWN[personality].items() if any(fnmatchcase(label, known) for known in labels)
    ]


@pytest.mark.parametrize("where", ["ground", "air"])
@pytest.mark.parametrize("personality", ["arduplane", "px4"])
def test_the_answers_are_those_of_the_real_autopilot(personality, where, start_vehicles):
    vehicles = start_vehicles(
        "--count", 1, "--personality", personality, *(["--on-ground"] if where == "ground" else [])
    )
    link = mavutil.mavlink_connection(f"udpout:{vehicles.rows[0]['address']}", source_system=255, source_component=190)
    ours = play(link, in_air=where == "air")
    link.close()
    real = recorded(personality if where == "ground" else f"{personality}-air")
    differing = {label: (answer, ours[label]) for label, answer in real.items() if ours[label] != answer}
    share = 1 - len(differing) / len(real)
    print(f"{personality}, {where}: {share:.2%} of {len(real)} answers are the same")
    for label, (theirs, own) in differing.items():
        print(f"  {label}: {theirs}, ours {own} ({'; '.join(reasons(personality, label)) or 'NO REASON'})")
    unexplained = {label: pair for label, pair in differing.items() if not reasons(personality, label)}
    assert not unexplained
    used = Counter(reason for label in differing for reason in reasons(personality, label))
    gone = [reason for reason in KNOWN[personality] if not used[reason]]
    assert not gone or where == "air", "these differences are no more"
    assert share >= FLOOR


def plain(text):
    return " ".join(text.split())


@pytest.mark.parametrize("personality", ["arduplane", "px4"])
def test_each_reason_is_in_the_page(personality):
    missing = [reason for reason in KNOWN[personality] if plain(reason) not in plain(PAGE)]
    assert not missing
