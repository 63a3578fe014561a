"""For all tests: one thread each, children that hear signals, slow files first, `--everything`."""

import os
import signal
import tomllib
from collections.abc import Generator
from pathlib import Path

import pytest

# Before NumPy is loaded. Two workers whose BLAS takes all cores hold each other up.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

# A job in the background or under nohup ignores these, and so would every child of it; a handler,
# even of nothing, makes way for the default when a child starts.
for _number in (signal.SIGINT, signal.SIGHUP, signal.SIGTERM, signal.SIGQUIT):
    if signal.getsignal(_number) == signal.SIG_IGN:
        signal.signal(_number, lambda number, frame: None)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Offer the option."""
    parser.addoption(
        "--everything",
        action="store_true",
        help="count skipped tests and expected failures as failed",
    )


SLOW = Path(__file__).parent / "tools" / "slow.toml"
"""Tests that may take more than `MOST` seconds of processor time, and why."""
MOST = 10.0

taken: dict[str, float] = {}
"""Seconds of processor time of each test, its fixtures and its children included."""


def known_slow() -> dict[str, str]:
    """Reason by the name of a test, without its parameters."""
    return tomllib.loads(SLOW.read_text()) if SLOW.exists() else {}


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put golden runs first, then files with slow tests: a short one is begun last."""
    slow = {name.partition("::")[0] for name in known_slow()}

    def place(item: pytest.Item) -> int:
        file = item.nodeid.partition("::")[0]
        return 0 if file.startswith("tests/golden/") else 1 if file in slow else 2

    items.sort(key=place)


def seconds() -> float:
    """Processor time so far, that of ended children included."""
    return sum(os.times()[:4])


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Note when a test began."""
    item.began = seconds()  # type: ignore[attr-defined]
    return (yield)


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    """Keep what each test took."""
    if report.when == "teardown":
        taken[report.nodeid] = getattr(report, "processor_time", 0.0)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Say which tests take long without a reason in `tools/slow.toml`."""
    known = known_slow()
    for name, time in sorted(taken.items(), key=lambda pair: -pair[1]):
        if time > MOST and name.partition("[")[0] not in known:
            terminalreporter.write_line(f"{name}: {time:.0f} s of processor time, see {SLOW.name}")


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Say what a test took; turn the report of one that did not run into a failure."""
    report = yield
    if report.when == "teardown":
        report.processor_time = seconds() - item.began  # type: ignore[attr-defined]
    if item.config.getoption("--everything"):
        _fail_unless_run(report)
    return report


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_make_collect_report(
    collector: pytest.Collector,
) -> Generator[None, pytest.CollectReport, pytest.CollectReport]:
    """Turn the report of a file that was skipped into an error."""
    report = yield
    if collector.config.getoption("--everything"):
        _fail_unless_run(report)
    return report


def _fail_unless_run(report: pytest.TestReport | pytest.CollectReport) -> None:
    expected = hasattr(report, "wasxfail")
    if report.skipped or expected:
        reason = report.wasxfail if expected else str(report.longrepr)
        report.outcome = "failed"
        report.longrepr = f"did not count as a test: {reason}"
        if expected:
            del report.wasxfail
