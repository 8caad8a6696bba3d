"""The element arithmetic of the CPU kernels as C++ text: a number becomes a vector of lanes, all else stays as in the textbook.

Warp compiles kernels for the CPU without vectorising them. These are the same steps as in `kernels`, written with the vector
extensions of clang, the compiler inside Warp: `Lanes` adds and multiplies like a float, and the compiler maps it to whatever the
processor has (AVX, SSE or NEON registers, one or several). What lies in the lanes is for the layout to say: sixteen tetrahedra of one
drop (`simd_by_element`). It provides `load`, `load_ahead` (u + β v), `geometry` and `add`; all here is written in terms of these.
`Linear` and `Quadratic` are the elements of `elements`. Element, law, whether it yields and whether stress is recorded are types, so that
each of their loops is compiled on its own: a tenth faster than asking at every Gauss point.

What has flowed at a Gauss point is eight numbers: A = C_p⁻¹ − I as xx yy zz xy yz zx, the plastic strain, and that gathered in tension;
the formulas are those of `elasticity.StableNeoHookean` and of `laws`. A block of tetrahedra that has never yielded is computed without.
"""

from __future__ import annotations

from mechstyle.fea.elements import GAUSS_A, GAUSS_B

CONTRACT = """
    _Pragma("clang fp contract(fast)")  // a * b + c is one operation; must be the first line of a function
"""

TYPES = """
    #define INLINE __attribute__((always_inline))
    #define UNROLL _Pragma("clang loop unroll(full)")
    typedef float Lanes __attribute__((vector_size(4 * LANES), aligned(4)));
    typedef double DoubleLanes __attribute__((vector_size(8 * LANES), aligned(8)));
    struct Matrix {
        Lanes entry[3][3];
        Lanes *operator[](int i) { return entry[i]; }
        const Lanes *operator[](int i) const { return entry[i]; }
    };
    struct Linear { enum { nodes = 4, points = 1 }; };
    struct Quadratic { enum { nodes = 10, points = 4 }; };
    struct Kirchhoff { enum { neo_hookean = 0, yields = 0 }; };
    struct NeoHookean { enum { neo_hookean = 1, yields = 0 }; };
    struct ElasticPlastic { enum { neo_hookean = 1, yields = 1 }; };
    struct Virgin { enum { flowed = 0 }; };  // C_p = I
    struct Flowed { enum { flowed = 1 }; };
    enum { STATE = 8, STRAIN = 6, TENSION = 7 };  // numbers of a Gauss point, and where the plastic strains are among them
    struct Unrecorded { enum { record = 0 }; };
    struct Recorded { enum { record = 1 }; };
"""

ALGEBRA = """
    auto trace = [](const Matrix &A) { return A[0][0] + A[1][1] + A[2][2]; };
    auto contraction = [](const Matrix &A, const Matrix &B) {
        Lanes sum[3];  // one for each row: a single sum would wait nine times for its last term
        for (int i = 0; i < 3; i++) sum[i] = A[i][0] * B[i][0] + A[i][1] * B[i][1] + A[i][2] * B[i][2];
        return sum[0] + sum[1] + sum[2];
    };
    auto cofactor = [](const Matrix &A) {
        Matrix C;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                const int a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
                C[i][j] = A[a][c] * A[b][d] - A[a][d] * A[b][c];
            }
        return C;
    };
    // J - 1 = tr H + tr cof H + det H
    auto volume_change = [&](const Matrix &H, const Matrix &C) {
        return trace(H) + trace(C) + (H[0][0] * C[0][0] + H[0][1] * C[0][1] + H[0][2] * C[0][2]);
    };
"""

