"""Printable materials: what the drop test needs to know of them, and where the figures come from.

Example:
    >>> ms.LIBRARY["PLA"].yield_strength
    45.6
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import msgspec

from mechstyle.errors import BadInput, unknown
from mechstyle.records.written import read_table

LIMITS: Mapping[str, tuple[float, float, str]] = {
    "youngs_modulus": (0.1, 1e6, "MPa"),
    "poisson_ratio": (0.0, 0.495, ""),
    "density": (1e-5, 3e-2, "g/mm³ (water is 1e-3)"),
    "yield_strength": (1e-3, 1e4, "MPa"),
    "hardening": (0.0, 1e5, "MPa"),
    "elongation": (1e-3, 10.0, "(0.05 is 5 %)"),
    "safety_coefficient": (1e-3, 1.0, ""),
    "layer_ratio": (0.05, 1.0, ""),
}
"""Least and greatest value of a figure of any solid, and its unit."""

USUAL: Mapping[str, tuple[float, float]] = {
    "youngs_modulus": (10.0, 5e5),
    "poisson_ratio": (0.05, 0.495),
    "density": (2e-4, 2.3e-2),
    "yield_strength": (1.0, 3e3),
    "hardening": (1.0, 1e4),
    "elongation": (5e-3, 10.0),
    "safety_coefficient": (1e-2, 1.0),
    "layer_ratio": (0.05, 1.0),
}
"""Where the figures of solids usually lie; a figure that a change of unit brings there is taken for one in that unit."""

PER_CENT = ((1e-2, "per cent"),)
OTHER_UNITS: Mapping[str, tuple[tuple[float, str], ...]] = {
    "youngs_modulus": ((1e3, "GPa"), (1e-6, "Pa"), (1e-3, "kPa")),
    "poisson_ratio": PER_CENT,
    "density": ((1e-3, "g/cm³"), (1e-6, "kg/m³"), (1e3, "kg/mm³"), (1e6, "t/mm³")),
    "yield_strength": ((1e-6, "Pa"), (1e-3, "kPa"), (1e3, "GPa")),
    "hardening": ((1e-6, "Pa"), (1e-3, "kPa"), (1e3, "GPa")),
    "elongation": PER_CENT,
    "safety_coefficient": PER_CENT,
    "layer_ratio": PER_CENT,
}
"""Units in which data sheets state a figure, each with its factor to ours."""

RUBBERY = 0.45
"""Poisson's ratio from which a material is an elastomer."""

STIFF, STIFF_ELONGATION = 1000.0, 2.0
"""Young's modulus [MPa] from which no solid is drawn to three times its length before it breaks."""

SOFTEST = 10.0
"""Least Young's modulus of a solid that is no elastomer [MPa]; low-density polyethylene has 100."""

YIELD_STRAIN = {False: (1e-4, 0.1), True: (1e-4, 1.0)}
"""Least and greatest yield strength over E of a solid, and of an elastomer: soft metals are near 3e-4, plastics at 0.01 to 0.04."""

USUAL_STRAIN = {False: (4e-3, 0.06), True: (0.05, 0.6)}
"""The same where printed plastics lie."""


def _likely(field: str, value: float) -> str:
    """What a figure out of range was probably meant to be, as the end of a sentence; "" if nothing explains it."""
    low, high = USUAL[field]
    if field == "poisson_ratio" and high < value <= 0.5:
        return "; no solid is quite incompressible: write 0.49 for a rubber"
    for factor, unit in OTHER_UNITS[field]:
        if low <= value * factor <= high:
            return f"; it looks like {unit}: write {_four_digits(value * factor)}"
    return ""


def _four_digits(value: float) -> str:
    """A figure as people write it: what a change of unit adds behind the fourth digit is left out."""
    return f"{float(f'{value:.4g}'):g}"


def _mismatch(material: Material) -> str:
    """What is wrong with E, ν and yield strength taken together, in words; "" if nothing is."""
    young, strength, elastomer = material.youngs_modulus, material.yield_strength, material.poisson_ratio >= RUBBERY
    if young < SOFTEST and not elastomer:
        meant = _likely("youngs_modulus", young)
        return f"youngs_modulus is {young:g} MPa, softer than any solid with a Poisson's ratio of {material.poisson_ratio:g}{meant}"
    if material.elongation > STIFF_ELONGATION and young > STIFF:
        likely = _four_digits(0.01 * material.elongation)
        return f"elongation is {material.elongation:g}, which is {material.elongation:.0%}; it looks like per cent: write {likely}"
    low, high = YIELD_STRAIN[elastomer]
    if low <= strength / young <= high:
        if material.hardening <= young:
            return ""
        return f"hardening is {material.hardening:g} MPa, above youngs_modulus with {young:g} MPa: past yield a solid is softer than before"
    share = f"yield_strength is {strength:g} MPa and youngs_modulus {young:g} MPa, so it would yield at a strain of {strength / young:.2g}"
    usual_low, usual_high = USUAL_STRAIN[elastomer]
    stiffest = USUAL["youngs_modulus"][1] if not elastomer else 2e3
    strengths = ((6.894757e-3, "psi"), (1e-3, "kPa"), (1e3, "GPa"))
    for field, factor, unit in (("youngs_modulus", 1e3, "GPa"), *(("yield_strength", *other) for other in strengths)):
        changed = {"youngs_modulus": young, "yield_strength": strength} | {field: getattr(material, field) * factor}
        strain = changed["yield_strength"] / changed["youngs_modulus"]
        if usual_low <= strain <= usual_high and changed["youngs_modulus"] <= stiffest:
            return f"{share}; {field} looks like {unit}: write {_four_digits(changed[field])}"
    return f"{share}, which must lie in {low:g} to {high:g}: one of them is in another unit"


