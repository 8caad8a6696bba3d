"""Results of a test: scalars of one drop, of each landing and of each load case, and fields over the surface."""

from __future__ import annotations

from dataclasses import dataclass, field

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.records.mesh import frozen_array


class Measures(msgspec.Struct, frozen=True, kw_only=True):
    """Scalar results of one drop test (or of the envelope of several): running-maximum von Mises stress [MPa].

    Attributes:
        peak: The larger of `surface` and `contact`, which decides.
        surface: Largest mean over 2 mm along the surface outside contact zones; under a load also the largest stress at a vertex of the
            surface that the mesh resolves.
        contact: Largest 2 mm volume average inside contact zones; under a load around the borders of supports and loads.
        p999: Volume-weighted 99.9th percentile.
        p99: Volume-weighted 99th percentile.
        maximum: Literal maximum over the elements; depends on the mesh where contact is a point.
        where: Place of `peak` in the undeformed part [mm].
        volume: Volume of the tetrahedra [mm³].
        surface_where, contact_where: Places of `surface` and `contact` [mm]; None in records of earlier versions.
    """

    peak: float
    p999: float
    p99: float
    maximum: float
    where: tuple[float, float, float]
    volume: float
    surface: float = 0.0
    contact: float = 0.0
    surface_where: tuple[float, float, float] | None = None
    contact_where: tuple[float, float, float] | None = None

    def or_worse(self, other: Measures) -> Measures:
        """The larger of each stress of two tests of one part, and where those are."""
        larger = {name: max(getattr(self, name), getattr(other, name)) for name in ("peak", "surface", "contact", "p999", "p99", "maximum")}
        places = {
            place: getattr(self if getattr(self, name) >= getattr(other, name) else other, place)
            for name, place in (("peak", "where"), ("surface", "surface_where"), ("contact", "contact_where"))
        }
        return msgspec.structs.replace(self, **larger, **places)


class Landing(msgspec.Struct, frozen=True, kw_only=True):
    """One drop of a test in several orientations.

    Attributes:
        name: What the landing is called; "" in records of earlier versions.
        normal: Floor normal in the frame of the part, out of the floor.
        weight: Its share of the landings: the probability that a random drop lands so, in poses that are a sample of such.
        measures: What that drop did.
        touches: Speed of the touching point at the start of each phase that was simulated [mm/ms = m/s].
        ended: Why it was followed no further, in words.
    """

    name: str = ""
    normal: tuple[float, float, float]
    weight: float
    measures: Measures
    touches: tuple[float, ...] = ()
    ended: str = ""


class LoadResult(msgspec.Struct, frozen=True, kw_only=True):
    """Result of one load case.

    Attributes:
        name: The case.
        peak: The larger of `surface` and `averaged` [MPa], which decides.
        where: Place of `peak` in the undeformed part [mm].
        deflection: Largest displacement [mm].
        surface: Largest von Mises stress at a vertex of the surface, of those where the mesh resolves it [MPa]; 0 if it does nowhere.
        averaged: Largest mean over 2 mm along the surface, or, around the borders of supports and loads, 2 mm volume average [MPa].
        measures: Its stress as that of a drop is measured, by which it is judged; None in records of earlier versions.
        border: What the stress heads for where supports and loads end and elements are too long to read it [MPa]; 0 where they are not.
    """

    name: str
    peak: float
    where: tuple[float, float, float]
    deflection: float
    surface: float = 0.0
    averaged: float = 0.0
    measures: Measures | None = None
    border: float = 0.0

    @property
    def measured(self) -> Measures:
        """Its measures; in records of earlier versions all of its stress counts as the surface's, whose limit is the lower one."""
        if self.measures is not None:
            return self.measures
        peak = self.peak
        return Measures(peak=peak, surface=peak, contact=self.averaged, p999=peak, p99=peak, maximum=peak, where=self.where, volume=0.0)

    @property
    def words(self) -> str:
        """Its figures, as they are printed."""
        x, y, z = self.where
        stress = f"{self.peak:.1f} MPa over 2 mm"
        if self.surface >= self.averaged:
            stress = f"{self.surface:.1f} MPa at the surface ({self.averaged:.1f} over 2 mm)"
        return f"{stress} at ({x:.1f}, {y:.1f}, {z:.1f}) mm, deflection {self.deflection:.2f} mm"


LEAST_CARRIED = 0.9
"""Share of a relief that tetrahedra must follow to judge it: what they do not follow bears no stress in them. A hook in bricks read 43 MPa
where 0.81 were carried, and 50 where 0.92 were."""

