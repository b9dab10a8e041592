"""Error against seconds as a picture: scenes side by side, and of each its kinds of error below it."""

import inspect

from surflux.bench.solvers import OF_REFERENCE, PATHS, SOLVERS

COLORS = {"rays": "tab:blue", "pairs": "tab:orange", "meshless": "tab:green", PATHS: "0.45", "Mitsuba": "black"}
MARKERS = {"error": "o", "surfels": "s", "rays": "^", "zeta": "v", "insert": "P", "shadow rays": "d", "tolerance": "X"}
MARKERS |= {"epsilon_e": "v", "levels": "D", "samples": "s"}
PANELS = (
    ("error", "error of H, %"),
    ("indirect", "error of its indirect part, %"),
    ("local_90", "local error, 90th percentile, %"),
)
ABREAST = 3  # scenes


def draw(rows, path):
    """Writes the PNG: a color for each solver, a marker for each knob, `error=` in bold.

    Hollow points are errors that the reference is not sure enough of to claim them.
    """
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    scenes = list(dict.fromkeys(row.scene for row in rows))
    across, down = min(len(scenes), ABREAST), -(-len(scenes) // ABREAST)
    figure = Figure(figsize=(max(9.0, 3.6 * across), 1.5 + 3.0 * len(PANELS) * down), layout="constrained")
    axes = figure.subplots(len(PANELS) * down, across, squeeze=False, sharey=True)
    for number, scene in enumerate(scenes):
        column, first = number % ABREAST, number // ABREAST * len(PANELS)
        for k, (error, label) in enumerate(PANELS, first):
            panel = axes[k, column]
            if k > first:
                panel.sharex(axes[first, column])
            for name, points in curves([row for row in rows if row.scene == scene]).items():
                _draw_curve(panel, points, error, _style(*name))
            _set_logarithmic(panel)
            if column == 0:
                panel.set_ylabel(label)
        axes[first, column].set_title(scene, fontsize="x-large")
        axes[k, column].set_xlabel("seconds")
    for unused in axes[len(PANELS) * (down - 1) :, column + 1 :].flat:
        unused.axis("off")
    names = dict.fromkeys((row.solver, row.knob) for row in rows)
    handles = [Line2D([], [], label=": ".join(name), **_style(*name)) for name in names]
    empty = {"linestyle": "none", "color": "0.3", "marker": "o"}
    handles.append(Line2D([], [], markerfacecolor="none", markersize=10, label="all knobs at their defaults", **empty))
    if not all(row.is_claimed(name) for row in rows for name, _ in PANELS):
        text = "reference's own error above a quarter"
        handles.append(Line2D([], [], markerfacecolor="white", markersize=5, label=text, **empty))
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(path, dpi=110)


def draw_asked(rows, path):
    """Writes the PNG of the first page: of one scene what `error=` of `solve` costs, beside path tracers."""
    from matplotlib.figure import Figure

    rows = [row for row in rows if row.scene == "three spheres"]
    figure = Figure(figsize=(6.4, 4.2), layout="constrained")
    panel = figure.subplots()
    shown = {("rays", "error"): "solve, error=", (PATHS, "samples"): PATHS, ("Mitsuba", "samples"): "Mitsuba 3"}
    for name, label in shown.items():
        points = [row for row in rows if (row.solver, row.knob) == name]
        if points:
            _draw_curve(panel, points, "error", _style(*name) | {"label": label})
    surfels = next((row.surfels for row in rows if (row.solver, row.knob) in shown), 0)
    panel.set(xlabel=f"seconds, light of {surfels} surfels", ylabel="error of the irradiance, %")
    _set_logarithmic(panel)
    panel.legend()
    figure.savefig(path, dpi=90)


def _style(solver, knob):
    style = {"color": COLORS[solver], "marker": MARKERS[knob], "markersize": 5, "linewidth": 1.0}
    if knob == "error":
        return style | {"linewidth": 2.4}
    return style if solver in SOLVERS else style | {"linestyle": "--"}


def _set_logarithmic(panel):
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    panel.set(xscale="log", yscale="log")
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.10g}"))
        axis.set_minor_formatter(NullFormatter())
    panel.grid(True, color="0.9")
    panel.set_axisbelow(True)


