"""One drop on one CPU core, sixteen tetrahedra at a time: the lanes are tetrahedra.

State is [node][x y z 0], one row of four floats a node, so that a row is one load; rows of sixteen tetrahedra are transposed into lanes
and back. Tetrahedra come in blocks of LANES, their indices and geometry as [block][quantity][lane]; the last block is filled up with
tetrahedra without volume. Forces are added to the nodes in the order of the tetrahedra: the same inputs give the same bytes.
"""

# mypy: disable-error-code="untyped-decorator,valid-type"
# Warp reads the annotations of its functions itself: they are calls.

from __future__ import annotations

from mechstyle._warp import wp
from mechstyle.fea.backends.simd_code import ALGEBRA, CONTRACT, ELEMENTS, FORCES, STRAIN, STRESS, TYPES
from mechstyle.fea.backends.simd_state import LaneBody, LaneScheme, LaneState
from mechstyle.fea.backends.subnormals import flush_subnormals, restore_mode
from mechstyle.fea.explicit import QUANTITIES

wp.set_module_options({"enable_backward": False})

LANES = 16
"""Tetrahedra in a block: one AVX-512 register of floats. With AVX2 alone 4, 8 and 16 were equally fast."""

_LAYOUT = """
    typedef float Row __attribute__((vector_size(16), aligned(4)));  // x, y, z, 0 of one node
    typedef Lanes Number;  // the bodies in the lanes differ
    auto geometry = [&](int block) { return (const Number *)body.geometry.data + 10 * block; };
    // Four rows at a time are transposed into lanes: row(node, lane) of every node of every tetrahedron.
    auto transposed = [&](auto element, int block, Lanes (*buffer)[3], const Lanes **x, auto row) INLINE {
        constexpr int nodes = decltype(element)::nodes;
        const int *numbers = body.nodes_of.data + nodes * LANES * block;
        for (int a = 0; a < nodes; a++) {
            x[a] = buffer[a];
            for (int l = 0; l < LANES; l += 4) {
                const int *node = numbers + LANES * a + l;
                const Row p = row(node[0], l), q = row(node[1], l + 1), r = row(node[2], l + 2), s = row(node[3], l + 3);
                const Row pq = __builtin_shufflevector(p, q, 0, 4, 1, 5), rs = __builtin_shufflevector(r, s, 0, 4, 1, 5);
                ((Row *)&buffer[a][0])[l / 4] = __builtin_shufflevector(pq, rs, 0, 1, 4, 5);
                ((Row *)&buffer[a][1])[l / 4] = __builtin_shufflevector(pq, rs, 2, 3, 6, 7);
                const Row pq_z = __builtin_shufflevector(p, q, 2, 6, 3, 7), rs_z = __builtin_shufflevector(r, s, 2, 6, 3, 7);
                ((Row *)&buffer[a][2])[l / 4] = __builtin_shufflevector(pq_z, rs_z, 0, 1, 4, 5);
            }
        }
    };
    auto load = [&](auto element, const float *field, int block, Lanes (*buffer)[3], const Lanes **x) INLINE {
        transposed(element, block, buffer, x, [&](int node, int) INLINE { return ((const Row *)field)[node]; });
    };
    auto load_ahead = [&](auto element, int block, Lanes (*buffer)[3], const Lanes **x) INLINE {
        const float *beta = scheme.damping.data + LANES * block;
        const Row *u = (const Row *)state.u.data, *v = (const Row *)state.v.data;
        transposed(element, block, buffer, x, [&](int node, int lane) INLINE { return u[node] + beta[lane] * v[node]; });
    };
    // The forces are transposed back into rows, which are added tetrahedron by tetrahedron.
    auto add = [&](auto element, int block, auto forces) INLINE {
        constexpr int nodes = decltype(element)::nodes;
        Lanes f[nodes][3];
        forces([&](int a, int k, Lanes value) INLINE { f[a][k] = value; });
        Row rows[nodes][LANES];
        for (int a = 0; a < nodes; a++)
            for (int l = 0; l < LANES; l += 4) {
                const Row x = ((Row *)&f[a][0])[l / 4], y = ((Row *)&f[a][1])[l / 4], z = ((Row *)&f[a][2])[l / 4], zero = {};
                const Row xy = __builtin_shufflevector(x, y, 0, 4, 1, 5), xy_2 = __builtin_shufflevector(x, y, 2, 6, 3, 7);
                const Row z0 = __builtin_shufflevector(z, zero, 0, 4, 1, 5), z0_2 = __builtin_shufflevector(z, zero, 2, 6, 3, 7);
                rows[a][l] = __builtin_shufflevector(xy, z0, 0, 1, 4, 5);
                rows[a][l + 1] = __builtin_shufflevector(xy, z0, 2, 3, 6, 7);
                rows[a][l + 2] = __builtin_shufflevector(xy_2, z0_2, 0, 1, 4, 5);
                rows[a][l + 3] = __builtin_shufflevector(xy_2, z0_2, 2, 3, 6, 7);
            }
        const int *numbers = body.nodes_of.data + nodes * LANES * block;
        for (int l = 0; l < LANES; l++)
            for (int a = 0; a < nodes; a++) *(Row *)(state.forces.data + 4 * numbers[LANES * a + l]) += rows[a][l];
    };
"""

