import numpy as np
import pytest

from mechstyle.styling.dimensions import Dimensions
from mechstyle.styling.drawn import NEUTRAL, ProceduralStylizer, Target, target
from mechstyle.styling.library import names
from mechstyle.styling.prompt import Wish, read
from support.degenerate import seamed, twinned

WALL = 3.0


def drawn(mesh, prompt="stone", *, seed=0, amplitude=0.3, inward=0.75, outward=2.0) -> Target:
    ones = np.ones(len(mesh.vertices))
    size = Dimensions(amplitude=amplitude, side="both", nozzle=0.0)
    (wish,) = read(prompt).wishes
    return target(mesh, wish, size, seed=seed, thickness=WALL * ones, inward=inward * ones, outward=outward * ones)


@pytest.fixture(scope="module")
def stony(holder) -> Target:
    return drawn(holder)


def test_a_target_is_single_precision_and_decided_by_the_seed(holder, stony):
    assert (stony.displacement.dtype, stony.colour.dtype) == (np.float32, np.float32)
    again, other = drawn(holder), drawn(holder, seed=1)
    assert again.displacement.tobytes() == stony.displacement.tobytes()
    assert again.colour.tobytes() == stony.colour.tobytes()
    assert not np.array_equal(other.displacement, stony.displacement)


def test_a_target_keeps_the_volume_where_no_limit_cuts_it(holder):
    free = drawn(holder, inward=9.0, outward=9.0).displacement
    assert abs(holder.vertex_areas @ free) < 1e-5 * holder.vertex_areas @ np.abs(free)


def test_a_target_stays_within_its_limits(holder):
    inward = np.linspace(0.0, 0.4, len(holder.vertices))
    outward = np.linspace(0.3, 0.0, len(holder.vertices))
    wall = np.full(len(holder.vertices), WALL)
    deep = Dimensions(amplitude=0.5, side="both")
    relief = target(holder, Wish("brick"), deep, seed=0, thickness=wall, inward=inward, outward=outward).displacement
    assert np.all(relief >= -inward.astype(np.float32))
    assert np.all(relief <= outward.astype(np.float32))


def test_the_relief_is_amplitude_times_amount_times_wall(holder, stony):
    wide = {"inward": 9.0, "outward": 9.0}
    full = drawn(holder, amplitude=0.3, **wide).displacement
    assert np.allclose(drawn(holder, amplitude=0.15, **wide).displacement, 0.5 * full, atol=1e-6)
    assert np.allclose(drawn(holder, "subtle stone", **wide).displacement, 0.5 * full, atol=1e-6)
    assert not drawn(holder, amplitude=0.0).displacement.any()


def test_a_colour_asked_for_changes_the_body_and_no_relief(holder, stony):
    blue = drawn(holder, "blue stone")
    assert np.array_equal(blue.displacement, stony.displacement)
    stones = stony.displacement > 0.0
    assert np.all(blue.colour[stones].argmax(axis=1) == 2)
    assert np.ptp(blue.colour[stones].sum(axis=1)) > 0.2  # light and dark stones stay


def test_a_shade_darkens_the_body_and_leaves_relief_and_joints(holder):
    plain, dark = drawn(holder, "brick"), drawn(holder, "dark brick")
    assert np.array_equal(dark.displacement, plain.displacement)
    bricks, joints = plain.displacement > 0.1, plain.displacement < -0.25
    assert dark.colour[bricks].mean() < 0.65 * plain.colour[bricks].mean()
    assert dark.colour[joints].mean() > 0.85 * plain.colour[joints].mean()


def test_the_canvas_tells_the_target_what_the_mesh_cannot_carry(holder):
    assert any("too coarse" in note for note in drawn(holder, "tiny brick").notes)


@pytest.fixture
def stylizer(holder, stony) -> ProceduralStylizer:
    return ProceduralStylizer(holder, stony)


def test_a_stylizer_starts_at_the_plain_part(stylizer):
    start = stylizer.proposal()
    assert not start.displacement.any()
    assert np.all(start.colour == np.float32(NEUTRAL))
    assert (start.displacement.dtype, start.colour.dtype) == (np.float32, np.float32)


def test_the_loss_is_that_of_the_formula(holder, stony, stylizer):
    relief = np.full(len(holder.vertices), 0.1)
    colour = np.full((len(holder.vertices), 3), 0.5)
    areas = holder.vertex_areas
    mean_square = (areas * stony.displacement.astype(float) ** 2).sum() / areas.sum()
    terms = (relief - stony.displacement) ** 2 / mean_square + 4.0 * ((colour - stony.colour) ** 2).sum(axis=1)
    assert stylizer.loss(relief, colour) == pytest.approx((areas * terms).sum() / areas.sum(), rel=1e-9)
    assert stylizer.loss(stony.displacement, stony.colour) == 0.0


