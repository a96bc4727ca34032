"""What an autopilot answers to commands by their params: types, magic numbers, masks, frames, what is no number.

    python tests/params.py udpout:127.0.0.1:14600 ground|air [ANSWERS.json]

On the ground the vehicle stands disarmed, fresh from its start, without a mission; in the air it is in its guided mode.
The labels are those of `reference/params-arduplane.json`, which a real one gave. `test_params.py` compares.
"""

import json
import math
import sys

from pymavlink import mavutil
from sweep import ARDUPILOT, ARM_DISARM, Sweep

NAN = math.nan
SET_MODE, SET_HOME = 176, 179
# Commands that change the mode or arm, or move home: it is taken back.
THAT_CHANGE = (17, 20, 21, 22, 23, 34, 84, 176, 188, 189, 191, 192, 262, 300, 400)
FRAMES = (0, 2, 3, 5, 6, 7, 10, 11, 99)
# By COMMAND_LONG: a command, and the params of each time that it is sent; what is left out is 0.
GROUND = {
    "arduplane": {
        176: [(128, 0), (128, 1), (128, 2), (129, 5), (1, 99), (1, 5.9), (0, 5), (217, 5), (257, 5)],
        400: [(2,), (0.5,), (-1,), (1, 2989), (1, 21196)],
        245: [(0,), (1,), (3,), (-1,)],
        2600: [(0,), (1,), (2,), (0.5,), (-1,)],
        208: [(0,), (0.5,), (-1,)],
        5300: [(0,), (1,), (2,), (0.5,), (-1,)],
        42007: [(0,), (1,), (2,), (3,), (4,), (0.5,), (-1,), (1,)],
        2001: [(0,), (1,), (2,), (0.5,), (-1,)],
        2000: [(0,), (1,), (-1,)],
        531: [(0, 50), (1, 50), (2, 50)],
        532: [(0, 50), (1, 50), (2, 50), (3, 50), (4, 50), (5, 50), (6, 50), (7, 50), (-1, 50)],
        534: [(0, 1, 2), (1, 1, 2), (3, 1, 2), (-1, 1, 2)],
        526: [(1,), (1, 1), (0, 1)],
        32000: [(0,), (1,), (3,), (256,)],
        42424: [(256,), (-1,), (0,)],
        42425: [(0,), (255,), (256,), (-1,)],
        42426: [(0,), (255,), (256,), (-1,)],
        181: [(0, 1), (0, 0), (1, 1), (5, 1), (16, 1)],
        182: [(0, 2, 1), (1, 2, 1)],
        183: [(0, 1500), (1, 1500), (4, 1500), (5, 1500), (9, 1500), (16, 1500), (17, 1500), (33, 1500), (9, 65000)],
        184: [(5, 1600, 2, 1), (1, 1600, 2, 1), (33, 1600, 2, 1)],
        207: [(0,), (1,), (2,), (3,), (-1,), (0, 1), (1, 1), (1, 4), (1, 255), (2, 4), (0, 256), (1, 256)],
        42651: [(1, 100), (1, -5), (1, 200), (0, 50), (2, 50), (255, 10), (256, 10)],
        218: [
            (41, 0),
            (41, 2),
            (41, 3),
            (11, 2),
            (11, 0),
            (9999, 0),
            (0, 0),
            (24, 2),
            (105, 2),
            (46, 2),
            (81, 2),
            (9, 0),
        ],
        519: [(0,), (1,), (2,)],
        520: [(0,), (1,), (2,), (-1,)],
        300: [(0,), (1,), (0, 1), (-1,)],
        224: [(0,), (1,), (-1,), (0, 1)],
        601: [(0,), (-1,), (65535,), (70000,)],
        511: [
            (33, -2),
            (33, -1),
            (33, 0),
            (33, 25000),
            (33, 33333),
            (33, 1e9),
            (33, 1e6, 1),
            (33, 1e6, 0, 1),
            (0, 1e6),
            (33.9, 1e6),
            (99999, 1e6),
            (-1, 1e6),
            (33, 1e6, 0, 0, 1, 1, 1),
            (33, 0),
        ],
        510: [(33,), (0,), (148,), (99999,), (65569,), (-1,), (33.9,), (33, 0, 0, 0, NAN, NAN, NAN)],
        512: [(244, 33), (244, 99999), (435, 0), (435, 1), (435, 99), (435, -1), (33.9,), (65569,)],
        43004: [(5, 0, 0), (5, 0, 360), (5, 0, 361), (5, 0, -1), (-1,)],
        192: [(0, 1)],
        195: [(0, 0, 0, 0, NAN, NAN, 50)],
        179: [(1,), (0,), (0, 0, 0, 0, NAN, NAN, 590), (1,)],
        246: [(0,), (2,), (4,)],
        241: [
            (0,),
            (2,),
            (0, 0, 0, 1),
            (0, 76),
            (0, 0, 0, 0, 76),
            (0, 0, 0, 0, 3),
            (0, 0, 0, 0, 77),
            (0, 0, 0, 0, 1),
            (0, 0, 0, 0, 2),
            (0, 0, 0, 0, 4),
            (0, 0, 0, 0, 76),
        ],
        42429: [(2,), (1,)],
    },
    "px4": {
        176: [(0,), (1, 5), (1, 9), (1, 4, 30), (1, 4, 3), (4,), (64,), (80,), (88,), (1, 3, 7), (257, 4, 3)],
        400: [(2,), (0.4,), (-1,), (1.4, 21196), (0,)],
        245: [(0,), (1,), (2,), (3,), (4,)],
        5300: [(0,), (1,), (2,), (0.5,), (-1,)],
        310: [
            (0, 1, 0, 0, 0),
            (0, 1, 0, 0, 1),
            (0, 1, 0, 0, 12),
            (0, 1, 0, 0, 13),
            (0, 1, 0, 0, 33),
            (0, 1, 0, 0, 1101),
        ],
        178: [(0, 15), (1, 15), (2, 15), (9, 15), (0, 0), (0, -1), (0, NAN), (0, 1000), (0, 15, 50), (0, 15, 0, 1)],
        186: [(500,), (NAN,), (500, 3)],
        34: [(0,), (50,), (-50,), (NAN,)],
        192: [(0, 0), (0, 1), (-1, 1), (5, 1), (0, 1, 50), (0, 1, 0, 90), (NAN, 1, NAN, NAN, NAN, NAN, NAN)],
        179: [
            (1,),
            (0.4,),
            (0, 0, 0, 0, NAN, 8.5, 500),
            (0, 0, 0, 0, 47.4, 8.5, NAN),
            (0, 0, 0, 90, 47.4, 8.5, 500),
            (1,),
        ],
        300: [(0,), (-1,), (-2,), (5,), (NAN,)],
        511: [
            (30, 1e5, 1),
            (30, 1e5, 0, 1),
            (30, 1e5, 0, 0, 0, 0, 1),
            (0, 1e6),
            (30, -1),
            (30, 0),
            (30, 100),
            (30, NAN),
            (29.6, 1e6),
            (12345, 1e6),
            (30, 1e5, NAN, NAN, NAN, NAN, NAN),
            (30, 1e5, 0.4),
            (-1, 1e6),
        ],
        512: [(244, 30), (244, 99999), (435, 0), (435, 1), (435, 99), (29.6,), (99999,), (65566,)],
        510: [(30,), (99999,), (29.6,)],
        195: [(0,), (NAN, NAN, NAN, NAN, 47.4, 8.5, 500), (0, 1), (0, 0, 0, 0, 2147483648.0, 2147483648.0, 0)],
        197: [(0,), (0, 1)],
        420: [(0, 0), (4, 1), (4, 0), (99, 0), (4, 9)],
        246: [(0,), (4,), (0.9,)],
        2600: [(0,), (1,)],
        401: [(0,), (1,)],
        191: [(0,), (1,)],
        212: [(0,), (0, 1), (1,)],
        185: [(0,), (0.4,)],
        262: [(0,), (1,), (2,), (3,), (5,), (6,), (8,), (9,), (-1,)],
        23: [(0,)],
        93: [(1,)],
        203: [(0,)],
        206: [(10,)],
        214: [(1000,)],
        500: [(0,)],
        531: [(0, 1)],
        1000: [(0,)],
        2003: [(1,)],
        3000: [(4,)],
        42600: [(1,)],
        2510: [(0,), (1,)],
        2511: [(0,)],
        43002: [(0, 90)],
        519: [(0,), (1,)],
        520: [(0,), (1,)],
        521: [(1,)],
        241: [(76,), (0, 0, 0, 2, 76), (0, 0, 0, 3), (0, 0, 0, 0, 3), (0, 0, 0, 0, 0, 3), (0,)],
    },
}
AIR = {
    "arduplane": {
        178: [
            (0, 22),
            (0, 5),
            (0, 50),
            (0, -2),
            (0, -1),
            (0, 0),
            (1, 15),
            (1, 0),
            (1, -5),
            (2, 3),
            (3, 3),
            (4, 3),
            (0.9, 20),
            (-1, 20),
            (0, 0, 50),
            (0, 5, 50),
            (0, 5, 101),
            (0, 5, -1),
            (1, 15, 50),
            (5, 22, 60),
            (1, 0),
            (0, -2),
        ],
        43000: [(0, 22), (0.9, 22), (1, 22), (-1, 22), (0, 5), (0, 31), (0, 10), (0, 30), (0, 20, -1), (0, 21, 100)],
        43002: [
            (0, 90),
            (1, 90),
            (2, 90),
            (3, 90),
            (-1, 90),
            (0, 360),
            (0, -1),
            (0, 359.9),
            (0.9, 90),
            (0, 90, -1),
            (0, 90),
        ],
        186: [(100, 3), (700, 0), (100, 1), (100, 2), (100, 10), (100, 99), (100, -1), (100, 3.9), (-50, 3)],
        300: [(0,), (1,)],
        191: [(0,), (50,)],
        189: [(0,)],
        188: [(0,)],
        22: [(0,)],
        17: [(1, 2, 3, 4)],
        20: [(1, 2, 3, 4)],
        400: [(0,), (1,)],
        401: [(1,)],
        241: [(1,)],
        246: [(1,), (2,)],
        42424: [(0,)],
        245: [(0,)],
    },
    # It begins in Hold.
    "px4": {
        176: [
            (1, 1),
            (1, 2),
            (1, 3),
            (1, 4),
            (1, 4, 2),
            (1, 4, 3),
            (1, 4, 4),
            (1, 4, 5),
            (1, 4, 6),
            (1, 4, 9),
            (1, 4, 19),
            (1, 4, 30),
            (1, 5),
            (1, 6),
            (1, 7),
            (1, 9),
            (0,),
            (4,),
            (64,),
            (80,),
            (88,),
            (1, 4.4, 3),
        ],
        262: [(0,), (1,), (2,), (3,), (5,), (6,), (8,), (9,)],
        22: [(0, 0, 0, NAN, NAN, NAN, NAN), (1, 0, 0, NAN, NAN, NAN, NAN), (0, 0, 0, NAN, NAN, NAN, 0)],
        21: [(0, 0, 0, NAN, NAN, NAN, NAN)],
        20: [(0,), (1,)],
        23: [(0,)],
        400: [(0,), (1,), (2,)],
        401: [(0,)],
        178: [(0, 15), (1, 15), (0, NAN), (0, 1000), (0, -1), (0, 15, 50), (0, 15, -1), (0, 15, 0, 1), (0, -2)],
        186: [(580,), (NAN,), (580, 3), (580, 0, 1), (1e5,), (580,)],
        34: [(0,), (60,), (-60,), (60, 5), (60, NAN, 1, NAN, NAN, NAN, NAN), (60, NAN, 9, NAN, NAN, NAN, NAN)],
        192: [
            (-1, 0, 0, NAN, NAN, NAN, NAN),
            (-1, 1, 0, NAN, NAN, NAN, NAN),
            (15, 1, 0, NAN, NAN, NAN, 580),
            (-1, 1, -60, NAN, NAN, NAN, 580),
            (-1, 2, 0, NAN, NAN, NAN, 580),
            (-1, 1, 0, NAN, 47.4, NAN, 580),
        ],
        43002: [(0, 90), (1, 90), (0, 360), (0, NAN)],
        241: [(1,), (0,)],
        245: [(0,), (1,), (9,)],
        246: [(0,), (1,), (2,), (3,)],
        300: [(0,), (-1,)],
        189: [(0,)],
        191: [(0,)],
        5300: [(0,), (1,)],
        310: [(0, 1, 0, 0, 1), (0, 1, 0, 0, 0)],
        42006: [(0,)],
        511: [(30, 1e5), (30, 0)],
    },
}
# By COMMAND_INT at the vehicle's place, in each of the frames: params 1 to 4, and z by the frame's datum.
PLACED = {
    "ground": {195: (0,), 201: (0,), 611: (0,), 43003: (0,), 22: (0,), 179: (0,)},
    "air": {192: (0, 1), 43001: (0,)},
}
# By COMMAND_INT: a command, its frame, params 1 to 4, x, y and z; no x and y: the vehicle's place.
ODD = {
    "ground": [
        (195, 3, (0,), (950_000_000, 0), 60), (195, 3, (0,), (0, 1_850_000_000), 60), (195, 0, (0,), (0, 0), 0),
        (611, 0, (0,), (950_000_000, 5), 60), (611, 0, (0,), (0, 0), 0), (611, 3, (0,), (0, 0), 0),
        (179, 3, (0,), (950_000_000, 5), 60), (179, 0, (2,), None, 590), (179, 0, (0.5,), None, 590),
        (195, 3, (0,), None, 83_000), (195, 3, (0,), None, 83_001),
        (179, 3, (0,), None, 83_001), (611, 3, (0,), None, -83_001),
        (22, 7, (0,), None, -50), (176, 99, (1, 5), (0, 0), 0),
        (400, 99, (0,), (0, 0), 0), (512, 22, (148,), (0, 0), 0),
        (192, 3, (0, 0), None, 60), (192, 3, (0, 1), (0x7FF8_0000, 0x7FF8_0000), 60), (179, 0, (1,), (0, 0), 0),
    ],
    "air": [
        (192, 3, (0, 0, 0, 0), None, 100), (192, 3, (0, 1, 100, 0), None, 100), (192, 3, (0, 1, -100, 0), None, 100),
        (192, 3, (0, 1, 1e6, 0), None, 100), (192, 3, (0, 1, 0.5, 0), None, 100), (192, 3, (25, 3), None, 100),
        (192, 3, (0, 1), None, -1), (192, 0, (0, 1), None, -1), (192, 3, (0, 1), None, 84_000),
        (192, 3, (0, 1), (950_000_000, 5), 60), (192, 3, (0, 1), (0, 0), 60),
        (43001, 3, (0,), (0, 0), -1), (43001, 3, (0,), (0, 0), 5000), (43001, 3, (0,), (0, 0), -100),
    ],
}  # fmt: skip


