"""The page's modules, called in the browser: geometry, simplification, views and colours."""

import base64
import gzip
import io
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from playwright.sync_api import BrowserContext, Page
from scipy.spatial.transform import Rotation

from broker.contracts import LIKELY_RIGHT
from solver.mesh import surface_tree, triangle_mesh
from tests.client._models.test_schema import OPENAPI
from tests.client.shapes import CLASSES
from tests.service.conftest import Api
from tests.service.page.conftest import PATIENCE, SMALL, opened
from tests.worker.figures import blob
from worker.pictures import View, packed_geometry, target_view
from worker.pictures.coloring import point_colors
from worker.pictures.heat_map import digits, scale_end


@pytest.fixture(scope="module")
def page(profile: BrowserContext, api: Api) -> Iterator[Page]:
    """One tab for all tests, which call functions and leave nothing."""
    with opened(profile, api.url, viewport=SMALL) as tab:
        yield tab


def call(page: Page, module: str, body: str, given: Any) -> Any:
    """Evaluate the body of a function, in which `m` is a module of the page."""
    if page.url == "about:blank":
        page.goto("/#/nowhere")
    script = f"async (given) => {{ const m = await import('/page/{module}.js'); {body} }}"
    return page.evaluate(script, given)


def flat(array: npt.NDArray[Any]) -> list[float]:
    return [float(value) for value in array.ravel()]


@pytest.mark.parametrize("colored", [False, True])
def test_geometries_are_read(page: Page, colored: bool) -> None:
    vertices, faces = blob(2, seed=5)
    colors = np.random.default_rng(2).random((len(vertices), 3)) if colored else None
    # What of colours is read does not depend on what is a cloud.
    mesh = replace(triangle_mesh(vertices, faces, colors), is_cloud=colored)
    data = base64.b64encode(gzip.decompress(packed_geometry(mesh))).decode()
    body = """
        const bytes = Uint8Array.from(atob(given), (letter) => letter.charCodeAt(0));
        const read = m.readGeometry(bytes.buffer);
        const entries = Object.entries(read);
        return Object.fromEntries(entries.map(([k, v]) => [k, v?.length ? [...v] : v]));
    """
    read = call(page, "geometry", body, data)
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    scale = 0.5 * np.ptp(vertices, axis=0).max()
    assert read["scale"] == pytest.approx(scale)
    np.testing.assert_allclose(read["origin"], middle, atol=1e-12)
    seen = (vertices - middle) / scale
    np.testing.assert_allclose(read["positions"], seen.ravel(), atol=1e-7)
    np.testing.assert_array_equal(read["faces"], mesh.faces.ravel())
    assert read["cloud"] is mesh.is_cloud
    np.testing.assert_array_equal(read["numbers"], mesh.vertex_ids)
    assert (read["colors"] is None) is not colored
    if mesh.colors is not None:
        np.testing.assert_array_equal(read["colors"], np.rint(255 * mesh.colors).ravel())


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_arrays_are_read(page: Page, save: Callable[..., None]) -> None:
    rng = np.random.default_rng(4)
    given: dict[str, npt.NDArray[Any]] = {
        "positions": rng.standard_normal((3, 4, 2)),
        "single": rng.standard_normal((5, 2)).astype(np.float32),
        "images": np.array([7, -1, 2**31 - 1]),
        "columns": np.asfortranarray(rng.integers(-9, 9, (4, 3, 2), dtype=np.int32)),
        "none": np.zeros((0, 4, 3)),
        "bytes": np.array([b"a", b"b"]),
    }
    stream = io.BytesIO()
    save(stream, **given)
    body = """
        const bytes = Uint8Array.from(atob(given), (letter) => letter.charCodeAt(0));
        const array = m.openNpz(bytes.buffer);
        const read = async (name) => {
          const { shape, data } = await array(name);
          return [shape, [...data]];
        };
        const names = ["positions", "single", "images", "columns", "none"];
        const refused = await read("bytes").then(() => "", (error) => error.message);
        return [await Promise.all(names.map(read)), await array("missing"), refused];
    """
    found, missing, refused = call(page, "npz", body, base64.b64encode(stream.getvalue()).decode())
    for (shape, data), expected in zip(found, list(given.values())[:5], strict=True):
        assert tuple(shape) == expected.shape
        assert data == expected.ravel().tolist()
    assert missing is None
    assert "|S1" in refused
    other = "try { m.openNpz(new ArrayBuffer(100)) } catch (error) { return error.message }"
    assert "not an NPZ file" in call(page, "npz", other, None)


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (["a.off", "b.off"], ["a.off", "b.off"]),
        (["same words, left 01.off", "same words, left 02.off"], ["…01.off", "…02.off"]),
        (["x" * 30, "a"], ["x" * 17 + "…", "a"]),
        (["x" * 30, "x" * 30], ["x" * 17 + "…"] * 2),
        (["🐎" * 30, "🦴"], ["🐎" * 17 + "…", "🦴"]),
        (["🐎 🐎 a" + "b" * 20, "🐎 🐎 🦴"], ["…a" + "b" * 15 + "…", "🐎 🐎 🦴"]),
    ],
)
def test_long_names_are_told_apart(page: Page, names: list[str], expected: list[str]) -> None:
    assert call(page, "heat_map", "return m.shortened(given)", names) == expected


