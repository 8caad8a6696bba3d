"""What style and print have to do with each other: the thinnest wall that is printed, and whether more walls would do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mechstyle.fea.permanent_set import quantile
from mechstyle.records import Simulation, Verdict
from mechstyle.records.mesh import SurfaceMesh
from mechstyle.records.recipe import Recipe
from mechstyle.records.sentences import bend
from mechstyle.simulation.simulator import DropSimulator

MORE = 2
"""Walls more that are tried of a print that fails."""
SPOT = 4.0
"""Of the surface [mm²], on which the shell may be thinner: less is a nozzle's width of an edge."""


def thinnest_shell(surface: SurfaceMesh, recipe: Recipe) -> float:
    """The least thickness of walls and solid layers across them, on all of a surface but SPOT [mm].

    On a slope a layer shows no more of its walls than their width times the sine of the slope, nor of solid layers than their height times
    its cosine: the shell is thinnest where both give the same.
    """
    printed, up = recipe.printed, np.asarray(recipe.test.build_direction or (0.0, 0.0, 1.0))
    along = surface.face_normals @ (up / np.linalg.norm(up))
    layers = np.where(along > 0.0, printed.top, printed.bottom) * printed.layer_height
    depth = np.maximum(printed.walls * printed.line_width * np.sqrt(np.maximum(1.0 - along**2, 0.0)), layers * np.abs(along))
    return -quantile(-depth[:, None], surface.face_areas, SPOT)


def shell_words(surface: SurfaceMesh, recipe: Recipe) -> str:
    """How thick the walls of a print are at least, in a sentence; "" of a solid part."""
    if recipe.printed.solid:
        return ""
    return f"walls and solid layers are {thinnest_shell(surface, recipe):.2f} mm thick where they are thinnest, on slopes"


def with_more_walls(simulator: DropSimulator, simulation: Simulation, verdict: Verdict) -> str:
    """What MORE walls come to, where a print fails and they make it hold by itself: dropped and loaded as it was; else ""."""
    recipe = simulator.recipe
    if verdict.outcome != "FAILS" or recipe.printed.solid:
        return ""
    thicker = replace(simulator, recipe=recipe.with_settings(walls=recipe.printed.walls + MORE))
    found = thicker.simulate(simulation.displacement, thorough=True)
    other = thicker.judge(found, alone=True)
    if other.outcome != "HOLDS" or other.deciding is None:
        return ""
    gained = recipe.test.material.density * (found.volume * found.plastic_share - simulation.volume * simulation.plastic_share)
    return f"with {MORE} more walls it HOLDS: at worst {bend(other.deciding.permanent_set)} stays bent, and it weighs {gained:.1f} g more"
