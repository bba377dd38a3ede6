"""Files of landmarks: what is written is read again, and files of other programs are read."""

import json
import math
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from isomatch import LandmarkSet, read_landmarks, write_landmarks

LABELLED, NUMBERED = ("mrk.json", "fcsv", "csv"), ("tps", "txt")

# A line of text without blanks around it, and without what would stand for "no name".
words = st.text(
    st.characters(blacklist_categories=("Cc", "Cs", "Zs", "Zl", "Zp", "Cf")), min_size=1
)
coordinates = st.floats(-1e12, 1e12)
places = st.one_of(st.none(), st.tuples(coordinates, coordinates, coordinates))


@st.composite
def landmark_sets(draw: st.DrawFn, count: int | None = None) -> LandmarkSet:
    size = draw(st.integers(1, 6)) if count is None else count
    rows = [(draw(words), draw(places)) for _ in range(size)]
    return LandmarkSet.of(rows, draw(words))


def returned(path: str, *specimens: LandmarkSet, system: Any = "LPS") -> tuple[LandmarkSet, ...]:
    with TemporaryDirectory() as folder:
        write_landmarks(Path(folder) / path, specimens, system)
        return read_landmarks(Path(folder) / path, system)


@pytest.mark.parametrize("ending", LABELLED)
@pytest.mark.parametrize("system", ["LPS", "RAS"])
@settings(max_examples=30)
@given(landmarks=landmark_sets())
def test_labels_and_places_are_read_as_written(
    ending: str, system: str, landmarks: LandmarkSet
) -> None:
    (found,) = returned(f"a.{ending}", landmarks, system=system)
    assert found.labels == landmarks.labels
    np.testing.assert_array_equal(found.positions, landmarks.positions)


@pytest.mark.parametrize("ending", NUMBERED)
@settings(max_examples=30)
@given(specimens=st.integers(1, 4).flatmap(lambda n: st.lists(landmark_sets(n), min_size=1)))
@example([LandmarkSet.of([("1", (1.0, 2.0, 3.0))], name) for name in ('"', '"a" b', "a, b;c")])
def test_specimens_are_read_as_written(ending: str, specimens: list[LandmarkSet]) -> None:
    found = returned(f"a.{ending}", *specimens)
    assert [one.name for one in found] == [one.name for one in specimens]
    for one, other in zip(found, specimens, strict=True):
        assert one.labels == tuple(str(place + 1) for place in range(len(other)))
        np.testing.assert_array_equal(one.positions, other.positions)


@settings(max_examples=30)
@given(landmarks=landmark_sets())
def test_slicer_files_are_converted_between_coordinate_systems(landmarks: LandmarkSet) -> None:
    for ending in ("mrk.json", "fcsv"):
        with TemporaryDirectory() as folder:
            file = Path(folder) / f"a.{ending}"
            write_landmarks(file, [landmarks], "RAS")
            (found,) = read_landmarks(file, "LPS")
        np.testing.assert_array_equal(found.positions, landmarks.positions * [-1.0, -1.0, 1.0])


def test_descriptions_are_kept(tmp_path: Path) -> None:
    given_set = LandmarkSet.of([("a", (1.0, 2.0, 3.0)), ("b", None)], "x", ("sure, very", ""))
    for ending in ("mrk.json", "fcsv"):
        assert returned(f"a.{ending}", given_set)[0].descriptions == ("sure, very", "")
    path = tmp_path / "a.mrk.json"
    write_landmarks(path, [given_set])
    points = json.loads(path.read_text())["markups"][0]["controlPoints"]
    assert [point["positionStatus"] for point in points] == ["defined", "missing"]


@pytest.mark.parametrize("ending", [*LABELLED, *NUMBERED])
@pytest.mark.parametrize("blank", ["", " "])
def test_a_missing_landmark_without_a_label_keeps_its_row(ending: str, blank: str) -> None:
    point = (1.0, 2.0, 3.0)
    unnamed = LandmarkSet.of([(blank, None), ("b", point), (blank, None), (blank, point)], blank)
    (found,) = returned(f"a.{ending}", unnamed)
    assert found.present.tolist() == [False, True, False, True]
    if ending == "csv":
        assert found.labels == ("1", "b", "3", "4")


def read(folder: Path, name: str, text: str, system: Any = "LPS") -> tuple[LandmarkSet, ...]:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return read_landmarks(path, system)


