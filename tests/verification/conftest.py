"""At full count, what the verifications found becomes a table in docs/verification.

A test tells its figures by `record_property(name, text)`.
"""

import os
import subprocess
from collections import defaultdict
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from vanelock.fem import Material, assemble, eigenpairs
from vanelock.mesh import Part

ROOT = Path(__file__).resolve().parents[2]
FULL = os.environ.get("VANELOCK_VERIFY") == "full"
rows: dict[str, list[tuple[str, str, str]]] = defaultdict(list)


@pytest.fixture(scope="session")
def lowest_frequencies() -> Callable[..., np.ndarray]:
    """Function that finds the lowest frequencies, Hz, of a part supported component by component.

    `lowest_frequencies(part, material, 6, x0="yz")` holds y and z of the nodes of the set x0.
    """

    def find(part: Part, material: Material, count: int, **held: str) -> np.ndarray:
        model = assemble(part, material, fixed=None)
        free = np.ones(part.points.shape, bool)
        for node_set, axes in held.items():
            for axis in axes:
                free[part.node_sets[node_set], "xyz".index(axis)] = False
        rows = np.sort(model.dofs[free])
        K, M = (A.tocsr()[rows][:, rows].tocsc() for A in (model.K, model.M))
        values, _ = eigenpairs(K, M, count, shift=-1.0)
        frequencies: np.ndarray = np.sqrt(np.maximum(values, 0)) / (2 * np.pi)
        return frequencies

    return find


@pytest.fixture
def compare(record_property: Callable[[str, object], None]) -> Callable[..., None]:
    """Function that records frequencies, Hz, beside their targets and asserts the differences."""

    def within(
        targets: Sequence[float],
        found: Sequence[float],
        least: float,
        most: float,
        source: str = "target",
    ) -> None:
        difference = np.divide(found, targets) - 1
        pairs = zip(found, targets, difference, strict=True)
        text = ", ".join(f"{f:.5g} Hz ({t:.5g}, {d:+.2%})" for f, t, d in pairs)
        record_property(f"found ({source})", text)
        assert np.all(difference > least)
        assert np.all(difference < most)

    return within


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    if FULL and (report.when == "call" or report.failed) and "verification" in report.nodeid:
        file, _, name = report.nodeid.partition("::")
        figures = "; ".join(f"{key} {value}" for key, value in report.user_properties)
        rows[Path(file).stem.removeprefix("test_")].append((name, figures, report.outcome))


def pytest_sessionfinish(session: pytest.Session) -> None:
    if not FULL or hasattr(session.config, "workerinput"):
        return
    commit = subprocess.run(
        ["git", "describe", "--always", "--dirty"], cwd=ROOT, capture_output=True, text=True
    ).stdout.strip()
    folder = ROOT / "docs" / "verification"
    folder.mkdir(parents=True, exist_ok=True)
    for page, found in rows.items():
        passed = sum(outcome == "passed" for *_, outcome in found)
        lines = [
            f"# Verification: {page.replace('_', ' ')}\n",
            f"Written by `make verify` at commit {commit or 'unknown'}: "
            f"{passed} of {len(found)} passed.\n",
            "| test | figures | outcome |",
            "|---|---|---|",
            *(f"| `{name}` | {figures} | {outcome} |" for name, figures, outcome in sorted(found)),
            "",
        ]
        (folder / f"{page}.md").write_text("\n".join(lines))