def test_scales_are_those_of_pictures(page: Page) -> None:
    for shapes in (3, 10, 11, 14):
        matrix = np.random.default_rng(shapes).random((shapes, shapes))
        pairs = matrix[np.triu_indices(shapes, 1)]
        end = scale_end(pairs)
        assert call(page, "heat_map", "return m.scaleEnd(given)", matrix.tolist()) == {
            "most": end,
            "clipped": bool(pairs.max() > end),
        }
    nothing = [[None, None], [None, None]]
    empty = {"most": 1, "clipped": False}
    assert call(page, "heat_map", "return m.scaleEnd(given)", nothing) == empty


@pytest.mark.parametrize(
    ("probability", "badge"),
    [
        (0.01, "doubt"),
        (0.499, "doubt"),
        (0.5, "doubt"),
        (0.501, "fair"),
        (0.899, "fair"),
        (0.9, "good"),
        (1.0, "good"),
    ],
)
def test_confidence_has_three_colours(page: Page, probability: float, badge: str) -> None:
    body = """
        const confidence = { probability: given, reasons: ["low; give `points`, or `a"] };
        const note = m.confidenceNote({ confidence });
        const code = [...note.querySelectorAll("li code")].map((node) => node.textContent);
        return [m.inDoubt(given), note.querySelector(".badge").className, code, note.textContent];
    """
    doubtful, found, code, text = call(page, "confidence", body, probability)
    assert doubtful == (probability <= LIKELY_RIGHT) == (badge == "doubt")
    assert found == f"badge {badge}"
    assert ("in doubt" in text) is (badge == "doubt")
    assert code == ["points"]
    assert text.endswith("low; give points, or `a")


def test_reasons_for_doubt_are_opened_in_tables(page: Page) -> None:
    """Titles are for mice alone."""
    body = """
        return given.map((reasons) => {
          const badge = m.confidenceBadge({ confidence: { probability: 0.6, reasons } });
          const said = [...badge.querySelectorAll("summary, li")].map((node) => node.textContent);
          return [badge.tagName, badge.outerHTML.includes("title="), ...said];
        });
    """
    assert call(page, "confidence", body, [[], ["low", "far"]]) == [
        ["SPAN", False],
        ["DETAILS", False, "confidence 60 %, reasons for doubt", "low", "far"],
    ]


def test_points_have_the_colours_of_pictures(page: Page) -> None:
    tall = np.random.default_rng(9).normal(size=(40, 3)) * [0.3, 1.0, 2.0]
    for points in (tall, tall * [1.0, 0.0, 1.0], tall[:1]):
        found = call(page, "colors", "return m.pointColors(given)", points.tolist())
        np.testing.assert_allclose(found, 255.0 * point_colors(points), atol=0.5 + 1e-6)


def test_own_colours_are_pale_behind_names(page: Page) -> None:
    body = """const colors = Uint8Array.from(given);
        return [true, false].map((named) => Array.from(m.behindNames(colors, named)))"""
    behind, alone = call(page, "colors", body, [0, 120, 255])
    assert alone == [0, 120, 255]
    assert behind == sorted(behind)
    # Names are dark: the darkest of the colours is not.
    assert 160 < behind[0] < behind[2] < 255
    assert call(page, "colors", "return m.behindNames(given, true)", None) is None


