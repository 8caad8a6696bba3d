"""Materials: what a solid can be, where the figures come from, and files of one's own."""

import re

import msgspec
import pytest

from mechstyle.errors import BadInput
from mechstyle.records.material import LIBRARY, SPREAD, Material, material_named, read_material
from support import ROOT

STEEL = Material(name="steel", youngs_modulus=210e3, poisson_ratio=0.3, density=7.85e-3, yield_strength=235.0)
DOCUMENTED = (ROOT / "docs" / "loads.md").read_text(encoding="utf-8")
BRAND = re.search(r"```toml\n(# polyterra\.toml.*?)```", DOCUMENTED, re.DOTALL)[1]


def toml(**changes):
    fields = {"name": "own", "youngs_modulus": 3000.0, "poisson_ratio": 0.35, "density": 1.2e-3, "yield_strength": 40.0} | changes
    return "\n".join(f"{key} = {msgspec.json.encode(value).decode()}" for key, value in fields.items() if value is not None)


@pytest.mark.parametrize("material", LIBRARY.values(), ids=LIBRARY)
def test_library_materials_are_plastics_with_a_source(material):
    elastomer = material.name == "TPU"
    assert 0.9e-3 <= material.density <= 1.35e-3  # unfilled printable plastics, sintered ones with pores included
    assert (0.45 if elastomer else 0.33) <= material.poisson_ratio <= (0.49 if elastomer else 0.42)
    assert (10 if elastomer else 1000) <= material.youngs_modulus <= (100 if elastomer else 4000)
    strain = material.yield_strength / material.youngs_modulus
    assert (0.1 if elastomer else 0.01) <= strain <= (0.6 if elastomer else 0.04)  # plastics yield at one to four per cent
    assert 0.0 < material.hardening < 0.2 * material.youngs_modulus
    assert (1.0 if elastomer else 0.02) <= material.elongation <= (6.0 if elastomer else 0.2)
    for source in (material.source, material.yielding_source):
        assert len(source) > 20
        assert "user" not in source


def test_the_library_has_what_people_print_with_and_pla_is_the_paper_s():
    assert set(LIBRARY) == {"PLA", "PETG", "ABS", "PA12", "TPU", "Vero", "Resin"}
    pla = LIBRARY["PLA"]
    assert (pla.youngs_modulus, pla.poisson_ratio, pla.density, pla.yield_strength) == (3500.0, 0.36, 1.24e-3, 45.6)
    assert pla.critical_stress == pytest.approx(9.12)  # a fifth of yield (Stava et al. 2012)


def test_lame_parameters_of_steel_and_its_waves():
    # λ = Eν/((1+ν)(1−2ν)) and μ = E/(2(1+ν)) for E = 210 GPa, ν = 0.3, to be found in any table.
    assert pytest.approx(121_154, rel=1e-5) == STEEL.lame_lambda
    assert pytest.approx(80_769, rel=1e-5) == STEEL.shear_modulus
    assert pytest.approx(5172, rel=1e-3) == STEEL.bar_wave_speed  # m/s


@pytest.mark.parametrize("material", [*LIBRARY.values(), STEEL], ids=lambda material: material.name)
def test_youngs_modulus_and_poisson_ratio_come_back_from_the_lame_parameters(material):
    lam, mu = material.lame_lambda, material.shear_modulus
    assert mu * (3 * lam + 2 * mu) / (lam + mu) == pytest.approx(material.youngs_modulus)
    assert lam / (2 * (lam + mu)) == pytest.approx(material.poisson_ratio)


@pytest.mark.parametrize("material", LIBRARY.values(), ids=LIBRARY)
def test_a_material_survives_toml_and_json(material, tmp_path):
    table = msgspec.to_builtins(material)
    (tmp_path / "m.json").write_bytes(msgspec.json.encode(material))
    (tmp_path / "m.toml").write_text(toml(**table), encoding="utf-8")
    assert read_material(tmp_path / "m.json") == read_material(tmp_path / "m.toml") == material


