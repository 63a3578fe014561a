"""What each reduction costs and how far its frequencies and responses are from the unreduced ones.

The vane of examples/vane.toml, hooks as linear springs, the interlock free and stuck, against the
unreduced sector (segment.py).

    python -m benchmarks.rom.error [--size medium] [--modes 5 10 20 40 80] [--write]

prints the tables; `--write` puts them into docs/benchmarks/reduction_error.md, with pictures.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from benchmarks.pages import FOLDER, page
from benchmarks.rom.pictures import errors, responses
from benchmarks.rom.reduced import DISTANCE, EVERY, Bench, Outcome, Setting, fewer
from benchmarks.segment import CASES

Floats = NDArray[np.float64]

ACCURACIES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
PROMISES = {1e-4: "the default settings", 1e-6: "`accuracy=1e-6`"}
DIAMETERS = (0, 1, 3)
ABOVE = 1e-8  # errors below are round-off in part
INTRODUCTION = """\
Mesh size {size}: vane {vane} dofs, casing {casing} dofs, unreduced sector {sector}. Hooks are
linear springs, the interlock is free or stuck; where one number stands, it is the worse of the two.
Errors are relative; nodal diameter 1 unless stated. Cost: CPU time of reducing both parts at one
nodal diameter, one thread, in units of a real factorisation of the vane's stiffness ({unit:.2f} s).

The unreduced frequencies differ by {doubt:.0e} at most between two shifts of Lanczos, and the
unreduced response by {doubt_of_response:.0e} from a solution with the indefinite K - ω²M. Responses
have no damping: {points} frequencies from {low:g} to {high:g} Hz, at least {distance:.0%} from the
natural ones; error and amplitude are the largest of all outputs at one frequency."""
ESTIMATES = """\
The estimate of the error (`rom.frequency_errors`, `rom.response_errors`) over the true error, of
all settings of the route "cyclic" on this page, where the true error exceeds {above:.0e}, which
round-off does not touch. An estimate is infinite where a mode lies above the frequency up to which
all fixed-interface modes are kept: the reduction then promises nothing.

