"""Picture of the page with a match, its loading time and its pauses: ``python -m bench.page``.

Needs the packages of `make .venv/dev`, and Chromium: `make browser`.
"""

import shutil
import tempfile
import time
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from bench.command_line import command_line
from demo.figures import generate, write_off
from demo.stack import running_stack

VERTICES = 4000
SIZE = 1100, 1040
PATIENCE = 120_000
"""Milliseconds."""

PAUSES = """
window.longestPause = 0;
new PerformanceObserver((list) => {
  const durations = list.getEntries().map(({ duration }) => duration);
  window.longestPause = Math.max(window.longestPause, ...durations);
}).observe({ type: "longtask", buffered: true });
"""
"""Longest time the page does not answer, in milliseconds."""

SOFTWARE = ("--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader")


def main() -> None:
    """Start the service, match two figures on the page, and save what is seen."""
    parser = command_line(__doc__)
    parser.add_argument("--output", type=Path, default=Path("bench-output/page.png"))
    parser.add_argument("--vertices", type=int, default=VERTICES)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, running_stack() as stack:
        figures = generate(options.vertices)
        files = Path(folder, "standing.off"), Path(folder, "walking.off")
        for path, shape in zip(files, (figures.source, figures.target), strict=True):
            write_off(path, shape)
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=shutil.which("chromium-headless-shell") or shutil.which("chromium"),
                args=list(SOFTWARE),
            )
            page = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]})
            page.set_default_timeout(PATIENCE)
            page.add_init_script(PAUSES)
            page.goto(stack.url)
            _match(page, files)
            print(f"longest pause    {page.evaluate('window.longestPause') / 1000:5.2f} s")
            options.output.parent.mkdir(parents=True, exist_ok=True)
            page.screenshot(path=options.output)
            browser.close()
    print(f"{options.output}: {options.output.stat().st_size / 1000:.0f} kB")


def _match(page: Page, files: tuple[Path, Path]) -> None:
    start = time.perf_counter()
    page.locator("#files").set_input_files([str(path) for path in files])
    page.locator(".chips li").nth(1).wait_for()
    print(f"uploaded after   {time.perf_counter() - start:5.1f} s")
    page.get_by_role("button", name="Match", exact=True).click()
    page.locator("[data-field=energy]").wait_for()
    print(f"matched after    {time.perf_counter() - start:5.1f} s")
    page.locator("[data-drawn]").wait_for()
    print(f"drawn after      {time.perf_counter() - start:5.1f} s")
    page.locator("tr[data-pair='8'] button").click()
    page.locator(".scene[data-side=target][data-pair='8']").wait_for()
    page.mouse.move(0, 0)
    page.evaluate("() => scrollTo(0, 0)")
    page.wait_for_timeout(1000)


if __name__ == "__main__":
    main()
