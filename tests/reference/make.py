"""Makes nsga2-pymoo.csv and mopso-pymoo.csv: how good other people's optimisers are on the problems of `columba
suites`.

    python -m venv venv && venv/bin/pip install -r requirements.txt
    venv/bin/python make.py              # all of it, about 40 minutes on one core
    venv/bin/python make.py nsga2        # only one of the two

Every row is one solve by pymoo of pymoo's own problem, judged by pymoo's own indicators, so that nothing of ours is
in it but the reference points and the rule by which true fronts are sampled (`reference_front`, which is that of
`columba suites`).
"""

import csv
import sys
from pathlib import Path

import numpy as np
from pymoo.algorithms.moo.mopso_cd import MOPSO_CD
from pymoo.algorithms.moo.nsga2 import NSGA2
from pymoo.indicators.hv import HV
from pymoo.indicators.igd_plus import IGDPlus
from pymoo.operators.crossover.sbx import SBX
from pymoo.operators.mutation.pm import PM
from pymoo.optimize import minimize
from pymoo.problems import get_problem

SEEDS = range(1, 32)

# Name, variables as is customary, objectives, the reference point's value in every objective.
PROBLEMS = [
    ("zdt1", 30, 2, 1.1),
    ("zdt2", 30, 2, 1.1),
    ("zdt3", 30, 2, 1.1),
    ("zdt4", 10, 2, 1.1),
    ("zdt6", 10, 2, 1.1),
    ("dtlz1", 7, 3, 0.55),
    ("dtlz2", 12, 3, 1.1),
]

# Population, generations and variables (None: as is customary). The second is what a flight spends at each decision.
BUDGETS = [(100, 250, None), (50, 13, 3)]

COLUMNS = ["problem", "dimensions", "population", "generations", "seed", "hypervolume", "igd_plus"]


def nsga2(population):
    """As Deb et al. 2002 have it: SBX with eta 20 and probability 0.9, polynomial mutation with eta 20 of 1 variable
    in n."""
    return NSGA2(pop_size=population, crossover=SBX(prob=0.9, eta=20), mutation=PM(prob=1.0, eta=20))


def mopso(population):
    """With pymoo's own defaults, but an archive as large as everybody's front."""
    return MOPSO_CD(pop_size=population, archive_size=population)


ALGORITHMS = {"nsga2": nsga2, "mopso": mopso}


def lattice(divisions):
    """The points of the unit simplex in three objectives whose coordinates are multiples of 1 / divisions."""
    pairs = ((i, j) for i in range(divisions + 1) for j in range(divisions + 1 - i))
    return np.array([(i, j, divisions - i - j) for i, j in pairs]) / divisions


def reference_front(name):
    """Points of the true front: evenly in f1 for two objectives, a lattice on the front for three."""
    if name == "dtlz1":
        return 0.5 * lattice(30)
    if name == "dtlz2":
        points = lattice(30)
        return points / np.linalg.norm(points, axis=1, keepdims=True)
    f1 = np.arange(1001) / 1000
    if name == "zdt6":
        f1 = 0.2807753191 + (1.0 - 0.2807753191) * f1
    if name in ("zdt1", "zdt4"):
        f2 = 1.0 - np.sqrt(f1)
    elif name == "zdt3":
        f2 = 1.0 - np.sqrt(f1) - f1 * np.sin(10.0 * np.pi * f1)
        # On the front is who is better in f2 than all with less f1.
        on_front = f2 < np.minimum.accumulate(np.concatenate(([np.inf], f2[:-1])))
        f1, f2 = f1[on_front], f2[on_front]
    else:
        f2 = 1.0 - f1 * f1
    return np.column_stack((f1, f2))


def solve(algorithm, name, dimensions, objectives, population, generations, seed):
    """The costs of the front that a solve ends with."""
    arguments = {"n_obj": objectives} if name.startswith("dtlz") else {}
    problem = get_problem(name, n_var=dimensions, **arguments)
    return minimize(problem, ALGORITHMS[algorithm](population), ("n_gen", generations), seed=seed).F


def make(algorithm):
    path = Path(__file__).with_name(f"{algorithm}-pymoo.csv")
    with path.open("w", newline="") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(COLUMNS)
        for population, generations, few in reversed(BUDGETS):
            for name, customary, objectives, limit in PROBLEMS:
                hypervolume = HV(ref_point=np.full(objectives, limit))
                igd_plus = IGDPlus(reference_front(name))
                dimensions = few or customary
                for seed in SEEDS:
                    front = solve(algorithm, name, dimensions, objectives, population, generations, seed)
                    figures = [repr(float(indicator(front))) for indicator in (hypervolume, igd_plus)]
                    rows.writerow([name, dimensions, population, generations, seed, *figures])
                file.flush()
                print(algorithm, name, population, generations, flush=True)


if __name__ == "__main__":
    for algorithm in sys.argv[1:] or ALGORITHMS:
        make(algorithm)
