"""Vertex and fragment shaders of the viewer, with the light and the colours of `mechstyle.pictures`.

One number per vertex says how it is painted, so that one small buffer is all that changes with a layer or a threshold:
`OWN` for the part's own colour, `NOTHING` where a field is not known, else the place on the ramp, 0 to 1. Beyond 1 lies what
is beyond the threshold, hatched and outlined. A field without one has its places from `OPEN` to `OPEN` + 1, far from any hatch.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from mechstyle._colour import linear_to_srgb
from mechstyle.pictures.colormap import ABOVE, ABSENT, LINE, PLAIN, STEPS, STRIPE, UNKNOWN, Scale
from mechstyle.pictures.scene import FILL, FILL_LIGHT, FLATNESS, GROUND_LIGHT, KEY, KEY_LIGHT, SKY_LIGHT

OWN, NOTHING, OPEN = 1000.0, -1000.0, -3.0
MAXIMUM, MINIMUM, PICKED, END, PIN, HIDDEN = 0.0, 1.0, 2.0, 3.0, 10.0, -1.0  # kinds of markers; PIN + 1 is number 1
COLUMNS, ROWS, CELL = 6, 4, 32  # of the numbers of pins in their texture, and their size [pixels]
MOST_PINS = COLUMNS * ROWS
LETTER, FINE = 0.52, 4
"""Height of their letters, of a cell, and how many times larger they are drawn at first, so that their edges are smooth."""
LEANS = (0.16, 0.1)
"""How far a shadow lies beside what throws it, along x and y, as a share of its height above the floor."""
WHOLE = (0.0, 0.0, 0.0, 1.0)
"""The plane (normal, distance) that cuts nothing off."""


def paint(values: NDArray[np.float32], scale: Scale) -> NDArray[np.float32]:
    """Paint code of each vertex under a field, shape [vertex_count]."""
    place = (np.asarray(values, dtype=np.float64) - scale.low) / (scale.top - scale.low)
    shown = np.clip(place, 0.0, 10.0) if scale.split else OPEN + np.clip(place, 0.0, 1.0)
    return np.where(np.isfinite(place), shown, NOTHING).astype(np.float32)


def ramp() -> NDArray[np.uint8]:
    """The colours of fields as a texture, sRGB and opaque, shape [1, STEPS, 4]."""
    colours = linear_to_srgb(Scale(0.0, 1.0).colours(np.linspace(0.0, 1.0, STEPS)))
    return np.rint(255 * np.insert(colours, 3, 1.0, axis=1)).astype(np.uint8)[None]


@lru_cache(maxsize=1)
def numbers() -> NDArray[np.uint8]:
    """The numbers of pins, white on nothing, a cell each, as a texture, shape [ROWS * CELL, COLUMNS * CELL, 4]."""
    cell = FINE * CELL
    sheet, font = Image.new("L", (COLUMNS * cell, ROWS * cell)), ImageFont.load_default(LETTER * cell)
    pen = ImageDraw.Draw(sheet)
    for number in range(MOST_PINS):
        row, column = divmod(number, COLUMNS)
        pen.text(((column + 0.5) * cell, (row + 0.5) * cell), str(number + 1), 255, font, anchor="mm", stroke_width=FINE // 2)
    return np.ascontiguousarray(np.stack([np.asarray(sheet.reduce(FINE))] * 4, axis=-1))


def _vec(values: tuple[float, ...]) -> str:
    return f"vec{len(values)}({', '.join(f'{value:.6f}' for value in values)})"


PART_VERTEX = """
attribute vec3 colour;
attribute float place;
attribute float is_protected;
varying vec3 v_colour;
varying vec3 v_normal;
varying float v_place;
varying float v_protected;
varying vec3 v_at;
varying vec3 v_seen;
void main() {
    v_at = position;
    v_seen = (modelViewMatrix * vec4(position, 1.0)).xyz;
    v_colour = colour;
    v_place = place;
    v_protected = is_protected;
    v_normal = normalMatrix * normal;
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}
"""

PART_FRAGMENT = f"""
uniform sampler2D ramp;
uniform vec4 cut;  // what lies beyond this plane is cut off
uniform float filled;
uniform float bands;  // how many colours a field has, 0 for all
varying vec3 v_at;
varying vec3 v_seen;
varying vec3 v_colour;
varying vec3 v_normal;
varying float v_place;
varying float v_protected;

vec3 to_light(vec3 c) {{ return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }}
vec3 to_display(vec3 c) {{ return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }}

float light() {{
    vec3 facet = normalize(cross(dFdx(v_seen), dFdy(v_seen)));
    vec3 normal = normalize(gl_FrontFacing ? v_normal : -v_normal);
    normal = normalize(mix(facet, normal, smoothstep(0.70, 0.85, dot(facet, normal))));  // edges stay crisp, rounds smooth
    vec3 sky = (viewMatrix * vec4(0.0, 0.0, 1.0, 0.0)).xyz;
    vec3 flip = vec3(1.0, sky.z < 0.0 ? -1.0 : 1.0, 1.0);  // what faces down is lit from below
    float key = max(dot(normal, normalize({_vec(KEY)}) * flip), 0.0);
    float fill = max(dot(normal, normalize({_vec(FILL)}) * flip), 0.0);
    float around = mix({GROUND_LIGHT:.4f}, {SKY_LIGHT:.4f}, 0.5 + 0.5 * dot(normal, sky));
    return around + {KEY_LIGHT:.4f} * key + {FILL_LIGHT:.4f} * fill;
}}

