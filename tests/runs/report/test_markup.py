"""Templates of a report: what a person typed is escaped wherever it lands."""

import json

import pytest

from mechstyle.runs.report.markup import Markup, cells, fill, joined, script_json, table, with_code

EVIL = "</script><img src=x onerror=alert(1)>\"'&{name}"
ESCAPED = "&lt;/script&gt;&lt;img src=x onerror=alert(1)&gt;&quot;&#x27;&amp;{name}"


def test_a_value_is_escaped_and_markup_is_not_escaped_again():
    assert fill("<p>{words}</p>", words=EVIL) == f"<p>{ESCAPED}</p>"
    assert fill("<p>{words}</p>", words=fill("<b>{n}</b>", n=3)) == "<p><b>3</b></p>"
    assert isinstance(fill("{n}", n=1), Markup)
    assert not isinstance(joined([fill("{n}", n=1)]) + "", Markup), "what is put together by hand counts as typed"


def test_a_table_escapes_caption_heads_and_cells():
    page = table([EVIL], [[EVIL, EVIL]], EVIL, kind=EVIL)
    assert EVIL not in page
    assert page.count(ESCAPED) == 6
    assert cells(["a", 1, 2]) == '<th scope="row">a</th>\n<td>1</td>\n<td>2</td>'


@pytest.mark.parametrize(
    ("text", "wanted"),
    [("say `a < b` here", "say <code>a &lt; b</code> here"), ("an odd ` < quote", "an odd ` &lt; quote"), ("none", "none")],
)
def test_what_one_types_stands_in_letters_of_its_own(text, wanted):
    assert with_code(text) == wanted


def test_json_cannot_end_its_script_and_says_the_same():
    text = script_json({"words": EVIL, "more": "\u2028é"})
    assert not set(text) & set("<>&")
    assert text.isascii()
    assert json.loads(text) == {"words": EVIL, "more": "\u2028é"}
    with pytest.raises(ValueError, match="JSON"):
        script_json(float("nan"))