STRESS = """
    const float mu = scheme.mu, la = scheme.la;
    auto green_strain = [](const Matrix &H) {
        Matrix E;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                E[i][j] = 0.5f * (H[i][j] + H[j][i] + H[0][i] * H[0][j] + H[1][i] * H[1][j] + H[2][i] * H[2][j]);
        return E;
    };
    auto st_venant_kirchhoff = [&](const Matrix &H) {
        Matrix S = green_strain(H), P;
        const Lanes spherical = la * trace(S);
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) S[i][j] = 2.0f * mu * S[i][j] + (i == j ? spherical : Lanes{});
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) P[i][j] = S[i][j] + H[i][0] * S[0][j] + H[i][1] * S[1][j] + H[i][2] * S[2][j];
        return P;
    };
    // What the law is made of: cof H, tr H, q = tr b_e - 3, k and J - 1; G = F A of what has flowed.
    struct Invariants { Matrix C; Lanes tr, q, k, change; };
    auto factor = [&](const Lanes &q) { return mu * q / (4.0f * (4.0f + q)); };
    auto invariants = [&](auto history, const Matrix &H, const Matrix &G) INLINE {
        Invariants at;
        at.C = cofactor(H), at.tr = trace(H), at.q = 2.0f * at.tr + contraction(H, H);
        if constexpr (decltype(history)::flowed) at.q += trace(G) + contraction(H, G);
        at.k = factor(at.q), at.change = volume_change(H, at.C);
        return at;
    };
    auto neo_hookean = [&](auto history, const Matrix &H, const Matrix &G, const Invariants &at) INLINE {
        const float m = 0.75f * mu;
        const Lanes pressure = la * at.change, excess = pressure - m, diagonal = at.k + pressure + excess * at.tr, stiff = m + at.k;
        Matrix P;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                P[i][j] = stiff * H[i][j] + excess * (at.C[i][j] - H[j][i]) + (i == j ? diagonal : Lanes{});
                if constexpr (decltype(history)::flowed) P[i][j] += stiff * G[i][j];
            }
        return P;
    };
    auto stable_neo_hookean = [&](const Matrix &H) {
        const Matrix none = {};
        return neo_hookean(Virgin{}, H, none, invariants(Virgin{}, H, none));
    };
    auto first_piola = [&](auto law, const Matrix &H) INLINE {
        if constexpr (decltype(law)::neo_hookean) return stable_neo_hookean(H);
        else return st_venant_kirchhoff(H);
    };
    auto max = [](const Lanes &a, const Lanes &b) { return a > b ? a : b; };
    // `explicit.limits` of a Gauss point and its factor on stiffness, of a cellular body; of a solid one they are those of the scheme.
    struct Limits { Lanes strength, hardening, comparable, stiffness; };
    auto limits = [&](int point) INLINE {
        if (!body.cellular) return Limits{Lanes{} + scheme.yield_strength, Lanes{} + scheme.hardening, Lanes{} + 1.0f, Lanes{} + 1.0f};
        const Lanes *at = (const Lanes *)scheme.limits.data + 4 * point;
        return Limits{at[0], at[1], at[2], at[3]};
    };
    auto scaled = [&](Matrix P, const Limits &limit) INLINE {
        if (body.cellular)
            for (int i = 0; i < 9; i++) P[0][i] *= limit.stiffness;
        return P;
    };
    const float across[3] = {scheme.across[0], scheme.across[1], scheme.across[2]};
    const float steep = across[0] * across[0] + across[1] * across[1] + across[2] * across[2];
    // What pulls or shears printed layers apart, over their share of the strength, squared.
    auto across_layers = [&](const Matrix &T) {
        if (steep == 0.0f) return Lanes{};
        Lanes pull = {}, square = {};
        for (int i = 0; i < 3; i++) {
            const Lanes traction = T[i][0] * across[0] + T[i][1] * across[1] + T[i][2] * across[2];
            pull += traction * across[i];
            square += traction * traction;
        }
        const Lanes normal = pull * pull / steep;
        return max(3.0f * (square - normal), pull > 0.0f ? normal : Lanes{});
    };
    auto equivalent_squared = [&](const Matrix &H, const Matrix &P) {
        Matrix T;  // Kirchhoff stress J sigma = P F^T
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) T[i][j] = P[i][j] + P[i][0] * H[j][0] + P[i][1] * H[j][1] + P[i][2] * H[j][2];
        const Lanes a = T[0][0] - T[1][1], b = T[1][1] - T[2][2], c = T[2][2] - T[0][0];
        const Lanes shear = T[0][1] * T[0][1] + T[1][2] * T[1][2] + T[2][0] * T[2][0], J = 1.0f + volume_change(H, cofactor(H));
        const Lanes of_solid = 0.5f * (a * a + b * b + c * c) + 3.0f * shear;
        return max(of_solid, across_layers(T)) / (J * J);
    };
    auto energy_density = [&](auto history, const Matrix &H, const Matrix &G) INLINE {
        if (scheme.law == 0) {
            const Matrix E = green_strain(H);
            return 0.5f * la * trace(E) * trace(E) + mu * contraction(E, E);
        }
        const Invariants at = invariants(history, H, G);
        const Lanes x = 0.25f * at.q;
        Lanes square = contraction(H, H);
        if constexpr (decltype(history)::flowed) square += trace(G) + contraction(H, G);
        const Lanes s = x / (2.0f + x);  // x - ln(1 + x) by the series of artanh s
        const Lanes remainder = s * (x - s * s * (2.0f / 3.0f + s * s * (2.0f / 5.0f + s * s * 2.0f / 7.0f)));
        return 0.375f * mu * (square - 2.0f * (at.change - at.tr)) + 0.5f * mu * remainder + 0.5f * la * at.change * at.change;
    };
"""

