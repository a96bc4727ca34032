"""How fast NSGA-II is: ours beside pagmo2's and pymoo's, in the same run on the same core.

    cargo build --release
    python speed.py [../../target/release/columba]

ZDT1 with 3 variables, 52 candidates x 20 generations, every solve with a seed of its own. The three take turns, so
that what else the machine does meets them alike. Ours is the `solve_us` of `columba suites --threads 1`, which is one
solve without the start of the program; the others are timed around one call, with whatever they set up in it.
"""

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import pyarrow.parquet
import pygmo
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM
from pymoo.optimize import minimize
from pymoo.problems import get_problem

PROGRAM = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parents[2] / "target/release/columba").resolve()
ROUNDS = 7


def ours(round):
    with tempfile.TemporaryDirectory() as folder:
        seeds = f"{1 + 100 * round}..{100 + 100 * round}"
        options = (
            "--problems zdt1 --optimizers nsga2 --dimensions 3 --population 52 --generations 20 --threads 1 --quiet"
        )
        subprocess.run([PROGRAM, "suites", *options.split(), "--seeds", seeds, "--out", folder], check=True)
        return pyarrow.parquet.read_table(f"{folder}/timings.parquet")["solve_us"].to_pylist()


def timed(solve, seed):
    start = time.perf_counter()
    solve(seed)
    return 1e6 * (time.perf_counter() - start)


def pagmo(seed):
    population = pygmo.population(pygmo.problem(pygmo.zdt(prob_id=1, param=3)), 52, seed=seed)
    # The first population is a generation too.
    nsga2 = pygmo.nsga2(gen=19, cr=0.9, eta_c=20, m=1 / 3, eta_m=20, seed=seed)
    pygmo.algorithm(nsga2).evolve(population)


def pymoo(seed):
    nsga2 = NSGA2(pop_size=52, crossover=SBX(prob=0.9, eta=20), mutation=PM(prob=1.0, eta=20))
    minimize(get_problem("zdt1", n_var=3), nsga2, ("n_gen", 20), seed=seed)


def main():
    times = {"columba": [], "pagmo2": [], "pymoo": []}
    for round in range(ROUNDS):
        times["columba"] += ours(round)
        times["pagmo2"] += [timed(pagmo, 1 + 100 * round + i) for i in range(100)]
        times["pymoo"] += [timed(pymoo, 1 + 100 * round + i) for i in range(5)]
    for name, values in times.items():
        ratios = statistics.median(values) / statistics.median(times["columba"]), min(values) / min(times["columba"])
        print(
            f"{name:8} median {statistics.median(values):9.1f} us ({ratios[0]:6.1f} times ours), "
            f"least {min(values):9.1f} us ({ratios[1]:6.1f} times ours), {len(values)} solves"
        )


if __name__ == "__main__":
    main()
