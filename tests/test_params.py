"""Ours answers what a real autopilot answers to commands by their params (`params.py`): types, masks, frames.

`reference/params-arduplane.json` and `reference/params-px4.json` are what real ones said,
`reference/plan-params-px4.json` what a PX4 said to plans and parameters (`plan_params.py`). What ours says otherwise is
here, each with its reason, which docs/mavlink.md gives too.
"""

import json
from fnmatch import fnmatchcase
from pathlib import Path

import params
import plan_params
import pytest
from pymavlink import mavutil

FOLDER = Path(__file__).parent
PAGE = " ".join((FOLDER.parent / "docs/mavlink.md").read_text().split())
KNOWN = {
    "arduplane": {
        "Terrain is as high as home": ["ground int 179 frame 1[01],*"],
        "PROTOCOL_VERSION, CURRENT_MODE, ALTITUDE, ODOMETRY, PING and WIND_COV are answered.": ["ground long 519 1"],
    },
    "px4": {
        "DO_SET_GLOBAL_ORIGIN is DENIED: the origin is the scenario's.": ["ground int 611 *"],
        "A place that there is not, and an altitude above 83000 m, are DENIED.": [
            "ground int 179 frame 3, 0, z 60 elsewhere",
            "ground int 179 frame 3, 0, z 83001",
            "air long 186 100000",
        ],
        "There is no autotune, and there are no logs.": ["ground long 212 1", "ground long 2510 0"],
        "A value out of a parameter's range is refused.": [
            "write COM_OF_LOSS_T 1000.0 *",
            "write FW_AIRSPD_* 0.5 *",
            "write FW_AIRSPD_TRIM 500.0 *",
            "write MIS_TAKEOFF_ALT -4.0 *",
            "write MIS_TKO_LAND_REQ 9 *",
            "write NAV_ACC_RAD -5.0 *",
            "write NAV_ACC_RAD 1000000.0 *",
            "write NAV_ACC_RAD nan *",
            "write NAV_DLL_ACT -3 *",
            "write NAV_DLL_ACT 99 *",
        ],
        "The mode of a NAV_ROI that is no number is none.": ["item 80 p1=nan"],
    },
}


def recorded(name, where=""):
    """Label -> answer; none for silence."""
    answers = json.loads((FOLDER / f"reference/{name}.json").read_text())["answers"]
    return {
        label: None if answer == "SILENCE" else answer
        for answer, labels in answers.items()
        for label in labels
        if label.startswith(where)
    }


def reason(personality, label):
    by = KNOWN[personality].items()
    return next((words for words, labels in by if any(fnmatchcase(label, known) for known in labels)), None)


@pytest.fixture
def answers(start_vehicles):
    """What ours answers."""

    def ask(personality, where, play):
        stands = ["--on-ground"] if where == "ground" else []
        vehicles = start_vehicles("--count", 1, "--personality", personality, "--airframe", "plane", *stands)
        address = vehicles.rows[0]["address"]
        link = mavutil.mavlink_connection(f"udpout:{address}", source_system=255, source_component=190)
        ours = play(link)
        link.close()
        return ours

    return ask


def compare(personality, what, real, ours):
    differing = {label: (answer, ours[label]) for label, answer in real.items() if ours[label] != answer}
    print(f"{personality}, {what}: {len(real) - len(differing)} of {len(real)} answers are the same")
    assert not {label: pair for label, pair in differing.items() if not reason(personality, label)}


@pytest.mark.parametrize("where", ["ground", "air"])
@pytest.mark.parametrize("personality", ["arduplane", "px4"])
def test_params_are_answered_as_by_the_real_autopilot(personality, where, answers):
    ours = answers(personality, where, lambda link: params.play(link, where))
    compare(personality, where, recorded(f"params-{personality}", where), ours)


def test_plans_and_parameters_are_answered_as_by_a_real_px4(answers):
    compare("px4", "plans", recorded("plan-params-px4"), answers("px4", "ground", plan_params.play))


@pytest.mark.parametrize("personality", KNOWN)
def test_each_reason_is_in_the_page(personality):
    assert not [words for words in KNOWN[personality] if words not in PAGE]