PLASTICITY = """
    constexpr float TINY = 1e-20f;
    constexpr int ROW[6] = {0, 1, 2, 0, 1, 2}, COLUMN[6] = {0, 1, 2, 1, 2, 0};
    auto any = [](auto mask) { return __builtin_reduce_or(mask) != 0; };
    // G = F A.
    auto plastic_part = [](const Matrix &H, const Lanes *A) {
        const Matrix whole = {{{A[0], A[3], A[5]}, {A[3], A[1], A[4]}, {A[5], A[4], A[2]}}};
        Matrix G;
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++)
                G[i][j] = whole[i][j] + H[i][0] * whole[0][j] + H[i][1] * whole[1][j] + H[i][2] * whole[2][j];
        return G;
    };
    // The deviator s of b_e - I = H + H^T + H H^T + G F^T.
    auto deviator = [&](auto history, const Matrix &H, const Matrix &G, Lanes *s) INLINE {
        for (int n = 0; n < 6; n++) {
            const int i = ROW[n], j = COLUMN[n];
            s[n] = H[i][j] + H[j][i] + H[i][0] * H[j][0] + H[i][1] * H[j][1] + H[i][2] * H[j][2];
            if constexpr (decltype(history)::flowed) s[n] += G[i][j] + G[i][0] * H[j][0] + G[i][1] * H[j][1] + G[i][2] * H[j][2];
        }
        const Lanes mean = (s[0] + s[1] + s[2]) * (1.0f / 3.0f);
        for (int n = 0; n < 3; n++) s[n] -= mean;
    };
    auto square = [](const Lanes *s) {
        return s[0] * s[0] + s[1] * s[1] + s[2] * s[2] + 2.0f * (s[3] * s[3] + s[4] * s[4] + s[5] * s[5]);
    };
    // Mean Kirchhoff stress.
    auto mean_stress = [&](const Lanes &q, const Lanes &change) {
        return mu * (q * (15.0f + 4.0f * q) / (12.0f * (4.0f + q)) - 0.75f * change) + la * change * (1.0f + change);
    };
    // What is held against the strength, squared: von Mises' Kirchhoff stress, or where it is larger what pulls or shears layers apart.
    auto demand_squared = [&](const Lanes *s, const Invariants &at) INLINE {
        const Lanes stiff = 0.75f * mu + at.k, of_solid = 1.5f * stiff * stiff * square(s);
        if (steep == 0.0f) return of_solid;
        const Lanes p = mean_stress(at.q, at.change), xy = stiff * s[3], yz = stiff * s[4], zx = stiff * s[5];
        const Matrix T = {{{stiff * s[0] + p, xy, zx}, {xy, stiff * s[1] + p, yz}, {zx, yz, stiff * s[2] + p}}};
        return max(of_solid, across_layers(T));
    };
    // As `elasticity.softened`: a factor on the elastic constants.
    auto softened = [&](const Lanes *A, int block) {
        const Lanes size = ((const Lanes *)scheme.shares.data)[block] * (1.0f + __builtin_elementwise_sqrt(square(A)));
        return 1.0f / (size > 1.0f ? size : Lanes{} + 1.0f);
    };
    // One Gauss point where something has flowed or flows now: `elastic_plastic` of `laws`, lane by lane; G becomes that after the flow.
    auto flow = [&](const Matrix &H, Matrix &G, Invariants &at, Lanes *point, const Limits &of, const Lanes &softer, const Lanes *s,
                    Lanes &demand) INLINE {
        const Lanes limit = of.strength + of.hardening * point[STRAIN], J = 1.0f + at.change;
        const auto yields = (demand > limit * limit) & (J > 0.1f);
        if (!any(yields)) return;
        const Lanes stiff = softer * (0.75f * mu + at.k), m = at.q * (1.0f / 3.0f), against = 3.0f * stiff * (1.0f + m);
        const Lanes above = yields ? 1.0f - limit / __builtin_elementwise_sqrt(demand) : Lanes{};
        const Lanes along = above / (against + of.hardening), lost = against * along;
        const Lanes von_mises = stiff * __builtin_elementwise_sqrt(1.5f * square(s)), kept = 1.0f - lost;
        Lanes after[6];
        for (int n = 0; n < 6; n++) after[n] = kept * s[n];
        // Flow keeps det b_e = J^2: m^3 - 1/2 (s:s) m + det s = J^2, in m - 1, by two Newton steps from where it was.
        const Lanes half = 0.5f * square(after);
        const Lanes determinant = after[0] * (after[1] * after[2] - after[4] * after[4])
            - after[3] * (after[3] * after[2] - after[4] * after[5]) + after[5] * (after[3] * after[4] - after[1] * after[5]);
        const Lanes wanted = at.change * (2.0f + at.change) - determinant + half;
        Lanes x = m;
        for (int step = 0; step < 2; step++)
            x -= (x * (3.0f - half + x * (3.0f + x)) - wanted) / (3.0f * (1.0f + x) * (1.0f + x) - half);
        x = yields ? x : m;
        const Lanes inverse = 1.0f / (yields ? J : Lanes{} + 1.0f), spherical = x - m;
        Lanes d[6];
        for (int n = 0; n < 6; n++) d[n] = (n < 3 ? spherical : Lanes{}) - lost * s[n];
        const Matrix D = {{{d[0], d[3], d[5]}, {d[3], d[1], d[4]}, {d[5], d[4], d[2]}}};
        Matrix cof, W;  // F^-T and the change of G
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) cof[i][j] = inverse * (at.C[i][j] - H[j][i] + (i == j ? 1.0f + at.tr : Lanes{}));
        for (int i = 0; i < 3; i++)
            for (int j = 0; j < 3; j++) {
                W[i][j] = D[i][0] * cof[0][j] + D[i][1] * cof[1][j] + D[i][2] * cof[2][j];
                G[i][j] += W[i][j];
            }
        for (int n = 0; n < 6; n++) {
            const int i = ROW[n], j = COLUMN[n];
            point[n] += cof[0][i] * W[0][j] + cof[1][i] * W[1][j] + cof[2][i] * W[2][j];
        }
        at.q = 3.0f * x, at.k = factor(at.q);
        const Lanes conjugate = 1.0f - 1.5f * determinant / ((1.0f + m) * (half + TINY)), more = conjugate * along * von_mises;
        point[STRAIN] += more;
        const Lanes p = softer * mean_stress(at.q, at.change);
        point[TENSION] += 3.0f * p > -kept * von_mises ? more : Lanes{};
        demand *= kept * kept;
    };
    auto flowed_stress = [&](const Matrix &H, int block, Lanes *point, const Limits &limit, Lanes *highest) __attribute__((noinline)) {
        Matrix G = plastic_part(H, point);
        const Lanes softer = softened(point, block);
        Invariants at = invariants(Flowed{}, H, G);
        Lanes s[6];
        deviator(Flowed{}, H, G, s);
        Lanes demand = softer * softer * demand_squared(s, at);
        flow(H, G, at, point, limit, softer, s, demand);
        if (highest) *highest = max(*highest, limit.comparable * demand);
        Matrix P = neo_hookean(Flowed{}, H, G, at);
        for (int i = 0; i < 9; i++) P[0][i] *= softer;
        return P;
    };
    // Stress at a Gauss point of a block; `point` is what has flowed there, `highest` the running maximum of what is held against the
    // strength, squared, or null.
    auto elastic_plastic = [&](const Matrix &H, int block, Lanes *point, const Limits &limit, Lanes *highest) INLINE {
        if (!state.flowed.data[block]) {
            const Matrix none = {};
            const Invariants at = invariants(Virgin{}, H, none);
            Lanes s[6];
            deviator(Virgin{}, H, none, s);
            const Lanes demand = demand_squared(s, at);
            if (!any(demand > limit.strength * limit.strength)) {
                if (highest) *highest = max(*highest, limit.comparable * demand);
                return neo_hookean(Virgin{}, H, none, at);
            }
            state.flowed.data[block] = 1;
        }
        return flowed_stress(H, block, point, limit, highest);
    };
"""

