"""Plans as a stranger uploads and downloads them: missions, fences and rally points, over a bad link too."""

import math
import time

from pymavlink.dialects.v20 import ardupilotmega as mavlink

MISSION, FENCE, RALLY = (
    mavlink.MAV_MISSION_TYPE_MISSION,
    mavlink.MAV_MISSION_TYPE_FENCE,
    mavlink.MAV_MISSION_TYPE_RALLY,
)
RELATIVE = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
METRES_PER_DEGREE = 111_200


def place(north_m, east_m, home=(39.98, 116.34)):
    latitude = home[0] + north_m / METRES_PER_DEGREE
    return round(latitude * 1e7), round((home[1] + east_m / METRES_PER_DEGREE / math.cos(math.radians(home[0]))) * 1e7)


def item(command, north_m=0, east_m=0, altitude_m=60, p1=0, p2=0, p3=0, frame=RELATIVE):
    return (frame, command, p1, p2, p3, *place(north_m, east_m), altitude_m)


class Uploader:
    """Answers what the vehicle asks for; what is lost is said again."""

    KINDS = ["MISSION_REQUEST", "MISSION_REQUEST_INT", "MISSION_ACK", "STATUSTEXT"]

    def __init__(self, link, system=1, plan=MISSION):
        self.link, self.system, self.plan = link, system, plan
        self.words = []

    def send_item(self, seq, fields):
        frame, command, p1, p2, p3, x, y, z = fields
        self.link.mav.mission_item_int_send(
            self.system, 1, seq, frame, command, 0, 1, p1, p2, p3, 0, x, y, z, self.plan
        )

    def upload(self, items, patience_s=30):
        start = time.monotonic()
        asked = None
        while time.monotonic() - start < patience_s:
            if asked is None:
                self.link.mav.mission_count_send(self.system, 1, len(items), self.plan)
            message = self.link.recv_match(type=self.KINDS, blocking=True, timeout=1)
            if message is None:
                if asked is not None:  # the item, or the acknowledgement, may be lost
                    self.send_item(asked, items[asked])
            elif message.get_type() == "STATUSTEXT":
                self.words.append(message.text)
            elif message.mission_type != self.plan:
                pass
            elif message.get_type() == "MISSION_ACK":
                return message.type
            else:
                asked = message.seq
                self.send_item(asked, items[asked])
        raise TimeoutError("the upload did not end")

    def ask(self, send, kind):
        for _ in range(60):
            send()
            message = self.link.recv_match(type=kind, blocking=True, timeout=0.3)
            if message is not None:
                return message
        raise TimeoutError(kind)

    def download(self):
        def ask_for_list():
            self.link.mav.mission_request_list_send(self.system, 1, self.plan)

        def ask_for_item():
            self.link.mav.mission_request_int_send(self.system, 1, len(items), self.plan)

        items = {}
        count = self.ask(ask_for_list, "MISSION_COUNT").count
        while len(items) < count:
            item = self.ask(ask_for_item, "MISSION_ITEM_INT")
            items[item.seq] = item
        # A PX4 goes on with a download until that is heard.
        self.link.mav.mission_ack_send(self.system, 1, mavlink.MAV_MISSION_ACCEPTED, self.plan)
        return [items[seq] for seq in range(count)]
