"""`surflux bench --areas`: effective areas, error beside seconds.

Tables of clouds with known areas, of each knob, of growth with the number of surfels, of the methods and backends, and,
where it is installed, of the peer robust_laplacian (lumped mass of the point-cloud Laplacian of Sharp and Crane 2020).
"""

import contextlib
import json
import subprocess
import sys
from pathlib import Path
from statistics import median
from time import perf_counter

import numpy as np

import surflux as sf
from surflux.bench import clouds

# Name -> cloud; "random" is uniform, not blue noise.
CLOUDS = {
    "icosphere 642": lambda: clouds.icosphere(642),
    "icosphere 2562": lambda: clouds.icosphere(2562),
    "Fibonacci sphere 642": lambda: clouds.fibonacci_sphere(642),
    "Fibonacci sphere 10 000": lambda: clouds.fibonacci_sphere(10_000),
    "random sphere 2000": lambda: clouds.random_sphere(2000),
    "random sphere 35 000": lambda: clouds.random_sphere(35_000),
    "sphere 10 000, density 1:20": lambda: clouds.uneven_sphere(10_000),
    "random torus 3000": lambda: clouds.random_torus(3000),
    "cube, 400 a face": lambda: clouds.cube(400),
    "open square 1000": lambda: clouds.open_square(1000),
    "noisy Fibonacci sphere 2000": lambda: clouds.noisy(clouds.fibonacci_sphere(2000)),
    "noisy random sphere 2000": lambda: clouds.noisy(clouds.random_sphere(2000)),
    "Fibonacci sphere 2000, twice": lambda: clouds.twice(clouds.fibonacci_sphere(2000)),
}
SIZES = (10_000, 100_000, 1_000_000)
SPEED_CLOUD = 100_000
KNOB_CLOUD = 20_000
KNOB_TITLE = f"Knobs, on a random sphere of {KNOB_CLOUD}; epsilon on a noisy one"
DENSITIES = (250, 1000, 4000, 16_000)


def main(repeats, threads, markdown=None, json_path=None, plot=None, heading=""):
    """Measures, prints the tables, writes them where asked, and returns them by title."""
    steps = {
        "Clouds": of_clouds,
        "Convergence on random clouds": convergence,
        KNOB_TITLE: lambda: knobs(repeats, threads),
        "Growth, on Fibonacci spheres": lambda: growth(repeats, threads),
        f"Methods and peers, on a Fibonacci sphere of {SPEED_CLOUD}": lambda: methods(repeats, threads),
    }
    tables = {}
    for title, step in steps.items():
        print(f"bench: areas: {title}", file=sys.stderr)
        tables[title] = step()
    text = heading + "\n\n".join(f"### {title}\n\n{as_markdown(rows)}" for title, rows in tables.items())
    print(text)
    if markdown:
        Path(markdown).write_text(text + "\n")
    if json_path:
        Path(json_path).write_text(json.dumps({"machine": dict(sf.info()), "tables": tables}, indent=2) + "\n")
    if plot:
        draw(tables[KNOB_TITLE], plot)
    return tables


def as_markdown(rows):
    """Columns of words to the left, of numbers to the right."""
    columns = list(rows[0]) if rows else []
    words = [all(isinstance(row.get(c) or "", str) for row in rows) for c in columns]
    lines = [
        "| " + " | ".join(columns) + " |",
        "|" + "|".join("---" if left else "--:" for left in words) + "|",
    ]
    lines += ["| " + " | ".join(_text(row.get(c)) for c in columns) + " |" for row in rows]
    return "\n".join(lines)


def _text(value):
    if value is None:
        return ""
    return f"{value:.3g}" if isinstance(value, float) else str(value)


def percent(x):
    return float(f"{100 * x:.3g}")


def timed(call, repeats):
    """(median seconds, last result), after one call that is not counted."""
    call()
    seconds = []
    for _ in range(repeats):
        start = perf_counter()
        result = call()
        seconds.append(perf_counter() - start)
    return median(seconds), result