ELEMENTS = (
    f"    constexpr float NEAR = 4.0f * {GAUSS_A}f, FAR = 4.0f * {GAUSS_B}f, SELF = FAR - 1.0f, EXTRA = NEAR - FAR;"
    """
    // Node between corners i and j, the corner itself for i = j.
    constexpr int between[4][4] = {{0, 4, 5, 6}, {4, 1, 7, 8}, {5, 7, 2, 9}, {6, 8, 9, 3}};
    // H + sum_i (x_i - x_0) (x) B_i: with B_i = grad L_i the gradient of what has the values x at the corners.
    auto plus_linear = [](Matrix H, const Lanes *x0, const Lanes *x1, const Lanes *x2, const Lanes *x3, const Lanes *B) INLINE {
        for (int k = 0; k < 3; k++) {
            const Lanes a = x1[k] - x0[k], b = x2[k] - x0[k], c = x3[k] - x0[k];
            for (int j = 0; j < 3; j++) H[k][j] += a * B[j] + b * B[3 + j] + c * B[6 + j];
        }
        return H;
    };
    // What the gradients at the four Gauss points of a quadratic element have in common; x[a] are the three components at node a.
    auto common_gradient = [&](const Lanes *const *x, const Lanes *B) INLINE {
        Lanes base[4][3];
        for (int i = 0; i < 4; i++)
            for (int k = 0; k < 3; k++) {
                Lanes edges = {};
                for (int j = 0; j < 4; j++)
                    if (j != i) edges += x[between[i][j]][k];
                base[i][k] = SELF * x[i][k] + FAR * edges;
            }
        return plus_linear(Matrix{}, base[0], base[1], base[2], base[3], B);
    };
    // The gradient at Gauss point q; `extra` is EXTRA grad L_i.
    auto gradient = [&](auto element, const Matrix &common, const Lanes *const *x, const Lanes *B, const Lanes *extra, int q) INLINE {
        if constexpr (decltype(element)::points == 1) return plus_linear(Matrix{}, x[0], x[1], x[2], x[3], B);
        else return plus_linear(common, x[between[0][q]], x[between[1][q]], x[between[2][q]], x[between[3][q]], extra);
    };
    // Nodal forces -sum_q V/points P_q grad N_a of an element, P_q = stress(q, H_q), handed to emit(node, component, force).
    auto nodal_forces = [&](auto element, const Lanes *const *x, const Lanes *G, auto stress, auto emit) INLINE {
        constexpr int points = decltype(element)::points;
        Lanes b[9], extra[9];
        for (int i = 0; i < 9; i++) b[i] = (-1.0f / points) * G[9] * G[i], extra[i] = EXTRA * G[i];
        Matrix common = {};
        if constexpr (points > 1) common = common_gradient(x, G);
        Lanes g[points][3][4];  // [q][component][corner]: -V/points P_q grad L_i, forces on the corners of a linear element
        UNROLL
        for (int q = 0; q < points; q++) {
            const Matrix P = stress(q, gradient(element, common, x, G, extra, q));
            for (int k = 0; k < 3; k++) {
                for (int i = 0; i < 3; i++) g[q][k][i + 1] = P[k][0] * b[3 * i] + P[k][1] * b[3 * i + 1] + P[k][2] * b[3 * i + 2];
                g[q][k][0] = -(g[q][k][1] + g[q][k][2] + g[q][k][3]);
            }
        }
        UNROLL
        for (int k = 0; k < 3; k++) {
            if constexpr (points == 1) {
                for (int i = 0; i < 4; i++) emit(i, k, g[0][k][i]);
            } else {
                Lanes total[4];
                for (int i = 0; i < 4; i++) total[i] = g[0][k][i] + g[1][k][i] + g[2][k][i] + g[3][k][i];
                UNROLL
                for (int i = 0; i < 4; i++) {
                    emit(i, k, SELF * total[i] + EXTRA * g[i][k][i]);
                    UNROLL
                    for (int j = i + 1; j < 4; j++) emit(between[i][j], k, FAR * (total[i] + total[j]) + EXTRA * (g[i][k][j] + g[j][k][i]));
                }
            }
        }
    };
    // Hands the element and the law of the body to work(element, law).
    auto for_the_body = [&](auto work) INLINE {
        auto of_element = [&](auto element) INLINE {
            if (scheme.law == 0) work(element, Kirchhoff{});
            else if (scheme.yields) work(element, ElasticPlastic{});
            else work(element, NeoHookean{});
        };
        if (body.nodes == 4) of_element(Linear{});
        else of_element(Quadratic{});
    };
"""
)

