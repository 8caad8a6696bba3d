"""A part in three dimensions: turn it, see its style or a field on it.

All of pythreejs stays behind `Viewer`. The scene is built whole before it is shown, and afterwards only the contents of
its buffers change: replacing a buffer, or adding to a scene on show, leaks memory in the browser.
"""

from __future__ import annotations

import math
from html import escape
from typing import Any

import ipywidgets
import numpy as np
import pythreejs
import traitlets
from numpy.typing import ArrayLike, NDArray

from mechstyle.errors import BadInput
from mechstyle.mesh import SurfaceMesh
from mechstyle.pictures.colormap import Scale, linear_to_srgb

PLASTIC = (0.76, 0.75, 0.73)  # sRGB of a part without colours: unpainted, neither light nor dark
BACKGROUNDS = {"light": "#f4f4f2", "dark": "#1e1f22"}
FIELD_OF_VIEW = 30.0  # [degrees]
VIEWED_FROM = np.array([0.45, -1.0, 0.55])  # in front, from the right, from above

Floats32 = NDArray[np.float32]


class Viewer(ipywidgets.VBox):  # type: ignore[misc]  # ipywidgets has no types
    """A part one can orbit with the mouse, coloured by its style or by a field over it.

    Attributes:
        mesh: The part; may be replaced by one with the same faces.
        values: Field over the surface [unit], shape [vertex_count], None for none. Grey where it is not a number.
        layer: `style` shows the colours of the part, `field` shows the values.
        limits: Values at the two ends of the colour scale [unit]; None takes them from the values at hand.
        threshold: Values above it are set apart in colour, marked on the scale and counted [unit]; None for none.
        theme: `light` or `dark` background.
    """

    mesh = traitlets.Instance(SurfaceMesh)
    values = traitlets.Any(None, allow_none=True)
    layer = traitlets.Enum(("style", "field"), "style")
    limits = traitlets.Any(None, allow_none=True)
    threshold = traitlets.Float(None, allow_none=True)
    theme = traitlets.Enum(tuple(BACKGROUNDS), "light")

    def __init__(
        self,
        mesh: SurfaceMesh,
        values: ArrayLike | None = None,
        label: str = "",
        unit: str = "",
        threshold: float | None = None,
        *,
        limits: tuple[float, float] | None = None,
        theme: str = "light",
        width: int = 640,
        height: int = 440,
    ) -> None:
        """Show a part.

        Args:
            mesh: The part [mm].
            values: Field over its surface [unit], shape [vertex_count]; if given it is shown first.
            label: What the values are, for example "von Mises stress".
            unit: Their unit.
            threshold: Values above it are set apart [unit].
            limits: Values at the two ends of the colour scale [unit].
            theme: `light` or `dark`.
            width: Width of the view [pixels].
            height: Height of the view [pixels].

        Raises:
            BadInput: If there is not one value per vertex, or the limits do not rise.
        """
        self._label, self._unit = label, unit
        self._position = pythreejs.BufferAttribute(_single(mesh.vertices), normalized=False)
        self._normal = pythreejs.BufferAttribute(_single(mesh.vertex_normals), normalized=False)
        self._colour = pythreejs.BufferAttribute(_plain(mesh), normalized=False)
        self._index = pythreejs.BufferAttribute(mesh.faces.ravel().astype(np.uint32), normalized=False)
        self._geometry = pythreejs.BufferGeometry(
            attributes={"position": self._position, "normal": self._normal, "color": self._colour, "index": self._index}
        )
        self._scene, renderer = _stage(mesh, self._geometry, width, height)
        self._bar = ipywidgets.HTML()
        self._choice = ipywidgets.ToggleButtons(options=["style", "field"], tooltips=["colours of the part", label or "values"])
        super().__init__([renderer, self._choice, self._bar])
        self.mesh = mesh
        traitlets.link((self, "layer"), (self._choice, "value"))
        try:
            self.values, self.limits, self.threshold, self.theme = values, limits, threshold, theme
        except BadInput:
            self.close()
            raise
        self.layer = "style" if values is None else "field"
        self.observe(self._repaint, ("mesh", "values", "layer", "limits", "threshold"))
        self._repaint()

    def __repr__(self) -> str:
        """What is shown; never the arrays."""
        return f"Viewer({self.mesh!r}, layer={self.layer!r})"

    @property
    def scale(self) -> Scale | None:
        """The colour scale of the values, None without values."""
        if self.values is None:
            return None
        if self.limits is not None:
            low, high = self.limits
            return Scale(low, high, self.threshold)
        known = self.values[np.isfinite(self.values)]
        low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
        return Scale(low, high if high > low else low + max(abs(low), 1.0), self.threshold)

    def close(self) -> None:
        """Close the view and every widget it is made of; nothing stays behind in the kernel."""
        for part in _family(self):
            if part is not self:
                part.close()
        super().close()

    @traitlets.validate("values")
    def _one_value_per_vertex(self, proposal: dict[str, Any]) -> Floats32 | None:
        if proposal["value"] is None:
            return None
        values, count = _single(proposal["value"]), len(self.mesh.vertices)
        if values.shape != (count,):
            raise BadInput(f"a viewer needs one value for each of the {count} vertices, but got an array of shape {values.shape}")
        return values

    @traitlets.validate("mesh")
    def _same_faces(self, proposal: dict[str, Any]) -> SurfaceMesh:
        mesh: SurfaceMesh = proposal["value"]
        if not np.array_equal(mesh.faces.ravel(), self._index.array):
            raise BadInput("a viewer follows one part as it moves, but the new mesh has other faces: make another Viewer for it")
        return mesh

    @traitlets.validate("limits")
    def _rising(self, proposal: dict[str, Any]) -> tuple[float, float] | None:
        if proposal["value"] is None:
            return None
        low, high = proposal["value"]
        Scale(low, high)
        return float(low), float(high)

    @traitlets.validate("threshold")
    def _finite(self, proposal: dict[str, Any]) -> float | None:
        return Scale(0.0, 1.0, proposal["value"]).threshold

    @traitlets.validate("layer")
    def _something_to_show(self, proposal: dict[str, Any]) -> str:
        if proposal["value"] == "field" and self.values is None:
            raise BadInput("there is no field to show: set `values` first, one for each vertex")
        return proposal["value"]

    @traitlets.observe("mesh")
    def _move(self, change: dict[str, Any]) -> None:
        self._position.array = _single(change["new"].vertices)
        self._normal.array = _single(change["new"].vertex_normals)
        self._geometry.exec_three_obj_method("computeBoundingSphere")

    @traitlets.observe("theme")
    def _relight(self, change: dict[str, Any]) -> None:
        self._scene.background = BACKGROUNDS[change["new"]]

    def _repaint(self, _change: object = None) -> None:
        """Bring colours, colour bar and buttons up to date with the traits."""
        scale = self.scale
        if scale is None:
            self.layer = "style"
        shown = self.layer == "field"
        self._colour.array = linear_to_srgb(scale.colours(self.values)) if scale and shown else _plain(self.mesh)
        self._bar.value = self._legend(scale) if scale and shown else ""
        self._choice.layout.display = "none" if scale is None or self.mesh.colours is None else ""

    def _legend(self, scale: Scale) -> str:
        """The colour bar with its ends, the threshold, and how much of the surface lies above it."""
        caption = escape(f"{self._label} [{self._unit}]" if self._unit else self._label)
        if scale.threshold is not None:
            share = self.mesh.vertex_areas[scale.above(self.values)].sum() / self.mesh.vertex_areas.sum()
            caption += escape(f" · {share:.1%} of the surface above {scale.threshold:.3g} {self._unit}".rstrip())
        ticks = [_tick(0.0, 0.0, scale.low), _tick(1.0, 1.0, scale.high)]
        edge = (scale.top - scale.low) / (scale.high - scale.low)
        if 0.15 < edge < 0.85:  # nearer to an end the numbers would overlap, and the caption has it too
            ticks.append(_tick(edge, 0.5, scale.top))
        bar = f'<div style="width:320px;height:12px;border-radius:2px;background:{_gradient(scale)}"></div>'
        numbers = f'<div style="position:relative;width:320px;height:1.6em">{"".join(ticks)}</div>'
        return f'<div style="margin:4px 12px;line-height:1.4"><div>{caption}</div>{bar}{numbers}</div>'


