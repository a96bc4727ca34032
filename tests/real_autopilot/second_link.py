"""The judge: positions and modes of a vehicle by a link of its own, and the least distances of a flight."""

import math
import threading
import time

from pymavlink import mavutil

STEP_S = 0.02
POSITION_US = 50_000
# What PX4 sends a ground station unasked, many times a second, and nobody needs here.
NOT_NEEDED = [30, 31, 32, 36, 83, 85, 105, 140, 147, 241, 331, 380]


class SecondLink(threading.Thread):
    """Positions at 20 Hz and modes with their times, until it is told to end."""

    def __init__(self, address, system):
        super().__init__(daemon=True)
        self.address, self.system = address, system
        # Wall time, the vehicle's own time, latitude, longitude, velocity north and east.
        self.samples, self.modes, self.mode, self.armed, self.running = [], [], None, False, True
        self.link = None
        self.start()

    def run(self):
        self.link = link = mavutil.mavlink_connection(
            self.address, source_system=200, source_component=self.system, retries=600
        )
        beat = asked = 0.0
        while self.running:
            now = time.time()
            if now - beat > 1:
                beat = now
                link.mav.heartbeat_send(6, 8, 0, 0, 0)
            if link.target_system and now - asked > 5:
                asked = now
                self.command(511, 33, POSITION_US)
                if not self.address.startswith("tcp"):
                    for message in NOT_NEEDED:
                        self.command(511, message, -1)
            message = link.recv_match(type=["HEARTBEAT", "GLOBAL_POSITION_INT"], blocking=True, timeout=0.2)
            if message is None or message.get_srcSystem() != self.system:
                continue
            if message.get_type() == "HEARTBEAT" and message.get_srcComponent() == 1:
                self.mode, self.armed = mavutil.mode_string_v10(message), bool(message.base_mode & 128)
                self.modes.append((time.time(), self.mode, self.armed))
            elif message.get_type() == "GLOBAL_POSITION_INT" and abs(message.lat) > 10_000:
                self.samples.append(
                    (
                        time.time(),
                        message.time_boot_ms / 1e3,
                        message.lat * 1e-7,
                        message.lon * 1e-7,
                        message.vx / 100,
                        message.vy / 100,
                    )
                )

    def command(self, number, *params):
        self.link.mav.command_long_send(self.system, 1, number, 0, *params, *[0] * (7 - len(params)))

    def wait_for(self, mode, patience_s=30):
        deadline = time.monotonic() + patience_s
        while self.mode != mode:
            assert time.monotonic() < deadline, f"system {self.system} is in {self.mode}, not in {mode}"
            time.sleep(0.1)


class Track:
    """One vehicle's way over the wall clock: when it was there, not when it was heard."""

    def __init__(self, samples, place):
        # In a window the least delay of a message is that of the link; what is more is the computer's.
        self.points = []
        window = 60
        for first in range(0, len(samples), window):
            around = samples[max(0, first - window) : first + 2 * window]
            mean_wall, mean_boot = (sum(sample[k] for sample in around) / len(around) for k in (0, 1))
            variance = sum((sample[1] - mean_boot) ** 2 for sample in around)
            rate = sum((s[1] - mean_boot) * (s[0] - mean_wall) for s in around) / variance if variance else 1.0
            offset = min(wall - rate * boot for wall, boot, *_ in around)
            for _, boot, latitude, longitude, north, east in samples[first : first + window]:
                # A velocity over the wall clock, where the vehicle's own is slow.
                self.points.append((offset + rate * boot, *place(latitude, longitude), north / rate, east / rate))

    def between(self, began, ended, step_s):
        """North and east at each step; none where nothing was heard for a second."""
        at, places = 0, []
        for step in range(int((ended - began) / step_s) + 1):
            when = began + step_s * step
            while at + 2 < len(self.points) and self.points[at + 1][0] < when:
                at += 1
            before, after = self.points[at], self.points[at + 1]
            span = after[0] - before[0]
            if not before[0] <= when <= after[0] or span > 1.0:
                places.append(None)
                continue
            u = (when - before[0]) / span
            h = (2 * u**3 - 3 * u**2 + 1, (u**3 - 2 * u**2 + u) * span, 3 * u**2 - 2 * u**3, (u**3 - u**2) * span)
            places.append(
                tuple(h[0] * before[k] + h[1] * before[k + 2] + h[2] * after[k] + h[3] * after[k + 2] for k in (1, 2))
            )
        return places


def least_distances(judges, obstacles, origin, began, ended, step_s=STEP_S):
    """The least separation of two vehicles and the least clearance to a circle, m, and the share of time seen."""
    latitude_deg, longitude_deg = origin
    # Metres of a degree on the ellipsoid (WGS 84), as close as centimetres over a kilometre.
    sin = math.sin(math.radians(latitude_deg))
    curvature = 1 - 0.006_694_38 * sin * sin
    north = math.radians(6_378_137 * (1 - 0.006_694_38) / curvature**1.5)
    east = math.radians(6_378_137 / math.sqrt(curvature)) * math.cos(math.radians(latitude_deg))
    place = lambda latitude, longitude: ((latitude - latitude_deg) * north, (longitude - longitude_deg) * east)  # noqa: E731
    columns = [Track(list(judge.samples), place).between(began, ended, step_s) for judge in judges]
    separation = clearance = math.inf
    seen = 0
    for places in zip(*columns):
        known = [spot for spot in places if spot is not None]
        seen += len(known) == len(places)
        for index, spot in enumerate(known):
            for other in known[:index]:
                separation = min(separation, math.dist(spot, other))
            for x, y, radius in obstacles:
                clearance = min(clearance, math.dist(spot, (x, y)) - radius)
    return separation, clearance, seen / max(1, len(columns[0]))
