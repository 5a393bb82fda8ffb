"""The page offers every number of a look, in its range."""

from dataclasses import fields

from makeup_video.pipeline import FINISHES, GraphicsParams
from makeup_video.web.messages import parameters


def test_parameters_come_in_the_order_of_a_look_file():
    assert [parameter["name"] for parameter in parameters()] == [
        spec.name for spec in fields(GraphicsParams)
    ]


def test_ranges_and_meanings_are_those_of_the_code():
    for parameter, spec in zip(parameters(), fields(GraphicsParams), strict=True):
        assert (
            parameter["low"] == spec.metadata["low"]
            and parameter["help"] == spec.metadata["meaning"]
        )
        assert parameter["high"] == (4 if parameter["name"] == "gloss" else spec.metadata["high"])
        assert 0 < parameter["step"] <= (parameter["high"] - parameter["low"]) / 50


def test_labels_are_short_and_differ():
    labels = [parameter["label"] for parameter in parameters()]
    assert len(set(labels)) == 17 and max(map(len, labels)) <= 20


def test_no_finish_lies_outside_of_the_sliders():
    high = {parameter["name"]: parameter["high"] for parameter in parameters()}
    for regions in FINISHES.values():
        for values in regions.values():
            assert all(value <= high[name] for name, value in values.items())