def play(link, where):
    """Plays all of them with the vehicle at the other end of a link: label -> answer, None for silence."""
    return Params(link).play_params(where)


class Params(Sweep):
    def play_params(self, where):
        is_plane = self.autopilot == ARDUPILOT
        self.link.mav.mission_clear_all_send(self.system, 1, 0)
        place, personality = self.place(), "arduplane" if is_plane else "px4"
        for command, times in (GROUND if where == "ground" else AIR)[personality].items():
            for params in times:
                label = f"{where} long {command} " + " ".join(f"{param:g}" for param in params)
                self.note(label, self.long(command, *params))
                self.take_back(command, where)
        if is_plane or where == "ground":
            for command, params in PLACED[where].items():
                for frame in FRAMES:
                    z = (590 if where == "ground" else 700) if frame in (0, 5) else 60
                    self.ask_at(where, command, frame, params, place, z)
            for command, frame, params, at, z in ODD[where]:
                self.ask_at(where, command, frame, params, place if at is None else at, z)
        return self.answers

    def ask_at(self, where, command, frame, params, at, z):
        numbers = " ".join(f"{param:g}" for param in params)
        self.forget()
        self.link.mav.command_int_send(
            self.system, 1, frame, command, 0, 0, *params, *[0] * (4 - len(params)), *at, z
        )  # fmt: skip
        label = f"{where} int {command} frame {frame}, {numbers}, z {z}"
        if at[0] in (0, 950_000_000):
            label += " elsewhere"
        self.note(label, self.result(command))
        self.take_back(command, where)

    def note(self, label, answer):
        while label in self.answers:
            label += " again"
        self.answers[label] = answer

    def take_back(self, command, where):
        is_plane = self.autopilot == ARDUPILOT
        if command in THAT_CHANGE:
            if where == "ground":
                self.long(ARM_DISARM, 0, 21196 if is_plane else 0)
                self.long(SET_MODE, 1, *((0,) if is_plane else (4, 3)))
            else:
                self.long(SET_MODE, 1, *((15,) if is_plane else (4, 3)))
        if command == SET_HOME and is_plane:
            self.long(SET_HOME, 1)


def by_answer(found):
    """Answer -> labels; SILENCE is no answer."""
    heard = {label: answer or "SILENCE" for label, answer in found.items()}
    return {answer: [at for at in heard if heard[at] == answer] for answer in sorted(set(heard.values()))}


def tell(found, path=None):
    """Writes answers to a file, or prints them."""
    text = json.dumps(by_answer(found), indent=1)
    if path is None:
        print(text)
    else:
        with open(path, "w") as file:
            file.write(text + "\n")


if __name__ == "__main__":
    found = play(mavutil.mavlink_connection(sys.argv[1], source_system=255, source_component=190), sys.argv[2])
    tell(found, *sys.argv[3:])
