"""Prints the tables of docs/optimisers.md: medians of what `columba suites` wrote, beside those of the CSV files here.

columba suites --out runs/suites
columba suites --dimensions 3 --population 50 --generations 13 --out runs/suites-flight
python medians.py runs/suites runs/suites-flight
"""

import csv
import statistics
import sys
from pathlib import Path

import pyarrow.parquet

OUTSIDE = {"pymoo NSGA-II": "nsga2-pymoo.csv", "pymoo MOPSO-CD": "mopso-pymoo.csv"}
OURS = {"MSLPIO": "mslpio", "MPIO": "mpio", "NSGA-II": "nsga2"}
INDICATORS = {"Hypervolume, more is better": ("hypervolume", max), "IGD+, less is better": ("igd_plus", min)}


def solves(folder):
    """Of one folder: (problem, optimiser) to the rows, and how much was spent."""
    found = {}
    rows = pyarrow.parquet.read_table(Path(folder) / "indicators.parquet").to_pylist()
    for row in rows:
        name = next(name for name, key in OURS.items() if key == row["optimizer"])
        found.setdefault((row["problem"], name), []).append(row)
    spent = {(row["problem"].lower(), row["dimensions"], row["evaluations"]) for row in rows}
    for name, file in OUTSIDE.items():
        with Path(__file__).with_name(file).open() as lines:
            for row in csv.DictReader(lines):
                evaluations = int(row["population"]) * int(row["generations"])
                if (row["problem"], int(row["dimensions"]), evaluations) in spent:
                    found.setdefault((row["problem"].upper(), name), []).append(row)
    return found, rows[0]["evaluations"]


def main():
    for folder in sys.argv[1:]:
        found, evaluations = solves(folder)
        names = [*OURS, *OUTSIDE]
        for title, (column, best) in INDICATORS.items():
            print(
                f"{title}, after {evaluations} evaluations:\n\n"
                f"| problem | {' | '.join(names)} |\n|---|{'---|' * len(names)}"
            )
            for problem in dict.fromkeys(problem for problem, _ in found):
                medians = [statistics.median(float(row[column]) for row in found[problem, name]) for name in names]
                texts = [f"{median:.4f}" for median in medians]
                marked = [
                    f"**{text}**" if float(text) == float(f"{best(medians):.4f}") and float(text) else text
                    for text in texts
                ]
                print(f"| {problem} | {' | '.join(marked)} |")
            print()


if __name__ == "__main__":
    main()