VOLUME_ERROR = 0.03
"""Relative difference of volume from the surface's above which tetrahedra are not used, or tell nothing for certain."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """One drop test brought to the surface.

    Attributes:
        displacement: What was simulated [mm], shape [vertex_count]: the request, less what the tets could not follow.
        stress: Stress that drives the mask and decides, its largest the peak: of drop as placed and load cases [MPa], shape [vertex_count].
        envelope: The same over all orientations that were dropped [MPa], shape [vertex_count].
        probability: Probability that a random drop takes `stress` there beyond the yield strength, shape [vertex_count]; zero for one
            orientation and for poses that are no sample of random drops. Of the drop alone.
        contact: Whether the surface there touched the floor in the as-placed drop, shape [vertex_count].
        as_placed: Measures of the as-placed drop and of all load cases, the largest of each: what is shown. Each is judged by itself.
        overall: Measures of the envelope over all orientations, None if only one was run.
        failure_probability: Probability that a random drop takes the peak of the part beyond the yield strength; None where `probability`
            is no such thing.
        landings: What each drop did, the first as placed; none if the drop failed.
        backed_off: Share of the surface whose displacement the morph had to reduce.
        deviation: Largest such reduction [mm].
        time_step: Step of the explicit integration [ms].
        steps: Steps per drop.
        added_mass: Mass added by scaling slivers, over the mass of the part.
        loaded: What each load case did.
        level_share: Share of the flat faces it stands on that the relief leaves on the floor, None for a part that stands on none.
        carried: Share of the relief that the boundary of the tetrahedra follows, 1 without any.
        carried_base: The same on the flat faces the part stands on, or the share of what is on the floor that theirs has there too,
            whichever is less; None where there is no relief on any.
        volume_error: Volume of the tetrahedra over that inside the surface, less 1; with or without relief, whichever is further off.
        mesh: Digest of the tetrahedra as they were made.
        meshing: How the tetrahedra followed the surface: `morphed`, or what else was tried and how it went.
        failure: Why there is no usable answer, "" if there is.
        tilted: Measures of the drops nearly as placed, the largest of each; None if there was none.
        tilted_stress: Surface stress outside the contact in those drops, the largest [MPa], shape [vertex_count]; zero if there was none.
        dropped: Measures of the as-placed drop alone, where there are load cases; None without, and in records of earlier versions.
        dropped_stress: Of `stress` that of the drop alone [MPa], shape [vertex_count], where there are load cases; else empty.
        loaded_stress: Of `stress` that of each load case [MPa], shape [case_count, vertex_count]; empty without any.
    """

    displacement: NDArray[np.float32]
    stress: NDArray[np.float32]
    envelope: NDArray[np.float32]
    probability: NDArray[np.float32]
    contact: NDArray[np.bool_]
    as_placed: Measures
    overall: Measures | None
    backed_off: float
    deviation: float
    time_step: float
    steps: int
    added_mass: float
    failure_probability: float | None = None
    landings: tuple[Landing, ...] = ()
    loaded: tuple[LoadResult, ...] = ()
    level_share: float | None = None
    carried: float = 1.0
    carried_base: float | None = None
    volume_error: float = 0.0
    mesh: str = ""
    meshing: str = "morphed"
    failure: str = ""
    tilted: Measures | None = None
    tilted_stress: NDArray[np.float32] = field(default_factory=lambda: np.zeros(0, np.float32))
    dropped: Measures | None = None
    dropped_stress: NDArray[np.float32] = field(default_factory=lambda: np.zeros(0, np.float32))
    loaded_stress: NDArray[np.float32] = field(default_factory=lambda: np.zeros((0, 0), np.float32))

    def __post_init__(self) -> None:
        """Freeze the fields over the surface."""
        count = len(self.displacement)
        if not len(self.tilted_stress):
            object.__setattr__(self, "tilted_stress", np.zeros(count, np.float32))
        for name in ("displacement", "stress", "tilted_stress", "envelope", "probability", "contact"):
            kind = np.bool_ if name == "contact" else np.float32
            object.__setattr__(self, name, frozen_array(getattr(self, name), kind, (count,), name))
        shapes: dict[str, tuple[int | None, ...]] = {"dropped_stress": (count,), "loaded_stress": (None, count)}
        for name, shape in shapes.items():
            values = getattr(self, name)
            held = frozen_array(values, np.float32, shape if values.size else values.shape, name)
            object.__setattr__(self, name, held)

    @property
    def drop(self) -> Measures:
        """Measures of the as-placed drop alone."""
        if self.dropped is not None:
            return self.dropped
        return self.landings[0].measures if self.loaded and self.landings else self.as_placed

    @property
    def drop_stress(self) -> NDArray[np.float32]:
        """Stress of the as-placed drop alone [MPa], shape [vertex_count]; in records of earlier versions the most that it can be."""
        return self.dropped_stress if self.dropped_stress.size else self.stress

    def load(self, name: str) -> Measures | None:
        """Measures of a load case, None if there was none of that name."""
        return next((case.measured for case in self.loaded if case.name == name), None)

    def load_stress(self, name: str) -> NDArray[np.float32]:
        """Stress under a load case [MPa], shape [vertex_count]; zero if there was none, in earlier records the most that it can be."""
        names = [case.name for case in self.loaded]
        if name not in names:
            return np.zeros_like(self.stress)
        return self.loaded_stress[names.index(name)] if len(self.loaded_stress) == len(names) else self.stress

    @property
    def least_carried(self) -> float:
        """The smaller share of the relief that the tetrahedra follow, of all of it and of that on the faces it stands on."""
        return float(np.min([self.carried, 1.0 if self.carried_base is None else self.carried_base]))  # NaN if one of them is

    @property
    def worst(self) -> Landing | None:
        """The landing with the largest peak, None if there is none."""
        return max(self.landings, key=lambda landing: landing.measures.peak, default=None)

    @property
    def governing(self) -> str:
        """Name of the load case with the peak that decides, "" if it is the drop's."""
        return next((case.name for case in self.loaded if case.peak == self.as_placed.peak), "")