def test_documented_example_of_slicer_markups(tmp_path: Path) -> None:
    point = {"label": "F-1", "position": [-53.4, -73.3, 0.0]}
    placed = {"label": "F-2", "position": [49.9, -88.6, 1], "positionStatus": "undefined"}
    document = {
        "markups": [
            {"type": "Fiducial", "coordinateSystem": "LPS", "controlPoints": [point, placed]}
        ]
    }
    (found,) = read(tmp_path, "a.mrk.json", json.dumps(document))
    assert found.labels == ("F-1", "F-2")
    assert found.positions[0].tolist() == [-53.4, -73.3, 0.0]
    assert found.present.tolist() == [True, False]


def test_markups_without_a_label_are_numbered(tmp_path: Path) -> None:
    points = [{"label": None, "description": None, "position": [1, 2, 3]}, {"position": [4, 5, 6]}]
    document = {"markups": [{"type": "Fiducial", "controlPoints": points}]}
    (found,) = read(tmp_path, "a.mrk.json", json.dumps(document))
    assert found.labels == ("1", "2")
    assert found.descriptions == ("", "")


@pytest.mark.parametrize(("system", "sign"), [("LPS", 1.0), ("1", 1.0), ("RAS", -1.0), ("0", -1.0)])
def test_fiducials_of_slicer_versions(tmp_path: Path, system: str, sign: float) -> None:
    text = (
        f"# Markups fiducial file version = 4.13\n# CoordinateSystem = {system}\n"
        "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
        'vtkMRMLMarkupsFiducialNode_0,1,2,3,0,0,0,1,1,1,0,"tip, left",,vtkMRMLModelNode4\n'
        "2,4,5,6,0,0,0,1,1,1,0,b,,,2,0\n"
        "3,0,0,0,0,0,0,1,1,1,0,c,,,3,0\n"
    )
    (found,) = read(tmp_path, "a.fcsv", text)
    assert found.labels == ("tip, left", "b", "c")
    np.testing.assert_array_equal(
        found.positions[:2], [[sign, 2 * sign, 3], [4 * sign, 5 * sign, 6]]
    )
    assert found.present.tolist() == [True, True, False]
    (unnamed,) = read(tmp_path, "b.fcsv", "0,1,2,3,0,0,0,1,1,1,0,F-1,,\n")
    np.testing.assert_array_equal(unnamed.positions, [[-1, -2, 3]])


def test_tps_with_scale_curves_and_missing_landmarks(tmp_path: Path) -> None:
    text = (
        "LM3=3\n1 2 3\n-1 -1 -1\nNA NA NA\nCURVES=1\nPOINTS=2\n9 9 9\n8 8 8\n"
        "IMAGE=skull.jpg\nID=17\nSCALE=0.5\n\nlm3=1\n4\t5\t6\nIMAGE=other\n"
    )
    first, second = read(tmp_path, "a.TPS", text)
    assert (first.name, second.name) == ("17", "other")
    assert first.positions[0].tolist() == [0.5, 1.0, 1.5]
    assert first.present.tolist() == [True, False, False]
    assert second.positions.tolist() == [[4.0, 5.0, 6.0]]


@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_morphoj_with_and_without_names(tmp_path: Path, delimiter: str) -> None:
    rows = [["Homo sapiens f 025", "1", "2", "3", "4", "5", "6"], ["b"] + ["0"] * 3 + ["NA"] * 3]
    body = "\n".join(delimiter.join(row) for row in rows)
    names = delimiter.join(["ID", "x1", "y1", "z1", "x2", "y2", "z2"])
    for text in (body, f"{names}\n{body}"):
        for name in ("a.txt", "a.csv"):
            first, second = read(tmp_path, name, text)
            assert (first.name, second.name) == ("Homo sapiens f 025", "b")
            assert first.positions.tolist() == [[1, 2, 3], [4, 5, 6]]
            assert second.present.tolist() == [True, False]


@pytest.mark.parametrize("missing", ["NA", "", "nan"])
def test_morphoj_begins_with_a_specimen_without_landmarks(tmp_path: Path, missing: str) -> None:
    rows = [["a", *6 * [missing]], ["b", *"123456"]]
    names = ["ID", "x1", "y1", "z1", "x2", "y2", "z2"]
    for lines in (rows, [names, *rows]):
        text = "".join("\t".join(row) + "\n" for row in lines)
        first, second = read(tmp_path, "a.txt", text)
        assert (first.name, first.present.tolist()) == ("a", [False, False])
        assert second.positions.tolist() == [[1, 2, 3], [4, 5, 6]]


