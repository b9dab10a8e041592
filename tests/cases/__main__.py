"""The table of all cases by all solvers, as Markdown: PYTHONPATH=tests python -m cases [words of a name]."""

import sys
from time import perf_counter

from cases import CASES
from cases.case import converge, problem_of
from cases.solvers import SOLVERS

print("| case | solver | surfels | errors | order | least order | tolerance | s |")
print("|---|---|--:|--:|--:|--:|--:|--:|")
for case in CASES:
    if not all(word in case.name for word in sys.argv[1:]):
        continue
    for name, solver in SOLVERS.items():
        if not solver.takes(problem_of(case, case.densities[0])):
            continue
        start = perf_counter()
        found = converge(case, solver)
        errors = ", ".join(f"{e:.1e}" for e in found.errors)
        tolerance, asked = case.judged(solver)
        least = "floor" if asked is None else f"{asked:.1f}"
        order = "" if asked is None else f"{found.order:.2f}"
        counts = ", ".join(map(str, found.surfels))
        row = (case.name, name, counts, errors, order, least, f"{tolerance:.1e}", f"{perf_counter() - start:.1f}")
        print(f"| {' | '.join(row)} |", flush=True)