def test_a_step_goes_down_the_gradient_of_the_loss(holder, stony, stylizer):
    slope, tint = stylizer._gradient()
    start = stylizer.proposal()
    displacement, colour = start.displacement.astype(float), start.colour.astype(float)
    for vertex in (0, 500, 3000):
        nudge = np.zeros(len(displacement))
        nudge[vertex] = 1e-3
        central = (stylizer.loss(displacement + nudge, colour) - stylizer.loss(displacement - nudge, colour)) / 2e-3
        assert central == pytest.approx(slope[vertex], rel=1e-6)
        red = nudge[:, None] * [1.0, 0.0, 0.0]
        central = (stylizer.loss(displacement, colour + red) - stylizer.loss(displacement, colour - red)) / 2e-3
        assert central == pytest.approx(tint[vertex, 0], rel=1e-6)
    moved = stylizer.step()
    assert np.all((moved.displacement - start.displacement) * slope <= 0.0)


@pytest.mark.parametrize("iterations", [1, 12, 40, 200])
def test_a_run_of_any_number_of_iterations_arrives_at_its_style(holder, stony, iterations):
    stylizer = ProceduralStylizer(holder, stony, iterations)
    losses = [stylizer.loss(*stylizer.proposal()), *(stylizer.loss(*stylizer.step()) for _ in range(iterations))]
    assert np.all(np.diff(losses) < 0.0)
    assert losses[-1] / losses[0] == pytest.approx(0.005**2, rel=0.02)  # the loss is a square


def test_a_restored_run_goes_on_with_the_same_bytes(holder, stony, stylizer):
    for _ in range(7):
        stylizer.step()
    state = stylizer.state()
    first = [stylizer.step() for _ in range(5)]
    other = ProceduralStylizer(holder, stony)
    other.restore(state)
    again = [other.step() for _ in range(5)]
    for a, b in zip(first, again, strict=True):
        assert a.displacement.tobytes() == b.displacement.tobytes()
        assert a.colour.tobytes() == b.colour.tobytes()


def test_a_state_is_not_changed_by_later_steps(stylizer):
    state = stylizer.state()
    before = {name: field.copy() for name, field in state.items()}
    stylizer.step()
    assert all(np.array_equal(state[name], before[name]) for name in state)


def test_the_proposal_does_not_know_what_a_mask_held_back(holder, stony, stylizer):
    other = ProceduralStylizer(holder, stony)
    for _ in range(5):
        proposal = other.step()
        stylizer.step()
        # An engine may ask for the loss of anything; only steps move the stylizer.
        other.loss(0.0 * proposal.displacement, proposal.colour)
    assert other.proposal().displacement.tobytes() == stylizer.proposal().displacement.tobytes()


def test_another_style_takes_over_from_what_the_first_left(holder, stony):
    brick = ProceduralStylizer(holder, drawn(holder, "brick"))
    brick.start_from(stony.displacement, stony.colour)
    left = brick.proposal()
    assert np.array_equal(left.displacement, stony.displacement)
    assert brick.loss(*brick.step()) < brick.loss(*left)


def test_a_target_without_relief_still_gets_its_colour(holder):
    flat = ProceduralStylizer(holder, drawn(holder, amplitude=0.0))
    before = flat.loss(*flat.proposal())
    assert np.isfinite(before)
    assert flat.loss(*flat.step()) < before
    assert not flat.proposal().displacement.any()


def test_a_target_does_not_fold_and_says_where_it_would_have(stand):
    deep = drawn(stand, amplitude=4.0, inward=9.0, outward=9.0)
    turned = np.einsum("ij,ij->i", stand.displaced(deep.displacement).face_normals, stand.face_normals)
    assert turned.min() > 0.16
    assert any("folded over itself" in note for note in deep.notes)


@pytest.mark.parametrize("make", [seamed, lambda mesh: twinned(mesh, range(0, 300, 15))], ids=["seams", "twins"])
def test_every_style_can_be_drawn_and_approached_where_there_is_no_area(coarse_cup, blank, make):
    """A plug-in or a run of an earlier version may bring such a surface."""
    part = make(coarse_cup)
    assert part.face_areas.min() == 0.0
    thick = np.full(len(part.vertices), 3.0)
    limits = {"thickness": thick, "inward": 0.25 * thick, "outward": thick}
    for style in names():
        aim = target(part, Wish(style), Dimensions(), seed=0, canvas=blank(part), **limits)
        stylizer = ProceduralStylizer(part, aim)
        for _ in range(200):
            proposal = stylizer.step()
        assert np.isfinite(proposal.displacement).all()
        assert np.isfinite(proposal.colour).all()
        assert np.abs(proposal.displacement - aim.displacement).max() < 0.02 * np.abs(aim.displacement).max() + 1e-6