def test_numbers_of_heat_maps_are_those_of_pictures(page: Page) -> None:
    values = [0.0, 1e-5, 0.00098, 0.0123, 0.5, 1.0, 9.96, 123.4, 99999.0, 1.26e7]
    for significant in (2, 3):
        body = f"return given.map((value) => m.digits(value, {significant}))"
        written = [digits(value, significant) for value in values]
        assert call(page, "format", body, values) == written


def test_one_of_many_shapes_is_found_in_their_table(page: Page) -> None:
    body = """
        const names = Array.from({ length: given }, (_, i) => `Shape ${i}`);
        const result = {
          shapes: names, labels: null, nearest: names.map((_, i) => [(i + 1) % given]),
          matrix: names.map((_, i) => names.map((_, j) => Math.abs(i - j))),
        };
        const nodes = [m.neighbours(result, names, () => {})].flat();
        document.querySelector("main").replaceChildren(...nodes);
        const field = document.querySelector("#find");
        if (field === null) return null;
        field.value = " shape 2";
        field.dispatchEvent(new Event("input"));
        const table = document.querySelector("table");
        const found = table.querySelectorAll("tbody tr:not([hidden])").length;
        return [table.parentElement.tabIndex, found];
    """
    assert call(page, "collection", body, 20) is None
    # Shapes 2, and 20 to 29; the table is scrolled by keyboard.
    assert call(page, "collection", body, 100) == [0, 11]


def test_the_focus_is_kept(page: Page) -> None:
    body = """
        const area = document.createElement("div");
        area.tabIndex = -1;
        area.id = "area";
        document.body.append(area);
        const draw = (names) => area.replaceChildren(...names.map((name) => {
          const button = document.createElement("button");
          button.textContent = name;
          return button;
        }));
        const found = given.map(([before, at, after]) => {
          draw(before);
          area.children[at].focus();
          m.keepFocus(area, () => draw(after));
          return document.activeElement.id || document.activeElement.textContent;
        });
        draw(["a", "b"]);
        area.children[0].focus();
        m.keepFocus(area, () => { area.children[0].hidden = true; });
        found.push(document.activeElement.textContent);
        m.keepFocus(area.children[0], () => draw([]));
        found.push(document.activeElement === document.body);
        area.remove();
        return found;
    """
    drawn: list[tuple[list[str], int, list[str]]] = [
        (["a", "b", "c"], 1, ["c", "b", "a"]),
        (["a", "b", "c"], 1, ["a", "c", "d"]),
        (["a", "b", "c"], 2, ["a", "b"]),
        (["a"], 0, []),
    ]
    # What is called the same, what is at its place, what is last, the area, and what is not hidden;
    # what has no focus in it gives none.
    assert call(page, "focus", body, drawn) == ["b", "c", "b", "area", "b", True]


def test_only_what_is_all_is_a_hundred_percent(page: Page) -> None:
    given = [1.0, 0.999999, 0.9999, 0.996, 0.9949, 0.25, 0.0999, 0.00001, 0.0]
    expected = ["100", "more than 99.99", "99.99", "99.60", "99", "25", "9.99", "less than 0.01"]
    found = call(page, "format", "return given.map(m.percent)", given)
    assert found == [f"{text} %" for text in [*expected, "0.00"]]


@pytest.mark.parametrize("lack", ["room", "leave", None])
def test_a_tab_that_may_keep_nothing_works_until_it_is_loaded_again(
    page: Page, lack: str | None
) -> None:
    body = """
        const allowed = Object.getOwnPropertyDescriptor(window, 'sessionStorage');
        const { setItem } = Storage.prototype;
        const refuse = () => { throw new DOMException('no', 'QuotaExceededError'); };
        m.keep('one', 'before');
        if (given === 'room') Storage.prototype.setItem = refuse;
        const forbidden = { ...allowed, get: refuse };
        if (given === 'leave') Object.defineProperty(window, 'sessionStorage', forbidden);
        const found = [m.keep('one', 'now'), m.kept('one'), m.kept('two')];
        const { key } = await import('/page/api_key.js');
        found.push(key());
        m.drop('one');
        found.push(m.kept('one'));
        Storage.prototype.setItem = setItem;
        Object.defineProperty(window, 'sessionStorage', allowed);
        found.push(m.keep('one', 'again'), m.kept('one'), sessionStorage.getItem('one'));
        m.drop('one');
        return found;
    """
    found = call(page, "tab_storage", body, lack)
    assert found == [lack is None, "now", None, None, None, True, "again", "again"]