def _stage(mesh: SurfaceMesh, geometry: Any, width: int, height: int) -> tuple[Any, Any]:
    """The scene around a geometry, whole, and its renderer: light from the camera, which orbits about the centre of the part.

    The part is moved to the origin, as the controls look there until the mouse first moves, whatever their target.
    """
    centre = 0.5 * (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0))
    distance = 0.5 * mesh.size / math.tan(math.radians(FIELD_OF_VIEW / 2))
    eye = distance * VIEWED_FROM / np.linalg.norm(VIEWED_FROM)
    camera = pythreejs.PerspectiveCamera(
        position=eye.tolist(),
        up=[0.0, 0.0, 1.0],
        fov=FIELD_OF_VIEW,
        aspect=width / height,
        near=distance / 100.0,
        far=distance * 20.0,
        children=[pythreejs.DirectionalLight(position=[-0.5, 0.8, 1.0], intensity=0.65)],
    )
    material = pythreejs.MeshStandardMaterial(vertexColors="VertexColors", roughness=0.85, metalness=0.0, side="DoubleSide")
    part = pythreejs.Mesh(geometry, material, position=(-centre).tolist())
    scene = pythreejs.Scene(children=[part, camera, pythreejs.AmbientLight(intensity=0.5)], background=BACKGROUNDS["light"])
    orbit = pythreejs.OrbitControls(controlling=camera)
    return scene, pythreejs.Renderer(camera=camera, scene=scene, controls=[orbit], width=width, height=height, antialias=True)


