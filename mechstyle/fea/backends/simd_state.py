"""Inputs of the SIMD kernels; `simd_by_element` documents the order of their arrays."""

# mypy: disable-error-code="valid-type"
# Warp reads these annotations itself: they are calls.

from __future__ import annotations

from mechstyle._warp import wp


@wp.struct
class LaneBody:
    """A discretised body in blocks."""

    nodes: wp.int32  # of an element: 4 or 10
    blocks: wp.int32
    nodes_of: wp.array(dtype=wp.int32)
    geometry: wp.array(dtype=wp.float32)  # ∇L_1, ∇L_2, ∇L_3 (1/mm), volume (mm³)
    masses: wp.array(dtype=wp.float32)  # [node] g
    arms: wp.array(dtype=wp.float32)  # [node][x y z 0] from the centre of mass (mm)


@wp.struct
class LaneState:
    """Drops in progress; see `explicit.Batch` for the quantities."""

    heights: wp.array(dtype=wp.float32)
    u: wp.array(dtype=wp.float32)
    v: wp.array(dtype=wp.float32)
    forces: wp.array(dtype=wp.float32)
    impulse: wp.array(dtype=wp.float32)
    contact_loss: wp.array(dtype=wp.float32)
    peak_squared: wp.array(dtype=wp.float32)
    corners_squared: wp.array(dtype=wp.float32)
    samples: wp.array(dtype=wp.float32)


@wp.struct
class LaneScheme:
    """Parameters of one time step; see `explicit.Scheme`."""

    law: wp.int32
    mu: wp.float32
    la: wp.float32
    time_step: wp.float32
    gravity: wp.float32
    friction: wp.float32
    damping: wp.array(dtype=wp.float32)  # β of each tetrahedron, as the blocks lie
    normals: wp.array(dtype=wp.float32)
    across: wp.vec3f  # normal of printed layers over their share of the strength, zero for none