| | values | least | greatest | below one half | above ten | infinite |
|---|---:|---:|---:|---:|---:|---:|"""


def settings(modes: list[int]) -> Iterator[Setting]:
    """All that are compared at nodal diameter 1."""
    for f in modes:
        yield Setting(f"cyclic, {f} modes", {"modes": f}, {"modes": f}, f)
    for accuracy in ACCURACIES:
        default = " (default)" if accuracy == 1e-4 else ""
        given = {"accuracy": accuracy}
        yield Setting(f"cyclic, accuracy {accuracy:.0e}{default}", given, given)
    for interface in ("published", "followed"):
        for f in modes:
            yield tran(interface, f, f)
    for f in dict.fromkeys((ten(modes), modes[-1])):
        yield tran("published", f, f, "paper")


def tran(interface: str, modes: int, face: int, route: str = "direct") -> Setting:
    """Fixed-interface modes of both parts and face modes of the casing."""
    given: dict[str, Any] = {"modes": modes, "interface_modes": face}
    given |= {"route": route} if route == "paper" else {"interface": interface}
    name = f"{route}, {interface}, {modes} fixed and {face} face modes"
    return Setting(name, {"modes": modes}, given, modes, face)


def ten(modes: list[int]) -> int:
    """The second number of modes: ten, as published."""
    return modes[:2][-1]


def ratios(outcomes: list[Outcome], kind: str) -> tuple[Floats, Floats, int]:
    """True errors beyond round-off, their estimates, and how many estimates are infinite.

    `kind` is "frequency" or "response".
    """
    pairs = []
    for o in outcomes:
        if kind == "frequency":
            pairs += [(abs(o.error[case]), o.estimate[case]) for case in o.estimate]
        else:
            pairs += [(o.response[case][::EVERY], o.estimated[case]) for case in o.estimated]
    true, estimated = (np.concatenate(values) for values in zip(*pairs, strict=True))
    shown = (true > ABOVE) & np.isfinite(estimated)
    return true[shown], estimated[shown], int(np.sum(np.isinf(estimated)))


def spread(outcome: Outcome, kind: str = "frequency") -> str:
    """Least and greatest estimate over truth."""
    if not outcome.estimate:
        return ""
    true, estimated, infinite = ratios([outcome], kind)
    if len(true) == 0:
        return "infinite" if infinite else "round-off"
    more = f", {infinite} infinite" if infinite else ""
    return f"{(estimated / true).min():.2f} to {(estimated / true).max():.2f}{more}"


def overview(found: list[tuple[Setting, Outcome]], unit: float) -> list[str]:
    """All settings."""
    lines = [
        "| | modal coordinates | all | cost | f2 | worst of ten | estimate over truth | response "
        "| estimate over truth |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for setting, o in found:
        lines.append(
            f"| {setting.name} | {o.coordinates} | {o.size} | {o.cost / unit:.1f} | "
            f"{o.second():.1e} | {o.worst():.1e} | {spread(o)} | {o.worst_response():.1e} | "
            f"{spread(o, 'response')} |"
        )
    return lines


def grids(bench: Bench, modes: list[int]) -> list[str]:
    """The ways "direct" over fixed modes and face modes, from the largest model of each basis."""
    lines: list[str] = []
    for interface in ("published", "followed"):
        vane, casing, _ = bench.pair(tran(interface, modes[-1], modes[-1]))
        across = " | ".join(f"{face} face modes" for face in modes)
        lines += ["", f'### interface="{interface}"', ""]
        lines += [f"| fixed modes | {across} |", "|---:" * (len(modes) + 1) + "|"]
        for f in modes:
            row = [bench.compared(fewer(vane, f), fewer(casing, f, n), 0.0) for n in modes]
            cells = [f"{o.second():.0e} / {o.worst():.0e} / {o.worst_response():.0e}" for o in row]
            lines.append(f"| {f} | " + " | ".join(cells) + " |")
    return lines


def by_diameter(bench: Bench, modes: list[int]) -> tuple[list[str], list[Outcome]]:
    """Short table of several nodal diameters, and what its rows of the route "cyclic" gave."""
    few = ten(modes)
    chosen = [Setting(f"cyclic, {few} modes", {"modes": few}, {"modes": few})]
    for accuracy in PROMISES:
        given = {"accuracy": accuracy}
        chosen.append(Setting(f"cyclic, accuracy {accuracy:.0e}", given, given))
    chosen += [tran(interface, few, few) for interface in ("published", "followed")]
    lines = [
        "| | " + " | ".join(f"ND {k}: f2 | worst of ten" for k in DIAMETERS) + " |",
        "|---" + "|---:" * (2 * len(DIAMETERS)) + "|",
    ]
    outcomes = []
    for setting in chosen:
        row = [bench.outcome(setting, k) for k in DIAMETERS]
        outcomes += [o for o in row if o.estimate]
        cells = " | ".join(f"{o.second():.1e} | {o.worst():.1e}" for o in row)
        lines.append(f"| {setting.name} | {cells} |")
    return lines, outcomes


def estimates(outcomes: list[Outcome]) -> list[str]:
    """Table of estimates over true errors."""
    lines = []
    for kind in ("frequency", "response"):
        true, estimated, infinite = ratios(
            [o for o in outcomes if o.estimated or kind == "frequency"], kind
        )
        r = estimated / true
        lines.append(
            f"| {kind} | {len(r)} | {r.min():.2f} | {r.max():.2f} | {np.sum(r < 0.5)} | "
            f"{np.sum(r > 10)} | {infinite} |"
        )
    return lines


def report(size: str | float, modes: list[int], folder: Path | None) -> list[str]:
    """Lines of the page; its pictures go into a folder, if there is one."""
    bench = Bench(size)
    unit = bench.unit()
    found = []
    for setting in settings(modes):
        found.append((setting, bench.outcome(setting)))
        print(f"{setting.name}: {found[-1][1].worst():.1e}", flush=True)
    cyclic = [o for s, o in found if s.name.startswith("cyclic")]
    table, more = by_diameter(bench, modes)
    text = INTRODUCTION.format(
        size=size,
        vane=bench.vane.K.shape[0],
        casing=bench.casing.K.shape[0],
        sector=bench.sector("stuck", 1).K.shape[0],
        unit=unit,
        doubt=max(bench.sector(case, 1).doubt() for case in CASES),
        doubt_of_response=bench.doubt_of_response(),
        points=len(bench.frequencies),
        low=bench.frequencies[0],
        high=bench.frequencies[-1],
        distance=DISTANCE,
    )
    lines = [*text.splitlines(), ""]
    by_accuracy = dict(zip(ACCURACIES, cyclic[len(modes) :], strict=True))
    for accuracy, name in PROMISES.items():
        o = by_accuracy[accuracy]
        free, stuck = (abs(o.error[case]).max() for case in CASES)
        lines.append(
            f"- First ten frequencies with {name}, asked to be within {accuracy:.0e}: "
            f"{free:.1e} with the interlock free, {stuck:.1e} with it stuck."
        )
    lines += ["", "![errors against coordinates and cost](reduction_error.png)", ""]
    lines += overview(found, unit)
    lines += ["", "![response and its error](reduction_response.png)", ""]
    lines += ["## Estimated errors", "", *ESTIMATES.format(above=ABOVE).splitlines()]
    lines += estimates(cyclic + more)
    lines += ["", "## Nodal diameters", "", *table]
    lines += ["", '## The subspace of the routes "paper" and of "direct"', ""]
    lines += ["f2 / worst of ten / response: fixed modes of both parts down, face modes across."]
    lines += grids(bench, modes)
    if folder:
        true, estimated, _ = ratios(cyclic + more, "frequency")
        of_response = ratios([o for o in cyclic if o.estimated], "response")[:2]
        errors(found, unit, (true, estimated), of_response, folder / "reduction_error.png")
        responses(bench, found, folder / "reduction_response.png")
    return lines


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", default="medium", help="mesh size by name, or in metres")
    parser.add_argument("--modes", type=int, nargs="+", default=[5, 10, 20, 40, 80])
    parser.add_argument("--write", action="store_true", help="write docs/benchmarks as well")
    options = parser.parse_args()
    size = float(options.size) if options.size[0].isdigit() else options.size
    with threadpool_limits(1):
        lines = report(size, options.modes, FOLDER if options.write else None)
    print("\n".join(lines))
    title = "Reduced models against the unreduced sector"
    page("reduction_error", title, lines, options.write)


if __name__ == "__main__":
    main()
