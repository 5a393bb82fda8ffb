"""Tables: rows by column, and every fault with its file and line."""

import csv
import io

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.errors import UsageError
from makeup_video.pipeline.files.table import TableRow, open_table, table_rows

# Text that the csv module writes and reads back: no NUL, and no lone surrogate.
TEXT = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"), max_size=8)


def rows(text, columns=list):
    return list(table_rows(io.StringIO(text, newline=""), "t.csv", columns, UsageError))


@given(st.lists(st.tuples(TEXT, TEXT), max_size=5), st.sampled_from(",;"))
def test_rows_come_back_as_csv_wrote_them(cells, between):
    text = io.StringIO(newline="")
    csv.writer(text, delimiter=between).writerows([("One", " two "), *cells])
    got = [dict(row.cells) for row in rows(text.getvalue())]
    stripped = [(one.strip(), two.strip()) for one, two in cells]
    assert got == [{"one": one, "two": two} for one, two in stripped if one or two]


def test_a_row_of_several_lines_is_named_by_its_first():
    found = rows('a,b\n\n"x\ny",z\nu,v\n')
    assert found == [
        TableRow("t.csv", 3, {"a": "x\ny", "b": "z"}),
        TableRow("t.csv", 5, {"a": "u", "b": "v"}),
    ]
    assert [row.where for row in found] == ["t.csv, line 3", "t.csv, line 5"]
    with pytest.raises(UsageError, match=r"t\.csv, line 2: no proper CSV"):
        rows('a,b\n"x\ny,z\n')


def test_columns_may_be_renamed_and_refused():
    assert rows("A-b\nx\n", lambda names: [name.replace("-", "_") for name in names]) == [
        TableRow("t.csv", 2, {"a_b": "x"})
    ]

    def refuse(names):
        raise UsageError(str(names))

    for text, names in (("", "[]"), ("\n", "[]"), (" A ,B\n", "['a', 'b']")):
        with pytest.raises(UsageError) as caught:
            rows(text, refuse)
        assert str(caught.value) == names


@pytest.mark.parametrize(
    ("data", "words"),
    [(b"a\n\xff\n", "not UTF-8 text"), (b"a\n" * 100, "more than 0 MB"), (None, None)],
)
def test_a_file_that_cannot_be_read_is_named(tmp_path, data, words):
    path = tmp_path / "t.csv"
    if data is not None:
        path.write_bytes(data)
    text = f"t.csv cannot be read as a list: .*{words}"
    with (
        pytest.raises(
            UsageError, match=text if words else r"t.csv does not exist: give a list \(CSV\)"
        ),
        open_table(path, "a list", 99, UsageError) as lines,
    ):
        list(table_rows(lines, path, list, UsageError))