def test_tables_that_are_replaced_follow_no_selection(page: Page) -> None:
    body = """
        const { Selection } = await import('/page/selection.js');
        const { landmarkTable } = await import('/page/landmark_table.js');
        const { Corrections } = await import('/page/corrections.js');
        const [selection, replaced] = [new Selection(), new AbortController()];
        const marks = [{ label: 'one', lack: '', confidence: null }];
        const corrections = new Corrections([{}]);
        const tables = [
          m.pairTable([{ source: 1, target: 2, cost: 3 }], null, selection, false, replaced.signal),
          landmarkTable(marks, corrections, selection, () => {}, replaced.signal),
        ];
        const shown = () => tables.map((table) => table.querySelectorAll('.shown').length);
        selection.choose(0);
        const before = shown();
        replaced.abort();
        selection.clear();
        return [before, shown()];
    """
    assert call(page, "pair_table", body, None) == [[1, 1], [1, 1]]


def test_drawings_do_not_end_one_another(page: Page) -> None:
    """Browsers end the oldest of many WebGL contexts, of which each question would make one."""
    body = """
        const { getContext } = HTMLCanvasElement.prototype;
        m.canDraw();
        let made = 0;
        HTMLCanvasElement.prototype.getContext = () => { made += 1; return null; };
        const answers = [m.canDraw(), m.canDraw()];
        HTMLCanvasElement.prototype.getContext = getContext;
        return [answers, made];
    """
    assert call(page, "plotly", body, None) == [[True, True], 0]


def test_names_are_searched_for_once(page: Page) -> None:
    """Those of a request are not, but where it gave none."""
    body = """
        const answer = window.fetch;
        const asked = [];
        const partial = { pairs: 1, pairs_done: 1, labels: null, matrix: [[0, 1], [1, 0]] };
        window.fetch = async (path) => {
          asked.push(path);
          const named = { ...partial, shapes: ['c', 'third-id'], names: given };
          return Response.json(path === 'named' ? named : { items: [], next_cursor: 'more' });
        };
        const { signal } = new AbortController();
        const found = [];
        for (const pages of [1, 1, 3, 3]) {
          await m.namesOf(['first-id-of-none', 'second-id-of-none'], signal, pages);
          found.push(asked.splice(0).length);
        }
        const { collectionProgress } = await import('/page/collection.js');
        const node = document.createElement('div');
        document.querySelector('main').append(node);
        await collectionProgress(node, 'named', signal);
        window.fetch = answer;
        const ticks = [...node.querySelectorAll('.xtick text')].map((one) => one.textContent);
        node.remove();
        return [found, asked, ticks];
    """
    searched, asked, ticks = call(page, "names", body, ["one.off", None])
    assert searched == [1, 0, 3, 0]
    assert [path.partition("?")[0] for path in asked] == ["named", *10 * ["/v1/shapes"]]
    assert ticks == ["one.off", "third-id"]


def test_what_fails_is_said_until_the_next_try(page: Page) -> None:
    """By buttons, boxes, and what nobody waits for; what was left is no failure."""
    body = """
        const { toggle } = await import('/page/match_scenes.js');
        const { Problem } = await import('/page/api.js');
        const place = document.createElement('div');
        document.querySelector('main').append(place);
        const errors = ['lost', 'busy', 'AbortError', null];
        const fail = async () => {
          const text = errors.shift();
          if (text === 'AbortError') throw new DOMException('left', text);
          if (text) throw new Problem(503, { title: 'Busy', detail: text });
        };
        const said = async (act) => {
          act();
          await new Promise((resolve) => setTimeout(resolve, 20));
          return [...document.querySelectorAll('[role=alert] p')].map((one) => one.textContent);
        };
        const found = [];
        for (const control of [m.button('Act', fail), toggle('Act', { on: true }, 'on', fail)]) {
          place.replaceChildren(control);
          for (let i = 0; i < 4; i++) found.push(await said(() => control.click()));
          errors.push('lost', 'busy', 'AbortError', null);
        }
        for (const text of ['first', 'second']) {
          found.push(await said(() => { Promise.reject(new Problem(0, { detail: text })); }));
        }
        found.push(await said(() => { Promise.reject(new DOMException('left', 'AbortError')); }));
        place.remove();
        document.querySelector('[role=alert]').remove();
        return found;
    """
    tries = [["lost"], ["busy"], [], []]
    expected = [*tries, *tries, ["first"], ["second"], ["second"]]
    assert call(page, "actions", body, None) == expected