def test_a_file_of_one_s_own_says_so(tmp_path):
    (tmp_path / "own.toml").write_text(toml(), encoding="utf-8")
    own = material_named(tmp_path / "own.toml")
    assert own.source == "given by the user"
    assert own.safety_coefficient == 0.2


@pytest.mark.parametrize("typed", ["petg", "PETG", "Petg"])
def test_names_do_not_mind_capitals(typed):
    assert material_named(typed) is LIBRARY["PETG"]


def test_a_material_names_itself():
    assert material_named(STEEL) is STEEL


@pytest.mark.parametrize(("typed", "meant"), [("PTG", "PETG"), ("nylon pa12", "PA12"), ("verowhite", "Vero"), ("resn", "Resin")])
def test_an_unknown_name_is_answered_with_the_nearest(typed, meant):
    with pytest.raises(BadInput, match=f"did you mean '{meant}'"):
        material_named(typed)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("youngs_modulus", 0.0),
        ("youngs_modulus", 3.5e9),  # pascals
        ("youngs_modulus", float("nan")),
        ("poisson_ratio", 0.5),
        ("poisson_ratio", -0.1),
        ("density", 1240.0),  # kilogrammes per cubic metre
        ("density", 1.24),  # grammes per cubic centimetre
        ("yield_strength", -1.0),
        ("yield_strength", float("inf")),
        ("hardening", -1.0),
        ("hardening", float("nan")),
        ("elongation", -0.05),
        ("elongation", 0.0),
        ("elongation", float("inf")),
        ("safety_coefficient", 0.0),
    ],
)
def test_what_no_solid_has_is_refused_with_field_and_range(field, value):
    with pytest.raises(BadInput, match=f"material 'steel': {field} is .*, but must lie in"):
        msgspec.structs.replace(STEEL, **{field: value})


@pytest.mark.parametrize(
    ("changes", "unit", "meant"),
    [
        ({"youngs_modulus": 3.5}, "GPa", "3500"),
        ({"youngs_modulus": 0.026, "poisson_ratio": 0.48, "yield_strength": 8.6}, "GPa", "26"),  # a rubber
        ({"youngs_modulus": 3.5, "yield_strength": 0.0456}, "GPa", "3500"),  # both: their ratio is that of a plastic
        ({"youngs_modulus": 14.0, "yield_strength": 150.0}, "GPa", "14000"),  # filled with carbon fibre
        ({"youngs_modulus": 3.5e9}, "Pa", "3500"),
        ({"youngs_modulus": 3.5e6}, "kPa", "3500"),
        ({"density": 1.24}, "g/cm³", "0.00124"),
        ({"density": 1240.0}, "kg/m³", "0.00124"),
        ({"density": 1.24e-6}, "kg/mm³", "0.00124"),
        ({"density": 1.24e-9}, "t/mm³", "0.00124"),
        ({"yield_strength": 45.6e6}, "Pa", "45.6"),
        ({"yield_strength": 45.6e3}, "kPa", "45.6"),
        ({"yield_strength": 0.0456}, "GPa", "45.6"),
        ({"yield_strength": 6613.7}, "psi", "45.6"),
        ({"youngs_modulus": 26.0, "poisson_ratio": 0.48, "yield_strength": 8600.0}, "kPa", "8.6"),
        ({"hardening": 35e6}, "Pa", "35"),
        ({"elongation": 6.0}, "per cent", "0.06"),
        ({"elongation": 18.0}, "per cent", "0.18"),
        ({"poisson_ratio": 36.0}, "per cent", "0.36"),
        ({"layer_ratio": 55.0}, "per cent", "0.55"),
        ({"safety_coefficient": 20.0}, "per cent", "0.2"),
    ],
)
def test_a_figure_in_another_unit_is_refused_with_the_likely_meaning(changes, unit, meant):
    with pytest.raises(BadInput, match=r"^material 'PLA': ") as refusal:
        msgspec.structs.replace(LIBRARY["PLA"], **changes)
    assert re.search(rf" looks like {re.escape(unit)}: write {re.escape(meant)}$", str(refusal.value))


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"poisson_ratio": 0.5}, "write 0.49 for a rubber"),
        ({"youngs_modulus": 300.0}, "yield at a strain of 0.15, which must lie in 0.0001 to 0.1: one of them is in another unit"),
        ({"yield_strength": 0.2}, "yield at a strain of 5.7e-05"),
        ({"layer_ratio": 0.0}, "layer_ratio is 0, but must lie in 0.05 to 1$"),
        ({"hardening": 3501.0}, "hardening is 3501 MPa, above youngs_modulus with 3500 MPa"),
    ],
)
def test_what_no_unit_explains_is_refused_all_the_same(changes, words):
    with pytest.raises(BadInput, match=words):
        msgspec.structs.replace(LIBRARY["PLA"], **changes)


