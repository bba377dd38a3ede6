"""Damaged and hostile files of landmarks: refused, with the file and the line."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from isomatch import LandmarkSet, read_landmarks, write_landmarks

REFUSED = {
    "none.off": ("", "ends with"),
    "empty.tps": ("", "no landmarks"),
    "cut.mrk.json": ('{"markups": [\n{"controlPoints": [', "line 2"),
    "deep.json": ("[" * 200_000, "not usable as JSON"),
    "digits.json": ('{"markups": ' + "9" * 10_000 + "}", "not usable as JSON"),
    "other.json": ('{"points": []}', "Slicer markups"),
    "number.json": ("3", "Slicer markups"),
    "ijk.json": (
        '{"markups": [{"coordinateSystem": "IJK", "controlPoints": []}]}',
        "neither LPS nor RAS",
    ),
    "text.json": (
        '{"markups": [{"controlPoints": [{"position": [1, "2", 3]}]}]}',
        r"controlPoints\[0\].position is not three finite numbers",
    ),
    "huge.json": (
        '{"markups": [{"controlPoints": [{"position": [1, 1e999, 3]}]}]}',
        "not three finite",
    ),
    "nan.json": ('{"markups": [{"controlPoints": [{"position": [1, NaN, 3]}]}]}', "finite"),
    "state.json": (
        '{"markups": [{"controlPoints": [{"positionStatus": "lost"}]}]}',
        "positionStatus",
    ),
    "short.fcsv": ("# CoordinateSystem = LPS\n1,2\n", "line 2: 2 entries"),
    "ijk.fcsv": ("# CoordinateSystem = 2\n", "line 1: .*neither"),
    "columns.fcsv": ("# columns = id,x,y\n", "line 1: there are no columns"),
    "half.fcsv": ("1,2,,4,0,0,0,1,1,1,0,a,,\n", "line 1: '' is not"),
    "plane.tps": ("LM=1\n1 2\n", "line 2: two coordinates"),
    "cut.tps": ("LM3=3\n1 2 3\n", "the file ends before the last of 3"),
    "many.tps": ("LM3=99999999999999\n", "line 1: .* from 0 to"),
    "negative.tps": ("LM3=-1\n", "line 1"),
    "stray.tps": ("LM3=1\n1 2 3\n4 5 6\n", "line 3: '4 5 6' is not of the form"),
    "first.tps": ("ID=a\nLM3=1\n1 2 3\n", "line 1: ID comes before"),
    "infinite.tps": ("LM3=1\n1 2 inf\n", "line 2: 'inf' is not"),
    "grouped.tps": ("LM3=1\n1 2 1_0\n", "line 2"),
    "scaled.tps": ("LM3=1\n1 2 3\nSCALE=0\n", "line 3: the scale is not greater than 0"),
    "mirrored.tps": ("LM3=1\n1 2 3\nSCALE=-2\n", "line 3: the scale is not greater than 0"),
    "twice.csv": ("label,x,y,z,X\na,1,2,3,4\n", "line 1: the column 'x' is named twice"),
    "labels.csv": ("label,l,p,s,label\na,1,2,3,b\n", "line 1: the column 'label' is named"),
    "twice.fcsv": ("# columns = x,y,z,x\n1,2,3,4\n", "line 1: the column 'x' is named twice"),
    "script.tps": ("LM3=1\n1 2 \u0663\n", "line 2: '\u0663' is not"),
    "script.csv": ("label,x,y,z\na,1,\uff12,3\n", "line 2: '\uff12' is not"),
    "script.fcsv": ("1,1,2,\u0663,0,0,0,1,1,1,0,a,,\n", "line 1: '\u0663' is not"),
    "script.txt": ("a\t1\t2\t3\t4\t5\t\u0666\n", "line 1: '\u0666' is not"),
    "ragged.txt": ("a\t1\t2\t3\t4\t5\n", "line 1: 5 coordinates"),
    "quoted.csv": ('label,x,y,z\n"a,1,2,3\n', "line 2"),
    "word.csv": ("label,x,y,z\na,1,two,3\n", "line 2: 'two' is not"),
    "decimal.csv": (
        "label,x,y,z\na,1,5,2,0,3,0\n",
        "line 2: 7 entries, but 4 columns; with decimal commas delimit columns by semicolons",
    ),
    "thousands.csv": ("label;x;y;z\na;1.234,5;2;3\n", "line 2: '1.234,5' is not a finite"),
    "fewer.csv": ("label,x,y,z\na,1,2\n", "line 2: 3 entries, but 4 columns"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refused_with_file_and_line(tmp_path: Path, name: str) -> None:
    text, message = REFUSED[name]
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ValueError, match=message) as refused:
        read_landmarks(path)
    assert str(refused.value).startswith(str(path))


def test_other_encodings_are_told(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(b"label,x,y,z\nFu\xdf,1,2,3\n")
    with pytest.raises(ValueError, match="line 2: the text is not UTF-8"):
        read_landmarks(path)


@pytest.mark.parametrize("ending", ["mrk.json", "fcsv", "csv", "tps", "txt"])
@settings(max_examples=50)
@given(content=st.one_of(st.text(), st.binary()))
def test_anything_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, ending: str, content: str | bytes
) -> None:
    path = tmp_path_factory.getbasetemp() / f"any.{ending}"
    path.write_bytes(content if isinstance(content, bytes) else content.encode(errors="replace"))
    with suppress(ValueError):
        assert any(len(one) for one in read_landmarks(path))


def test_what_a_format_has_no_place_for_is_not_written(tmp_path: Path) -> None:
    one = LandmarkSet.of([("a", (1.0, 2.0, 3.0))])
    two = LandmarkSet.of([("a", None), ("b", None)])
    for ending in ("mrk.json", "fcsv", "csv"):
        with pytest.raises(ValueError, match="one specimen, not 2"):
            write_landmarks(tmp_path / f"a.{ending}", [one, one])
    with pytest.raises(ValueError, match="1 to 2 landmarks"):
        write_landmarks(tmp_path / "a.txt", [one, two])


def test_sets_that_contradict_themselves_are_refused() -> None:
    with pytest.raises(ValueError, match="2 landmarks have positions"):
        LandmarkSet(("a", "b"), np.zeros((1, 3)))
    with pytest.raises(ValueError, match="'b' has a coordinate that is not finite"):
        LandmarkSet(("a", "b"), np.array([[np.nan] * 3, [1.0, np.nan, 2.0]]))
    with pytest.raises(ValueError, match="description for each"):
        LandmarkSet(("a",), np.zeros((1, 3)), descriptions=("x", "y"))
