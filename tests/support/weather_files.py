"""Files of weather: a year of clear hours at a place, as EPW has them."""

import numpy as np

HEADER = """LOCATION,HERE,-,NOW,surflux,000000,{latitude},{longitude},{zone:.1f},{altitude:.1f}
DESIGN CONDITIONS,0
TYPICAL/EXTREME PERIODS,0
GROUND TEMPERATURES,0
HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0
COMMENTS 1,
COMMENTS 2,
DATA PERIODS,1,{parts},Data,Sunday,1/1,12/31
"""
DAYS = (31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31)


def write_epw(path, above, direct_normal, diffuse, latitude=47.4, longitude=8.5, zone=1.0, altitude=400.0, parts=1):
    """above: (8760 parts,) W/m2 on a level plane above the air; direct_normal, diffuse: (8760 parts,) W/m2."""
    hours = [(month + 1, day + 1, hour + 1) for month in range(12) for day in range(DAYS[month]) for hour in range(24)]
    dates = [(*hour, 60 * (part + 1) // parts) for hour in hours for part in range(parts)]
    lines = [HEADER.format(latitude=latitude, longitude=longitude, zone=zone, altitude=altitude, parts=parts)]
    for (month, day, hour, minute), top, beam, sky in zip(dates, above, direct_normal, diffuse, strict=True):
        figures = [10.0, 5.0, 70, 95000, f"{top:.0f}", 1367, 300, f"{beam + sky:.0f}", f"{beam:.1f}", f"{sky:.1f}"]
        rest = [0, 0, 0, 0, 180, 2.0, 5, 5, 20.0, 77777, 9, 999999999, 0, 0.1, 0, 88, 0.2, 0.0, 0.0]
        lines.append(",".join(map(str, [2007, month, day, hour, minute, "?9", *figures, *rest])) + "\n")
    path.write_text("".join(lines))
    return path


def level_sun(latitude, longitude, zone, parts=1):
    """(8760 parts,) W/m2 above the air on a level plane in the middle of each record, by a sun of a line or two."""
    hours = (np.arange(8760 * parts) + 0.5) / parts
    days = hours / 24.0
    declination = np.radians(23.45) * np.sin(2 * np.pi * (284 + days) / 365)
    turn = np.radians(15.0 * (hours % 24.0 - 12.0 - zone) + longitude)
    up = np.radians(latitude)
    sine = np.sin(up) * np.sin(declination) + np.cos(up) * np.cos(declination) * np.cos(turn)
    return 1367.0 * sine.clip(0.0)
