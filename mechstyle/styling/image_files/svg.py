"""Filled and stroked shapes of an SVG file as pixels; nothing outside the file is ever read.

Paths, basic shapes, groups, `use`, transforms, plain colours and class styles of SVG 1.1 are drawn. What is not (text, embedded bitmaps,
clipping, masks, filters, patterns) is refused by name rather than left out, because a picture without it would be another one.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
from lxml import etree
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.colors import to_rgb
from matplotlib.path import Path as Outline
from matplotlib.transforms import Affine2D, IdentityTransform
from numpy.typing import NDArray

from mechstyle.errors import BadInput
from mechstyle.styling.image_files.svg_path import outline_of_path

LONGEST = 1024
"""Pixels along the longer side."""
MOST_SHAPES = 20_000
"""Shapes that are drawn, `use` counted as often as it is used."""
DEEPEST = 32
INHERITED = {
    "fill", "stroke", "stroke-width", "fill-opacity", "stroke-opacity", "fill-rule", "stroke-linecap", "stroke-linejoin", "visibility",
    "color",
}  # fmt: skip
SKIPPED = {
    "defs", "title", "desc", "metadata", "style", "symbol", "linearGradient", "radialGradient", "namedview", "script", "marker", "clipPath",
    "mask", "filter", "pattern",
}  # fmt: skip
SHAPES = {"path", "rect", "circle", "ellipse", "line", "polyline", "polygon"}
UNDRAWABLE = {"clip-path": "clipping", "mask": "a mask", "filter": "a filter"}
_ADVICE = "convert it to paths, or save it as PNG"
_NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")
_UNITS = {"": 1.0, "px": 1.0, "pt": 4 / 3, "pc": 16.0, "mm": 96 / 25.4, "cm": 96 / 2.54, "in": 96.0}

Style = Mapping[str, str]


def is_svg(content: bytes) -> bool:
    """Whether a file's content is text that begins like XML."""
    return content[:64].lstrip(b"\xef\xbb\xbf \t\r\n").startswith(b"<")


def rasterised(content: bytes, name: str) -> NDArray[np.uint8]:
    """The drawing as RGB and alpha, LONGEST pixels along the longer side, shape [height, width, 4].

    Raises:
        BadInput: If it is no SVG file, is hostile, or holds what cannot be drawn.
    """
    root = _parsed(content, name)
    left, top, width, height = _view(root, name)
    scale = LONGEST / max(width, height)
    size = max(round(scale * width), 2), max(round(scale * height), 2)
    drawing = _Drawing(root, name, size)
    place = Affine2D().translate(-left, -top).scale(size[0] / width, size[1] / height)
    try:
        drawing.draw(root, {}, place, 1.0, 0)
    except (ValueError, OverflowError, RecursionError, MemoryError, ArithmeticError) as error:
        raise BadInput(f"{name} holds a shape that cannot be drawn ({error}): {_ADVICE}") from error
    return np.array(drawing.pixels)