FORCES = """
    // Adds the internal forces of every block to the nodes in ascending order; if `Recorded`, keeps the running maximum of the stress
    // squared at the Gauss points.
    auto all_forces = [&](auto element, auto law, auto recorded) INLINE {
        constexpr int nodes = decltype(element)::nodes, points = decltype(element)::points;
        constexpr bool record = decltype(recorded)::record;
        Lanes *peak = (Lanes *)state.peak_squared.data, *plastic = (Lanes *)state.plastic.data;
        for (int block = 0; block < body.blocks; block++) {
            Lanes buffer[nodes][3];
            const Lanes *x[nodes];
            load_ahead(element, block, buffer, x);
            auto stress = [&](int q, const Matrix &H) INLINE {
                Lanes *highest = record ? peak + points * block + q : nullptr;
                const Limits limit = limits(points * block + q);
                if constexpr (decltype(law)::yields)
                    return scaled(elastic_plastic(H, block, plastic + STATE * (points * block + q), limit, highest), limit);
                const Matrix P = first_piola(law, H);
                if constexpr (record) *highest = max(*highest, limit.comparable * equivalent_squared(H, P));
                return scaled(P, limit);
            };
            add(element, block, [&](auto emit) INLINE { nodal_forces(element, x, geometry(block), stress, emit); });
        }
    };
    for_the_body([&](auto element, auto law) INLINE {
        if (record) all_forces(element, law, Recorded{});
        else all_forces(element, law, Unrecorded{});
    });
"""