class Material(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An isotropic material that yields (von Mises), hardens in proportion to its plastic strain, and breaks.

    Attributes:
        name: Its short name.
        youngs_modulus: E [MPa].
        poisson_ratio: ν, in (0, 0.5).
        density: ρ [g/mm³].
        yield_strength: S_yield, uniaxial [MPa].
        hardening: Slope of stress over plastic strain past yield [MPa]; 0, the safe side, where it is not known.
        elongation: Elongation at break, 0.05 for 5 %; that of a brittle resin where it is not known.
        safety_coefficient: λ_s in σ_c = λ_s S_yield (Stava et al. 2012); used by the `paper` criterion.
        source: Where the figures come from.
        yielding_source: Where hardening and elongation come from.
        layer_ratio: Strength across printed layers over strength along them; None where no source states both.
        layer_source: Where that ratio comes from.

    Example:
        >>> brand = ms.Material(name="my PLA", youngs_modulus=3300.0, poisson_ratio=0.36, density=1.24e-3, yield_strength=52.0)
        >>> brand.label
        'my PLA'
    """

    name: str
    youngs_modulus: float
    poisson_ratio: float
    density: float
    yield_strength: float
    hardening: float = 0.0
    elongation: float = 0.02
    safety_coefficient: float = 0.2
    source: str = "given by the user"
    yielding_source: str = "given by the user, or assumed as those of a brittle resin"
    layer_ratio: float | None = None
    layer_source: str = ""

    def __post_init__(self) -> None:
        """Refuse figures no solid has, naming the field, the value, the range and the unit it was probably meant in."""
        for field, (low, high, unit) in LIMITS.items():
            value = getattr(self, field)
            if value is not None and not low <= value <= high:
                range_ = f"must lie in {low:g} to {high:g} {unit}".rstrip()
                raise BadInput(f"material {self.name!r}: {field} is {value:g}, but {range_}{_likely(field, value)}")
        if doubt := _mismatch(self):
            raise BadInput(f"material {self.name!r}: {doubt}")

    @property
    def label(self) -> str:
        """Name for verdicts: `generic PLA` for the figures of the library, which no brand vouches for, else the name alone."""
        known = LIBRARY.get(self.name)
        figures = ("youngs_modulus", "poisson_ratio", "density", "yield_strength", "hardening", "elongation")
        generic = known is not None and all(getattr(self, figure) == getattr(known, figure) for figure in figures)
        return f"generic {self.name}" if generic else self.name

    @property
    def lame_lambda(self) -> float:
        """First Lamé parameter λ = E ν / ((1 + ν)(1 − 2ν)) [MPa]."""
        return self.youngs_modulus * self.poisson_ratio / ((1 + self.poisson_ratio) * (1 - 2 * self.poisson_ratio))

    @property
    def shear_modulus(self) -> float:
        """Second Lamé parameter μ = E / (2 (1 + ν)) [MPa]."""
        return self.youngs_modulus / (2 * (1 + self.poisson_ratio))

    @property
    def critical_stress(self) -> float:
        """σ_c = safety_coefficient · yield_strength [MPa] (Stava et al. 2012)."""
        return self.safety_coefficient * self.yield_strength

    @property
    def bar_wave_speed(self) -> float:
        """Speed of a longitudinal wave in a thin bar, sqrt(E / ρ) [mm/ms = m/s]."""
        return float((self.youngs_modulus / self.density) ** 0.5)


class Materials(dict[str, Material]):
    """Materials by name; BadInput for a name that is not among them."""

    def __missing__(self, name: object) -> Material:
        """Name those that come near."""
        raise unknown("material", str(name), self)


LIBRARY: dict[str, Material] = Materials(
    (material.name, material)
    for material in (
        Material(
            name="PLA", youngs_modulus=3500.0, poisson_ratio=0.36, density=1.24e-3, yield_strength=45.6, layer_ratio=0.55,
            hardening=35.0, elongation=0.04,
            source="Faruqi et al. 2025 (MechStyle), doi 10.1145/3745778.3766655",
            yielding_source="elongation at break 3 to 6 % in data sheets of printed PLA; hardening E/100, hardly any, assumed",
            layer_source="0.50 and 0.53 in two Polymaker data sheets (TDS V5.3 and V5.4), 0.5 to 0.7 in printing guides",
        ),
        Material(
            name="PETG", youngs_modulus=2200.0, poisson_ratio=0.38, density=1.27e-3, yield_strength=50.0, layer_ratio=0.6,
            hardening=22.0, elongation=0.06,
            source="typical value, E 2.2 GPa as MakeItFrom tabulates PETG, strength midway in 44 to 56 MPa reported for flat prints",
            yielding_source="elongation at break 5 to 8 % in data sheets of printed PETG; hardening E/100 assumed",
            layer_source="25 to 38 MPa across, 44 to 56 MPa along layers, additive.tools",
        ),
        Material(
            name="ABS", youngs_modulus=2413.0, poisson_ratio=0.35, density=1.04e-3, yield_strength=33.0,
            hardening=24.0, elongation=0.04,
            source="Stratasys, Fortus ABS-M30 white paper: E (ASTM D638), tensile strength for yield (ISO 527); ρ and ν typical value",
            yielding_source="elongation at break 4 %, Stratasys, Fortus ABS-M30; hardening E/100 assumed",
        ),
        Material(
            name="PA12", youngs_modulus=1650.0, poisson_ratio=0.40, density=0.93e-3, yield_strength=48.0, layer_ratio=1.0,
            hardening=16.0, elongation=0.18,
            source="sintered EOS PA 2200: density (safety data sheet), tensile strength for yield (data sheet); E and ν typical value",
            yielding_source="elongation at break 18 %, EOS PA 2200; hardening E/100 assumed",
            layer_source="48 MPa in both directions, HP PA 12 data sheet (Multi Jet Fusion)",
        ),
        Material(
            name="TPU", youngs_modulus=26.0, poisson_ratio=0.48, density=1.22e-3, yield_strength=8.6, layer_ratio=0.6,
            hardening=5.0, elongation=4.0,
            source="typical value, thermoplastic polyurethane of 95 Shore A; it has no sharp yield",
            yielding_source="elongation at break 400 to 600 %; hardening from 8.6 to some 25 MPa over it",
            layer_source="12 to 24 MPa across, 22 to 36 MPa along layers, 95 Shore A, additive.tools",
        ),
        Material(
            name="Vero", youngs_modulus=2250.0, poisson_ratio=0.38, density=1.17e-3, yield_strength=47.5, layer_ratio=1.0,
            hardening=22.0, elongation=0.1,
            source="Stratasys Vero (PolyJet), middle of E 2000 to 2500 MPa and tensile strength 40 to 55 MPa tabulated in PMC10406103; "
            "density and ν typical value",
            yielding_source="elongation at break 10 to 25 % in Stratasys data sheets of Vero; hardening E/100 assumed",
            layer_source="assumed: layers cure into each other",
        ),
        Material(
            name="Resin", youngs_modulus=2500.0, poisson_ratio=0.38, density=1.18e-3, yield_strength=50.0, layer_ratio=1.0,
            hardening=25.0, elongation=0.02,
            source="typical value, standard stereolithography resin, post-cured: tensile strength 38 to 65 MPa, hardly any yield",
            yielding_source="elongation at break 2 to 6 %, the brittle end; hardening E/100 assumed",
            layer_source="assumed: layers cure into each other",
        ),
    )
)  # fmt: skip

SPREAD: Mapping[str, str] = {
    "PLA": "strength 23 to 65 MPa, E 2.0 to 3.5 GPa by brand",
    "PETG": "strength 38 to 56 MPa, E 2.0 to 2.2 GPa by brand",
    "ABS": "strength 33 to 40 MPa, E 1.8 to 3.2 GPa by brand",
    "PA12": "strength 43 to 52 MPa, E 1.5 to 1.8 GPa by process",
    "TPU": "E 24 to 247 MPa by grade and rate of loading",
    "Vero": "strength 40 to 65 MPa, E 2.0 to 3.0 GPa by source",
    "Resin": "strength 38 to 65 MPa by brand",
}
"""What is sold under a name of the library: how far figures published for it lie apart."""


def read_material(path: str | Path) -> Material:
    """A material from a TOML or JSON file with the fields of `Material`; BadInput says what is wrong in it."""
    file = Path(path)
    if not file.is_file():
        raise BadInput(f"material file {file} does not exist; name a library material ({', '.join(sorted(LIBRARY))}) or a .toml/.json file")
    try:
        return msgspec.convert(read_table(file), Material)
    except BadInput as error:
        raise BadInput(f"material file {file}: {error}") from error
    except ValueError as error:
        fields = "name, youngs_modulus, poisson_ratio, density, yield_strength"
        raise BadInput(f"material file {file}: {error}; it needs the fields {fields}") from error


def material_named(name: str | Path | Material) -> Material:
    """A material by library name (upper and lower case alike), by file path, or itself."""
    if isinstance(name, Material):
        return name
    text = str(name)
    if Path(text).suffix.lower() in (".toml", ".json"):
        return read_material(text)
    by_name = {key.lower(): value for key, value in LIBRARY.items()}
    if text.lower() not in by_name:
        raise unknown("material", text, LIBRARY)
    return by_name[text.lower()]
