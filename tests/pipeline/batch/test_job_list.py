"""Lists of jobs: rows become inputs with options; an error names its line."""

import pytest
from makeup_video.pipeline import UsageError
from makeup_video.pipeline.batch.job_list import read_jobs

COLUMNS = ("look", "lips", "ref_face")


@pytest.mark.parametrize("between", [",", ";"])
def test_rows_are_read(tmp_path, between):
    path = tmp_path / "jobs.csv"
    rows = [["in", "Out", "look", "ref-face"], ["a.mp4", "", "nude", "2"], ["", "", "", ""],
            ['"b, c.mp4"', "x/{name}.mkv", "", ""]]  # fmt: skip
    path.write_text("\ufeff" + "\n".join(between.join(row) for row in rows), encoding="utf-8")
    first, second = read_jobs(path, COLUMNS)
    assert (first.source, first.output, first.options) == (
        "a.mp4", None, {"look": "nude", "ref_face": "2"},
    )  # fmt: skip
    assert (second.source, second.output, second.options) == ("b, c.mp4", "x/{name}.mkv", {})
    assert second.where == f"{path}, line 4"


@pytest.mark.parametrize("first", ['"in","look"', '"in";"look"'])
def test_names_of_columns_may_stand_in_quotes(tmp_path, first):
    (tmp_path / "jobs.csv").write_text(f'{first}\n"a.mp4"{first[4]}"nude"\n')
    (job,) = read_jobs(tmp_path / "jobs.csv", COLUMNS)
    assert (job.source, job.options) == ("a.mp4", {"look": "nude"})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1 is empty: it must name the columns, such as 'in'"),
        ("look\nnude", r"line 1: the column in, .* is missing"),
        (
            "in,lisp\na,b",
            r"line 1: there is no column 'lisp'; the columns .*: did you mean lips\?$",
        ),
        ("in,look,look\na,b,c", "line 1: the column look appears twice"),
        ("in,look\na", "line 2: 2 cells were expected, as in line 1, got 1"),
        ("in,look\na,b\n,nude", "line 3: the column in is empty"),
        ('in,look\n"a,b', "line 2: no proper CSV"),
        ('"in,look\na,b', "line 1: no proper CSV"),
        ("in,look\n", "has no rows"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(tmp_path, text, message):
    path = tmp_path / "jobs.csv"
    path.write_text(text)
    with pytest.raises(UsageError, match=message):
        read_jobs(path, COLUMNS)


def test_a_list_that_cannot_be_read(tmp_path):
    with pytest.raises(UsageError, match=r"does not exist: give a list of jobs \(CSV\)"):
        read_jobs(tmp_path / "no.csv", COLUMNS)
    (tmp_path / "raw.csv").write_bytes(b"in\n\xff\xfe")
    with pytest.raises(UsageError, match="not UTF-8 text"):
        read_jobs(tmp_path / "raw.csv", COLUMNS)