STRAIN = """
    // Strain energy half a step ago, plastic work so far and the largest stress now, lane by lane.
    DoubleLanes strain = {}, worked = {};
    Lanes peak = {};
    auto all_energy = [&](auto element, auto law) INLINE {
        constexpr int nodes = decltype(element)::nodes, points = decltype(element)::points;
        for (int block = 0; block < body.blocks; block++) {
            const Lanes *G = geometry(block);
            Lanes extra[9];
            for (int i = 0; i < 9; i++) extra[i] = EXTRA * G[i];
            Lanes x_buffer[nodes][3], v_buffer[nodes][3];
            const Lanes *x[nodes], *v[nodes];
            load(element, state.u.data, block, x_buffer, x);
            load(element, state.v.data, block, v_buffer, v);
            Matrix x_common = {}, v_common = {};
            if constexpr (points > 1) x_common = common_gradient(x, G), v_common = common_gradient(v, G);
            Lanes volume;
            Limits limit;
            // `softer` is a factor on energy and stress, `now` the stress squared without it.
            auto add = [&](auto past, const Matrix &H, const Matrix &rate, const Matrix &G, const Matrix &P, Lanes softer, Lanes now) {
                const Lanes energy = energy_density(past, H, G) - 0.5f * scheme.time_step * contraction(P, rate);
                strain += __builtin_convertvector(volume * softer * energy, DoubleLanes);
                peak = max(peak, limit.comparable * (softer * softer * now));
            };
            for (int q = 0; q < points; q++) {
                limit = limits(points * block + q);
                volume = G[9] * (1.0f / points) * limit.stiffness;
                const Matrix H = gradient(element, x_common, x, G, extra, q), rate = gradient(element, v_common, v, G, extra, q);
                if constexpr (decltype(law)::yields) {
                    Lanes none[STATE] = {}, s[6];
                    const Lanes *point = state.flowed.data[block] ? (Lanes *)state.plastic.data + STATE * (points * block + q) : none;
                    const Matrix flowed = plastic_part(H, point);
                    const Invariants at = invariants(Flowed{}, H, flowed);
                    deviator(Flowed{}, H, flowed, s);
                    const Matrix P = neo_hookean(Flowed{}, H, flowed, at);
                    add(Flowed{}, H, rate, flowed, P, softened(point, block), demand_squared(s, at));
                    const Lanes work = volume * point[STRAIN] * (limit.strength + 0.5f * limit.hardening * point[STRAIN]);
                    worked += __builtin_convertvector(work, DoubleLanes);
                } else {
                    const Matrix P = first_piola(law, H);
                    add(Virgin{}, H, rate, Matrix{}, P, Lanes{} + 1.0f, equivalent_squared(H, P));
                }
            }
        }
    };
    for_the_body(all_energy);
"""
