"""The page offers every number of a look, in its range."""

from dataclasses import fields

from makeup_video.pipeline import FINISHES, GraphicsParams
from makeup_video.web.messages import parameters


def test_parameters_come_in_the_order_of_a_look_file():
    assert [one["name"] for one in parameters()] == [spec.name for spec in fields(GraphicsParams)]


def test_ranges_and_meanings_are_those_of_the_code():
    for one, spec in zip(parameters(), fields(GraphicsParams), strict=True):
        assert one["low"] == spec.metadata["low"] and one["help"] == spec.metadata["meaning"]
        assert one["high"] == (4 if one["name"] == "gloss" else spec.metadata["high"])
        assert 0 < one["step"] <= (one["high"] - one["low"]) / 50


def test_labels_are_short_and_differ():
    labels = [one["label"] for one in parameters()]
    assert len(set(labels)) == 17 and max(map(len, labels)) <= 20


def test_no_finish_lies_outside_of_the_sliders():
    high = {one["name"]: one["high"] for one in parameters()}
    for regions in FINISHES.values():
        for values in regions.values():
            assert all(value <= high[name] for name, value in values.items())
