"""A run in a notebook without a kernel: a picture, a table, and nothing that such places strip."""

from mechstyle.loop.history import rows, steps
from mechstyle.loop.store import Lane
from mechstyle.records import sentences
from mechstyle.runs.report.page import mimebundle
from mechstyle.runs.report.replay_data import replay_data
from mechstyle.runs.run import Run
from support.reader import Reader


def test_a_notebook_without_a_kernel_shows_a_picture_and_a_table(lane):
    shown = lane._repr_mimebundle_()
    read = Reader(shown["text/html"])
    assert [tag for tag, _ in read.elements].count("img") == 2
    assert "script" not in [tag for tag, _ in read.elements]
    for text in (read.text, shown["text/plain"]):
        assert lane.verdict.words in text
        assert "every 10 iterations" in text


def test_a_notebook_without_a_kernel_and_the_replay_say_where_a_verdict_is_not_sure(sheet):
    run = sheet(iterations=20, gain=30.0, control="none", guarantee=False)
    told = [step.verdict for step in steps(run.store, rows(run.store))]
    assert {verdict.sure for verdict in told} == {True, False}
    shown, last = run._repr_mimebundle_(), replay_data(run).header["frames"][-1]
    for text in (Reader(shown["text/html"]).text, shown["text/plain"]):
        assert text.replace(run.verdict.words, "").count(sentences.NOT_SURE) == sum(not verdict.sure for verdict in told)
    assert last["outcome"].endswith(" (not sure)")
    assert " (not sure); " in last["words"]


def test_before_the_first_checkpoint_there_is_text_only(sheet):
    run = sheet(iterations=2)
    run.store.move("empty", Lane(recipe=run.recipe.digest))
    empty = Run(run.store, "empty", "cpu")
    assert mimebundle(empty) == {"text/plain": repr(empty)}