def _plain(mesh: SurfaceMesh) -> Floats32:
    """Display colours of the part itself, shape [vertex_count, 3]."""
    return _single(np.broadcast_to(PLASTIC, mesh.vertices.shape) if mesh.colours is None else mesh.colours)


def _single(array: ArrayLike) -> Floats32:
    return np.ascontiguousarray(array, dtype=np.float32)


def _gradient(scale: Scale) -> str:
    """The scale as a CSS gradient, with a hard edge where the over-colour begins."""
    end = 100.0 * (scale.top - scale.low) / (scale.high - scale.low)
    ramp = [(f"{share * end:.1f}%", scale.low + share * (scale.top - scale.low)) for share in np.linspace(0.0, 1.0, 17)]
    if scale.top < scale.high:
        ramp += [(f"{end:.1f}%", scale.high), ("100%", scale.high)]
    colours = np.rint(255 * linear_to_srgb(scale.colours([value for _, value in ramp]))).astype(int)
    stops = [f"rgb({r},{g},{b}) {place}" for (place, _), (r, g, b) in zip(ramp, colours.tolist(), strict=True)]
    return f"linear-gradient(to right,{','.join(stops)})"


def _tick(place: float, anchor: float, value: float) -> str:
    """A number under the bar: the share `anchor` of its own width stands at the share `place` of the bar's."""
    return f'<span style="position:absolute;left:{place:.1%};transform:translateX(-{anchor:.0%})">{value:.3g}</span>'


def _family(widget: ipywidgets.Widget) -> list[ipywidgets.Widget]:
    """The widget and every widget its state refers to, however deep."""
    found: dict[int, ipywidgets.Widget] = {}
    waiting: list[Any] = [widget]
    while waiting:
        one = waiting.pop()
        if isinstance(one, dict):
            waiting.extend(one.values())
        elif isinstance(one, list | tuple):
            waiting.extend(one)
        elif isinstance(one, ipywidgets.Widget) and id(one) not in found:
            found[id(one)] = one
            waiting.extend(getattr(one, key) for key in one.keys)
    return list(found.values())
