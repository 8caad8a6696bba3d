"""The recipe: all that decides a run, in chapters, and the flat view of its settings."""

from __future__ import annotations

import hashlib
import inspect
import math
import re
import sys
from collections.abc import Collection, Mapping
from typing import Any, ClassVar, Literal, get_args

import msgspec

from mechstyle.errors import BadInput, unknown
from mechstyle.records.infill import PATTERNS
from mechstyle.records.landings import POSES, STANDARDS, landings_after
from mechstyle.records.load_cases import LoadCase
from mechstyle.records.material import Material
from mechstyle.records.regions import Region

CONTROLS = ("linear", "exponential", "frozen", "none")
NORMALISATIONS = ("headroom", "own_max", "sigma_c")
SCHEDULES = ("every", "quadratic", "exponential", "geometry", "stress", "never")
CRITERIA = ("robust", "paper")
GUIDANCES = ("offline", "clip")
FIELDS = ("vertex", "network")
ELEMENTS = ("tet10", "tet4")
BASES = ("plain", "level", "free")
SIDES = ("auto", "outwards", "inwards", "both")
INSIDES = ("plain", "styled")
MOTIFS = ("height", "colour", "both")
LAYOUTS = ("tiled", "placed")
PROJECTIONS = ("box", "planar", "around")
Transfer = Literal["barycentric", "nearest"]

Choices = Mapping[str, Collection[str]]
Limits = Mapping[str, tuple[float, float]]

LONGEST_PROMPT = 500
"""Characters."""