def test_tables_of_points(tmp_path: Path) -> None:
    expected = [[1.0, 2.0, 3.0], [math.nan] * 3]
    for text in (
        "label,x,y,z\na,1,2,3\nb,,,\n",
        "a;1;2;3\nb;NA;NA;NA\n",
        "z\tname\ty\tx\n3\ta\t2\t1\n\tb\t\t\n",
        "label,l,p,s,defined,selected\na,1,2,3,1,1\nb,0,0,0,0,1\n",
        "label,r,a,s\na,-1,-2,3\nb,,,\n",
    ):
        (found,) = read(tmp_path, "a.csv", text)
        assert found.labels == ("a", "b")
        np.testing.assert_array_equal(found.positions, expected)
    decimals = [[1.5, -0.25, 3.0], [4.0, 5.5, 6.0]]
    for name, text in (
        ("a.csv", "label;x;y;z\na;1,5;-,25;3\nb;4,0;5.5;6\n"),
        ("a.csv", "a;1,5;-0,25;3,0\nb;4;5,5;6\n"),
        ("a.csv", "1,5;-0,25;3,0\n4,0;5,5;6,0\n"),
        ("a.csv", 'label,x,y,z\na,"1,5","-0,25",3\nb,4,"5,5",6\n'),
        ("a.txt", "one\t1,5\t-0,25\t3,0\t4,0\t5,5\t6,0\n"),
        ("a.tps", "LM3=2\n1,5 -0,25 3\n4 5,5 6\n"),
    ):
        (found,) = read(tmp_path, name, text)
        np.testing.assert_array_equal(found.positions, decimals)
    (numbered,) = read(tmp_path, "a.csv", "1,2,3\n4,5,6\n")
    assert numbered.labels == ("1", "2")


@pytest.mark.parametrize("separator", ["\x0b", "\x0c", "\x1e", "\x85", "\u2028", "\r", "\n"])
def test_separators_within_labels_end_no_row_of_a_table(separator: str) -> None:
    label = f"tip{separator}left"
    (found,) = returned("a.csv", LandmarkSet.of([(label, (1.0, 2.0, 3.0)), ("b", None)]))
    assert found.labels == (label, "b")


@pytest.mark.parametrize("separator", ["\x0b", "\x0c", "\x1e", "\x85", "\u2028"])
def test_separators_within_names_and_remarks_end_no_line(tmp_path: Path, separator: str) -> None:
    """Word processors write them, and str.splitlines ends lines there."""
    remark = tmp_path / "a.fcsv"
    remark.write_text(f"1,1,2,3,0,0,0,1,1,1,0,a,left{separator}side,\n", encoding="utf-8")
    (found,) = read_landmarks(remark, "RAS")
    assert found.descriptions == (f"left{separator}side",)
    name = tmp_path / "a.tps"
    name.write_text(f"LM3=1\n1 2 3\nID=skull{separator}7\n", encoding="utf-8")
    (found,) = read_landmarks(name)
    assert found.name == f"skull{separator}7"


def test_names_of_rows_without_a_heading_are_labels(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    for text, labels in (
        ('"","x","y","z"\n"bregma",1,2,3\n"inion",NA,NA,NA\n', ("bregma", "inion")),
        ('"","x","y","z"\n"3",1,2,3\n"7",4,5,6\n', ("1", "2")),
        (",label,x,y,z\n0,tip,1,2,3\n", ("tip",)),
        ("label,x,y,z,,\ntip,1,2,3,,\n", ("tip",)),
    ):
        path.write_text(text)
        (found,) = read_landmarks(path)
        assert found.labels == labels


def test_a_table_with_a_column_of_specimens_has_a_set_for_each(tmp_path: Path) -> None:
    path = tmp_path / "landmarks.csv"
    path.write_text(
        "specimen,label,x,y,z,confidence\nb,tip,1,2,3,0.9\na,tip,4,5,6,0.8\nb,,,,,\na,end,7,8,9,\n"
    )
    first, second = read_landmarks(path)
    assert (first.name, first.labels, first.present.tolist()) == ("b", ("tip", "2"), [True, False])
    assert (second.name, second.labels) == ("a", ("tip", "end"))
    np.testing.assert_array_equal(second.positions, [[4, 5, 6], [7, 8, 9]])
