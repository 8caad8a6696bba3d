"""Records with values a careless format would lose."""

import numpy as np

from mechstyle.records import Checkpoint, Landing, LoadResult, Recipe, Row, Simulation, Verdict
from mechstyle.records.material import LIBRARY

COUNT = 7
STRENGTH, FALL = 45.6, 1500.0
"""Yield strength [MPa] and height of the fall [mm] of `recipe`."""


def recipe(**changes):
    return Recipe.of(**{"surface": "5" * 64, "tetrahedra": "7" * 64, "prompt": "brick", "material": LIBRARY["PLA"], **changes})


def row(height=2000.0, **changes):
    """A flat landing from whose critical height [mm] all else follows."""
    stress = STRENGTH * (FALL / height) ** 0.5
    fields = {"test": "flat", "landing": "flat", "stress": stress, "limit": STRENGTH, "height": height, "asked": FALL, "decides": True}
    return Row(**{"outcome": "HOLDS" if height >= FALL else "FAILS", **fields, **changes})


def load_row(factor=1.5, **changes):
    """A load that is borne so many times."""
    figures = {"stress": STRENGTH / factor, "limit": STRENGTH, "factor": factor, "asked": 1.0}
    fields = {"test": "load", "load": "coat", "decides": True, **figures}
    return Row(**{"outcome": "HOLDS" if factor >= 1.0 else "FAILS", **fields, **changes})


def published_row(factor=0.76, **changes):
    """The literal maximum, which decides nothing."""
    return load_row(factor, **{"test": "published rule", "load": "", "landing": "flat", "decides": False, **changes})


def verdict(*rows, **changes):
    """A verdict of these rows, by default one that holds."""
    rows = rows or (row(0.1 + 0.2 + 2000.0), published_row())
    worst = max((one.outcome for one in rows if one.decides), key=("HOLDS", "NO WORSE", "UNKNOWN", "FAILS").index)
    fields = {"criterion": "robust", "fall": FALL, "strength": STRENGTH, "material": "PLA", "style": "brick"}
    return Verdict(**{"outcome": worst, "rows": rows, **fields, **changes})


VERDICT = verdict()
UNKNOWN = Verdict(outcome="UNKNOWN", criterion="robust", fall=FALL, strength=STRENGTH, material="PLA", failure="the integration blew up")
# Values a careless format would lose: the sign of zero, subnormals, the last bit, what is not a number.
AWKWARD = np.array([-0.0, 1e-45, np.nextafter(np.float32(1), np.float32(2)), np.pi, -3.4e38, np.inf, np.nan], np.float32)


def checkpoint(iteration=3, **changes):
    flat = {name: np.full(COUNT, 0.5) for name in ("mask", "share", "anchor", "stress", "demand")}
    rest = {"parent": "", "recipe": "", "simulated_at": 0, "style_loss": 0.1 + 0.2}
    colour = np.linspace(0, 1, 3 * COUNT).reshape(COUNT, 3)
    return Checkpoint(**{"iteration": iteration, "displacement": AWKWARD, "colour": colour, **flat, **rest, **changes})


def landing(name="flat", **changes):
    fields = {
        "way": "flat", "normal": (0.0, 0.0, 1.0), "stress": 0.1 + 0.2, "maximum": 30.0, "where": (0.1, -0.0, 1e-300), "fall": FALL,
        "critical_height": 2000.0,
    }  # fmt: skip
    return Landing(**{"name": name, **fields, **changes})


def simulation(**changes):
    """A test with a flat landing, two that are nearly flat, and a load; the fields differ everywhere."""
    nearly = [landing(name, way="nearly flat", normal=(0.1, 0.0, 0.99), exponent=0.4) for name in ("tilted left", "tilted right")]
    load = LoadResult(name="coat", stress=20.0, maximum=40.0, where=(0.0, 0.0, 0.0), deflection=0.1)
    fields = {
        "displacement": AWKWARD, "contact": np.arange(COUNT) % 2 == 0, "landings": (landing(), *nearly), "loads": (load,),
        "landing_stress": np.arange(3 * COUNT).reshape(3, COUNT) / 3, "load_stress": np.arange(COUNT)[None] / 7,
        "backed_off": 0.25, "deviation": 0.1, "time_step": 1e-4, "steps": 2752, "added_mass": 0.002, "meshing": "fresh",
        "failure": "the integration blew up",
    }  # fmt: skip
    return Simulation(**{**fields, **changes})
