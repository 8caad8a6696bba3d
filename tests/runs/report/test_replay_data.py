"""The replay data hold every iteration to within half a step, and say so in their header."""

import gzip
from dataclasses import replace

import numpy as np
import pytest
from msgspec.structs import replace as replace_fields

from mechstyle.errors import BadInput
from mechstyle.loop.store import Lane, Store
from mechstyle.pictures import scene
from mechstyle.pictures.fields import stays_bent
from mechstyle.records import sentences
from mechstyle.runs.report.replay_data import LEVELS, NO_NUMBER, Channel, channel_of, replay_data
from mechstyle.runs.run import Run


def unpacked(played):
    """What the browser makes of replay data: the base surface, and for each field the values of every frame."""
    header, content = played.header, gzip.decompress(played.payload)
    count, at = header["vertices"], 0
    base = {}
    for name, kind, length in (("vertices", "<f4", 3 * count), ("normals", "<f4", 3 * count), ("faces", "<u4", 3 * header["faces"])):
        base[name] = np.frombuffer(content, kind, length, at).reshape(-1, 3)
        at += 4 * length
    for spec in header["channels"]:
        length, size = count * spec["width"], spec["size"]
        changes = np.frombuffer(content, np.uint8, spec["planes"] * size * length, at).reshape(spec["planes"], size, length)
        at += changes.size
        kind = np.uint8 if size == 1 else np.uint16
        whole = sum(changes[:, byte].astype(np.uint32) << (8 * byte) for byte in range(size))
        planes = np.cumsum(whole, axis=0, dtype=np.uint32).astype(kind)
        base[spec["name"]] = spec["low"] + spec["step"] * planes[spec["frames"]].astype(float)
    assert at == len(content)
    return base


def test_every_iteration_is_there_once_and_in_order(lane):
    assert replay_data(lane).iterations == list(range(61))


def test_the_browser_gets_the_surface_and_every_field_of_every_iteration(lane):
    played = replay_data(lane)
    got, surface = unpacked(played), lane.part.surface
    assert np.allclose(got["vertices"], surface.vertices, atol=1e-4)
    assert np.allclose(got["normals"], surface.vertex_normals, atol=1e-6)
    assert np.array_equal(got["faces"], surface.faces)
    for frame in (0, 1, 37, 60):
        state = lane.checkpoint(frame)
        wanted = {"displacement": state.displacement, "stress": state.stress, "demand": state.demand, "restraint": 1.0 - state.mask}
        for name, values in wanted.items():
            half_a_step = 0.5 * next(spec["step"] for spec in played.header["channels"] if spec["name"] == name)
            assert np.abs(got[name][frame] - values).max() <= half_a_step * 1.001 + 1e-6, name
        assert np.abs(got["colour"][frame] / 255 - state.colour.ravel()).max() <= 0.5 / 255 + 1e-3


def test_fields_that_change_at_simulations_only_are_kept_once(lane):
    channels = {spec["name"]: spec for spec in replay_data(lane).header["channels"]}
    simulations = len({entry.simulated_at for entry in lane.history})
    assert channels["stress"]["planes"] == simulations
    assert channels["displacement"]["planes"] > 50


def test_frames_say_what_was_simulated_and_why(lane):
    frames = replay_data(lane).header["frames"]
    assert frames[20]["reason"] == "every 10 iterations"
    verdict = lane.checkpoint(20).verdict
    assert frames[20]["outcome"].startswith(verdict.outcome)
    assert frames[20]["words"] == sentences.note(verdict)
    assert "outcome" not in frames[21]
    assert frames[21]["simulatedAt"] == 20
    assert frames[60]["restrained"] == pytest.approx(float((lane.checkpoint(60).mask < 0.5).mean()), abs=1e-4)


def test_a_frame_counts_what_the_report_counts_and_not_what_quantising_made_of_it(sheet):
    """A mask of exactly one half does not restrain, but no step of the scale lies there."""
    run = sheet(iterations=10)
    last = run.checkpoint()
    mask = np.ones_like(last.mask)
    mask[:8], mask[8:20] = 0.0, 0.5
    digest = run.store.objects.put_record(replace(last, mask=mask))
    run.store.move("main", replace_fields(run.store.lane(), head=digest))
    assert replay_data(run).header["frames"][-1]["restrained"] == 8 / 64


def test_layers_hold_their_values_and_their_threshold(lane):
    played = replay_data(lane)
    stress = played.layer("stress")
    assert stress["threshold"] == lane.recipe.test.material.yield_strength
    assert stress["low"] <= stress["threshold"] < stress["high"]
    assert max(lane.checkpoint(i).stress.max() for i in range(61)) <= stress["high"] * 1.0001
    assert played.layer("style")["threshold"] is None
    bend = played.layer("stays_bent")
    assert (bend["unit"], bend["threshold"], bend["bounded"]) == ("mm", lane.verdict.deciding.allowed, True)


def test_what_stays_bent_is_that_of_the_worst_test_of_each_simulation(lane):
    got = unpacked(replay_data(lane))["stays_bent"]
    for frame in (0, 20, 25, 60):
        row = lane.store.verdict(lane.checkpoint(frame)).deciding
        assert got[frame] == pytest.approx(stays_bent(row).values_in(lane.simulation(frame)), abs=1e-3)


def test_demand_is_read_as_the_recipe_in_force_has_it(sheet, lane):
    run = sheet(iterations=20, threshold=0.5, control="frozen", normalisation="own_max")
    demand, usual = replay_data(run).layer("demand"), replay_data(lane).layer("demand")
    assert demand["threshold"] == 0.5
    assert usual["threshold"] == lane.recipe.restraint.threshold
    assert "original" in demand["label"]
    assert "reserve" in usual["label"]


def test_a_field_that_is_the_same_everywhere_has_a_scale_of_its_own_size(sheet):
    stress = replay_data(sheet(iterations=3, gain=0.0)).layer("stress")
    assert stress["high"] == pytest.approx(1.05 * stress["threshold"])


def test_the_light_is_that_of_the_figures(lane):
    assert replay_data(lane).header["light"] == {
        "key": list(scene.KEY), "keyLight": scene.KEY_LIGHT, "fill": list(scene.FILL), "fillLight": scene.FILL_LIGHT,
        "sky": scene.SKY_LIGHT, "ground": scene.GROUND_LIGHT, "flatness": scene.FLATNESS,
    }  # fmt: skip


def test_a_value_that_is_no_number_stays_apart_from_those_that_are():
    channel = channel_of("demand", [np.array([0.0, np.nan, 1.0], np.float32)])
    assert (channel.low, channel.step) == (0.0, 1.0 / LEVELS)
    assert channel.planes[0].tolist() == [0, NO_NUMBER, LEVELS]


def test_differences_wrap_around_instead_of_overflowing():
    planes = [np.array([250, 3], np.uint8), np.array([2, 255], np.uint8)]
    assert Channel("c", planes, [0, 1]).packed() == bytes([250, 3, 8, 252])


def test_the_same_lane_gives_the_same_bytes(lane):
    assert replay_data(lane) == replay_data(lane)


def test_a_lane_that_has_not_begun_is_refused(tmp_path, lane):
    store = Store(tmp_path)
    store.move("main", Lane(recipe=store.put_recipe(lane.recipe)))
    with pytest.raises(BadInput, match="has no checkpoint yet"):
        replay_data(Run(store))
