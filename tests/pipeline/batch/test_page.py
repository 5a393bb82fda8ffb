"""The page of results: one file holds everything, names are escaped, links find the files."""

import os
import re
from html.parser import HTMLParser
from urllib.parse import unquote

import pytest
from makeup_video.pipeline import Look, OutputError, Settings, UsageError
from makeup_video.pipeline.batch.job import Done, Failed, Job, JobLook
from makeup_video.pipeline.batch.page import check_page, page_of, write_page


class Reader(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.open, self.links, self.images, self.text = [], [], [], ""
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.links += [values["href"]] if tag == "a" else []
        self.images += [values["src"]] if tag == "img" else []
        if tag not in ("meta", "img"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


NASTY = "a <b>&\"'#?% é.mp4"


def batch(folder):
    source, outputs = folder / NASTY, [folder / "out" / f"{n} {NASTY}" for n in "123"]
    looks = [
        JobLook(f"look <{n}>", Look(), str(path)) for n, path in zip("123", outputs, strict=True)
    ]
    job = Job(str(source), tuple(looks), Settings())
    results = {
        str(outputs[0]): Done(str(outputs[0]), 2_500_000, 300, 4.25, ("left <out>",), False,
                              b"before", b"after"),
        str(outputs[1]): Failed(str(outputs[1]), OutputError("the disk <is> full")),
        str(outputs[2]): Done(str(outputs[2]), 900, 1, 0.0, (), False, b"before", None),
    }  # fmt: skip
    return job, results


def test_a_page_shows_every_result_and_needs_no_other_file(tmp_path):
    job, results = batch(tmp_path)
    text = page_of(tmp_path / "out", [job], results)
    page = Reader(text)
    assert "2 of 3 outputs done, 1 failed" in page.text
    for words in (NASTY, "look <1>", "300 frames, 2.5 MB", "4.2 s", "left <out>",
                  "the disk <is> full", "0.9 kB"):  # fmt: skip
        assert words in page.text
    assert len(page.images) == 2 and all(one.startswith("data:") for one in page.images)
    found = [(tmp_path / "out" / unquote(link)).resolve() for link in page.links]
    assert found == [tmp_path / NASTY, *(tmp_path / "out" / f"{n} {NASTY}" for n in "13")]
    assert not re.search(r'(src|href)="(https?:|//|/)', text)


def test_links_lead_to_another_drive_as_well(monkeypatch, tmp_path):
    def elsewhere(path, start):
        raise ValueError("path is on mount 'D:', start on mount 'C:'")

    monkeypatch.setattr("os.path.relpath", elsewhere)
    job, results = batch(tmp_path)
    write_page(tmp_path / "index.html", [job], results)
    page = Reader((tmp_path / "index.html").read_text(encoding="utf-8"))
    assert page.links[0].startswith("file:///")
    assert unquote(page.links[0].removeprefix("file://")) == str(tmp_path / NASTY)


def test_errors_are_put_into_the_words_of_the_reader(tmp_path):
    job, results = batch(tmp_path)
    page = Reader(page_of(tmp_path, [job], results, lambda error: "what I say"))
    assert "what I say" in page.text and "disk" not in page.text


def test_a_page_replaces_a_page_but_no_other_file(tmp_path):
    job, results = batch(tmp_path)
    path = tmp_path / "index.html"
    for _ in range(2):
        check_page(path, overwrite=False)
        write_page(path, [job], results)
    path.write_text("<html>mine</html>")
    with pytest.raises(UsageError, match="is another page"):
        check_page(path, overwrite=False)
    check_page(path, overwrite=True)


def test_what_was_not_reached_is_left_out(tmp_path):
    job, results = batch(tmp_path)
    del results[job.looks[1].output]
    page = Reader(page_of(tmp_path, [job, Job("other.mp4", (), Settings())], results))
    assert "2 of 2 outputs done" in page.text and "look <2>" not in page.text
    assert "other.mp4" not in page.text


def test_a_name_that_is_no_utf8_stands_on_the_page(tmp_path):
    source = tmp_path / os.fsdecode(b"caf\xe9.mp4")
    job = Job(str(source), (JobLook("red", Look(), str(tmp_path / "out.mp4")),), Settings())
    failed = Failed(job.looks[0].output, OutputError(f"{source} is gone"))
    write_page(tmp_path / "index.html", [job], {job.looks[0].output: failed})
    assert r"caf\udce9.mp4 is gone" in (tmp_path / "index.html").read_text(encoding="utf-8")
