"""What the server answers to uploads, and what it reads from their bodies."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import CatalogueError, Look, LookError
from makeup_video.web import answers
from makeup_video.web.answers import look_in, shades_message
from shows import BLUE, Page, StandIn, serving

TABLE = b"brand,product,shade,hex,type\nAcme,Velvet,Ruby,#b4002e,lipstick\n,Sand,,#C8A,\n"


def test_a_catalogue_becomes_titles_hex_digits_and_parts():
    answer = json.loads(shades_message("shades.csv", TABLE))
    assert answer["name"] == "shades.csv"
    ruby, sand = answer["shades"]
    assert ruby == {"title": "Acme Velvet Ruby", "hex": "#B4002E", "parts": ["lips"]}
    assert (sand["title"], sand["hex"]) == ("Sand", "#CC88AA") and "eyes" in sand["parts"]


def test_titles_of_shades_have_no_control_characters():
    table = 'brand,product,shade,hex\nA\0cme\x1b[31m,Vel\u202evet,"Ruby\nred\u200b",#b4002e\n'
    (ruby,) = json.loads(shades_message("shades.csv", table.encode()))["shades"]
    assert ruby["title"] == "Acme[31m Velvet Ruby red"


@pytest.mark.parametrize(
    ("data", "fault"),
    [
        (b"", "shades.csv, line 1 is empty"),
        (b"a,b\n1,2\n", "shades.csv, line 1: the columns brand, product, shade, hex"),
        (TABLE + b"Acme,Velvet,Wrong,#12345,\n", "shades.csv, line 4: hex must be"),
        (b"brand,product,shade,hex\n", "shades.csv has no rows"),
        (b"\xff\xfe", "shades.csv cannot be read as a catalogue: it is not UTF-8"),
    ],
)
def test_a_faulty_catalogue_names_file_line_and_fault(data, fault):
    with pytest.raises(CatalogueError, match=fault):
        shades_message("shades.csv", data)


def test_more_shades_than_a_page_shows_are_refused(monkeypatch):
    monkeypatch.setattr(answers, "MOST_SHADES", 1)
    with pytest.raises(CatalogueError, match="more than 1 shades"):
        shades_message("shades.csv", TABLE)


def test_the_page_gets_shades_or_the_reason_why_not():
    with serving(StandIn()) as url, Page(url) as page:
        answer = page.post("/shades", TABLE, x_file_name="shades.csv")
        assert answer.status_code == 200 and len(answer.json()["shades"]) == 2
        answer = page.post("/shades", b"x", x_file_name="shades.csv")
        assert answer.status_code == 422 and answer.json()["error"].startswith("shades.csv, line 1")


@given(st.binary(max_size=60))
def test_a_body_is_a_look_or_refused_in_one_line(data):
    try:
        assert isinstance(look_in(data), Look)
    except LookError as error:
        assert "\n" not in str(error)


def test_a_body_with_a_look_is_that_look():
    assert look_in(json.dumps(BLUE.to_dict()).encode()) == BLUE