def of_clouds():
    """Per cloud the errors of the total, and of single areas against their cells, in percent."""
    rows = []
    for name, make in CLOUDS.items():
        cloud = make()
        s = cloud.surfels()
        found = sf.effective_areas(s)
        paper = sf.effective_areas(s, method="paper")
        row = {"cloud": name, "total, %": percent(found.sum() / cloud.area - 1)}
        row["paper's total, %"] = percent(paper.sum() / cloud.area - 1)
        row["robust_laplacian's total, %"] = _lumped_total(cloud)
        if cloud.cells is not None:
            ratio = found / cloud.cells
            row["single, RMS %"] = percent(np.sqrt(np.mean((ratio - 1) ** 2)))
            row["least / cell"], row["most / cell"] = float(ratio.min()), float(ratio.max())
        rows.append(row)
    columns = {key: None for row in rows for key in row}
    return [{key: row.get(key) for key in columns} for row in rows]


def convergence():
    """Mean errors over four clouds at each density: of totals, and of the harmonics of degree 1 to 4 as integrals."""
    rows = []
    for n in DENSITIES:
        tori = [clouds.random_torus(n, seed) for seed in range(4)]
        totals = [abs(sf.effective_areas(c.surfels()).sum() / c.area - 1) for c in tori]
        row = {"n": n, "total of a torus, %": percent(np.mean(totals))}
        errors = [_harmonic_errors(clouds.random_sphere(n, seed)) for seed in range(4)]
        if errors[0] is not None:
            ours, equal = np.sqrt(np.mean(errors, axis=0))
            row["harmonics, RMS"], row["with equal weights"] = float(f"{ours:.3g}"), float(f"{equal:.3g}")
        rows.append(row)
    orders = {"n": "order in n"}
    for column in list(rows[0])[1:]:
        values = np.log([row[column] for row in rows])
        orders[column] = float(f"{-np.polyfit(np.log(DENSITIES), values, 1)[0]:.2f}")
    return [*rows, orders]


def _harmonic_errors(cloud):
    """Mean squares of what areas, and equal weights, make of integrals that are 0; None without scipy."""
    basis = clouds.harmonics(cloud.points)
    if basis is None:
        return None
    ours, equal = basis @ sf.effective_areas(cloud.surfels()), basis.mean(axis=1) * cloud.area
    return np.mean(ours**2), np.mean(equal**2)


def knobs(repeats, threads):
    """Error and seconds along each knob, the others at their defaults; epsilon where normals are noisy."""
    even = clouds.random_sphere(KNOB_CLOUD)
    exact = sf.effective_areas(even.surfels(), resolution=512)
    rows = []
    settings = [("resolution", r, even) for r in (4, 8, 16, 24, 32, 48, 64, 128)]
    settings += [("kappa", k, even) for k in (0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0)]
    noisy = clouds.noisy(even)
    settings += [("epsilon", e, noisy) for e in (0.2, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99)]
    for knob, value, cloud in settings:
        s = cloud.surfels()
        seconds, found = timed(lambda s=s, k=knob, v=value: sf.effective_areas(s, threads=threads, **{k: v}), repeats)
        row = {"knob": knob, "value": value, "seconds": float(f"{seconds:.3g}")}
        row["total, %"] = percent(found.sum() / cloud.area - 1)
        if cloud.cells is not None:
            row["single against cells, RMS %"] = percent(np.sqrt(np.mean((found / cloud.cells - 1) ** 2)))
        if knob == "resolution":
            row["single against resolution 512, RMS %"] = percent(np.sqrt(np.mean((found / exact - 1) ** 2)))
        rows.append(row)
    columns = {key: None for row in rows for key in row}
    return [{key: row.get(key) for key in columns} for row in rows]


