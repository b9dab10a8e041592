"""What a view or a page can colour a Subject by: what its surfels have of themselves, and what was solved for."""

from surflux._base import check
from surflux.drawing.colors import SURFACE, Shown, surface_property

# name: (kind, title), with kind as of Shown.
PROPERTIES = {
    "radiosity": ("light", "radiosity B, W/m2"),
    "irradiance": ("light", "irradiance H, W/m2"),
    "direct": ("light", "direct irradiance D, W/m2"),
    "indirect": ("light", "irradiance from surfels H - D, W/m2"),
    **SURFACE,
    "level": ("number", "level that light was gathered at (Solution.levels); below 0 inserted"),
    "object": ("members", "objects of the scene"),
    "parent": ("members", "surfels of the scene; those inserted in place of one have its colour"),
    "group": ("members", "groups of the hierarchy"),
    "cut": ("members", "the cut: nodes that light was solved for"),
}
LIGHTS = ("all", "direct", "indirect")


def names_of(subject):
    """The properties that a Subject has, in the order of PROPERTIES, and its further arrays."""
    solved, several = subject.solution is not None, subject.objects.max(initial=0) > 0
    there = {
        "radiosity": solved,
        "irradiance": solved,
        "direct": solved,
        "indirect": solved,
        "emission": bool(subject.surfels.emission.any()),
        "level": solved and bool(subject.inserted().any()),
        "object": several,
        "parent": solved and bool(subject.inserted().any()),
        "cut": solved and subject.solution.cut is not None,
    }
    return [*(name for name in PROPERTIES if there.get(name, True)), *subject.values]


def property_of(subject, name, light="all", groups=None):
    """Shown: one property of a Subject.

    Args:
        subject: Subject.
        name: one of names_of(subject).
        light: "all", "direct" or "indirect": what radiosity and irradiance are made of. Emission is direct light.
        groups: (n,) of the level of the hierarchy that "group" shows; None for the finest.

    Raises:
        ValueError: name and light, by those names.
    """
    check.choice("color", name, (*names_of(subject), "emission"))
    check.choice("light", light, LIGHTS)
    solution = subject.solution
    if name in SURFACE or name in subject.values:
        return surface_property(subject.surfels, name, subject.values)
    kind, title = PROPERTIES[name]
    if name in ("radiosity", "irradiance"):
        part = {"all": 1, "direct": solution.direct, "indirect": solution.irradiance - solution.direct}[light]
        if light == "all":
            values = getattr(solution, name)
        else:
            s, values = subject.surfels, part
            if name == "radiosity":
                values = s.reflectance * part + (s.emission if light == "direct" else 0.0)
            title = f"{title.removesuffix(', W/m2')} by {light} light alone, W/m2"
    elif name == "indirect":
        values = solution.irradiance - solution.direct
    elif name in ("direct", "cut", "parent"):
        values = getattr(solution, "parents" if name == "parent" else name)
    elif name == "level":
        values = solution.values()["level"]
    elif name == "group":
        values = subject.tree().levels[0] if groups is None else groups
    else:
        values = subject.objects
    return Shown(name, kind, title, values)