def test_what_is_deleted_leads_back_only_from_its_own_view(page: Page) -> None:
    body = """
        const answer = window.fetch;
        window.fetch = async () => new Response(null, { status: 204 });
        const reached = [];
        for (const left of [true, false]) {
          const leaving = new AbortController();
          const node = m.deleteButton('/v1/shapes/none', 'a.off', 'It is lost.', leaving.signal);
          document.querySelector('main').append(node);
          node.click();
          document.querySelector('dialog button').click();
          if (left) leaving.abort();
          await new Promise((resolve) => setTimeout(resolve, 50));
          reached.push(location.hash);
          node.remove();
        }
        window.fetch = answer;
        location.hash = '#/nowhere';
        return reached;
    """
    assert call(page, "deletion", body, None) == ["#/nowhere", "#/"]


SPECIMENS = """
    const answer = window.fetch;
    const [template, asked] = [{ coordinates: 'LPS', given: [] }, []];
    const refused = (status, detail) => new Response(JSON.stringify({ detail }), { status });
    window.fetch = () => new Promise((resolve) => { asked.push(resolve); });
    const soon = () => new Promise((resolve) => later(resolve, 20));
    const later = window.setTimeout;
    const match = { state: 'succeeded', job: 'one', target: 'none', target_name: 'a.off' };
    const leaving = new AbortController();
    const all = new m.Specimens({ job: given, matches: [match] }, leaving.signal);
    const over = (found) => {
      leaving.abort();
      sessionStorage.clear();
      window.fetch = answer;
      window.setTimeout = later;
      return found;
    };
"""
"""A batch with one specimen, whose requests `asked` are answered by the test."""


def test_specimens_are_tried_again_after_a_passing_problem(page: Page) -> None:
    body = f"""{SPECIMENS}
        const begun = all.begin({{ ...template, file: 'a.csv' }});
        window.setTimeout = (action, time) => later(action, time === 4000 ? 10 : time);
        const found = [];
        for (const [status, text] of [[404, ""], [429, "busy"], [503, "away"], [404, "gone"]]) {{
          asked.shift()(refused(status, text));
          await soon();
          found.push([all.pause?.message, all.all[0].problem?.message]);
        }}
        await begun;
        return over(found.slice(1));
    """
    expected = [["busy", None], ["away", None], [None, "gone"]]
    assert call(page, "specimens", body, "batch-busy") == expected


def test_the_landmarks_that_were_chosen_last_are_carried(page: Page) -> None:
    body = f"""{SPECIMENS}
        const older = all.begin({{ ...template, file: 'older.csv' }});
        const newer = all.begin({{ ...template, file: 'newer.csv' }});
        asked[1](refused(404, 'gone'));
        await newer;
        asked[0](refused(404, 'gone'));
        await older;
        return over(all.template.file);
    """
    assert call(page, "specimens", body, "batch-late") == "newer.csv"


def test_shapes_are_simplified_only_if_that_is_chosen(page: Page) -> None:
    body = """
        const shapes = given.map((vertices, at) => ({ id: `s${at}`, name: `s${at}.off`, vertices,
          faces: 2 * vertices, file_vertices: vertices, components: 1, has_colors: false }));
        const known = { metrics: [], descriptors: [] };
        return ["match", "compare", "batch", "learn"].map((name) => {
          const form = document.createElement("form");
          form.append(...m.fieldsOf(m.TASKS[name], known, shapes, new AbortController().signal));
          return [...form.querySelectorAll("[name=simplify]")].map((field) =>
            [field.type, field.checked]);
        });
    """
    assert call(page, "tasks", body, [60000, 5000]) == [[["checkbox", False]]] * 4
    assert call(page, "tasks", body, [20000, 5000]) == [[["number", False]]] * 4


def test_classes_are_those_of_the_command(page: Page) -> None:
    found = call(page, "tasks", "return given.map(m.classOf)", [*CLASSES])
    assert found == [*CLASSES.values()]