def growth(repeats, threads):
    """Seconds from 10^4 to 10^6 surfels, and the memory that it takes in a process of its own."""
    rows = []
    for n in SIZES:
        points = clouds.spiral(n)
        s = sf.Surfels(points, points)
        seconds, found = timed(lambda s=s: sf.effective_areas(s, threads=threads), repeats)
        row = {"surfels": n, "seconds": float(f"{seconds:.3g}"), "surfels/s": round(n / seconds)}
        row["total, %"] = percent(found.sum() / (4 * np.pi) - 1)
        with contextlib.suppress(OSError, ValueError, subprocess.CalledProcessError):
            taken = subprocess.run([sys.executable, "-c", _MEMORY, str(n)], check=True, capture_output=True, text=True)
            row["bytes a surfel"] = round(int(taken.stdout) / n)
        rows.append(row)
    return rows


# Prints by how many bytes the peak of the process (Linux) grows in effective_areas.
_MEMORY = """
import re, sys
from pathlib import Path
import surflux as sf
from surflux.bench import clouds
def status(name):
    return 1024 * int(re.search(name + r":\\s+(\\d+)", Path("/proc/self/status").read_text())[1])
small = clouds.spiral(100)
sf.effective_areas(sf.Surfels(small, small))
points = clouds.spiral(int(sys.argv[1]))
s = sf.Surfels(points, points, radii=(4 / len(points)) ** 0.5)
before = status("VmRSS")
Path("/proc/self/clear_refs").write_text("5")
sf.effective_areas(s)
print(status("VmHWM") - before)
"""


def methods(repeats, threads):
    """Seconds of the methods and backends, and of robust_laplacian on the same points."""
    points = clouds.spiral(SPEED_CLOUD)
    s = sf.Surfels(points, points)
    rows = []

    def add(name, call):
        seconds, found = timed(call, repeats)
        rows.append(
            {
                "what": name,
                "seconds": float(f"{seconds:.3g}"),
                "points/s": round(SPEED_CLOUD / seconds),
                "total, %": percent(found.sum() / (4 * np.pi) - 1),
            }
        )

    for method in ("curved", "paper"):
        add(f"{method}, cpu", lambda m=method: sf.effective_areas(s, method=m, backend="cpu", threads=threads))
    with contextlib.suppress(sf.DeviceError):
        for method in ("curved", "paper"):
            add(f"{method}, gl", lambda m=method: sf.effective_areas(s, method=m, backend="gl", threads=threads))
    with contextlib.suppress(ModuleNotFoundError):
        import robust_laplacian

        add("robust_laplacian", lambda: robust_laplacian.point_cloud_laplacian(points)[1].diagonal())
        add("curved, cpu, with its radii and normals", lambda: sf.effective_areas(sf.Surfels(points), threads=threads))
    return rows


def draw(rows, path):
    """Error and seconds along each knob, as a picture."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 5), layout="constrained")
    axes = figure.subplots(2, 3, sharex="col", sharey="row")
    for (above, below), knob in zip(axes.T, ("resolution", "kappa", "epsilon"), strict=True):
        of_knob = [row for row in rows if row["knob"] == knob]
        values = [row["value"] for row in of_knob]
        above.semilogy(values, [abs(row["total, %"]) for row in of_knob], "o-", label="total")
        for column in ("single against cells, RMS %", "single against resolution 512, RMS %"):
            if of_knob[0].get(column) is not None:
                above.semilogy(values, [row[column] for row in of_knob], "s-", label=column.removesuffix(", RMS %"))
        below.plot(values, [row["seconds"] for row in of_knob], "o-", color="black")
        below.set(xlabel=knob, ylim=(0, None))
    axes[0, 0].set_ylabel("error, %")
    axes[1, 0].set_ylabel("seconds")
    axes[0, 0].legend()
    figure.savefig(path, dpi=150)


def _lumped_total(cloud):
    try:
        import robust_laplacian
    except ModuleNotFoundError:
        return None
    return percent(robust_laplacian.point_cloud_laplacian(cloud.points)[1].diagonal().sum() / cloud.area - 1)
