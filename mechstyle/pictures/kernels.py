"""The Warp kernels of the rasteriser: faces into a z-buffer, the z-buffer into weights, and the edges that part two pixels."""

# mypy: disable-error-code="arg-type,attr-defined,index,no-any-return,no-untyped-call,no-untyped-def,valid-type"
# Warp reads the annotations of its functions itself (they are calls) and types what they compute.

from __future__ import annotations

from mechstyle._warp import wp

NOTHING = wp.constant(wp.int64(2**63 - 1))
FACE_BITS = wp.constant(wp.int64(31))
DEPTH_STEPS = wp.constant(wp.float64(2.0**32 - 1.0))
EDGE_BITS = wp.constant(wp.int64(33))
REACH_STEPS = wp.constant(wp.float64(2.0**30 - 2.0))


@wp.func
def _edge(p: wp.array2d(dtype=wp.int64), a: int, b: int, x: wp.int64, y: wp.int64) -> wp.int64:
    return (p[b, 0] - p[a, 0]) * (y - p[a, 1]) - (p[b, 1] - p[a, 1]) * (x - p[a, 0])


@wp.func
def _covers(value: wp.int64, dx: wp.int64, dy: wp.int64) -> bool:
    """Inside the edge; a pixel centre exactly on it belongs to one of the two faces that share it."""
    zero = wp.int64(0)
    return value > zero or (value == zero and (dy < zero or (dy == zero and dx > zero)))


@wp.func
def _first_pixel(low: wp.int64, step: wp.int64) -> int:
    half = step / wp.int64(2)
    return int((wp.max(low, half) - half + step - wp.int64(1)) / step)


@wp.func
def _last_pixel(high: wp.int64, step: wp.int64, count: int) -> int:
    half = step / wp.int64(2)
    if high < half:
        return -1
    return wp.min(int((high - half) / step), count - 1)


@wp.kernel
def draw(
    points: wp.array2d(dtype=wp.int64), inverse_depth: wp.array(dtype=wp.float64), faces: wp.array2d(dtype=wp.int32), size: wp.vec3i,
    scale: wp.vec2d, nearest: wp.array(dtype=wp.int64),
) -> None:  # fmt: skip
    """One thread per view and face.

    `size` is (points per view, height, width), `scale` (sub-pixels, 1 to skip back faces).
    """
    view = wp.tid() // faces.shape[0]
    face = wp.tid() - view * faces.shape[0]
    a = view * size[0] + faces[face, 0]
    b = view * size[0] + faces[face, 1]
    c = view * size[0] + faces[face, 2]
    if inverse_depth[a] <= wp.float64(0.0) or inverse_depth[b] <= wp.float64(0.0) or inverse_depth[c] <= wp.float64(0.0):
        return
    area = _edge(points, a, b, points[c, 0], points[c, 1])
    if area == wp.int64(0) or (scale[1] > wp.float64(0.0) and area > wp.int64(0)):
        return
    if area < wp.int64(0):  # rows run downwards, so front faces turn clockwise here
        swap = b
        b = c
        c = swap
        area = -area
    step = wp.int64(scale[0])
    half = step / wp.int64(2)
    left = _first_pixel(wp.min(points[a, 0], wp.min(points[b, 0], points[c, 0])), step)
    right = _last_pixel(wp.max(points[a, 0], wp.max(points[b, 0], points[c, 0])), step, size[2])
    top = _first_pixel(wp.min(points[a, 1], wp.min(points[b, 1], points[c, 1])), step)
    bottom = _last_pixel(wp.max(points[a, 1], wp.max(points[b, 1], points[c, 1])), step, size[1])
    for row in range(top, bottom + 1):
        y = wp.int64(row) * step + half
        for column in range(left, right + 1):
            x = wp.int64(column) * step + half
            u = _edge(points, b, c, x, y)
            v = _edge(points, c, a, x, y)
            w = area - u - v
            if (
                _covers(u, points[c, 0] - points[b, 0], points[c, 1] - points[b, 1])
                and _covers(v, points[a, 0] - points[c, 0], points[a, 1] - points[c, 1])
                and _covers(w, points[b, 0] - points[a, 0], points[b, 1] - points[a, 1])
            ):
                inverse = wp.float64(u) * inverse_depth[a] + wp.float64(v) * inverse_depth[b] + wp.float64(w) * inverse_depth[c]
                far = wp.clamp(wp.float64(1.0) - inverse / wp.float64(area), wp.float64(0.0), wp.float64(1.0))
                key = (wp.int64(far * DEPTH_STEPS) << FACE_BITS) | wp.int64(face)
                wp.atomic_min(nearest, (view * size[1] + row) * size[2] + column, key)


