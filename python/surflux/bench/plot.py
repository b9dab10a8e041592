"""Error against seconds as a picture: a column for each scene, above the error of H, below of its indirect part."""

import inspect

from surflux.bench.solvers import SOLVERS

COLORS = ("tab:blue", "tab:orange", "tab:green", "tab:red", "tab:purple", "tab:brown", "tab:olive", "tab:cyan")
COLORS += ("tab:pink", "gold", "navy", "darkgreen", "black", "salmon")  # no two curves alike
PANELS = (("error", "error of H, %"), ("indirect", "error of its indirect part, %"))


def draw(rows, path):
    """Writes the PNG. Hollow points are errors that the reference is not sure enough of to claim them."""
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    scenes = list(dict.fromkeys(row.scene for row in rows))
    names = list(dict.fromkeys((row.solver, row.knob) for row in rows))
    ours = [name for name in names if name[0] in SOLVERS]
    style = {name: {"color": COLORS[k % len(COLORS)]} for k, name in enumerate(ours)}
    figure = Figure(figsize=(max(8.0, 4.0 * len(scenes)), 7.6), layout="constrained")
    axes = figure.subplots(2, len(scenes), squeeze=False, sharex=True, sharey=True)
    for column, scene in enumerate(scenes):
        for k, (error, label) in enumerate(PANELS):
            panel = axes[k, column]
            for name, points in curves([row for row in rows if row.scene == scene]).items():
                _draw_curve(panel, points, error, style.get(name, {"color": "0.3", "linestyle": "--"}))
            panel.set(xscale="log", yscale="log")
            for axis in (panel.xaxis, panel.yaxis):
                axis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
                axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
                axis.set_minor_formatter(NullFormatter())
            panel.grid(True, color="0.9")
            panel.set_axisbelow(True)
            if column == 0:
                panel.set_ylabel(label)
        axes[0, column].set_title(scene, fontsize="x-large")
        axes[1, column].set_xlabel("seconds")
    dashed = {"color": "0.3", "linestyle": "--"}
    handles = [Line2D([], [], marker="o", **style.get(name, dashed), label=f"{name[0]}: {name[1]}") for name in names]
    empty = {"linestyle": "none", "color": "0.3", "markersize": 9}
    handles.append(Line2D([], [], marker="o", markerfacecolor="none", label="all knobs at their defaults", **empty))
    if not all(row.is_claimed(name) for row in rows for name, _ in PANELS if getattr(row, name) is not None):
        empty["markersize"] = 5.5
        text = "reference's own error above a quarter"
        handles.append(Line2D([], [], marker="o", markerfacecolor="white", label=text, **empty))
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(path, dpi=130)


def curves(rows):
    """{(solver, knob): rows in the order of the knob} of one scene; all knobs' go through the row of the defaults."""
    found = {}
    for solver, knob in dict.fromkeys((row.solver, row.knob) for row in rows):
        points = [row for row in rows if (row.solver, row.knob) == (solver, knob)]
        if points[0].options:
            untouched = [r for r in rows if r.solver == solver and not r.options and r.surfels == points[0].surfels]
            first = next(iter(points[0].options))
            usual = inspect.signature(SOLVERS[solver].run).parameters[first].default
            points = sorted(points + untouched, key=lambda row: row.options.get(first, usual))
        found[solver, knob] = points
    return found


def _draw_curve(panel, rows, error, style):
    rows = [row for row in rows if getattr(row, error) is not None]
    # What the reference drowns has no place on a logarithmic axis but where it would begin to be seen.
    seconds, shown = [r.seconds for r in rows], [100 * max(getattr(r, error), 0.25 * r.reference) for r in rows]
    panel.plot(seconds, shown, linewidth=1.4, **style)
    for row, value in zip(rows, shown, strict=True):
        point = {"color": style["color"], "linestyle": "none", "markersize": 5.5}
        fill = {} if row.is_claimed(error) else {"markerfacecolor": "white"}
        panel.plot([row.seconds], [value], marker="o", **point, **fill)
        if row.solver in SOLVERS and not row.options:
            panel.plot([row.seconds], [value], marker="o", markerfacecolor="none", markersize=10, color="0.3")


def draw_growth(rows, path):
    """Writes the PNG of `surflux bench --scale`: seconds, memory and errors against surfels, of the galleries or, where
    there are none, the statues.
    """
    from matplotlib.figure import Figure

    from surflux.bench.scale import GROWING

    kinds = [[row for row in rows if row.scene.startswith(scene)] for scene in GROWING]
    rows = sorted(next(filter(None, kinds), []), key=lambda row: row.surfels)
    if not rows:
        raise ValueError("--plot: wanted galleries or statues among the scenes, got none")
    surfels = [row.surfels for row in rows]
    figure = Figure(figsize=(12.0, 3.8), layout="constrained")
    for panel, (label, curves_) in zip(
        figure.subplots(1, 3),
        (
            ("seconds", {"in all": [row.seconds for row in rows]} | _stages(rows)),
            ("GB", {"peak": [row.gigabytes for row in rows]}),
            ("error, %", {name: [100.0 * getattr(row, key) for row in rows] for name, key in ERRORS.items()}),
        ),
        strict=True,
    ):
        for name, values in curves_.items():
            panel.plot(surfels, values, marker="o", markersize=3, label=name, linewidth=2 if name == "in all" else 1)
        panel.set(xscale="log", yscale="linear" if label == "error, %" else "log", xlabel="surfels", ylabel=label)
        if label == "error, %":
            panel.set_ylim(bottom=0.0)
        panel.grid(True, color="0.9")
        if len(curves_) > 1:
            panel.legend(fontsize="small")
    figure.savefig(path, dpi=120)


ERRORS = {"of H": "error", "of its indirect part": "indirect"}


def _stages(rows):
    """The stages that take a tenth of the time somewhere, as curves."""
    names = dict.fromkeys(name for row in rows for name, seconds in row.stages.items() if seconds > 0.1 * row.seconds)
    return {name: [row.stages.get(name, float("nan")) for row in rows] for name in names}
