"""Printable materials: what the drop test needs to know of them, and where the figures come from."""

from __future__ import annotations

import tomllib
from pathlib import Path

import msgspec

from mechstyle.errors import BadInput, unknown


class Material(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """An isotropic elastic material with a yield strength.

    Attributes:
        name: Its short name.
        youngs_modulus: E [MPa].
        poisson_ratio: ν, in (0, 0.5).
        density: ρ [g/mm³].
        yield_strength: S_yield, uniaxial [MPa].
        safety_coefficient: λ_s in σ_c = λ_s S_yield (Stava et al. 2012); used by the `paper` criterion.
        source: Where the figures come from.
    """

    name: str
    youngs_modulus: float
    poisson_ratio: float
    density: float
    yield_strength: float
    safety_coefficient: float = 0.2
    source: str = "given by the user"

    def __post_init__(self) -> None:
        """Refuse values no solid has, naming the field, the value and the range."""
        limits = {
            "youngs_modulus": (0.1, 1e6, "MPa"),
            "poisson_ratio": (0.0, 0.495, ""),
            "density": (1e-5, 3e-2, "g/mm³ (water is 1e-3)"),
            "yield_strength": (1e-3, 1e4, "MPa"),
            "safety_coefficient": (1e-3, 1.0, ""),
        }
        for field, (low, high, unit) in limits.items():
            value = getattr(self, field)
            if not low <= value <= high:
                raise BadInput(f"material {self.name!r}: {field} is {value:g}, but must lie in {low:g} to {high:g} {unit}".rstrip())

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


LIBRARY: dict[str, Material] = {
    material.name: material
    for material in (
        Material(
            name="PLA",
            youngs_modulus=3500.0,
            poisson_ratio=0.36,
            density=1.24e-3,
            yield_strength=45.6,
            source="Faruqi et al. 2025 (MechStyle), doi 10.1145/3745778.3766655",
        ),
        Material(
            name="PETG",
            youngs_modulus=2200.0,
            poisson_ratio=0.38,
            density=1.27e-3,
            yield_strength=50.0,
            source="typical value, E 2.2 GPa as MakeItFrom tabulates PETG, strength midway in 44 to 56 MPa reported for flat prints",
        ),
        Material(
            name="ABS",
            youngs_modulus=2413.0,
            poisson_ratio=0.35,
            density=1.04e-3,
            yield_strength=33.0,
            source="Stratasys, Fortus ABS-M30 white paper: E (ASTM D638), tensile strength for yield (ISO 527); ρ and ν typical value",
        ),
        Material(
            name="PA12",
            youngs_modulus=1650.0,
            poisson_ratio=0.40,
            density=0.93e-3,
            yield_strength=48.0,
            source="sintered EOS PA 2200: density (safety data sheet), tensile strength for yield (data sheet); E and ν typical value",
        ),
        Material(
            name="TPU",
            youngs_modulus=26.0,
            poisson_ratio=0.48,
            density=1.22e-3,
            yield_strength=8.6,
            source="typical value, thermoplastic polyurethane of 95 Shore A; it has no sharp yield",
        ),
        Material(
            name="Vero",
            youngs_modulus=2250.0,
            poisson_ratio=0.38,
            density=1.17e-3,
            yield_strength=47.5,
            source="Stratasys Vero (PolyJet), middle of E 2000 to 2500 MPa and tensile strength 40 to 55 MPa tabulated in PMC10406103; "
            "density and ν typical value",
        ),
        Material(
            name="Resin",
            youngs_modulus=2500.0,
            poisson_ratio=0.38,
            density=1.18e-3,
            yield_strength=50.0,
            source="typical value, standard stereolithography resin, post-cured: tensile strength 38 to 65 MPa, hardly any yield",
        ),
    )
}


def read_material(path: str | Path) -> Material:
    """A material from a TOML or JSON file with the fields of `Material`; BadInput says what is wrong in it."""
    file = Path(path)
    if not file.is_file():
        raise BadInput(f"material file {file} does not exist; name a library material ({', '.join(sorted(LIBRARY))}) or a .toml/.json file")
    try:
        text = file.read_text(encoding="utf-8")
        table = tomllib.loads(text) if file.suffix.lower() == ".toml" else msgspec.json.decode(text)
        return msgspec.convert(table, Material)
    except BadInput as error:
        raise BadInput(f"material file {file}: {error}") from error
    except (tomllib.TOMLDecodeError, msgspec.DecodeError, UnicodeDecodeError, OSError) as error:
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