class Chapter(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Settings that belong together; a setting is called by the name it is written under.

    The first sentence on an attribute is its help wherever it is set; what follows it is for readers of this.
    """

    CHOICES: ClassVar[Choices] = {}
    LIMITS: ClassVar[Limits] = {}
    RARE: ClassVar[frozenset[str]] = frozenset()
    """Settings without an option of their own on the command line: they are given with --set."""

    def __post_init__(self) -> None:
        values = {name: getattr(self, own) for name, own in zip(self.__struct_encode_fields__, self.__struct_fields__, strict=True)}
        for name, known in self.CHOICES.items():
            if values[name] not in known:
                raise unknown(name, str(values[name]), known)
        for name, (low, high) in self.LIMITS.items():
            value = values[name]
            if value is not None and not low <= value <= high:
                figure = "beyond any float" if isinstance(value, int) and abs(value) > sys.float_info.max else f"{value:g}"
                raise BadInput(f"{name.replace('_', ' ')} is {figure}, but must lie between {low:g} and {high:g}")


class Specimen(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """The meshes that are tested, by their digests; both "" for a recipe of any part.

    Attributes:
        surface: Digest of the standardised surface M_0.
        tetrahedra: Digest of its tetrahedra (meshing is not deterministic, so they are part of the recipe).
    """

    surface: str = ""
    tetrahedra: str = ""


class Style(Chapter, frozen=True, kw_only=True):
    """What the part is to look like.

    Attributes:
        prompt: The style, in words, or one for each place: "outside: brick; rim: gold studs". Kept as typed; "" for none.
        stylizer: Name of a plugged-in stylizer to use instead of the built-in styles. "" for those.
        guidance: What the style descends to, one of GUIDANCES: a target drawn offline, or what CLIP takes for the prompt.
        field: What is descended in, one of FIELDS: values per vertex, or the X-Mesh style field.
        clip: CLIP weights of guidance clip. Kept as `NAME@DIGEST`; "" offline.
        crops: Close looks at each view per iteration of CLIP guidance and loss, 4 as published.
        seed: Seed of everything random in the style.
        relief: Depth of the relief from its lowest to its highest [mm]; by default the prompt's, or what can be seen and the walls allow.
            It goes before an amplitude, and either before the prompt.
        amplitude: Half the depth of the relief over local wall thickness, instead of a depth in mm.
        side: Where the relief goes from the surface, one of SIDES: auto goes to both, but only outwards where walls are too thin to cut.
        feature: Size of the style's feature, such as the height of a brick [mm]; by default the prompt's, or what fits the part.
        image: A picture of yours as the style, a PNG or JPEG file. Here the digest of its pixels, which the run keeps; "" for none.
        image_size: Width of the picture, or of one of its tiles [mm]; by default the prompt's, or what fits the part.
        image_as: What is taken of the picture, one of MOTIFS: light stands out and dark is cut in, its colours, or both.
        image_layout: How often the picture is laid out, one of LAYOUTS: without end, or once on each side it is seen from.
        projection: How the picture lies on the part, one of PROJECTIONS: from six sides, from the one that shows most or that the prompt
            names, or around an upright axis.
    """

    CHOICES: ClassVar[Choices] = {
        "guidance": GUIDANCES, "field": FIELDS, "side": SIDES,
        "image_as": MOTIFS, "image_layout": LAYOUTS, "projection": PROJECTIONS,
    }  # fmt: skip
    LIMITS: ClassVar[Limits] = {
        "crops": (1, 16), "seed": (0, 2**32 - 1), "relief": (0.0, 20.0), "amplitude": (0.0, 2.0), "feature": (0.2, 500.0),
        "image_size": (0.5, 2000.0),
    }  # fmt: skip
    RARE: ClassVar = frozenset({"crops"})

    prompt: str
    stylizer: str = ""
    guidance: str = "offline"
    field: str = "vertex"
    clip: str = ""
    crops: int = 1
    seed: int = 0
    relief: float | None = None
    amplitude: float | None = None
    side: str = "auto"
    feature: float | None = None
    image: str = ""
    image_size: float | None = None
    image_as: str = "both"
    image_layout: str = "tiled"
    projection: str = "box"

    def __post_init__(self) -> None:
        super().__post_init__()
        check_prompt(self.prompt)
        if self.image and not re.fullmatch("[0-9a-f]{64}", self.image):
            raise BadInput(f"a recipe names a picture by the digest of its pixels, not {self.image[:60]!r}: draft it from the file")


class Restraint(Chapter, frozen=True, kw_only=True):
    """What holds the style back: stress, protected places, the inside, the base, and a correction at the end.

    Attributes:
        control: How stress restrains the style, one of CONTROLS. It turns demand into a mask.
        normalisation: What stress is compared with, one of NORMALISATIONS. Demand is stress over that.
        threshold: Demand at which a vertex may move no further; 1 is the normalisation's own limit, less is stricter.
        base: Relief on the faces the part stands on, one of BASES: none, drawn inwards so that it stands level, or as the style has it.
        inside: What becomes of hollows, bores and flat ends that meet something else, one of INSIDES.
        protect: Regions protected from the style.
        guarantee: Whether the finished relief is corrected until the part passes: lowered where it yields, no more than needed.
    """

    CHOICES: ClassVar[Choices] = {"control": CONTROLS, "normalisation": NORMALISATIONS, "base": BASES, "inside": INSIDES}
    LIMITS: ClassVar[Limits] = {"threshold": (0.01, 100.0)}
    RARE: ClassVar = frozenset({"guarantee"})

    control: str = "exponential"
    normalisation: str = "headroom"
    threshold: float = 1.0
    base: str = "plain"
    inside: str = "plain"
    protect: tuple[Region, ...] = ()
    guarantee: bool = True

    @property
    def feedback(self) -> bool:
        """Whether simulation restrains the style (MechStyle) or not (Freestyle)."""
        return self.control != "none"


class Schedule(Chapter, frozen=True, kw_only=True):
    """How long the style grows, and when it is simulated meanwhile.

    Attributes:
        iterations: Stylization iterations.
        when: When to simulate while the style grows, one of SCHEDULES: never drops the finished relief and corrects it, without masks;
            a control asked for brings `stress`.
        every: Interval of the `every` schedule [iterations].
        travel: Displacement since the last simulation over local thickness that triggers `geometry` and `stress`.
    """

    CHOICES: ClassVar[Choices] = {"schedule": SCHEDULES}
    LIMITS: ClassVar[Limits] = {"iterations": (1, 100_000), "every": (1, 100_000), "travel": (1e-3, 10.0)}
    RARE: ClassVar = frozenset({"travel"})

    iterations: int = 200
    when: str = msgspec.field(default="never", name="schedule")
    every: int = 20
    travel: float = 0.1


class StrengthTest(Chapter, frozen=True, kw_only=True):
    """What the part must survive, and how that is computed.

    Attributes:
        specimen: The meshes that are tested.
        material: The material of the part. Kept in full, so that a library that changes leaves the recipe as it was.
        loads: Load cases the part must carry besides the drop.
        criterion: What the part is judged by, one of CRITERIA: paper is the published rule and method, which leave little of most styles.
        tolerance: The most that may stay bent after a fall or a load [mm].
        height: Height of the fall the part is to survive [mm].
        orientations: Landings that are not nearly flat, flat counted as the first; each of them decides.
        poses: How these land: `fibonacci` every way, `resting` as the part comes to rest, `box26`, `box10` or `faces6` on faces, edges and
            corners of the box around it. One of POSES.
        standard: Drop standard whose orientations and height are simulated, one of STANDARDS. It brings poses, orientations and
            height unless they are given; "" for none. A verdict is no test to a standard.
        nearly_flat: Whether landings tilted by 3° onto the corners and sides of what the part stands on are judged, too.
        build_direction: Direction it is printed in, x, y, z or a vector such as 0,0,1: what pulls or shears layers apart is judged by their
            own strength. None for no layers; the material must know its `layer_ratio`.
        friction: Coulomb coefficient of the floor.
        contact_stiffness: Stiffness of the published method's penalty floor at each node [N/mm], 0 for a rigid floor. Of criterion paper
            alone, which brings it: it softens with every coarser mesh and lets rough undersides off.
        window: Simulated time after first touch [ms]; by default until the impact has ended.
        element: `tet10`, or `tet4` as in the published study, which is several times too stiff in thin walls.
        damping: Share of critical damping of each tetrahedron.
        transfer: How stress gets from tets to surface, `barycentric` or `nearest` (the paper's unit-box nearest neighbour).
    """

    CHOICES: ClassVar[Choices] = {
        "criterion": CRITERIA, "poses": POSES, "standard": ("", *STANDARDS), "element": ELEMENTS, "transfer": get_args(Transfer),
    }  # fmt: skip
    LIMITS: ClassVar[Limits] = {
        "tolerance": (0.01, 100.0), "height": (1.0, 1e5), "orientations": (1, 512), "friction": (0.0, 2.0), "window": (0.05, 50.0),
        "contact_stiffness": (0.0, 1e5), "damping": (0.0, 1.0),
    }  # fmt: skip
    RARE: ClassVar = frozenset({"friction", "contact_stiffness", "element", "damping", "transfer"})

    specimen: Specimen = Specimen()
    material: Material
    loads: tuple[LoadCase, ...] = ()
    criterion: str = "robust"
    tolerance: float = 0.2
    height: float = 1500.0
    orientations: int = 1
    poses: str = "fibonacci"
    standard: str = ""
    nearly_flat: bool = True
    build_direction: tuple[float, float, float] | None = None
    friction: float = 0.0
    contact_stiffness: float = 0.0
    window: float | None = None
    element: str = "tet10"
    damping: float = 0.1
    transfer: Transfer = "barycentric"

    def __post_init__(self) -> None:
        super().__post_init__()
        direction = self.build_direction
        if direction is None:
            return
        if not (math.isfinite(math.hypot(*direction)) and math.hypot(*direction) > 0.0):
            raise BadInput(f"build direction is {direction}, but must be x, y, z or a vector of some length")
        if self.material.layer_ratio is None:
            raise BadInput(
                f"the strength of {self.material.label} across its layers is not known: leave the build direction out, or give the"
                " material in a file with a layer_ratio, strength across over strength along the layers, such as 0.5"
            )

    @property
    def floor(self) -> float:
        """Stiffness of the floor at each node [N/mm], 0 for a rigid one: every criterion but `paper` has a rigid floor."""
        return self.contact_stiffness if self.criterion == "paper" else 0.0

    @property
    def across_layers(self) -> tuple[float, float, float]:
        """Build direction over the strength ratio of layers, of which `fea.elasticity.equivalent_stress` makes use; zero if not judged."""
        if self.build_direction is None or self.material.layer_ratio is None:
            return (0.0, 0.0, 0.0)
        steep = math.hypot(*self.build_direction) * self.material.layer_ratio
        x, y, z = (part / steep for part in self.build_direction)
        return x, y, z

    @property
    def layers_judged(self) -> str:
        """What is assumed of layers, in words; "" if they are not judged."""
        if self.build_direction is None:
            return ""
        x, y, z = self.build_direction
        source = self.material.layer_source or self.material.source
        ratio = f"{self.material.layer_ratio:g} of the strength across them ({source})"
        return f"layers printed along ({x:g}, {y:g}, {z:g}) are judged with {ratio}"

    @property
    def after_standard(self) -> str:
        """Whose orientations are simulated, in words; "" without a standard."""
        return landings_after(self.standard, poses=self.poses, orientations=self.orientations, height=self.height)


class Delivery(Chapter, frozen=True, kw_only=True):
    """What a printer can make of the part, and what its walls must have for it.

    Attributes:
        nozzle: Diameter of the printer's nozzle [mm]: features that are not given are sized for it, and finer ones noted; 0 for no rule.
        minimum_wall: The thinnest wall the style may leave [mm]; 0 for no rule.
        strengthen: How much a plain part that does not hold is first thickened where it is overloaded, at most [mm]; 0 for not at all.
    """

    LIMITS: ClassVar[Limits] = {"nozzle": (0.0, 5.0), "minimum_wall": (0.0, 100.0), "strengthen": (0.0, 20.0)}

    nozzle: float = 0.4
    minimum_wall: float = 0.8
    strengthen: float = 0.0


class Printed(Chapter, frozen=True, kw_only=True):
    """How the part is printed inside; solid unless an infill is given.

    Attributes:
        infill: Share of the inside that the infill fills; 100 % is a solid part, of which walls and layers say nothing.
        infill_pattern: How the infill runs, one of PATTERNS.
        walls: Lines of plastic along every outline.
        top: Solid layers below what looks up.
        bottom: Solid layers above what looks down.
        layer_height: Height of a layer [mm].
        line_width: Width of a line of plastic [mm].
    """

    CHOICES: ClassVar[Choices] = {"infill_pattern": tuple(PATTERNS)}
    LIMITS: ClassVar[Limits] = {
        "infill": (0.0, 1.0), "walls": (0, 100), "top": (0, 1000), "bottom": (0, 1000),
        "layer_height": (0.02, 2.0), "line_width": (0.05, 3.0),
    }  # fmt: skip

    infill: float = 1.0
    infill_pattern: str = "gyroid"
    walls: int = 3
    top: int = 5
    bottom: int = 4
    layer_height: float = 0.2
    line_width: float = 0.42

    @property
    def solid(self) -> bool:
        """Whether all of the part is plastic."""
        return self.infill >= 1.0

    @property
    def words(self) -> str:
        """Which print is meant, as a verdict says it."""
        if self.solid:
            return "solid"
        walls = f"{self.walls} wall{'' if self.walls == 1 else 's'} of {self.line_width:g} mm"
        layers = f"{self.top} solid layers of {self.layer_height:g} mm on top and {self.bottom} below"
        return f"{walls}, {layers}, {f'{100.0 * self.infill:g} % {self.infill_pattern}' if self.infill else 'no infill'}"


def _article(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def check_prompt(prompt: str) -> None:
    """Refuse a prompt that is no text, or too long, with BadInput, without repeating it."""
    if not isinstance(prompt, str):
        raise BadInput(f"a prompt is text, such as 'brick', not {_article(type(prompt).__name__)}")
    if len(prompt) > LONGEST_PROMPT:
        raise BadInput(f"the prompt has {len(prompt)} characters, but may have {LONGEST_PROMPT}: name styles, colours, sizes, places")


class Recipe(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """All that decides a run, and nothing else: no times, hosts or paths.

    Who types settings types them flat, by names that no two chapters share: `Recipe.of(prompt="brick", height=1000.0, …)`.

    Attributes:
        style: What the part is to look like.
        restraint: What holds the style back.
        schedule: How long the style grows, and when it is simulated meanwhile.
        test: What the part must survive, of which material and meshes.
        delivery: What a printer can make of the part.
        printed: How it is printed inside.

    Example:
        >>> ms.Recipe.of(prompt="brick", material=ms.LIBRARY["PLA"], height=1000.0).test.height
        1000.0
    """

    style: Style
    restraint: Restraint = Restraint()
    schedule: Schedule = Schedule()
    test: StrengthTest
    delivery: Delivery = Delivery()
    printed: Printed = Printed()

    @classmethod
    def of(cls, *, surface: str = "", tetrahedra: str = "", **settings: Any) -> Recipe:
        """A recipe of flat settings: prompt and material, and what differs from the defaults; meshes as in `Specimen`.

        BadInput if a name is unknown or a value out of range.
        """
        given = _by_chapter(settings)
        given["test"]["specimen"] = Specimen(surface=surface, tetrahedra=tetrahedra)
        return cls(**{chapter: kind(**given[chapter]) for chapter, kind in CHAPTERS.items()})

    def with_settings(self, **changes: Any) -> Recipe:
        """This recipe with some settings changed, given flat; BadInput for an unknown name or a value out of range."""
        given = {chapter: changed for chapter, changed in _by_chapter(changes).items() if changed}
        return msgspec.structs.replace(
            self, **{chapter: msgspec.structs.replace(getattr(self, chapter), **changed) for chapter, changed in given.items()}
        )

    def on(self, **digests: str) -> Recipe:
        """This recipe with other meshes: digests of `surface`, `tetrahedra` or both."""
        specimen = msgspec.structs.replace(self.test.specimen, **digests)
        return msgspec.structs.replace(self, test=msgspec.structs.replace(self.test, specimen=specimen))

    @property
    def digest(self) -> str:
        """SHA-256 of the recipe's canonical JSON."""
        return hashlib.sha256(msgspec.json.encode(self, order="deterministic")).hexdigest()

    @property
    def settings(self) -> dict[str, Any]:
        """Every setting by name, chapter by chapter."""
        return {name: getattr(getattr(self, chapter), attribute) for name, (chapter, attribute) in _PLACES.items()}

    def differences(self, other: Recipe, *, by_figure: bool = False) -> tuple[tuple[str, Any, Any], ...]:
        """The settings that another recipe does not share: name, value here, value there.

        `by_figure` compares name and figures of the materials, for people to read, instead of the materials as a whole.
        """

        def flat(recipe: Recipe) -> dict[str, Any]:
            found: dict[str, Any] = {}
            for name, value in recipe.settings.items():
                found |= msgspec.structs.asdict(value) if by_figure and name == "material" else {name: value}
            return {name: value for name, value in found.items() if name not in ("source", "yielding_source", "layer_source")}

        here, there = flat(self), flat(other)
        return tuple((name, value, there[name]) for name, value in here.items() if value != there[name])


CHAPTERS: Mapping[str, Any] = {field.name: field.type for field in msgspec.structs.fields(Recipe)}
"""The chapters of a recipe, by the name of its field, in their order."""

_FIELDS = {
    field.encode_name: (chapter, field)
    for chapter, kind in CHAPTERS.items()
    for field in msgspec.structs.fields(kind)
    if field.type is not Specimen
}
_PLACES = {name: (chapter, field.name) for name, (chapter, field) in _FIELDS.items()}

SETTINGS = tuple(_FIELDS)
"""Names of the settings of a recipe, chapter by chapter."""

CHAPTER_OF: Mapping[str, str] = {name: chapter for name, (chapter, _) in _FIELDS.items()}
"""The chapter of a setting, by setting."""

TYPES: Mapping[str, Any] = {name: field.type for name, (_, field) in _FIELDS.items()}
"""Type of a setting, by setting."""

DEFAULTS: Mapping[str, Any] = {name: one.default for name, (_, one) in _FIELDS.items() if one.default is not msgspec.NODEFAULT}
"""What a setting is by default, by setting; those that every recipe must be given are not in it."""

CHOICES: Choices = {name: known for kind in CHAPTERS.values() for name, known in kind.CHOICES.items()}
"""The names a setting may have, by setting."""

LIMITS: Limits = {name: limits for kind in CHAPTERS.values() for name, limits in kind.LIMITS.items()}
"""The least and the greatest value of a setting, by setting, in its unit."""

OPTIONS = tuple(name for name in SETTINGS if not any(name in kind.RARE for kind in CHAPTERS.values()))
"""Settings with an option of their own on the command line; the others are given with --set."""

OF_FEEDBACK = ("control", "normalisation", "threshold", "base", "schedule", "every")
"""Options that restrain a style, or say when to simulate to that end: Freestyle has no use for them."""


def settings_of(chapter: str) -> tuple[str, ...]:
    """Names of the settings of a chapter."""
    return tuple(name for name, its in CHAPTER_OF.items() if its == chapter)


def _by_chapter(settings: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
    """Values by chapter and attribute."""
    given: dict[str, dict[str, Any]] = {chapter: {} for chapter in CHAPTERS}
    for name, value in settings.items():
        if name not in _PLACES:
            raise unknown("setting", name, SETTINGS, lists="docs/settings.md")
        chapter, attribute = _PLACES[name]
        given[chapter][attribute] = value
    return given


def direction_of(value: object) -> tuple[float, float, float]:
    """A direction given as x, y, z (of either sign and case), as text such as `0,0,1`, or as three numbers.

    BadInput if it is none of these.
    """
    axes = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    named = axes.get(value.strip().lower().lstrip("+-")) if isinstance(value, str) else None
    parts: Any = value.strip("[]() ").split(",") if isinstance(value, str) else value
    try:
        x, y, z = named or map(float, parts)
    except (TypeError, ValueError) as error:
        raise BadInput(f"a direction is x, y, z or three numbers such as 0,0,1, not {value!r}") from error
    return x, y, z


def described(name: str) -> str:
    """Description of a setting in one sentence with its unit and the names it may have.

    It is the first sentence on it in its chapter's docstring. Empty where Python runs without docstrings.
    """
    chapter, attribute = _PLACES[name]
    text = inspect.cleandoc(CHAPTERS[chapter].__doc__ or "").partition("Attributes:\n")[2]
    found = re.search(rf"^    {attribute}: (.+(?:\n        .+)*)", text, re.MULTILINE)
    if found is None:
        return ""
    sentence = " ".join(found[1].split()).partition(". ")[0].removesuffix(".") + "."
    return re.sub(r"\bone of [A-Z]+\b", f"one of {', '.join(filter(None, CHOICES.get(name, ())))}", sentence)
