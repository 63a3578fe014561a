"""For all tests: one thread each, children that hear signals, slow files first, `--everything`."""

import os
import signal
from collections.abc import Generator

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


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put files with slow tests first: the last file begun then is a short one."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_makereport(
    item: pytest.Item,
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Turn the report of a test that did not run into a failure."""
    report = yield
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
