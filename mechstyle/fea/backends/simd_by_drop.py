"""Eight drops on one CPU core, one tetrahedron at a time: the lanes are orientations.

Everything about the body is shared by the drops, everything that differs lies side by side: state is [node][x y z][lane], so that no
transposition is needed and each number of the body is read once for eight drops. Forces are added in the order of the tetrahedra.
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

LANES = 8
"""Drops computed together."""

_LAYOUT = """
    typedef float Number;  // what lies in no lane: the body is the same for all drops
    auto geometry = [&](int block) { return (const Number *)body.geometry.data + 10 * block; };
    auto load = [&](auto element, const float *field, int block, Lanes (*)[3], const Lanes **x) INLINE {
        constexpr int nodes = decltype(element)::nodes;
        const int *node = body.nodes_of.data + nodes * block;
        for (int a = 0; a < nodes; a++) x[a] = (const Lanes *)(field + 3 * LANES * node[a]);
    };
    auto load_ahead = [&](auto element, int block, Lanes (*buffer)[3], const Lanes **x) INLINE {
        constexpr int nodes = decltype(element)::nodes;
        const int *node = body.nodes_of.data + nodes * block;
        const float beta = scheme.damping.data[block];
        const Lanes *u = (const Lanes *)state.u.data, *v = (const Lanes *)state.v.data;
        for (int a = 0; a < nodes; a++) {
            x[a] = buffer[a];
            for (int k = 0; k < 3; k++) buffer[a][k] = u[3 * node[a] + k] + beta * v[3 * node[a] + k];
        }
    };
    auto add = [&](auto element, int block, auto forces) INLINE {
        const int *node = body.nodes_of.data + decltype(element)::nodes * block;
        forces([&](int a, int k, Lanes f) INLINE { ((Lanes *)(state.forces.data + 3 * LANES * node[a]))[k] += f; });
    };
"""

_ADVANCE = CONTRACT + f"    constexpr int LANES = {LANES};" + TYPES + """
    const float dt = scheme.time_step;
    const Lanes *n = (const Lanes *)scheme.normals.data;
    auto dot = [](const Lanes *a, const Lanes *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    for (int i = 0; i < body.masses.shape[0]; i++) {
        const float mass = body.masses.data[i], per_mass = 1.0f / mass;
        Lanes *u = (Lanes *)state.u.data + 3 * i, *v = (Lanes *)state.v.data + 3 * i;
        Lanes *force = (Lanes *)state.forces.data + 3 * i, velocity[3], ahead[3];
        for (int k = 0; k < 3; k++) {
            velocity[k] = v[k] + dt * (force[k] * per_mass - scheme.gravity * n[k]);
            ahead[k] = u[k] + dt * velocity[k];
        }
        const Lanes gap = ((const Lanes *)state.heights.data)[i] + dot(n, ahead);
        bool touching = false;
        for (int l = 0; l < LANES; l++) touching |= gap[l] < 0.0f;
        if (touching) {
            Lanes tangential[3], change[3], sum[3], length;
            const Lanes zero = {}, push = gap < 0.0f ? -gap / dt : zero;
            const Lanes along = dot(velocity, n) + push;
            for (int k = 0; k < 3; k++) tangential[k] = velocity[k] + push * n[k] - along * n[k];
            const Lanes square = dot(tangential, tangential);
            for (int l = 0; l < LANES; l++) length[l] = sqrtf(square[l]) > 1.0e-12f ? sqrtf(square[l]) : 1.0e-12f;
            const Lanes clipped = scheme.friction * push / length, kept = clipped < 1.0f ? 1.0f - clipped : zero;
            for (int k = 0; k < 3; k++) {
                const Lanes landed = along * n[k] + kept * tangential[k], after = gap < 0.0f ? landed : velocity[k];
                change[k] = after - velocity[k];
                sum[k] = v[k] + after;
                velocity[k] = after;
            }
            ((Lanes *)state.impulse.data)[i] += mass * push;
            ((Lanes *)state.contact_loss.data)[i] -= 0.5f * mass * dot(change, sum);
        }
        for (int k = 0; k < 3; k++) {
            v[k] = velocity[k];
            u[k] += dt * velocity[k];
            force[k] = Lanes{};
        }
    }
"""

_SAMPLE = """
    DoubleLanes kinetic = {}, height = {}, momentum = {}, impulse = {}, contact_loss = {}, motion[18] = {};
    const Lanes *n = (const Lanes *)scheme.normals.data;
    auto wide = [](Lanes x) { return __builtin_convertvector(x, DoubleLanes); };
    for (int i = 0; i < body.masses.shape[0]; i++) {
        const Lanes *u = (const Lanes *)state.u.data + 3 * i, *v = (const Lanes *)state.v.data + 3 * i;
        const float mass = body.masses.data[i];
        kinetic += wide(0.5f * mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
        height += wide(mass * (u[0] * n[0] + u[1] * n[1] + u[2] * n[2]));
        momentum += wide(mass * (v[0] * n[0] + v[1] * n[1] + v[2] * n[2]));
        impulse += wide(((const Lanes *)state.impulse.data)[i]);
        contact_loss += wide(((const Lanes *)state.contact_loss.data)[i]);
        const float *arm = body.arms.data + 4 * i;
        for (int k = 0; k < 3; k++) {
            const int a = (k + 1) % 3, b = (k + 2) % 3;
            motion[k] += wide(mass * u[k]);
            motion[3 + k] += wide(mass * v[k]);
            motion[6 + k] += wide(mass * ((arm[a] + u[a]) * v[b] - (arm[b] + u[b]) * v[a]));
            for (int j = 0; j < 3; j++) motion[9 + 3 * k + j] += wide(mass * u[k] * arm[j]);
        }
    }
    const DoubleLanes values[] = {kinetic, strain, impulse, contact_loss, height, momentum, wide(peak)};
    float *out = state.samples.data + QUANTITIES * LANES * row;
    for (int k = 0; k < QUANTITIES; k++)
        for (int l = 0; l < LANES; l++) out[k * LANES + l] = (float)(k < 7 ? values[k] : motion[k - 7])[l];
"""

_HEAD = CONTRACT + f"    constexpr int LANES = {LANES}, QUANTITIES = {len(QUANTITIES)};" + TYPES + ALGEBRA + STRESS + _LAYOUT + ELEMENTS


@wp.func_native(_HEAD + FORCES)
def element_forces_of_drops(body: LaneBody, state: LaneState, scheme: LaneScheme, record: int) -> None:
    """Internal forces of all tetrahedra, added to state.forces [N]; if `record`, the running maxima of σ_vM² [MPa²]."""


@wp.func_native(_ADVANCE)
def advance_drops(body: LaneBody, state: LaneState, scheme: LaneScheme) -> None:
    """Symplectic Euler with contact for every node, as `kernels.advance`; clears the forces."""


@wp.func_native(_HEAD + STRAIN + _SAMPLE)
def sample_drops(body: LaneBody, state: LaneState, scheme: LaneScheme, row: int) -> None:
    """One row of the history, in the order of `explicit.QUANTITIES`."""


@wp.kernel
def strides_of_drops(
    body: LaneBody, state: LaneState, scheme: LaneScheme, first_row: int, rows: int, steps: int, record_every: int
) -> None:
    """`rows` times `steps` steps and a sample."""
    mode = flush_subnormals()
    for row in range(rows):
        for step in range(steps):
            element_forces_of_drops(body, state, scheme, wp.where(step % record_every == 0, 1, 0))
            advance_drops(body, state, scheme)
        sample_drops(body, state, scheme, first_row + row)
    restore_mode(mode)
