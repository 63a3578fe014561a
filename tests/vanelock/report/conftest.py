"""A page with one block of each kind, made by hand, and a browser that opens it."""

import shutil
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import matplotlib.image
import numpy as np
import pytest
from playwright.sync_api import Browser, Page, sync_playwright

from vanelock import report
from vanelock.common.tables import Column, Table, heads
from vanelock.mesh import Part

SECTORS = 9
_BROWSERS = ("chromium", "chromium-browser", "google-chrome")


@pytest.fixture(scope="session")
def bent_block(lattice: Callable[..., Part]) -> Callable[..., report.Body]:
    """Function that makes the skin of nine tenths of a ring's sector."""

    def build(
        name: str = "vane", inner: float = 0.4, outer: float = 0.6, length: float = 0.1
    ) -> report.Body:
        def bent(p: np.ndarray) -> np.ndarray:
            r, angle = inner + (outer - inner) * p[:, 0], 2 * np.pi / SECTORS * 0.9 * p[:, 1]
            return np.column_stack([r * np.cos(angle), r * np.sin(angle), length * p[:, 2]])

        body, _ = report.body_of(lattice((4, 4, 4), bent, "tetra"))
        return replace(body, name=name, sectors=SECTORS)

    return build


def wave(body: report.Body, seed: int, amplitude: float) -> np.ndarray:
    """(m, 3) complex shape, smooth along the body and elliptic."""
    random = np.random.default_rng(seed)
    slope = random.normal(size=(3, 3)) + 1j * random.normal(size=(3, 3))
    shape = body.points @ slope
    return np.asarray(amplitude * shape / np.abs(shape).max())


@pytest.fixture(scope="session")
def sample(tmp_path_factory, bent_block):
    """The page, written, and what it was made of."""
    folder = tmp_path_factory.mktemp("run")
    picture = folder / "figures" / "shape.png"
    picture.parent.mkdir()
    matplotlib.image.imsave(picture, np.linspace(0, 1, 900 * 1500).reshape(900, 1500))
    bodies = (bent_block(), bent_block("casing", 0.61, 0.65, 0.14))
    motions = (
        report.Motion(
            "Response", 2, tuple(wave(b, 1, 42e-6) for b in bodies), 263.4, "At the peak."
        ),
        report.Motion("Mode", 7, tuple(wave(b, 2, 1.0) for b in bodies), 250.9, relative=True),
    )
    x = np.linspace(200, 300, 101)
    broken = 40 / (1 + ((x - 250) / 5) ** 2)
    broken[30:34] = np.nan
    curves = report.Plot(
        (
            report.Trace(x, broken, "μ = 0.15 & more", hover="H = 3"),
            report.Trace(x, 60 - np.abs(x - 270) / 2, "free", group="limits", dash="dash"),
            report.Trace(x, 50 - np.abs(x - 280) / 2, "stuck", group="limits", dash="dot"),
            report.Trace(x[::10], broken[::10], "measured", mode="markers", colour="#1a1a1a"),
        ),
        "frequency (Hz)",
        "amplitude (µm)",
        "Forced response",
        "Three cases.",
        data=(folder / "figures" / "response.csv",),
    )
    scales = report.Plot(
        (report.Trace(np.geomspace(0.01, 10, 20), np.geomspace(1e3, 1, 20), "peak"),),
        "friction coefficient (–)",
        "peak (µm)",
        "Peak against friction",
        log_x=True,
        log_y=True,
    )
    wide = Table(
        "Contacts",
        [*heads("contact", "state"), *(Column(f"quantity {i}", "N") for i in range(14))],
        [[i, "slips", *(1.2345 * 10.0**k for k in range(14))] for i in range(30)],
        flags=["bad" if i == 3 else "" for i in range(30)],
    )
    keys = [(f"key {i}", i) for i in range(5)]
    folded = Table("Every key", heads("key", "value"), keys, folded=True)
    page = report.Page(
        'Study "A" <b>',
        "22 November 2026, vanelock 0.1.0",
        (
            report.Section(
                "Answers",
                (
                    report.Text("First **bold** and `code`.\n\nSecond <script>alert(1)</script>."),
                    report.Answers(
                        (
                            report.Answer("Peak", "41.7 µm", "at 250.0 Hz", "good"),
                            report.Answer("Wear", "12 µm/1000 h", "", "bad"),
                        )
                    ),
                ),
            ),
            report.Section("Curves & tables", (curves, scales, wide, folded)),
            report.Section("Motion", (report.View(bodies, motions, "Ring in motion", "Drag it."),)),
            report.Section("Motion", (report.Picture(picture, "Shape", "As printed."),)),
        ),
    )
    path = report.write_page(folder / "report.html", page)
    return SimpleNamespace(path=path, page=page, bodies=bodies, motions=motions, curves=curves)


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    """A real browser without a screen, drawing by software; one for all tests."""
    found = next(filter(None, map(shutil.which, _BROWSERS)), None)
    if found is None:
        pytest.fail(f"no browser found: one of {', '.join(_BROWSERS)} is needed")
    options = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=found, args=options)
        yield started
        started.close()


@pytest.fixture(scope="session")
def visit(browser: Browser) -> Callable[..., Page]:
    """Function that opens a file, and `visit.until(page, expression)`, which waits.

    `visit.complaints` and `visit.requests` of all pages opened grow while pages are used.
    """
    complaints: list[str] = []
    requests: list[str] = []

    def until(page: Page, expression: str, given: object = None) -> None:
        """Wait; the page's own policy forbids Playwright's waiting, which evaluates text in it."""
        for _ in range(6000):  # minutes, on a machine that does much else
            if page.evaluate(expression, given):
                return
            page.wait_for_timeout(50)
        pytest.fail(f"in vain: {expression}")

    def visit(path: Path, width: int = 1280, height: int = 900, **options) -> Page:
        options = {"reduced_motion": "reduce", **options}
        context = browser.new_context(viewport={"width": width, "height": height}, **options)
        context.set_default_timeout(300_000)
        page = context.new_page()
        page.on("console", lambda message: complaints.append(f"{message.type}: {message.text}"))
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on("request", lambda request: requests.append(request.url))
        page.goto(path.as_uri())
        until(
            page,
            "[...document.querySelectorAll('.area')].every("
            "a => !a.checkVisibility() || a.querySelector('.main-svg'))",
        )
        return page

    visit.complaints = complaints  # type: ignore[attr-defined]
    visit.requests = requests  # type: ignore[attr-defined]
    visit.until = until  # type: ignore[attr-defined]
    return visit
