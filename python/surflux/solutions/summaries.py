"""What a solution is, in a line and in a table: methods of Solution."""

import math

import numpy as np

from surflux._base import check
from surflux._base.summary import box_text, html_table
from surflux.points.summaries import facts

_ACCOUNT = {
    "power_in": "power in",
    "power_absorbed": "absorbed",
    "power_escaped": "escaped",
    "power_into_backs": "into backs",
    "power_lost": "lost",
}


def as_text(self) -> str:
    """repr() of Solution."""
    surfels, seconds = check.counted(len(self.surfels), "surfel"), sum(self.timings.values())
    error = "unknown" if math.isnan(self.error) else f"{self.error:.2g}"
    return f"Solution({surfels}, error {error}, {seconds:.3g} s)"


def as_lines(self) -> str:
    """str() of Solution: its repr(), on a second line where the power went, in shares of what entered, and on a third
    what never entered, for it fell on backs.
    """
    power, text = _account(self), as_text(self) + _how_to_know(self)
    if power is None:
        return text
    whole = power["power_in"]
    places = ", ".join(
        f"{_ACCOUNT[key]} {power[key] / whole:.2%}" if whole > 0 else f"{_ACCOUNT[key]} {power[key]:.3g}"
        for key in list(_ACCOUNT)[1:]
    )
    backs = _on_backs(self)
    direct = "" if backs is None else f"\nof the light of lamps and suns {backs} fell on backs, and is no part of that"
    return f"{text}\npower in {whole:.5g} (on surfaces, all channels): {places}{direct}"


def as_table(self) -> str:
    """What Jupyter shows of a Solution."""
    s, power = self.surfels, _account(self)
    n, _, area = facts(s)
    inserted = int((self.levels < 0).sum())
    rows = [
        ("surfels", f"{n}, {inserted} of them inserted" if inserted else str(n)),
        ("bounds", box_text(s.bounds)),
        ("area", f"{area:.6g}"),
        ("error, estimated", f"unknown{_how_to_know(self)}" if math.isnan(self.error) else f"{self.error:.2%}"),
    ]
    if power is not None:
        whole, error = power["power_in"], self.history[-1].get("power_lost_error")
        for key, name in _ACCOUNT.items():
            share = f" ({power[key] / whole:.2%})" if whole > 0 and key != "power_in" else ""
            spread = f" ± {error:.2g}" if key == "power_lost" and isinstance(error, (int, float)) else ""
            rows.append((name, f"{power[key]:.5g}{spread}{share}"))
    if _on_backs(self) is not None:
        rows.append(("of lamps and suns, on backs", _on_backs(self)))
    rows.append(("seconds", f"{sum(self.timings.values()):.3g}"))
    return html_table("Solution", rows)


def _how_to_know(self):
    """Where an error is not known and can be found, how."""
    is_asked = bool(self.history) and "error" in self.history[-1]
    can_tell = math.isnan(self.error) and self._scene is not None and not is_asked and bool(np.any(self.irradiance))
    return "; estimate_error() finds the error" if can_tell else ""


def _account(self):
    """The figures of the power by their keys in the history; None where they are not all there."""
    last = self.history[-1] if self.history else {}
    power = {key: last.get(key) for key in _ACCOUNT}
    # A solution from a file has what the file says, which may be anything.
    return power if all(isinstance(value, (int, float)) for value in power.values()) else None


def _on_backs(self):
    """Of the light of lamps and suns the share that backs take, as text; None where that is next to nothing."""
    share = self.history[-1].get("direct_on_backs") if self.history else None
    known = isinstance(share, (int, float)) and share >= 0.00005
    return f"{share:.2%}" if known else None
