"""For all tests: one thread each, and `--everything`, which counts a skipped test as failed."""

import os
from collections.abc import Generator

import pytest

# Before NumPy is loaded. Two workers whose BLAS takes all cores hold each other up.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")


def pytest_addoption(parser: pytest.Parser) -> None:
    """Offer the option."""
    parser.addoption(
        "--everything",
        action="store_true",
        help="count skipped tests and expected failures as failed",
    )


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
