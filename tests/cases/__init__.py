"""One table of cases, crossed with every solver.

A case is a scene whose irradiance is known from a closed form, by a derivation that stands with it. All of its points
and seeds are fixed here. Each is built at three densities or more, so that the order of the error against the spacing
is seen as well as its size.

    CASES                    all of them (case.Case)
    solvers.SOLVERS          all solvers; a new one joins by one line there
    case.converge(case, solver)    surfels, spacing and error at each density

`tests/python/test_cases.py` holds every solver against every case, and the path tracer besides. Nothing here needs
pytest: `PYTHONPATH=tests python -m cases [words]` prints the table, and a script may take the same scenes.
"""

from cases import enclosures, exchange, lit, rooms

CASES = [*enclosures.CASES, *exchange.CASES, *lit.CASES, *rooms.CASES]

assert len({case.name for case in CASES}) == len(CASES)
