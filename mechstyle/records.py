"""What a run is made of: the recipe that decides it, what a drop test measured, the verdict, and one checkpoint per iteration."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields
from typing import Any, Literal

import msgspec
import numpy as np
from numpy.typing import NDArray

from mechstyle.errors import BadInput, unknown
from mechstyle.load_cases import LoadCase
from mechstyle.material import Material
from mechstyle.mesh import frozen_array
from mechstyle.regions import Region

CONTROLS = ("linear", "exponential", "frozen", "none")
NORMALISATIONS = ("headroom", "own_max", "sigma_c", "yield")
SCHEDULES = ("every", "quadratic", "exponential", "geometry", "stress", "never", "always")
CRITERIA = ("robust", "paper")
GUIDANCES = ("offline", "clip")
FIELDS = ("vertex", "network")
ELEMENTS = ("tet10", "tet4")
POSES = {"fibonacci": 5, "tilts": 8, "resting": 8}
"""Ways a part may land, and how many drops each takes unless told: all directions, small tilts, or what it comes to rest on."""

Outcome = Literal["VIABLE", "FAILS", "UNKNOWN"]


class Recipe(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All that decides a run, and nothing else: no times, hosts or paths.

    Attributes:
        surface: Digest of the standardised surface M_0.
        tetrahedra: Digest of its tetrahedra (meshing is not deterministic, so they are part of the recipe).
        prompt: The style asked for, as typed; "" for none.
        stylizer: Name of a plugged-in stylizer that draws it, "" for the built-in ones.
        guidance: What the style descends to, one of GUIDANCES: a target drawn offline, or what CLIP takes for the prompt.
        field: What is descended in, one of FIELDS: values per vertex, or the X-Mesh style field.
        clip: CLIP weights, `NAME@DIGEST`; "" offline.
        crops: Close looks at each view per iteration of CLIP guidance and loss, 4 as published.
        material: The material, in full.
        iterations: Stylization iterations N.
        seed: Seed of everything random in the style.
        amplitude: Relief height over local wall thickness.
        control: How demand becomes a mask, one of CONTROLS.
        normalisation: How stress becomes demand, one of NORMALISATIONS.
        threshold: Demand at which a vertex may move no further; 1 is the normalisation's own limit, less is stricter.
        memory: Whether a vertex once restrained stays so (running minimum of the mask).
        retraction: Whether the relief shrinks by half where stress exceeds 0.9 of the allowable.
        protect_resting_face: Whether the relief fades out towards the face the part rests on.
        protect: Regions the style must leave alone.
        minimum_wall: The thinnest wall the style may leave [mm]; 0 for no rule.
        loads: Load cases the part must carry besides the drop.
        schedule: When to simulate, one of SCHEDULES.
        every: Interval of the `every` schedule [iterations].
        travel: Displacement since the last simulation over local thickness that triggers `geometry` and `stress`.
        criterion: What viable means, one of CRITERIA.
        guarantee: Whether the finished relief is backed off until it is viable.
        orientations: Drops in the final test, the first as placed; of resting poses at most so many.
        poses: How the others land, one of POSES: `fibonacci` every way, `tilts` nearly as placed, `resting` as the part comes to rest.
        drop_height: Height of fall [mm].
        friction: Coulomb coefficient of the floor.
        window: Simulated time after first touch [ms].
        element: `tet10`, or `tet4` as in the published study, which is several times too stiff in thin walls.
        damping: Kelvin-Voigt time β [ms].
        transfer: How stress gets from tets to surface, `barycentric` or `nearest` (the paper's unit-box nearest neighbour).
    """

    surface: str
    tetrahedra: str
    prompt: str
    material: Material
    stylizer: str = ""
    guidance: str = "offline"
    field: str = "vertex"
    clip: str = ""
    crops: int = 1
    iterations: int = 200
    seed: int = 0
    amplitude: float = 0.15
    control: str = "exponential"
    normalisation: str = "headroom"
    threshold: float = 1.0
    memory: bool = True
    retraction: bool = True
    protect_resting_face: bool = True
    protect: tuple[Region, ...] = ()
    minimum_wall: float = 0.8
    loads: tuple[LoadCase, ...] = ()
    schedule: str = "stress"
    every: int = 20
    travel: float = 0.1
    criterion: str = "robust"
    guarantee: bool = True
    orientations: int = 5
    poses: str = "fibonacci"
    drop_height: float = 1500.0
    friction: float = 0.0
    window: float = 1.5
    element: str = "tet10"
    damping: float = 1e-4
    transfer: Literal["barycentric", "nearest"] = "barycentric"

    def __post_init__(self) -> None:
        """Refuse unknown names and values out of range, each in one sentence."""
        for field, known in (
            ("control", CONTROLS),
            ("normalisation", NORMALISATIONS),
            ("schedule", SCHEDULES),
            ("criterion", CRITERIA),
            ("guidance", GUIDANCES),
            ("field", FIELDS),
            ("element", ELEMENTS),
            ("poses", POSES),
            ("transfer", ("barycentric", "nearest")),
        ):
            if getattr(self, field) not in known:
                raise unknown(field, str(getattr(self, field)), known)
        limits = {
            "iterations": (1, 100_000),
            "crops": (1, 16),
            "every": (1, 100_000),
            "seed": (0, 2**32 - 1),
            "amplitude": (0.0, 2.0),
            "travel": (1e-3, 10.0),
            "threshold": (0.01, 100.0),
            "minimum_wall": (0.0, 100.0),
            "orientations": (1, 512),
            "drop_height": (1.0, 1e5),
            "friction": (0.0, 2.0),
            "window": (0.05, 50.0),
            "damping": (0.0, 0.1),
        }
        for field, (low, high) in limits.items():
            value = getattr(self, field)
            if not low <= value <= high:
                raise BadInput(f"{field.replace('_', ' ')} is {value:g}, but must lie between {low:g} and {high:g}")

    @property
    def digest(self) -> str:
        """SHA-256 of the recipe's canonical JSON."""
        return hashlib.sha256(msgspec.json.encode(self, order="deterministic")).hexdigest()

    @property
    def feedback(self) -> bool:
        """Whether simulation restrains the style (MechStyle) or not (Freestyle)."""
        return self.control != "none"


