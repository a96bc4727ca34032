"""Flights over bad links and through gusts: how many end with a collision, and how well the controller knows the
present.

    python tests/benchmark_links.py                    # 100 unseen fields for each link, 5 and 12 vehicles in turn
    python tests/benchmark_links.py --flights 20 --only "200 ms"
    python tests/benchmark_links.py --speed 1 --flights 2   # the same over UDP, by the wall clock

Every flight is `columba run --transport simulated` with a seed of its own, so that every one has another field; with
--speed it is `columba run --speed K` instead, whose link is real and whose flights take their time.
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).parent.parent
COLUMBA = os.environ.get("COLUMBA_BIN", ROOT / "target/release/columba")
FIELD = ROOT / "config/random-field.toml"
DELAY = ["--set", "link.delay_ms=200", "--set", "link.jitter_ms=50"]
GUSTS = ["--set", "parameters.SIM_WIND_TURB=3"]
WIND = ["--set", "parameters.SIM_WIND_SPD=4", "--set", "parameters.SIM_WIND_DIR=90"]
LINKS = {
    "clean": [],
    "200 ms each way, 50 ms jitter": DELAY,
    "20 % lost": ["--loss", "0.2"],
    "200 ms, 50 ms jitter, 20 % lost": [*DELAY, "--loss", "0.2"],
    "gusts (SIM_WIND_TURB 3)": GUSTS,
    "gusts, wind of 4 m/s across": [*GUSTS, *WIND],
    "gusts, 200 ms, 50 ms jitter, 20 % lost": [*GUSTS, *DELAY, "--loss", "0.2"],
    "positions at 1 Hz": ["--set", "autopilot.local_position_ned_hz=1"],
}


def fly(seed, vehicles, options, speed, more):
    """The summary of one flight."""
    with tempfile.TemporaryDirectory() as folder:
        # Flights by the clock run beside each other: each takes free ports.
        clock = ["--speed", str(speed), "--set", "link.vehicle_port=0"]
        world = clock if speed else ["--transport", "simulated"]
        command = [COLUMBA, "run", FIELD, "--quiet", "--no-report", "--threads", "1", "--seed", str(seed)]
        command += ["--set", f"vehicles.count={vehicles}", "--out", folder, *world, *options, *more]
        subprocess.run([str(part) for part in command], stderr=subprocess.DEVNULL, check=False)
        return json.loads((pathlib.Path(folder) / "summary.json").read_text())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--flights", type=int, default=100)
    parser.add_argument("--first-seed", type=int, default=1001)
    parser.add_argument("--only", help="links whose name has this in it")
    parser.add_argument("--speed", type=float)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("more", nargs="*", help="options for every flight, after --")
    arguments = parser.parse_args()
    print(
        "| link | flights | with a collision | least clearance, m | least separation, m | state error, m rms | "
        "late ticks |"
    )
    print("|---|---|---|---|---|---|---|")
    for name, options in LINKS.items():
        if arguments.only and arguments.only not in name:
            continue
        with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
            flights = [
                pool.submit(
                    fly, arguments.first_seed + flight, (5, 12)[flight % 2], options, arguments.speed, arguments.more
                )
                for flight in range(arguments.flights)
            ]
            flights = [flight.result() for flight in flights]
        hits = [flight for flight in flights if flight["obstacle_collisions"] + flight["vehicle_collisions"] > 0]
        present = [flight["present"] for flight in flights]
        squares = [p["state_error_rms_m"] ** 2 for p in present if p and p["state_error_rms_m"] is not None]
        error = (sum(squares) / len(squares)) ** 0.5 if squares else float("nan")
        late = sum(p["late_ticks"] for p in present if p)
        clearance = min(flight["min_clearance_m"] for flight in flights)
        separation = min(flight["min_separation_m"] for flight in flights)
        print(f"| {name} | {len(flights)} | {len(hits)} | {clearance:.2f} | {separation:.2f} | {error:.3f} | {late} |")
        for flight in hits:
            print(f"    seed {flight['seed']}, {flight['vehicles']} vehicles: {flight['failure']}", file=sys.stderr)
        sys.stdout.flush()


if __name__ == "__main__":
    main()