_ADVANCE = CONTRACT + """
    typedef float Row __attribute__((vector_size(16), aligned(4)));
    auto dot = [](Row a, Row b) { const Row p = a * b; return p[0] + p[1] + p[2]; };
    const float dt = scheme.time_step;
    const float *normal_of = scheme.normals.data;
    const Row n = {normal_of[0], normal_of[1], normal_of[2], 0.0f}, weight = scheme.gravity * n;
    Row *U = (Row *)state.u.data, *V = (Row *)state.v.data, *F = (Row *)state.forces.data;
    for (int i = 0; i < body.masses.shape[0]; i++) {
        const float mass = body.masses.data[i];
        const Row before = V[i], free = before + dt * (F[i] / mass - weight);
        const float gap = state.heights.data[i] + dot(n, U[i] + dt * free);
        Row velocity = free;
        if (gap < 0.0f) {
            const float push = -gap / dt;
            const Row landed = free + push * n, normal = dot(landed, n) * n, tangential = landed - normal;
            const float length = sqrtf(dot(tangential, tangential));
            const float clipped = scheme.friction * push / (length > 1.0e-12f ? length : 1.0e-12f);
            velocity = normal + (clipped < 1.0f ? 1.0f - clipped : 0.0f) * tangential;
            state.impulse.data[i] += mass * push;
            state.contact_loss.data[i] -= 0.5f * mass * dot(velocity - free, before + velocity);
        }
        V[i] = velocity;
        U[i] = U[i] + dt * velocity;
        F[i] = Row{};
    }
"""

_SAMPLE = """
    double kinetic = 0.0, height = 0.0, momentum = 0.0, impulse = 0.0, contact_loss = 0.0, stored = 0.0, motion[18] = {};
    float highest = 0.0f;
    const float *n = scheme.normals.data;
    for (int i = 0; i < body.masses.shape[0]; i++) {
        const float *u = state.u.data + 4 * i, *v = state.v.data + 4 * i, mass = body.masses.data[i];
        kinetic += 0.5f * mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
        height += mass * (u[0] * n[0] + u[1] * n[1] + u[2] * n[2]);
        momentum += mass * (v[0] * n[0] + v[1] * n[1] + v[2] * n[2]);
        impulse += state.impulse.data[i];
        contact_loss += state.contact_loss.data[i];
        const float *arm = body.arms.data + 4 * i;
        for (int k = 0; k < 3; k++) {
            const int a = (k + 1) % 3, b = (k + 2) % 3;
            motion[k] += mass * u[k];
            motion[3 + k] += mass * v[k];
            motion[6 + k] += mass * ((arm[a] + u[a]) * v[b] - (arm[b] + u[b]) * v[a]);
            for (int j = 0; j < 3; j++) motion[9 + 3 * k + j] += mass * u[k] * arm[j];
        }
    }
    for (int l = 0; l < LANES; l++) {
        stored += strain[l];
        highest = peak[l] > highest ? peak[l] : highest;
    }
    const double values[] = {kinetic, stored, impulse, contact_loss, height, momentum, highest};
    float *out = state.samples.data + QUANTITIES * row;
    for (int k = 0; k < 7; k++) out[k] = (float)values[k];
    for (int k = 0; k < 18; k++) out[7 + k] = (float)motion[k];
"""

_HEAD = CONTRACT + f"    constexpr int LANES = {LANES}, QUANTITIES = {len(QUANTITIES)};" + TYPES + ALGEBRA + STRESS + _LAYOUT + ELEMENTS


@wp.func_native(_HEAD + FORCES)
def element_forces(body: LaneBody, state: LaneState, scheme: LaneScheme, record: int) -> None:
    """Internal forces of all tetrahedra, added to state.forces [N]; if `record`, the running maxima of σ_vM² [MPa²]."""


@wp.func_native(_ADVANCE)
def advance(body: LaneBody, state: LaneState, scheme: LaneScheme) -> None:
    """Symplectic Euler with contact for every node, as `kernels.advance`; clears the forces."""


@wp.func_native(_HEAD + STRAIN + _SAMPLE)
def sample(body: LaneBody, state: LaneState, scheme: LaneScheme, row: int) -> None:
    """One row of the history, in the order of `explicit.QUANTITIES`."""


@wp.kernel
def forces_only(body: LaneBody, state: LaneState, scheme: LaneScheme) -> None:
    """The internal forces of u + β v [N], without a step."""
    element_forces(body, state, scheme, 0)


@wp.kernel
def strides(body: LaneBody, state: LaneState, scheme: LaneScheme, first_row: int, rows: int, steps: int, record_every: int) -> None:
    """`rows` times `steps` steps and a sample."""
    mode = flush_subnormals()
    for row in range(rows):
        for step in range(steps):
            element_forces(body, state, scheme, wp.where(step % record_every == 0, 1, 0))
            advance(body, state, scheme)
        sample(body, state, scheme, first_row + row)
    restore_mode(mode)