def test_tasks_have_the_limits_of_the_api(page: Page) -> None:
    body = "return Object.values(m.TASKS).map(({ path, most }) => [path, most ?? null])"
    schemas = OPENAPI["components"]["schemas"]
    for path, most in call(page, "tasks", body, None):
        content = OPENAPI["paths"][path]["post"]["requestBody"]["content"]
        reference = content["application/json"]["schema"]["$ref"]
        fields = schemas[reference.rpartition("/")[2]]["properties"]
        listed = fields.get("shapes") or fields.get("targets")
        if most is not None:
            first = "targets" in fields or "template" in fields
            assert most == listed["maxItems"] + first


def test_tasks_for_fewer_shapes_cannot_be_chosen(page: Page) -> None:
    body = """
        const shapes = Array.from({ length: given }, (_, at) => ({ id: `s${at}`, name: `s${at}.off`,
          vertices: 9, faces: 9, components: 1, has_colors: false }));
        const form = m.jobForm(shapes, { task: "map" }, { files: 0 }, new AbortController().signal);
        const task = form.querySelector("[value=map]");
        return [task.disabled, task.checked, task.parentElement.textContent];
    """
    for count in (8, 16, 17):
        disabled, checked, text = call(page, "job_form", body, count)
        assert disabled is (count == 17)
        assert checked is not disabled
        assert ("at most 16 shapes" in text) is (count > 8)


def test_large_meshes_are_simplified(page: Page) -> None:
    # A sphere of 200,000 vertices on circles of latitude.
    body = """
        const [rows, columns] = [400, 500];
        const [positions, faces] = [[], []];
        for (let i = 0; i < rows; i++) for (let j = 0; j < columns; j++) {
          const [a, b] = [Math.PI * (i + 0.5) / rows, 2 * Math.PI * j / columns];
          positions.push(Math.sin(a) * Math.cos(b), Math.cos(a), Math.sin(a) * Math.sin(b));
          if (i + 1 === rows) continue;
          const [p, q] = [i * columns + j, i * columns + (j + 1) % columns];
          faces.push(p, q, p + columns, q, q + columns, p + columns);
        }
        const whole = { positions: Float32Array.from(positions), faces: Uint32Array.from(faces),
          colors: new Uint8Array(positions.length).fill(7) };
        const start = performance.now();
        const coarse = m.simplified(whole);
        const radii = Array.from({ length: coarse.positions.length / 3 },
          (_, v) => Math.hypot(...coarse.positions.subarray(3 * v, 3 * v + 3)));
        const small = { ...whole, faces: whole.faces.subarray(0, 3000) };
        const [least, greatest] = [Math.min(...radii), Math.max(...radii)];
        return { seconds: (performance.now() - start) / 1000, most: m.MOST, least, greatest,
          share: coarse.share, count: coarse.faces.length / 3, vertices: radii.length,
          highest: coarse.faces.reduce((a, b) => Math.max(a, b)),
          colors: [...new Set(coarse.colors)],
          left: [0, 999, 77777].map((v) => Math.hypot(...[0, 1, 2].map((k) =>
            whole.positions[3 * v + k] - coarse.positions[3 * coarse.left(v) + k]))),
          reduced: coarse.reduced(whole.positions).every((x, at) => x === coarse.positions[at]),
          same: m.simplified(small).positions === whole.positions };
    """
    coarse = call(page, "vertex_clustering", body, None)
    assert 0.5 * coarse["most"] < coarse["count"] <= coarse["most"]
    assert coarse["share"] == pytest.approx(coarse["count"] / (2 * 399 * 500))
    assert coarse["highest"] < coarse["vertices"]
    assert 0.98 < coarse["least"] <= coarse["greatest"] < 1.0001
    assert coarse["colors"] == [7]
    assert coarse["reduced"]
    # A cell of the grid is about 1/50 wide.
    assert max(coarse["left"]) < 0.05
    assert coarse["same"]
    assert coarse["seconds"] < PATIENCE / 1000


