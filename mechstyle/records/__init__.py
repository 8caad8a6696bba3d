"""The nouns, frozen: meshes, material, regions, load cases, recipe, simulation, verdict, checkpoint."""

import msgspec

from mechstyle.records.checkpoint import Checkpoint
from mechstyle.records.landings import POSES
from mechstyle.records.recipe import CONTROLS, CRITERIA, ELEMENTS, FIELDS, GUIDANCES, NORMALISATIONS, SCHEDULES, SETTINGS, Recipe
from mechstyle.records.simulation import Landing, LoadResult, Simulation
from mechstyle.records.verdict import Doubt, Outcome, Row, Verdict, judge

__all__ = [
    "CONTROLS", "CRITERIA", "ELEMENTS", "FIELDS", "GUIDANCES", "NORMALISATIONS", "POSES", "SCHEDULES", "SETTINGS", "Checkpoint",
    "Doubt", "Landing", "LoadResult", "Outcome", "Recipe", "Row", "Simulation", "Verdict", "judge",
]  # fmt: skip

for _kind in (Recipe, Checkpoint, Simulation, Verdict):
    msgspec.json.Decoder(_kind)  # learnt while this is imported, by one thread alone (`loop.objects.from_json` says why)
