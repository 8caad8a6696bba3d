"""The stress that decides against beam theory and handbooks: plates of a printed wall's thickness, a hole, a fillet."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from mechstyle.fea.statics.load_test import StaticTest
from mechstyle.fea.statics.solve import Response
from mechstyle.fea.surface_stress import Deciding, SurfaceStress
from mechstyle.records.load_cases import Load, LoadCase, Patch, Support
from mechstyle.records.material import LIBRARY, Material
from mechstyle.records.mesh import Bools, TetMesh
from mechstyle.simulation.validation.cases import Result, compared
from mechstyle.simulation.validation.meshes import box
from mechstyle.simulation.validation.notches import THICKNESS, WIDTH, bar_with_fillets, bar_with_hole

PLA = LIBRARY["PLA"]
SPAN, BREADTH = 100.0, 20.0
"""Of the plates [mm]."""
CLAMP = 37.5
"""Beam theory at the clamp, 6 F L/(b t²) [MPa]: 45.6 MPa of PLA over it is a safety factor of 1.22."""
PLATES = {0.8: (50, 10, 1), 2.0: (40, 8, 1), 4.0: (25, 5, 1), 6.0: (25, 5, 1), 8.0: (25, 5, 2)}
"""Cells of the plates by their thickness [mm]."""
FACTOR = 0.1
"""From 1.10 to 1.34 for 1.22."""
HOLE, FILLET = 3.35, 1.86
"""Stress concentration: Ø 6 in 20 mm over the stress far away (Howland 1930), radius 2 from 16 to 20 mm over that in the narrow part
(Pilkey, Peterson's Stress Concentration Factors)."""
PLATE, NOTCH = 0.10, 0.10


class Loaded(NamedTuple):
    """A body under a load.

    Attributes:
        mesh: The body.
        response: What the load does.
        reading: What reads it.
        border: Vertices on the border of support and load, shape [vertex_count].
    """

    mesh: TetMesh
    response: Response
    reading: SurfaceStress
    border: Bools

    @property
    def load(self) -> Deciding:
        """The stress that decides."""
        return self.reading.of_load(self.mesh, self.response.von_mises, self.response.corners, self.border)

    @property
    def landing(self) -> Deciding:
        """What would decide in a drop with this stress and this border for contact: without the stress at single vertices."""
        return self.reading.of_landing(self.mesh, self.response.von_mises, self.response.corners, self.border)


def plates() -> Iterator[Result]:
    """Cantilevers whose clamp sees 37.5 MPa: the peak that decides, as a load case and as a landing."""
    for thickness, counts in PLATES.items():
        mesh = box(counts, (SPAN, BREADTH, thickness))
        found = bent(mesh, CLAMP)
        note = f"beam theory at the clamp, {len(mesh.tets)} TET10, {counts[2]} through the wall"
        yield compared(f"plates: {thickness:g} mm, load", found.load.peak, CLAMP, PLATE, "MPa", note)
        yield compared(f"plates: {thickness:g} mm, landing", found.landing.peak, CLAMP, PLATE, "MPa", note)


def factor() -> Iterator[Result]:
    """The safety factor of a 4 mm plate whose clamp sees 37.5 MPa, in one and two layers."""
    for counts in ((25, 5, 1), (34, 6, 2)):
        mesh = box(counts, (SPAN, BREADTH, 4.0))
        measured = PLA.yield_strength / bent(mesh, CLAMP).load.peak
        note = f"beam theory at the clamp, {len(mesh.tets)} TET10; passes from 1.10 to 1.34"
        yield compared(f"factor: {counts[2]} through the wall", measured, PLA.yield_strength / CLAMP, FACTOR, "", note)


def notches() -> Iterator[Result]:
    """A hole and a fillet in tension: the largest resolved stress, and how much of it the mean along the surface sees."""
    holes = [bar_with_hole(3.0, *cells) for cells in ((24, 5, 1), (32, 6, 2))]
    fillets = [bar_with_fillets(2.0, *cells) for cells in ((4, 10, 1), (6, 12, 2))]
    for name, meshes, width, handbook in (("hole", holes, WIDTH, HOLE), ("fillet", fillets, WIDTH - 4.0, FILLET)):
        for mesh in meshes:
            load = held_and_loaded(mesh, (10.0 * width * THICKNESS, 0.0, 0.0)).load
            note = f"handbook; σ_2 reads {load.averaged / 10.0:.2f}; {len(mesh.tets)} TET10"
            yield compared(f"notches: {name}, {len(mesh.tets)} tetrahedra", load.peak / 10.0, handbook, NOTCH, "", note)


def bent(mesh: TetMesh, stress: float, material: Material = PLA) -> Loaded:
    """A cantilever along x with a given stress at its clamp by beam theory [MPa]."""
    length, width, thickness = np.ptp(mesh.vertices, axis=0)
    return held_and_loaded(mesh, (0.0, 0.0, -stress * width * thickness**2 / 6.0 / length), material)


def held_and_loaded(mesh: TetMesh, force: tuple[float, float, float], material: Material = PLA) -> Loaded:
    """Held at its low end along x, a force [N] at the other."""
    low, high = mesh.vertices[:, 0].min(), mesh.vertices[:, 0].max()
    case = LoadCase(
        name="load",
        supports=(Support(at=Patch(plane=(low, 0.0, 0.0, -1.0, 0.0, 0.0))),),
        loads=(Load(at=Patch(plane=(high, 0.0, 0.0, 1.0, 0.0, 0.0)), force=force),),
    )
    test = StaticTest(mesh, (case,))
    return Loaded(mesh, test.run(mesh, material)["load"], SurfaceStress(mesh), test.borders["load"])