vec3 mapped(float place) {{
    if (bands > 0.5) place = (min(floor(clamp(place, 0.0, 1.0) * bands), bands - 1.0) + 0.5) / bands;
    return texture2D(ramp, vec2((clamp(place, 0.0, 1.0) * {STEPS - 1}.0 + 0.5) / {STEPS}.0, 0.5)).rgb;
}}

vec3 field() {{
    if (v_place < {OPEN - 0.01:.2f}) return {_vec(UNKNOWN)};
    if (v_place < {OPEN + 1.01:.2f}) return mapped(v_place - {OPEN:.1f});
    float pixels = abs(v_place - 1.0) / max(fwidth(v_place), 1e-9);
    if (v_place > 1.0 || pixels < 0.8) {{
        if (pixels < 1.6 && fwidth(v_place) > 1e-7) return {_vec(LINE)};
        return mod(gl_FragCoord.x + gl_FragCoord.y, 9.0) < 3.0 ? {_vec(STRIPE)} : {_vec(ABOVE)};
    }}
    return mapped(v_place);
}}

bool hatched() {{  // what is protected: grey stripes that lean the other way than those above a limit, and an outline
    if (abs(v_protected - 0.5) < 0.8 * fwidth(v_protected)) return true;
    return v_protected > 0.5 && mod(gl_FragCoord.x - gl_FragCoord.y, 8.0) < 3.0;
}}

vec3 inside() {{  // what is seen of the surface from within, as if the cut were solid: hatched as in a drawing
    return mod(gl_FragCoord.x + gl_FragCoord.y, 12.0) < 1.5 ? {_vec(ABSENT)} : {_vec(PLAIN)};
}}

void main() {{
    if (dot(cut.xyz, v_at) > cut.w) discard;
    if (filled > 0.5 && !gl_FrontFacing) {{ gl_FragColor = vec4(inside(), 1.0); return; }}
    bool own = v_place > {OWN / 2:.1f};
    float shade = own ? light() : mix(light(), 1.0, {FLATNESS:.4f});
    vec3 colour = hatched() ? {_vec(ABSENT)} : own ? v_colour : field();
    gl_FragColor = vec4(to_display(min(to_light(colour) * shade, 1.0)), 1.0);
}}
"""

SHADOW_VERTEX = f"""
uniform float level;  // of the floor
void main() {{
    vec3 fallen = vec3(position.xy + vec2({LEANS[0]:.2f}, {LEANS[1]:.2f}) * max(position.z - level, 0.0), level);
    gl_Position = projectionMatrix * modelViewMatrix * vec4(fallen, 1.0);
}}
"""

SHADOW_FRAGMENT = """
uniform vec3 shade;
void main() {
    if ((viewMatrix * vec4(0.0, 0.0, 1.0, 0.0)).z < 0.0) discard;  // from below the floor would hide the part
    gl_FragColor = vec4(shade, 1.0);
}
"""

FLOOR_VERTEX = """
void main() { gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }
"""

FLOOR_FRAGMENT = """
void main() {
    if ((viewMatrix * vec4(0.0, 0.0, 1.0, 0.0)).z < 0.0) discard;  // from below the floor would hide the part
    gl_FragColor = vec4(0.5, 0.5, 0.5, 0.3);
}
"""

MARKER_VERTEX = """
attribute float kind;
uniform float near_side;
varying float v_kind;
void main() {
    v_kind = kind;
    vec4 seen = modelViewMatrix * vec4(position, 1.0);
    seen.xyz *= near_side > 0.5 ? 0.985 : 1.0;  // before the surface it lies on
    gl_Position = kind < 0.0 || (near_side > 0.5 && kind > 1.5) ? vec4(2.0, 2.0, 2.0, 1.0) : projectionMatrix * seen;
    gl_PointSize = kind > 9.0 ? 26.0 : 22.0;
}
"""

MARKER_FRAGMENT = f"""
uniform sampler2D numbers;
uniform float near_side;
varying float v_kind;
float ring(vec2 p) {{ return abs(length(p) - 0.62); }}
float triangle(vec2 p) {{ return abs(max(p.y, abs(p.x) * 0.866 - p.y * 0.5) - 0.36); }}
float star(vec2 p) {{ return max(min(abs(p.x), abs(p.y)), length(p) - 0.8); }}
float dot_(vec2 p) {{ return length(p) - 0.16; }}
vec4 pin(float number, vec2 p) {{  // a disc with its number
    float away = length(p);
    if (away > 0.92) discard;
    float row = floor(number / {COLUMNS}.0);
    vec2 cell = vec2(number - {COLUMNS}.0 * row, row) + gl_PointCoord;
    float ink = texture2D(numbers, cell / vec2({COLUMNS}.0, {ROWS}.0)).a;
    return vec4(vec3(away > 0.78 ? 1.0 : mix(0.09, 1.0, ink)), 1.0);
}}
void main() {{
    vec2 p = 2.0 * gl_PointCoord - 1.0;
    p.y = -p.y;
    if (v_kind > {PIN + 0.5:.1f}) {{ gl_FragColor = pin(floor(v_kind - {PIN + 0.5:.1f}), p); return; }}
    float away = v_kind < 0.5 ? ring(p) : v_kind < 1.5 ? triangle(p) : v_kind < 2.5 ? star(p) : dot_(p);
    if (away > 0.2) discard;
    if (v_kind < 1.5 && near_side < 0.5) {{  // hidden by the part unless it is drawn once more over it: hollow and dashed
        if (mod(atan(p.y, p.x) + 3.2, 0.7854) < 0.36 || away > 0.09) discard;
        gl_FragColor = vec4(vec3(0.07), 0.8);
        return;
    }}
    gl_FragColor = vec4(vec3(away > 0.09 ? 1.0 : 0.07), 1.0);
}}
"""
