"""Fields for real vehicles: the paper's, at a scale, with circles that a seed has moved and swollen."""

import random
import tomllib
from pathlib import Path

from builds import ALTITUDE_M, LATITUDE_DEG, LONGITUDE_DEG

PAPER = Path(__file__).resolve().parents[2] / "config/paper.toml"

# What differs from the paper for each kind: the scale of lengths, speeds, time constants, and how long it takes. Planes
# fly by what `columba identify` found of them.
PLANES = dict(
    scale=4.0, speed_mps=20.0, speeds=(14.0, 26.0), time_constants=None, period_s=1.0, duration_s=80.0, airframe="plane"
)
PX4_PLANES = dict(
    scale=2.5,
    speed_mps=13.9,
    speeds=(11.0, 18.0),
    time_constants=None,
    period_s=0.5,
    duration_s=65.0,
    airframe="px4-plane",
)
PAPER_SCALE = dict(scale=1.0, speed_mps=None, speeds=None, time_constants=None, period_s=0.5, duration_s=42.0)
# As `columba identify` finds a PX4 quad whose drag is that of a real one (SIH_KDV 0.2): 0.44 s and a dead time of 0.3
# s.
PX4_QUADS = PAPER_SCALE | dict(time_constants=(0.5, 0.44), dead_times=(0.3, 0.3))
# An ArduCopter flies at most 10 m/s (WPNAV_SPEED).
COPTERS = PAPER_SCALE | dict(speed_mps=8.0, speeds=(3.0, 10.0), duration_s=50.0)


def field(
    count,
    seed,
    scale,
    speed_mps,
    speeds,
    time_constants,
    period_s,
    duration_s,
    dead_times=(0.0, 0.0),
    airframe=None,
    link=None,
):
    """The text of a scenario, and its circles (x, y, radius)."""
    paper = tomllib.loads(PAPER.read_text())
    dice = random.Random(seed)
    circles = []
    for circle in paper["obstacle"]:
        moved = [scale * (circle[axis] + (dice.uniform(-5, 5) if seed else 0)) for axis in ("x_m", "y_m")]
        circles.append((*moved, scale * circle["radius_m"] * (dice.uniform(0.8, 1.2) if seed else 1.0)))
    speed = speed_mps or paper["flock"]["expected_speed_mps"]
    lines = [f'airframe = "{airframe}"'] if airframe else []
    lines += [
        "[scenario]", f'name = "real-{seed}"', f"seed = {max(1, seed)}", f"duration_s = {duration_s}",
        f"control_period_s = {period_s}",
        f"origin = {{ latitude_deg = {LATITUDE_DEG}, longitude_deg = {LONGITUDE_DEG}, altitude_amsl_m = "
        f"{ALTITUDE_M} }}",
        "[flock]", f"expected_speed_mps = {speed}", "expected_altitude_m = 50.0",
    ]  # fmt: skip
    if time_constants:
        lines += ["[dynamics]"]
        lines += [f"{name}_time_constant_s = {value}" for name, value in zip(("speed", "course"), time_constants)]
        lines += [f"{name}_dead_time_s = {value}" for name, value in zip(("speed", "course"), dead_times)]
    if speeds:
        lines += [] if time_constants else ["[dynamics]"]
        lines += [f"speed_min_mps = {speeds[0]}", f"speed_max_mps = {speeds[1]}"]
    if link:
        lines += ["[link]", *(f"{name} = {value}" for name, value in link.items())]
    if scale != 1.0:
        lines += [
            "[law]", f"communication_distance_m = {10 * scale}", f"desired_distance_m = {10 * scale}",
            f"safe_distance_m = {2 * scale}", f"perception_distance_m = {120 * scale}", f"obstacle_margin_m = "
            f"{1.5 * scale}",
            "[look_ahead]", f"separation_m = {3 * scale}", f"clearance_m = {scale}", "horizon_s = 6.0",
        ]  # fmt: skip
    for start in paper["vehicle"][:count]:
        lines += [
            "[[vehicle]]", f"x_m = {scale * start['x_m']}", f"y_m = {scale * start['y_m']}",
            f"altitude_m = {start['altitude_m']}", f"speed_mps = {start['speed_mps'] * speed / 10}",
            f"course_deg = {start['course_deg']}",
        ]  # fmt: skip
    for x, y, radius in circles:
        lines += ["[[obstacle]]", f"x_m = {x:.2f}", f"y_m = {y:.2f}", f"radius_m = {radius:.2f}"]
    return "\n".join(lines) + "\n", [tuple(round(value, 2) for value in circle) for circle in circles]