@pytest.mark.parametrize("young", [3.0, 10.0, 1e3])
def test_soft_elastomers_are_no_mistake(young):
    soft = msgspec.structs.replace(LIBRARY["TPU"], youngs_modulus=young, yield_strength=0.5 * young, hardening=0.0)
    assert soft.youngs_modulus == young


def test_the_library_is_generic_and_a_brand_of_the_same_name_is_not(tmp_path):
    assert {material.label for material in LIBRARY.values()} == {f"generic {name}" for name in LIBRARY}
    (tmp_path / "brand.toml").write_text(BRAND, encoding="utf-8")
    brand = material_named(tmp_path / "brand.toml")
    assert brand.label == "PolyTerra PLA"
    assert brand.layer_ratio == pytest.approx(0.53, abs=0.005)
    assert msgspec.structs.replace(brand, name="PLA").label == "PLA"
    earlier = msgspec.structs.replace(LIBRARY["PLA"], source="an earlier version", layer_ratio=None, layer_source="")
    assert earlier.label == "generic PLA", "the same figures, told otherwise"


def test_what_is_known_of_layers_and_of_the_spread_is_of_every_material():
    assert {name for name, material in LIBRARY.items() if material.layer_ratio is None} == {"ABS"}
    assert all(bool(material.layer_source) == (material.layer_ratio is not None) for material in LIBRARY.values())
    assert set(SPREAD) == set(LIBRARY)


def test_what_is_not_known_of_yielding_is_on_the_safe_side():
    """No hardening, and the elongation of the most brittle of the library."""
    assert (STEEL.hardening, STEEL.elongation) == (0.0, min(material.elongation for material in LIBRARY.values()))
    assert "assumed" in STEEL.yielding_source


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("torn.toml", "youngs_modulus =", "Invalid value"),
        ("torn.json", '{"name":', "truncated"),
        ("list.json", "[1, 2]", "Expected `object`"),
        ("short.toml", toml(density=None), "missing required field `density`"),
        ("more.toml", toml(strength=3.0), "unknown field `strength`"),
        ("words.toml", toml(density="light"), "Expected `float`"),
        ("pascal.toml", toml(youngs_modulus=3.5e9), "must lie in"),
        ("empty.json", "", "truncated"),
    ],
)
def test_a_bad_file_is_refused_in_one_sentence_that_names_it(name, text, words, tmp_path):
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(BadInput, match=words) as refusal:
        material_named(tmp_path / name)
    assert str(tmp_path / name) in str(refusal.value)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize("suffix", ["toml", "json"])
def test_the_mark_that_windows_editors_begin_a_file_with_is_no_part_of_it(suffix, tmp_path):
    """Notepad and PowerShell write it: «Invalid statement (at line 1, column 1)»."""
    text = toml() if suffix == "toml" else msgspec.json.encode(STEEL).decode()
    file = tmp_path / f"mine.{suffix}"
    file.write_text(text, encoding="utf-8-sig")
    assert read_material(file).yield_strength in (40.0, 235.0)


def test_bytes_that_are_no_text_are_refused(tmp_path):
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(BadInput, match="decode"):
        read_material(tmp_path / "binary.toml")


def test_a_missing_file_is_answered_with_what_there_is():
    with pytest.raises(BadInput, match=r"own\.toml does not exist.*PETG"):
        material_named("own.toml")
