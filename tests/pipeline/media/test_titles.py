"""Subtitles that overlap become subtitles that do not, and show the same at every moment."""

import itertools

from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.media.titles import OneAtATime, Title, joined

SEPARATOR = b"{\\rDefault}\\N"


def event(text):
    return b"0,0,Default,,0,0,0,," + text


def told(titles):
    """The titles that come out, with the texts that each shows."""
    turns = OneAtATime()
    out = [one for title in titles for one in turns(title)] + turns.drain()
    return [(one.begin, one.end, one.line.split(b",,")[-1].split(SEPARATOR)) for one in out]


numbered = st.lists(st.tuples(st.integers(0, 12), st.integers(1, 9)), max_size=9).map(
    lambda spans: [
        Title(begin, begin + length, event(b"%d, and" % number))
        for number, (begin, length) in enumerate(sorted(spans))
    ]
)


@given(numbered)
def test_every_moment_shows_what_it_showed_before(titles):
    out = told(titles)
    for moment in range(22):
        want = [one.line for one in titles if one.begin <= moment < one.end]
        shown = [texts for begin, end, texts in out if begin <= moment < end]
        assert len(shown) <= 1
        assert [event(text) for texts in shown for text in texts] == want


@given(numbered)
def test_titles_come_in_order_and_none_is_empty(titles):
    out = told(titles)
    assert all(begin < end for begin, end, _ in out)
    assert all(first[1] <= second[0] for first, second in itertools.pairwise(out))


def test_titles_that_do_not_overlap_are_left_as_they_are():
    titles = [Title(0, 5, event(b"one")), Title(5, 9, event(b"two")), Title(20, 21, event(b"3"))]
    assert told(titles) == [(0, 5, [b"one"]), (5, 9, [b"two"]), (20, 21, [b"3"])]


def test_a_title_without_an_end_lasts_until_the_next_one():
    titles = [Title(2, None, event(b"one")), Title(6, None, event(b"two"))]
    assert told(titles) == [(2, 6, [b"one"]), (6, 6, [b"two"])]


def test_titles_without_an_end_that_begin_together_stay_so():
    titles = [
        Title(2, None, event(b"one")),
        Title(2, None, event(b"two")),
        Title(6, 7, event(b"3")),
    ]
    assert told(titles) == [(2, 6, [b"one", b"two"]), (6, 7, [b"3"])]


def test_a_title_that_comes_late_is_shown_from_then_on():
    titles = [Title(5, 9, event(b"one")), Title(7, 8, event(b"two")), Title(3, 9, event(b"late"))]
    assert told(titles) == [
        (5, 7, [b"one"]),
        (7, 8, [b"one", b"two", b"late"]),
        (8, 9, [b"one", b"late"]),
    ]


def test_each_text_keeps_its_style():
    lines = [b"0,0,Bold,,0,0,0,,one", b"1,0,Small,,0,0,0,,two, three"]
    assert joined(lines) == b"0,0,Bold,,0,0,0,,one{\\rSmall}\\Ntwo, three"