@pytest.mark.parametrize("thinness", [1.0, 0.1, 0.01])
def test_a_target_is_turned_as_the_source_stands(page: Page, thinness: float) -> None:
    rng = np.random.default_rng(3)
    here = rng.standard_normal((12, 3)) * [thinness, 1.0, thinness]
    # About the vertical, and lying: its file has another axis up.
    for axis in ([0.0, 1.1, 0.0], [1.4, 0.5, -0.6]):
        there = here @ Rotation.from_rotvec(axis).as_matrix().T + 0.2
        given = [np.eye(3).tolist(), here.tolist(), there.tolist()]
        rows = np.array(call(page, "view", "return m.targetView(...given)", given))
        seen = (there - there.mean(axis=0)) @ rows.T
        np.testing.assert_allclose(seen, here - here.mean(axis=0), atol=1e-6)


def test_a_thin_target_is_turned_as_in_pictures(page: Page) -> None:
    """Eigenvalues of the rotation about the long axis are close."""
    rng = np.random.default_rng(5)
    given = []
    for _ in range(60):
        here = rng.standard_normal((12, 3)) * [0.05, 1.0, 0.05]
        turned = here @ Rotation.random(random_state=rng).as_matrix().T
        given.append([here.tolist(), (turned + 0.02 * rng.standard_normal((12, 3))).tolist()])
    body = "return given[1].map((both) => m.targetView(given[0], ...both))"
    found = call(page, "view", body, [np.eye(3).tolist(), given])
    for rows, (here, there) in zip(found, given, strict=True):
        expected = target_view(View(np.eye(3)), np.array(here), np.array(there)).axes
        np.testing.assert_allclose(np.array(rows), expected, atol=1e-4)


def test_colours_are_transferred_by_a_dense_map(page: Page) -> None:
    body = """
        const side = (numbers) => ({ mesh: { left: (v) => v, reduced: (values) => values },
          geometry: { positions: new Float32Array(3 * numbers.length) },
          place: (number) => (numbers.includes(number) ? numbers.indexOf(number) : undefined) });
        const [source, target] = [side([5, 6, 7, 8]), side([0, 2, 4])];
        const dense = { source: [5, 6, 8], target: [4, 0, 4] };
        return [...m.transferredColors([source, target], dense, [1, 2, 3, 4, 5, 6, 7, 8, 9])];
    """
    transferred = call(page, "colors", body, None)
    assert transferred == [7, 8, 9, 1, 2, 3, 200, 200, 200, 7, 8, 9]


def test_a_surface_has_the_colours_of_its_points(page: Page) -> None:
    vertices, faces = blob(3)
    points = vertices[[0, 40, 300]]
    colors = [[255, 0, 0], [0, 255, 0], [0, 0, 255]]
    body = "return [...m.surfaceColors(given[0], given[1], given[2])]"
    mesh = {"positions": flat(vertices), "faces": [int(v) for v in faces.ravel()]}
    shades = np.array(call(page, "colors", body, [mesh, points.tolist(), colors])).reshape(-1, 3)
    # Half of the colour, half of a light grey; smooth between the points.
    expected = 0.5 * np.array(colors) + 0.5 * 235
    np.testing.assert_allclose(shades[[0, 40, 300]], expected)
    assert shades.min() >= 0.5 * 235 - 1e-9
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    steps = np.abs(shades[edges[:, 0]] - shades[edges[:, 1]]).max(axis=1)
    assert np.median(steps) < 10.0


def test_nearest_points_are_those_of_the_solver(page: Page) -> None:
    vertices, faces = blob(2, seed=3)
    rng = np.random.default_rng(4)
    # Above triangles, beyond edges and corners, and far away.
    positions = np.concatenate(
        [3.0 * rng.standard_normal((20, 3)), vertices[:5], 1.4 * vertices[:5]]
    )
    body = """const [mesh, positions] = given;
        return positions.map((p) => m.positionOf(mesh.positions, m.nearestPoint(mesh, p)))"""
    mesh = {"positions": flat(vertices), "faces": [int(v) for v in faces.ravel()]}
    found = np.array(call(page, "surface_point", body, [mesh, positions.tolist()]))
    triangles, weights = surface_tree(vertices, faces).nearest(positions)
    expected = np.einsum("nc,ncd->nd", weights, vertices[faces[triangles]])
    distances = np.linalg.norm(expected - positions, axis=1)
    np.testing.assert_allclose(np.linalg.norm(found - positions, axis=1), distances, atol=1e-12)
    np.testing.assert_allclose(found, expected, atol=1e-7)