def _parsed(content: bytes, name: str) -> Any:
    """The root element. Entities are refused, not resolved, and neither DTDs nor anything on a network is loaded."""
    if b"<!ENTITY" in content:
        raise BadInput(f"{name} defines XML entities, which are not read: save it as plain SVG")
    parser = etree.XMLParser(resolve_entities=False, no_network=True, load_dtd=False, dtd_validation=False, huge_tree=False, recover=False)
    try:
        root = etree.fromstring(content, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        raise BadInput(f"{name} cannot be read as SVG: it is damaged or was cut off; save the picture again") from error
    if _tag(root) != "svg":
        raise BadInput(f"{name} is no SVG file, but XML of another kind ({_tag(root) or 'no element'}): give a PNG, JPEG or SVG file")
    return root


def _view(root: Any, name: str) -> tuple[float, float, float, float]:
    """The rectangle to show: left, top, width, height."""
    box = [float(number) for number in _NUMBER.findall(root.get("viewBox", ""))]
    if len(box) != 4:
        box = [0.0, 0.0, _length(root.get("width", "")), _length(root.get("height", ""))]
    if not (all(map(math.isfinite, box)) and min(box[2:]) > 0.0 and max(box[2:]) < 1000.0 * min(box[2:])):
        raise BadInput(f"{name} does not say how large its drawing is: give it a viewBox, or save it as PNG")
    return box[0], box[1], box[2], box[3]


class _Drawing:
    """Shapes as they are drawn over each other."""

    def __init__(self, root: Any, name: str, size: tuple[int, int]) -> None:
        self._name = name
        self._renderer: Any = RendererAgg(*size, 72)  # type: ignore[no-untyped-call]
        self._by_id = {element.get("id"): element for element in root.iter() if element.get("id")}
        self._rules = dict(_rules(root))
        self._drawn = itertools.count(1)

    @property
    def pixels(self) -> NDArray[np.uint8]:
        return np.asarray(self._renderer.buffer_rgba())

    def draw(self, element: Any, inherited: Style, place: Affine2D, opacity: float, depth: int) -> None:
        """An element and all in it."""
        tag = _tag(element)
        if not tag or tag in SKIPPED:
            return
        if depth > DEEPEST:
            raise BadInput(f"{self._name} is nested deeper than {DEEPEST} levels: save it as plain SVG")
        own = self._style(element, tag)
        self._refuse(tag, own)
        if own.get("display") == "none":
            return
        style = {**{key: value for key, value in inherited.items() if key in INHERITED}, **own}
        here = _then(_transform(element.get("transform", "")), place)
        through = opacity * _share(own.get("opacity", "1"))
        if tag in {"svg", "g", "a", "switch"}:
            for child in element:
                self.draw(child, style, here, through, depth + 1)
        elif tag == "use":
            self._use(element, style, here, through, depth)
        elif tag in SHAPES and style.get("visibility", "visible") == "visible":
            self._shape(_outline(element, tag), style, here, through)

    def _use(self, element: Any, style: Style, place: Affine2D, opacity: float, depth: int) -> None:
        """Another element of the same file; what is in other files is not read."""
        link = element.get("href") or element.get("{http://www.w3.org/1999/xlink}href") or ""
        target = self._by_id.get(link[1:]) if link.startswith("#") else None
        if target is None:
            raise BadInput(f"{self._name} uses {link[:60]!r}, which is not in it, and nothing else is read: save it as plain SVG")
        there = _then(Affine2D().translate(_length(element.get("x", "0")), _length(element.get("y", "0"))), place)
        if next(self._drawn) > MOST_SHAPES:
            raise BadInput(f"{self._name} draws more than {MOST_SHAPES} shapes: save it as PNG")
        for child in target if _tag(target) == "symbol" else [target]:
            self.draw(child, style, there, opacity, depth + 1)

    def _shape(self, outline: Outline, style: Style, place: Affine2D, opacity: float) -> None:
        """Fill and stroke of an outline."""
        if next(self._drawn) > MOST_SHAPES:
            raise BadInput(f"{self._name} draws more than {MOST_SHAPES} shapes: save it as PNG")
        shape = outline.transformed(place)
        if not np.size(shape.vertices) or not np.isfinite(shape.vertices).all() or np.abs(shape.vertices).max() > 1e6:
            return
        shape.should_simplify = False
        fill = self._paint(style.get("fill", "black"), style)
        if fill is not None:
            whole = _even_odd(shape) if style.get("fill-rule") == "evenodd" else shape
            self._paths(whole, 0.0, (*fill, opacity * _share(style.get("fill-opacity", "1"))), style, filled=True)
        line = self._paint(style.get("stroke", "none"), style)
        width = _length(style.get("stroke-width", "1")) * math.sqrt(abs(float(np.linalg.det(place.get_matrix()[:2, :2]))))
        if line is not None and width > 0.0:
            self._paths(shape, width, (*line, opacity * _share(style.get("stroke-opacity", "1"))), style, filled=False)

    def _paths(self, shape: Outline, width: float, colour: tuple[float, float, float, float], style: Style, *, filled: bool) -> None:
        pen = self._renderer.new_gc()
        pen.set_linewidth(width)
        pen.set_snap(False)
        pen.set_foreground(colour, isRGBA=True)
        caps, joins = {"round": "round", "square": "projecting"}, {"round": "round", "bevel": "bevel"}
        pen.set_capstyle(caps.get(style.get("stroke-linecap", ""), "butt"))
        pen.set_joinstyle(joins.get(style.get("stroke-linejoin", ""), "miter"))
        flipped = Affine2D().scale(1.0, -1.0).translate(0.0, self._renderer.height)  # Agg counts rows from the bottom
        self._renderer.draw_path(pen, shape.transformed(flipped), IdentityTransform(), colour if filled else None)
        pen.restore()

    def _style(self, element: Any, tag: str) -> dict[str, str]:
        """What is said of an element: by attributes, by rules for its kind, classes and name, and in its `style`, rising in weight."""
        style = {str(key): str(value).strip() for key, value in element.attrib.items()}
        for selector in (tag, *(f".{name}" for name in element.get("class", "").split()), f"#{element.get('id', '')}"):
            style |= self._rules.get(selector, {})
        return style | _declarations(element.get("style", ""))

    def _refuse(self, tag: str, style: Style) -> None:
        what = {"text": "text", "image": "an embedded picture", "foreignObject": "foreign content"}.get(tag, "")
        what = what or next((words for key, words in UNDRAWABLE.items() if style.get(key, "none") != "none"), "")
        if what:
            raise BadInput(f"{self._name} holds {what}, which is not drawn from SVG: {_ADVICE}")

    def _paint(self, value: str, style: Style) -> tuple[float, float, float] | None:
        """Display RGB, None for no paint; of a gradient the mean of its colours."""
        value = style.get("color", "black") if value == "currentColor" else value
        if value in {"none", "transparent"}:
            return None
        found = re.match(r"url\(\s*['\"]?#([^'\")]+)['\"]?\s*\)", value)
        if found:
            return self._mean(self._by_id.get(found[1]), 0)
        numbers = re.fullmatch(r"rgba?\(([^)]*)\)", value)
        if numbers:
            parts = re.findall(r"([-+.\d]+)\s*(%?)", numbers[1])[:3]
            levels = [min(max(float(number) / (100.0 if percent else 255.0), 0.0), 1.0) for number, percent in parts]
            if len(levels) == 3:
                return levels[0], levels[1], levels[2]
        try:
            red, green, blue = to_rgb(value.lower())
        except ValueError as error:
            raise BadInput(f"{self._name} paints with {value[:40]!r}, which is no colour that is known: {_ADVICE}") from error
        return red, green, blue

    def _mean(self, gradient: Any, depth: int) -> tuple[float, float, float]:
        """Mean colour of a gradient's stops; they may be those of another gradient."""
        if gradient is None or "Gradient" not in _tag(gradient) or depth > DEEPEST:
            raise BadInput(f"{self._name} paints with a pattern, which is not drawn from SVG: {_ADVICE}")
        stops = [self._style(stop, "stop").get("stop-color", "black") for stop in gradient if _tag(stop) == "stop"]
        if not stops:
            link = gradient.get("href") or gradient.get("{http://www.w3.org/1999/xlink}href") or ""
            return self._mean(self._by_id.get(link[1:]), depth + 1)
        paints = [self._paint(stop, {}) or (0.0, 0.0, 0.0) for stop in stops if not stop.startswith("url")]
        red, green, blue = np.mean(paints or [(0.0, 0.0, 0.0)], axis=0)
        return float(red), float(green), float(blue)


def _outline(element: Any, tag: str) -> Outline:
    """The outline of a basic shape or path, in its own coordinates."""
    if tag == "path":
        return outline_of_path(element.get("d", ""))
    if tag in {"polyline", "polygon"}:
        numbers = [float(number) for number in _NUMBER.findall(element.get("points", ""))]
        corners = np.reshape(numbers[: len(numbers) // 2 * 2], (-1, 2))
        ring = tag == "polygon" and len(corners) > 0
        return Outline(np.vstack([corners, corners[:1]]) if ring else corners, closed=ring)
    measure = {key: _length(element.get(key, "0")) for key in ("x", "y", "width", "height", "cx", "cy", "r", "x1", "y1", "x2", "y2")}
    if tag == "line":
        return Outline([(measure["x1"], measure["y1"]), (measure["x2"], measure["y2"])])
    if tag == "rect":
        return _rectangle(element, measure)
    radii = (measure["r"], measure["r"]) if tag == "circle" else (_length(element.get("rx", "0")), _length(element.get("ry", "0")))
    round_one = Outline.circle((0.0, 0.0), 1.0)
    return round_one.transformed(Affine2D().scale(*radii).translate(measure["cx"], measure["cy"]))


def _rectangle(element: Any, measure: Mapping[str, float]) -> Outline:
    """A rectangle, with round corners if it has radii."""
    x, y, width, height = (measure[key] for key in ("x", "y", "width", "height"))
    radii = [element.get("rx") or element.get("ry") or "0", element.get("ry") or element.get("rx") or "0"]
    rx, ry = min(_length(radii[0]), width / 2.0), min(_length(radii[1]), height / 2.0)
    if min(rx, ry) <= 0.0:
        return outline_of_path(f"M{x} {y}h{width}v{height}h{-width}z")
    turn = f"a{rx} {ry} 0 0 1"
    across, down = width - 2.0 * rx, height - 2.0 * ry
    half = f"M{x + rx} {y}h{across}{turn} {rx} {ry}v{down}{turn} {-rx} {ry}"
    return outline_of_path(f"{half}h{-across}{turn} {-rx} {-ry}v{-down}{turn} {rx} {-ry}z")


def _even_odd(shape: Outline) -> Outline:
    """The same outline, its rings turned so that a winding rule fills what the even-odd rule does; rings do not cross each other."""
    rings = [ring for ring in map(np.asarray, shape.to_polygons(closed_only=False)) if len(ring) >= 3]
    firsts = np.array([ring[0] for ring in rings]).reshape(-1, 2)
    depth = sum((Outline(ring).contains_points(firsts).astype(int) for ring in rings), np.zeros(len(rings), int))
    turned = []
    for at, ring in enumerate(rings):
        inside = depth[at] - int(Outline(ring).contains_point(firsts[at]))
        x, y = ring.T
        counter_clockwise = float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) > 0.0
        turned.append(Outline(ring[::-1] if counter_clockwise == bool(inside % 2) else ring))
    return Outline.make_compound_path(*turned) if turned else shape


def _transform(text: str) -> Affine2D:
    """A `transform` attribute; the last of its steps is done first."""
    whole = Affine2D()
    for kind, arguments in reversed(re.findall(r"(\w+)\s*\(([^)]*)\)", text)):
        whole = _then(whole, _step(kind, [float(number) for number in _NUMBER.findall(arguments)]))
    return whole


def _then(first: Affine2D, second: Affine2D) -> Affine2D:
    return Affine2D(second.get_matrix() @ first.get_matrix())


def _step(kind: str, n: list[float]) -> Affine2D:
    if kind == "matrix" and len(n) == 6:
        return Affine2D(np.array([[n[0], n[2], n[4]], [n[1], n[3], n[5]], [0.0, 0.0, 1.0]]))
    if kind == "translate" and n:
        return Affine2D().translate(n[0], n[1] if len(n) > 1 else 0.0)
    if kind == "scale" and n:
        return Affine2D().scale(n[0], n[1] if len(n) > 1 else n[0])
    if kind == "rotate" and n:
        x, y = (n[1], n[2]) if len(n) > 2 else (0.0, 0.0)
        return Affine2D().rotate_deg_around(x, y, n[0])
    if kind in {"skewX", "skewY"} and n:
        return Affine2D().skew_deg(n[0] if kind == "skewX" else 0.0, n[0] if kind == "skewY" else 0.0)
    raise ValueError(f"the transform {kind}")


def _rules(root: Any) -> Iterator[tuple[str, dict[str, str]]]:
    """The declarations of a style sheet in the file, by selector; of these only kinds, classes and names are known."""
    rules: dict[str, dict[str, str]] = {}
    for sheet in root.iter("{*}style"):
        text = re.sub(r"/\*.*?\*/", "", sheet.text or "", flags=re.DOTALL)
        for selectors, body in re.findall(r"([^{}]+)\{([^{}]*)\}", text):
            for selector in selectors.split(","):
                rules.setdefault(selector.strip(), {}).update(_declarations(body))
    yield from rules.items()


def _declarations(text: str) -> dict[str, str]:
    pairs = (part.partition(":") for part in text.split(";"))
    return {key.strip(): value.replace("!important", "").strip() for key, _, value in pairs if value.strip()}


def _length(text: str) -> float:
    """A length in pixels of 1/96 inch; percentages and what is no length count as none."""
    found = re.fullmatch(rf"\s*({_NUMBER.pattern})\s*([a-z]*)\s*", text)
    return float(found[1]) * _UNITS.get(found[2], 1.0) if found else 0.0


def _share(text: str) -> float:
    found = re.fullmatch(rf"\s*({_NUMBER.pattern})\s*(%?)\s*", text)
    return min(max(float(found[1]) / (100.0 if found[2] else 1.0), 0.0), 1.0) if found else 1.0


def _tag(element: Any) -> str:
    """Name of an element without its namespace, "" for comments and the like and for elements of other programs."""
    if not isinstance(element.tag, str):
        return ""
    space, _, name = element.tag.rpartition("}")
    return name if space in ("", "{http://www.w3.org/2000/svg") else ""
