"""`surflux bench --site FOLDER --only solar`: a year of sun and sky on open planes, and how far seeds differ on a tile.

Needs pvlib, and for weather and the tile SURFLUX_DATA.
"""

import importlib.util
import os
from pathlib import Path

import numpy as np

import surflux as sf
from surflux.bench import scenes

YEAR = 2025
PLACES = {"Cape Town": (-33.9, 18.4), "Singapore": (1.35, 103.8), "Zurich": (47.4, 8.5), "Oslo": (59.9, 10.7)}
WEATHER = "weather/NLD_Amsterdam062400_IWEC.epw"
TILE, TILE_PLACE, TILE_POINTS = "scans/autzen_trim.laz", (44.05, -123.07), 10_000
SEEDS = 0, 1, 2


def rows(threads=None):
    """kWh/m2 of a year, beside what is expected, and how far off the first is from that, %."""
    if importlib.util.find_spec("pvlib") is None:
        raise ImportError("--only solar: needs pvlib: pip install 'surflux[solar]'")
    found = [_row(f"open level plane, {name}", "pvlib, each five minutes", *_clear(*at)) for name, at in PLACES.items()]
    if not scenes.scans_for("weather and tile"):
        return found
    found.append(_row("open level plane, Amsterdam's weather", "its file", *_weather()))
    means = [_tile(seed, threads) for seed in SEEDS]
    farthest = max(means, key=lambda mean: abs(mean - np.mean(means)))
    return [*found, _row("airborne LiDAR, farthest of three seeds", "mean of the seeds", farthest, np.mean(means))]


def _row(what, against, total, expected):
    row = {"what": what, "kWh/m²": round(float(total)), "against": against, "expected": round(float(expected))}
    return row | {"off, %": float(f"{100.0 * (total / expected - 1.0):.2g}")}


def _clear(latitude, longitude):
    import pandas as pd
    import pvlib

    found = sf.solar_irradiation(_plane(), (latitude, longitude), YEAR)
    times = pd.date_range(f"{YEAR}-01-01 00:02:30", f"{YEAR + 1}-01-01", freq="5min", tz="UTC")
    sky = pvlib.location.Location(latitude, longitude, altitude=0.0).get_clearsky(times, model="ineichen")
    return found.total.mean(), sky["ghi"].sum() / 12.0 / 1000.0


def _weather():
    import pvlib

    path = Path(os.environ["SURFLUX_DATA"]) / WEATHER
    return sf.solar_irradiation(_plane(), epw=path).total.mean(), pvlib.iotools.read_epw(path)[0]["ghi"].sum() / 1000.0


def _plane():
    return sf.Surfels.from_mesh(([[0, 0, 0], [9, 0, 0], [9, 9, 0], [0, 9, 0]], [[0, 1, 2, 3]]))


def _tile(seed, threads):
    """Mean by area of some of the tile's points."""
    surfels = sf.read(Path(os.environ["SURFLUX_DATA"]) / TILE).thinned(TILE_POINTS)
    found = sf.solar_irradiation(surfels, TILE_PLACE, YEAR, seed=seed, threads=threads)
    return np.average(found.total, weights=found.surfels.areas)