def test_points_of_a_thin_plate_stay_on_their_side(page: Page) -> None:
    # Two parallel triangles, 0.01 apart, whose normals point away from one another.
    positions = [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, -0.01, 1, 0, -0.01, 0, 1, -0.01]
    mesh = {"positions": positions, "faces": [0, 1, 2, 3, 5, 4]}
    body = "return m.nearestPoint(given, [0.2, 0.3, -0.009], [0, 0, 1])"
    found = call(page, "surface_point", body, mesh)
    assert found["corners"] == [0, 1, 2]
    np.testing.assert_allclose(found["weights"], [0.5, 0.2, 0.3], atol=1e-12)


def test_the_seen_point_is_the_first_of_the_line_of_sight(page: Page) -> None:
    vertices, faces = blob(3, seed=3)
    mesh = {"positions": flat(vertices), "faces": [int(v) for v in faces.ravel()]}
    middle, rng = vertices.mean(axis=0), np.random.default_rng(6)
    body = """const [mesh, sights] = given;
        return sights.map((sight) => m.seenPoint(mesh, sight));"""
    corners, barycentric = faces[::37], rng.dirichlet([2.0, 2.0, 2.0], len(faces[::37]))
    points = np.einsum("nc,ncd->nd", barycentric, vertices[corners])
    # From the middle the surface is seen once in each direction: from outside, the point itself.
    sights = [{"origin": middle.tolist(), "towards": (p - middle).tolist()} for p in points]
    found = call(page, "surface_point", body, [mesh, sights])
    for one, expected, weights in zip(found, corners.tolist(), barycentric, strict=True):
        assert one["corners"] == expected
        np.testing.assert_allclose(one["weights"], weights, atol=1e-9)
        assert one["depth"] == pytest.approx(1.0)
    beside = {"origin": (middle + 100.0).tolist(), "towards": [0.0, 0.0, 1.0]}
    assert call(page, "surface_point", body, [mesh, [beside]]) == [None]


def test_carried_values_have_the_same_colours_on_both_shapes(page: Page) -> None:
    """Labels by a list, numbers by a scale; what has no value is grey."""
    body = "const { colors, legend, range } = m.carriedColors(...given);"
    body += "return { colors, legend, range };"
    grey = [200, 200, 200]
    labels = [
        {"shape": [3], "data": ["leg", "head", "leg"]},
        {"shape": [4], "data": ["leg", "", "arm", "leg"]},
    ]
    found = call(page, "carried_colors", body, ["labels", labels, None])
    assert [label for label, _ in found["legend"]] == ["arm", "head", "leg"]
    source, target = found["colors"]
    assert target[1] == grey
    assert source[0] == target[0] == target[3] == found["legend"][2][1]
    numbers = [
        {"shape": [1, 2], "data": [9.0, 5.0]},
        {"shape": [3, 2], "data": [9.0, 1.0, 9.0, 3.0, 9.0, 2.0]},
    ]
    found = call(page, "carried_colors", body, ["scalars", numbers, 1])
    source, target = found["colors"]
    assert found["range"] == [1.0, 5.0]
    assert (source, target[:2]) == ([[253, 231, 37]], [[68, 1, 84], [33, 145, 140]])
    painted = [{"shape": [1, 3], "data": [1.0, 0.5, 0.0]}]
    assert call(page, "carried_colors", body, ["colors", painted, None])["colors"] == [
        [[255, 127.5, 0]]
    ]
    shades = "return [...m.shadesOfFaces(given.colors, given)]"
    mesh = {"numbers": [0, 1, 2, 3], "faces": [0, 1, 2, 1, 3, 2], "colors": [[9, 9, 9], [3, 3, 3]]}
    assert call(page, "carried_colors", shades, mesh)[::3] == [9, 6, 6, 3]


def test_texts_of_archives_are_read(page: Page) -> None:
    stream = io.BytesIO()
    np.savez(stream, part=np.array(["arm", "", "Füße"]))
    body = """
        const bytes = Uint8Array.from(atob(given), (letter) => letter.charCodeAt(0));
        return (await m.openNpz(bytes.buffer)("part")).data;
    """
    given = base64.b64encode(stream.getvalue()).decode()
    assert call(page, "npz", body, given) == ["arm", "", "Füße"]
