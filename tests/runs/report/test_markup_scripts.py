"""The scripts as one: what makes joining them safe."""

import re

import pytest

from mechstyle.pictures import scene
from mechstyle.runs.report.markup import IN_A_REPORT, bundle, static


def top_level(text):
    return re.findall(r"^(?:export )?(?:async )?(?:function|class|const) (\w+)", text, re.MULTILINE)


@pytest.mark.parametrize("name", IN_A_REPORT)
def test_a_module_imports_only_earlier_ones(name):
    imported = re.findall(r'from "\./(\w+)\.js"', static(f"{name}.js"))
    assert set(imported) <= set(IN_A_REPORT[: IN_A_REPORT.index(name)])


def test_no_two_modules_share_a_top_level_name():
    names = [name for module in (*IN_A_REPORT, "report") for name in top_level(static(f"{module}.js"))]
    for module in (*IN_A_REPORT, "report"):
        names += re.findall(r"^const [^;=]+=[^;]*?, (\w+) = ", static(f"{module}.js"), re.MULTILINE)
    assert len(names) > 15
    assert len(names) == len(set(names))


def test_the_bundle_has_no_import_no_export_and_every_module():
    joined = bundle(static("report.js"), IN_A_REPORT)
    assert not re.search(r"^(import|export)\b", joined, re.MULTILINE)
    assert "</script" not in joined
    for name in (*IN_A_REPORT, "report"):
        assert set(top_level(static(f"{name}.js"))) <= set(top_level(joined))


def test_the_shaders_have_no_light_of_their_own():
    text = static("shaders.js")
    for number in (scene.KEY_LIGHT, scene.FILL_LIGHT, scene.SKY_LIGHT, scene.GROUND_LIGHT, *scene.KEY):
        assert not re.search(rf"\b{abs(number):.2f}\b", text), number
    light = text.split("float light(")[1].split("\n}")[0]
    assert set(re.findall(r"\d*\.\d+", light)) <= {"0.0", "0.5", "1.0"}