@wp.kernel
def resolve(
    points: wp.array2d(dtype=wp.int64), inverse_depth: wp.array(dtype=wp.float64), faces: wp.array2d(dtype=wp.int32), size: wp.vec3i,
    scale: wp.vec2d, nearest: wp.array(dtype=wp.int64), face_seen: wp.array(dtype=wp.int32), weights: wp.array(dtype=wp.vec3),
    depth: wp.array(dtype=wp.float32),
) -> None:  # fmt: skip
    """One thread per pixel: unpack the nearest face and weigh its corners."""
    pixel = wp.tid()
    face_seen[pixel] = -1
    depth[pixel] = wp.inf
    if nearest[pixel] == NOTHING:
        return
    face = int(nearest[pixel] & ((wp.int64(1) << FACE_BITS) - wp.int64(1)))
    view = pixel // (size[1] * size[2])
    a = view * size[0] + faces[face, 0]
    b = view * size[0] + faces[face, 1]
    c = view * size[0] + faces[face, 2]
    step = wp.int64(scale[0])
    x = wp.int64(pixel % size[2]) * step + step / wp.int64(2)
    y = wp.int64((pixel // size[2]) % size[1]) * step + step / wp.int64(2)
    area = wp.float64(_edge(points, a, b, points[c, 0], points[c, 1]))
    u = wp.float64(_edge(points, b, c, x, y)) / area * inverse_depth[a]
    v = wp.float64(_edge(points, c, a, x, y)) / area * inverse_depth[b]
    w = wp.float64(_edge(points, a, b, x, y)) / area * inverse_depth[c]
    total = u + v + w
    face_seen[pixel] = face
    weights[pixel] = wp.vec3(wp.float32(u / total), wp.float32(v / total), wp.float32(w / total))
    depth[pixel] = wp.float32(wp.float64(1.0) / total)


@wp.func
def _sign(value: wp.int64) -> int:
    if value > wp.int64(0):
        return 1
    if value < wp.int64(0):
        return -1
    return 0


@wp.func
def _inner_side(points: wp.array2d(dtype=wp.int64), a: int, b: int, c: int, d: int) -> int:
    """The side of an edge, as a sign, on which its faces' third corners c and d lie; 0 if they lie on both. d is -1 if there is none."""
    side = _sign(_edge(points, a, b, points[c, 0], points[c, 1]))
    if d < 0:
        return side
    other = _sign(_edge(points, a, b, points[d, 0], points[d, 1]))
    if side * other < 0:
        return 0
    if side == 0:
        return other
    return side


@wp.func
def _pixel(line: int, place: int, along: int, width: int) -> int:
    """The pixel at a place on a row (along 1) or on a column (along 0) of one picture."""
    if along == 1:
        return line * width + place
    return place * width + line


@wp.func
def _offer(
    points: wp.array2d(dtype=wp.int64), inverse_depth: wp.array(dtype=wp.float64), edge: wp.vec4i, along: int, view: int, size: wp.vec3i,
    step: wp.int64, nearest: wp.array(dtype=wp.int64), parting: wp.array2d(dtype=wp.int64),
) -> None:  # fmt: skip
    """Offer an edge (number, two ends, inner side) to all pairs of pixels it passes between, on rows (along 1) or on columns (along 0)."""
    a = edge[1]
    b = edge[2]
    across = 1 - along
    length = points[b, along] - points[a, along]
    if length == wp.int64(0):
        return
    half = step / wp.int64(2)
    counts = int(wp.abs(length) >= wp.abs(points[b, across] - points[a, across]))
    second_inside = int(edge[3] == (1 - 2 * along) * _sign(length))
    name = (wp.int64(edge[0]) << wp.int64(2)) | wp.int64(2 * counts + second_inside)
    low = wp.min(points[a, along], points[b, along])
    high = wp.max(points[a, along], points[b, along])
    for line in range(_first_pixel(low, step), _last_pixel(high, step, size[2 - along]) + 1):
        share = wp.float64(wp.int64(line) * step + half - points[a, along]) / wp.float64(length)
        crossing = wp.float64(points[a, across]) + share * wp.float64(points[b, across] - points[a, across])
        place = (crossing - wp.float64(half)) / wp.float64(step)
        first = int(wp.floor(place))
        if first >= 0 and first + 1 < size[2 - across]:
            picture = view * size[1] * size[2]
            inside = picture + _pixel(line, first + second_inside, along, size[2])
            outside = picture + _pixel(line, first + 1 - second_inside, along, size[2])
            inverse = (wp.float64(1.0) - share) * inverse_depth[a] + share * inverse_depth[b]
            far = wp.int64(wp.clamp(wp.float64(1.0) - inverse, wp.float64(0.0), wp.float64(1.0)) * DEPTH_STEPS)
            behind = nearest[outside] >> FACE_BITS
            if far < behind and (nearest[inside] >> FACE_BITS) < behind:
                short = wp.abs(place - wp.float64(first + 1 - second_inside))  # from the outer pixel
                key = (wp.int64(short * REACH_STEPS) << EDGE_BITS) | name
                wp.atomic_min(parting, across, picture + _pixel(line, first, along, size[2]), key)


@wp.kernel
def part(
    points: wp.array2d(dtype=wp.int64), inverse_depth: wp.array(dtype=wp.float64), edges: wp.array2d(dtype=wp.int32), size: wp.vec3i,
    step: wp.int64, nearest: wp.array(dtype=wp.int64), parting: wp.array2d(dtype=wp.int64),
) -> None:  # fmt: skip
    """One thread per view and edge: record the edge where an outline passes between the centres of two neighbouring pixels.

    An edge is of the outline where both its faces lie on one side of it in the picture. What lies outside it must be farther than the
    edge, or the edge is hidden. Of several edges the one that reaches farthest out is kept, in `parting[0]` for neighbours on a row, in
    `parting[1]` for those on a column, at the first pixel of the pair, packed with two bits: whether it counts there, and whether the
    second pixel is the inner one. A steep edge counts on rows, a flat one on columns, so that none counts twice; where it does not
    count it is kept all the same, for it hides what lies just behind it and would count.
    """
    view = wp.tid() // edges.shape[0]
    edge = wp.tid() - view * edges.shape[0]
    a = view * size[0] + edges[edge, 0]
    b = view * size[0] + edges[edge, 1]
    d = edges[edge, 3]
    if d >= 0:
        d += view * size[0]
    inner = _inner_side(points, a, b, view * size[0] + edges[edge, 2], d)
    if inner == 0 or inverse_depth[a] <= wp.float64(0.0) or inverse_depth[b] <= wp.float64(0.0):
        return
    for along in range(2):
        _offer(points, inverse_depth, wp.vec4i(edge, a, b, inner), along, view, size, step, nearest, parting)


@wp.kernel
def add_rows(
    rows: wp.array2d(dtype=wp.float32), index: wp.array2d(dtype=wp.int64), weights: wp.array2d(dtype=wp.float32),
    steps: wp.array(dtype=wp.float64), sums: wp.array2d(dtype=wp.int64),
) -> None:  # fmt: skip
    """One thread per row and column: add the weighted value, in whole steps (`steps` of them make 1), to all rows its indices name."""
    i, k = wp.tid()
    for j in range(index.shape[1]):
        value = rows[i, k] * weights[i, j]
        if value != 0.0:
            wp.atomic_add(sums, int(index[i, j]), k, wp.int64(wp.rint(wp.float64(value) * steps[0])))