class Measures(msgspec.Struct, frozen=True, kw_only=True):
    """Scalar results of one drop test (or of the envelope of several): running-maximum von Mises stress [MPa].

    Attributes:
        peak: Largest 2 mm volume average.
        p999: Volume-weighted 99.9th percentile.
        p99: Volume-weighted 99th percentile.
        maximum: Literal maximum over the elements; depends on the mesh where contact is a point.
        where: Place of `peak` in the undeformed part [mm].
        volume: Volume of the tetrahedra [mm³].
    """

    peak: float
    p999: float
    p99: float
    maximum: float
    where: tuple[float, float, float]
    volume: float

    def or_worse(self, other: Measures) -> Measures:
        """The larger of each stress of two tests of one part, and where the larger peak is."""
        larger = {name: max(getattr(self, name), getattr(other, name)) for name in ("peak", "p999", "p99", "maximum")}
        return msgspec.structs.replace(self, where=self.where if self.peak >= other.peak else other.where, **larger)


class Landing(msgspec.Struct, frozen=True, kw_only=True):
    """One drop of a test in several orientations.

    Attributes:
        normal: Floor normal in the frame of the part, out of the floor.
        weight: Probability that a random drop lands so.
        measures: What that drop did.
    """

    normal: tuple[float, float, float]
    weight: float
    measures: Measures


class Loaded(msgspec.Struct, frozen=True, kw_only=True):
    """What one load case did to the part.

    Attributes:
        name: The case.
        peak: Largest 2 mm volume average of the von Mises stress [MPa].
        where: Place of `peak` in the undeformed part [mm].
        deflection: Largest displacement [mm].
    """

    name: str
    peak: float
    where: tuple[float, float, float]
    deflection: float

    @property
    def words(self) -> str:
        """Its figures, as they are printed."""
        x, y, z = self.where
        return f"{self.peak:.1f} MPa at ({x:.1f}, {y:.1f}, {z:.1f}) mm, gives way {self.deflection:.2f} mm"


@dataclass(frozen=True, eq=False)
class Simulation:
    """One drop test brought to the surface.

    Attributes:
        displacement: What was simulated [mm], shape [vertex_count]: the request, less what the tets could not follow.
        stress: Robust stress field that drives the mask and decides: of drop as placed and load cases [MPa], shape [vertex_count].
        envelope: The same over all orientations [MPa], shape [vertex_count]; equals `stress` for one orientation.
        probability: Probability that a random drop takes `stress` there beyond the yield strength, shape [vertex_count]; zero for one
            orientation. Of the drop alone.
        contact: Whether the surface there touched the floor in the as-placed drop, shape [vertex_count].
        as_placed: Measures of the as-placed drop and of all load cases, the largest of each.
        overall: Measures of the envelope over all orientations, None if only one was run.
        failure_probability: Probability that a random drop takes the peak of the part beyond the yield strength; zero for one orientation.
        landings: What each drop did, the first as placed; none if the drop failed.
        backed_off: Share of the surface whose displacement the morph had to reduce.
        deviation: Largest such reduction [mm].
        time_step: Step of the explicit integration [ms].
        steps: Steps per drop.
        added_mass: Mass added by scaling slivers, over the mass of the part.
        loaded: What each load case did.
        meshing: How the tetrahedra followed the surface: `morphed`, `fresh`, or why a fresh mesh could not be had.
        failure: Why there is no usable answer, "" if there is.
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
    failure_probability: float = 0.0
    landings: tuple[Landing, ...] = ()
    loaded: tuple[Loaded, ...] = ()
    meshing: str = "morphed"
    failure: str = ""

    def __post_init__(self) -> None:
        """Freeze the fields over the surface."""
        count = len(self.displacement)
        for name in ("displacement", "stress", "envelope", "probability", "contact"):
            kind = np.bool_ if name == "contact" else np.float32
            object.__setattr__(self, name, frozen_array(getattr(self, name), kind, (count,), name))

    @property
    def governing(self) -> str:
        """Name of the load case with the peak that decides, "" if it is the drop's."""
        return next((case.name for case in self.loaded if case.peak == self.as_placed.peak), "")


