"""Error against seconds as a picture: a column for each scene, above the error of H, below of its indirect part."""

import inspect

from surflux.bench_solvers import SOLVERS

COLORS = ("tab:blue", "tab:orange", "tab:green", "tab:red", "tab:purple", "tab:brown", "tab:olive", "tab:cyan")
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
