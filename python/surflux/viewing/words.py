"""What a window writes: beside the picture, and about a picked surfel."""

import numpy as np

from surflux._base import check
from surflux.drawing.colors import LUMINANCE
from surflux.drawing.sharing import decimals

_MOST_OBJECTS = 6


def caption(view, shown):
    """What is shown, in a line or two."""
    lines = []
    if shown.kind == "light":
        lines.append(f"{shown.label}; white is {view.white() / 2.0**view.stops:.3g} {shown.unit}".rstrip())
    else:
        lines.append(shown.title)
    if shown.name == "group":
        level = min(view.level, len(view.subject.tree()) - 1)
        lines[0] += f": level {level}, {check.counted(view.subject.tree().counts[level], 'group')}"
    if shown.name == "cut":
        lines[0] += f", {len(np.unique(shown.values))} of them"
    lines.append(check.counted(len(view.subject), "surfel"))
    inserted = int(view.subject.inserted().sum())
    if inserted:
        lines[-1] += f", {inserted} of them inserted"
    if view.note:
        lines.append(view.note)
    return "\n".join(lines)


def values_of(subject, picked, links):
    """All that is known about a surfel, in lines: picked is a sharing.Picked, links a Links or None."""
    s, i, solution = subject.surfels, picked.index, subject.solution
    lines = [f"surfel {i} of object {subject.objects[i]}"]
    if subject.inserted()[i]:
        lines.append(f"inserted for surfel {solution.parents[i]}")
    lines += [
        "",
        f"position    {' '.join(f'{x:z.{decimals(s.radii[i])}f}' for x in s.points[i])}",
        f"normal      {_numbers(s.normals[i], 3)}",
        f"radius      {s.radii[i]:.5g}",
    ]
    if s.areas is not None:
        lines.append(f"area        {s.areas[i]:.5g}")
    lines.append(f"reflectance {_numbers(s.reflectance[i], 3)}")
    if s.emission[i].any():
        lines.append(f"emission    {_numbers(s.emission[i], 4)}")
    if solution is not None:
        lines += [
            f"direct      {_numbers(solution.direct[i], 4)}",
            f"irradiance  {_numbers(solution.irradiance[i], 4)}",
            f"radiosity   {_numbers(solution.radiosity[i], 4)}  W/m2",
        ]
        if solution.cut is not None:
            together = int(np.count_nonzero(solution.cut == solution.cut[i]))
            lines.append(f"cut node    {solution.cut[i]}, of {check.counted(together, 'surfel')}")
    lines += [f"{name:<11} {_given(np.atleast_1d(value[i]))}" for name, value in subject.values.items()]
    lines.append("")
    if picked.shares is None:
        lines.append("a patch of a mesh: shares its area with none")
    else:
        lines.append(f"shares its disk with {check.counted(len(picked.members) - 1, 'neighbour')}")
    return lines + (_of_links(subject, links) if links is not None else [])


def _of_links(subject, links):
    """Where the light comes from, in per cent of the irradiance."""
    solution, i = subject.solution, links.index
    total = solution.irradiance[i] @ LUMINANCE
    lines = ["", "its light comes from"]
    if not total > 0:
        return ["", "no light comes here"]
    lines.append(f"  lights, sky {100 * (solution.direct[i] @ LUMINANCE) / total:5.1f}%")
    of_object = links.by_object @ LUMINANCE / total
    order = [k for k in np.argsort(-of_object, kind="stable") if of_object[k] > 0]
    lines += [f"  object {k:<4} {100 * of_object[k]:5.1f}%" for k in order[:_MOST_OBJECTS]]
    if len(order) > _MOST_OBJECTS:
        rest = sum(of_object[k] for k in order[_MOST_OBJECTS:])
        lines.append(f"  {len(order) - _MOST_OBJECTS} more      {100 * rest:5.1f}%")
    if len(links.shares):
        lines.append(f"strongest link: {100 * links.shares[0]:.1f}%, surfel {links.senders[0]}")
    return lines


def _given(values):
    """Of an array that was given; whole numbers as such."""
    whole = np.issubdtype(values.dtype, np.integer)
    return " ".join(str(v) for v in values) if whole else _numbers(values, 6 if len(values) == 1 else 4)


def _numbers(values, digits):
    return " ".join(f"{v:.{digits}g}" for v in values)