class Judgement(msgspec.Struct, frozen=True, kw_only=True):
    """One rule applied to one simulation.

    Attributes:
        rule: What was compared, in words.
        outcome: VIABLE, FAILS or UNKNOWN.
        value: The measure [unit].
        limit: What it may at most be [unit].
        unit: "MPa" or "x the original".
        marginal: Whether value and limit differ by less than 15 %.
    """

    rule: str
    outcome: Outcome
    value: float
    limit: float
    unit: str
    marginal: bool

    @property
    def safety_factor(self) -> float:
        """Limit over value; infinite for a value of zero, NaN for NaN."""
        return float("inf") if self.value == 0 else self.limit / self.value


class Verdict(msgspec.Struct, frozen=True, kw_only=True):
    """Whether the part survives, with the figures behind it.

    Attributes:
        outcome: The worst of the judgements that count under the criterion.
        criterion: `robust` or `paper`.
        as_placed: (A) peak stress of the drop as placed.
        all_orientations: (B) envelope over all orientations relative to the unstylized part, None if not run.
        literal: The published rule, max σ_vM ≤ S_yield, always shown, mesh-dependent.
        words: One sentence a person can act on.
    """

    outcome: Outcome
    criterion: str
    as_placed: Judgement
    all_orientations: Judgement | None
    literal: Judgement
    words: str

    @property
    def deciding(self) -> Judgement:
        """The as-placed judgement under the criterion in force; its value is the peak, its limit the allowable stress."""
        return self.literal if self.criterion == "paper" else self.as_placed

    @property
    def viable(self) -> bool:
        """Whether the outcome is VIABLE."""
        return self.outcome == "VIABLE"


@dataclass(frozen=True, eq=False)
class Checkpoint:
    """The state after one iteration: all that is needed to show it, resume from it and branch at it.

    Attributes:
        iteration: 0 for the unstylized part, then 1 to N; back-off rounds repeat N.
        parent: Digest of the checkpoint before it, "" for the first.
        recipe: Digest of the recipe in force.
        displacement: D_i along the original normals [mm], shape [vertex_count].
        colour: Display RGB in [0, 1], shape [vertex_count, 3]; half precision, finer than any screen, at half the disk.
        mask: Factor on further movement in [0, 1], shape [vertex_count].
        share: Factor on the style's target after retraction in [0, 1], shape [vertex_count].
        anchor: Displacement at the last simulation [mm], shape [vertex_count].
        stress: Field of the last simulation [MPa], shape [vertex_count].
        demand: s_norm of the last simulation, shape [vertex_count].
        simulated_at: Iteration of the last simulation.
        simulation: Digest of the stored last simulation, which also holds contact and all orientations.
        style_loss: Loss of this very surface and its colours against the style's target.
        reason: Why this iteration was simulated, "" if it was not.
        verdict: Verdict of this iteration's simulation, None if it was not simulated.
        final: Whether the run ended with this checkpoint.
        keyframe: State of the stylizer, kept now and then so that resuming need not replay everything; None in between.
    """

    iteration: int
    parent: str
    recipe: str
    displacement: NDArray[np.float32]
    colour: NDArray[np.float16]
    mask: NDArray[np.float32]
    share: NDArray[np.float32]
    anchor: NDArray[np.float32]
    stress: NDArray[np.float32]
    demand: NDArray[np.float32]
    simulated_at: int
    style_loss: float
    simulation: str = ""
    reason: str = ""
    verdict: Verdict | None = None
    final: bool = False
    keyframe: dict[str, NDArray[np.float32]] | None = None

    def __post_init__(self) -> None:
        """Freeze the fields over the surface."""
        count = len(self.displacement)
        for field in fields(self):
            value: Any = getattr(self, field.name)
            if isinstance(value, np.ndarray):
                kind, shape = (np.float16, (count, 3)) if field.name == "colour" else (np.float32, (count,))
                object.__setattr__(self, field.name, frozen_array(value, kind, shape, field.name))