def curves(rows):
    """{(solver, knob): rows in the order of the knob} of one scene; knobs with a default go through its row."""
    found = {}
    for solver, knob in dict.fromkeys((row.solver, row.knob) for row in rows):
        points = [row for row in rows if (row.solver, row.knob) == (solver, knob)]
        if points[0].options:
            first = next(iter(points[0].options))
            usual = inspect.signature(SOLVERS[solver].run).parameters[first].default
            if usual is not None:
                surfels = points[0].surfels
                points += [r for r in rows if r.solver == solver and not r.options and r.surfels == surfels]
            points.sort(key=lambda row: row.options.get(first, usual))
        found[solver, knob] = points
    return found


def _draw_curve(panel, rows, error, style):
    rows = [row for row in rows if getattr(row, error) is not None]
    # What the reference drowns has no place on a logarithmic axis but where it would begin to be seen.
    shown = [100 * max(getattr(r, error), 0.25 * getattr(r, OF_REFERENCE[error])) for r in rows]
    panel.plot([r.seconds for r in rows], shown, **style)
    for row, value in zip(rows, shown, strict=True):
        if not row.is_claimed(error):
            hollow = {"linestyle": "none", "label": None, "markerfacecolor": "white"}
            panel.plot([row.seconds], [value], **(style | hollow))
        if row.solver in SOLVERS and not row.options:
            panel.plot([row.seconds], [value], marker="o", markerfacecolor="none", markersize=10, color="0.3")


def draw_growth(rows, path):
    """Writes the PNG of `surflux bench --scale`: seconds, memory and errors against surfels, of the galleries or the
    statues, of which there are more.
    """
    from surflux.bench.scale import GROWING

    kinds = [[row for row in rows if row.scene.startswith(scene)] for scene in GROWING]
    rows = sorted(max(kinds, key=len), key=lambda row: row.surfels)
    if not rows:
        raise ValueError("--plot: wanted galleries or statues among the scenes, got none")
    panels = {
        "seconds": {"in all": [row.seconds for row in rows]} | _stages(rows),
        "GB": {"peak": [row.gigabytes for row in rows]},
        "error, %": {name: [100.0 * getattr(row, key) for row in rows] for name, key in ERRORS.items()},
    }
    _draw_against_surfels([row.surfels for row in rows], panels, path)


def draw_many_surfels(rows, path):
    """Writes the PNG of `many_surfels`, of rows as JSON has them: seconds, memory and own estimates against surfels."""
    panels = {
        "seconds": {"in all": [row["seconds"] for row in rows]},
        "GB": {"peak": [row["gigabytes"] for row in rows]},
        "own estimate, %": {"of H": [100.0 * row["estimate"] for row in rows]},
    }
    _draw_against_surfels([row["surfels"] for row in rows], panels, path)


def _draw_against_surfels(surfels, panels, path):
    """panels: label -> {name of a curve: its values}; of shares in %, from 0, and logarithmic else."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 3.6), layout="constrained")
    for panel, (label, curves_) in zip(figure.subplots(1, len(panels)), panels.items(), strict=True):
        for name, values in curves_.items():
            panel.plot(surfels, values, marker="o", markersize=3, label=name, linewidth=2 if name == "in all" else 1)
        panel.set(xlabel="surfels", ylabel=label)
        _set_logarithmic(panel)
        if label.endswith("%"):
            panel.set_yscale("linear")
            panel.set_ylim(bottom=0.0)
        if len(curves_) > 1:
            panel.legend(fontsize="small", loc="upper left", bbox_to_anchor=(1.0, 1.0))
    figure.savefig(path, dpi=120)


ERRORS = {"of H": "error", "of its indirect part": "indirect"}


def _stages(rows):
    """The stages that take a tenth of the time somewhere, as curves; what is measured behind them is no part of it."""
    names = dict.fromkeys(name for row in rows for name, seconds in row.stages.items() if seconds > 0.1 * row.seconds)
    names = [name for name in names if not name.startswith("at ")]
    return {name: [row.stages.get(name, float("nan")) for row in rows] for name in names}
