"""What surfels are, in a line and in a table: methods of Surfels."""

import numpy as np

from surflux._base import check
from surflux._base.summary import box_text, html_table, range_text


def facts(s):
    """The numbers of surfels and of patches among them, and their area, None where it is open."""
    return len(s), len(np.unique(s.triangle_surfel)), None if s.areas is None else float(s.areas.sum())


def as_text(self) -> str:
    """repr() of Surfels."""
    n, patches, area = facts(self)
    of_patches = f", {patches} of them {'a patch' if patches == 1 else 'patches'}" if patches else ""
    area = "no areas" if area is None else f"area {area:.6g}"
    return f"Surfels({check.counted(n, 'surfel')}{of_patches}, {area})"


def as_table(self) -> str:
    """What Jupyter shows of Surfels."""
    return html_table("Surfels", rows(self))


def rows(s):
    """(name, text) of all that a table says of surfels."""
    n, patches, area = facts(s)
    if not n:
        return [("surfels", "0")]
    found = [
        ("surfels", f"{n}, {patches} of them patches" if patches else str(n)),
        ("bounds", box_text(s.bounds)),
        ("radii", range_text(s.radii)),
        ("area", "open" if area is None else f"{area:.6g}"),
        ("reflectance", range_text(s.reflectance)),
    ]
    shining = int(np.count_nonzero(s.emission.any(axis=1)))
    return found + (
        [("emission", f"{range_text(s.emission)}, of {check.counted(shining, 'surfel')}")] if shining else []
    )
