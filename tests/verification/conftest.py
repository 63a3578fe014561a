"""At full count, what the verifications found becomes a table in docs/verification.

A test tells its figures by `record_property(name, text)`.
"""

import os
import subprocess
from collections import defaultdict
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
FULL = os.environ.get("VANELOCK_VERIFY") == "full"
rows: dict[str, list[tuple[str, str, str]]] = defaultdict(list)


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
