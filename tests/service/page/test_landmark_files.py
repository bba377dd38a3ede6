"""Files of landmarks on the page: what the client writes it reads, and the other way round."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from isomatch import LandmarkSet, read_landmarks, write_landmarks
from playwright.sync_api import BrowserContext, Page

from tests.service.conftest import Api
from tests.service.page.conftest import SMALL, opened
from tests.service.page.test_modules import call

GIVEN = LandmarkSet.of(
    [
        ('nasion, "left"', (1.5, -2.25e-7, 1e12)),
        ("ß; <b>", None),
        ("inner  blanks", (0.1, 1 / 3, -7.0)),
    ],
    "specimen",
    ("confidence 0.93", "", 'said "twice", once'),
)
ENDINGS = ("mrk.json", "fcsv", "csv")

OTHERS = {
    "slicer.csv": "label,l,p,s,defined,selected\nF-1,1,2,3,1,1\nF-2,4,5,6,0,1\n",
    "decimals.csv": "label;x;y;z\na;1,5;,25;3,e1\nb;-1;2.5;3\n",
    "tied.csv": "a;1,5;2,5;3,5\n",
    "tabs.csv": "1,5\t2,5\t3,5\n",
    "bare.csv": "1;2;3\n\n4;5;6\n",
    "named.csv": "tip\t1\t2\t3\nNA row\tNA\tNA\tNA\n",
    "quoted.csv": 'name,x,y,z\n"a\nb",1,2,3\n',
    "r.csv": '"","x","y","z"\n"bregma",1,2,3\n"inion",4,5,6\n',
    "numbered.csv": ",x,y,z\n0,1,2,3\n1,4,5,6\n",
    "trailing.csv": "name,x,y,z,,\ntip,1,2,3,,\n",
    "one.csv": "specimen,label,x,y,z\na,tip,1,2,3\na,root,4,5,6\n",
    "old.fcsv": "# CoordinateSystem = 1\n# columns = id,x,y,z,label\n1,1,2,3,tip\n",
    "first.fcsv": "v,1,2,3,0,0,0,1,1,1,0,tip,remark,\n",
}
"""Files of other programs."""

WRONG = {
    "a.mrk.json": ("{", "not JSON"),
    "b.json": ('{"markups": [{"controlPoints": [{"position": [1, 2]}]}]}', "three numbers"),
    "c.json": ('{"points": []}', 'no list "markups"'),
    "d.json": ('{"markups": [{"coordinateSystem": "IJK"}]}', "neither LPS nor RAS"),
    "e.json": ('{"markups": [{"controlPoints": []}]}', "no landmarks"),
    "f.csv": ("label,x,y,z\na,1,2,x\n", 'line 2: "x" is not a finite number'),
    "g.csv": ('a,1,2,3\n"b,4,5,6\n', "quotation does not end"),
    "h.csv": ("label,x,y,z\na,1,2\n", "line 2: 3 entries for 4 columns"),
    "l.csv": ("label,x,y,z\na,1,5,2,5,3,5\n", "line 2: 7 entries for 4 columns; with decimal"),
    "m.csv": ("label;x;y;z\na;1.234,5;2;3\n", 'line 2: "1.234,5" is not a finite number'),
    "i.fcsv": ("# CoordinateSystem = voxels\n", "line 1: The coordinate system"),
    "j.tps": ("LM3=0\n", "ends with none of"),
    "n.csv": ("specimen,label,x,y,z\na,tip,1,2,3\nb,tip,4,5,6\n", 'several specimens, "a", "b"'),
    "k.csv": ("name,px,py,pz\ntip,1,2,3\n", "line 1: expected a header such as label,x,y,z"),
}


@pytest.fixture(scope="module")
def page(profile: BrowserContext, api: Api) -> Iterator[Page]:
    """One tab for all tests, which call functions and leave nothing."""
    with opened(profile, api.url, viewport=SMALL) as tab:
        yield tab


def by_page(page: Page, name: str, text: str, system: str) -> LandmarkSet:
    rows = call(page, "landmark_files", "return m.readLandmarks(...given)", [name, text, system])
    places = [(row["label"], row["position"]) for row in rows]
    return LandmarkSet.of(places, "", tuple(row["remark"] for row in rows))


def same(one: LandmarkSet, other: LandmarkSet) -> None:
    assert one.labels == other.labels
    np.testing.assert_array_equal(one.positions, other.positions)


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize(("written", "wanted"), [("LPS", "LPS"), ("RAS", "LPS"), ("RAS", "RAS")])
def test_the_page_reads_as_the_client_does(
    page: Page, tmp_path: Path, ending: str, written: Any, wanted: Any
) -> None:
    file = tmp_path / f"a.{ending}"
    write_landmarks(file, [GIVEN], written)
    (expected,) = read_landmarks(file, wanted)
    found = by_page(page, file.name, file.read_text(), wanted)
    same(found, expected)
    if ending != "csv":
        assert found.descriptions == expected.descriptions


@pytest.mark.parametrize("name", OTHERS)
def test_files_of_other_programs(page: Page, tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.write_text(OTHERS[name])
    for system in ("LPS", "RAS"):
        (expected,) = read_landmarks(file, system)
        same(by_page(page, name, OTHERS[name], system), expected)


def test_of_several_specimens_that_of_the_mesh_is_taken(page: Page) -> None:
    table = "specimen,label,x,y,z\na,tip,1,2,3\nb,tip,4,5,6\n"
    body = "return m.readLandmarks(...given)"
    (found,) = call(page, "landmark_files", body, ["all.csv", table, "LPS", "b.ply"])
    assert found == {"label": "tip", "position": [4, 5, 6], "remark": ""}


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("system", ["LPS", "RAS"])
def test_the_client_reads_what_the_page_writes(
    page: Page, tmp_path: Path, ending: str, system: Any
) -> None:
    places = GIVEN.positions.tolist()
    rows = zip(GIVEN.labels, places, GIVEN.present.tolist(), GIVEN.descriptions, strict=True)
    landmarks = [
        {"label": label, "position": place if there else None, "remark": remark}
        for label, place, there, remark in rows
    ]
    body = "return m.writeLandmarks(...given)"
    text = call(page, "landmark_files", body, [ending, "specimen", landmarks, system])
    file = tmp_path / f"a.{ending}"
    file.write_text(text)
    (found,) = read_landmarks(file, system)
    np.testing.assert_array_equal(found.positions, GIVEN.positions)
    if ending != "csv":
        assert found.descriptions == GIVEN.descriptions
    blanks = "inner blanks" if ending == "fcsv" else "inner  blanks"
    assert found.labels == (*GIVEN.labels[:2], blanks)


@pytest.mark.parametrize("name", WRONG)
def test_wrong_files_are_refused_with_the_reason(page: Page, name: str) -> None:
    text, reason = WRONG[name]
    body = """try { m.readLandmarks(...given); return null; }
        catch (error) { return [error.title, error.message]; }"""
    said = call(page, "landmark_files", body, [name, text, "LPS", "mesh.ply"])
    assert said is not None
    assert said[0] == "This file of landmarks cannot be read"
    assert reason in said[1]
