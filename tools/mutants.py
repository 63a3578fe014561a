"""Change the program in many small ways, one at a time, and see whether its tests notice.

    python tools/mutants.py cover            # which test files run which lines; an hour
    python tools/mutants.py try 300 --seed 1 # draw changes, run the tests that run their lines

Changes are drawn evenly from all places of all folders where cosmic-ray knows one, at most a
quarter of them of one kind; of one seed always the same. Test files that run the changed line run
in the order of their time, those that mirror its folder first, until one fails, none is left, or
the time allowed is spent. Compiled functions hide their lines: for them the test files of their
folder run. What is found is kept in build/mutants and not done again. Needs the extra "mutants".
"""

import argparse
import json
import os
import random
import shutil
import subprocess
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import SimpleQueue
from typing import Any, NamedTuple

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator
from coverage import CoverageData

ROOT = Path(__file__).resolve().parent.parent
KEPT = ROOT / "build" / "mutants"
FOLDERS = tuple(sorted(init.parent.name for init in ROOT.glob("*/__init__.py")))
KINDS = (
    *(f"ReplaceBinaryOperator_{pair}" for pair in ("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul")),
    "ReplaceBinaryOperator_Pow_Mul",
    *(
        f"ReplaceComparisonOperator_{pair}"
        for pair in ("Lt_LtE", "LtE_Lt", "Gt_GtE", "GtE_Gt", "Lt_Gt", "Gt_Lt", "Eq_NotEq")
    ),
    "ReplaceUnaryOperator_Delete_USub",
    "ReplaceUnaryOperator_Delete_Not",
    "ReplaceTrueWithFalse",
    "ReplaceFalseWithTrue",
    "ReplaceAndWithOr",
    "ReplaceOrWithAnd",
    "ReplaceBreakWithContinue",
    "ReplaceContinueWithBreak",
    "AddNot",
    "NumberReplacer",
    "ZeroIterationForLoop",
)
"""Kinds of change that a slip of the hand makes; those that no type checker lets pass are left
out, since any test notices them."""
MOST = 0.25
"""Largest share of one kind: most places hold a number."""
START = 15.0
"""Seconds that starting the tests may take beside their own time."""


class Mutant(NamedTuple):
    """One change: file, kind, which of its places in the file, line."""

    file: str
    kind: str
    occurrence: int
    line: int


def main() -> None:
    """Do what is asked for."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("what", choices=("cover", "try"))
    parser.add_argument("count", type=int, nargs="?", default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=300.0, help="of test time a change")
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    KEPT.mkdir(parents=True, exist_ok=True)
    if given.what == "cover":
        cover(given.workers)
    else:
        attempt(drawn(given.count, given.seed), given.seconds, given.workers)


def trees(count: int) -> SimpleQueue[Path]:
    """So many copies of what git knows, as it stands here."""
    found: SimpleQueue[Path] = SimpleQueue()
    for number in range(count):
        tree = KEPT / f"tree{number}"
        tree.mkdir(exist_ok=True)
        command = ["git", "ls-files", "-z"]
        listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
        for name in filter(None, listed.stdout.split("\0")):
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            (tree / name).unlink(missing_ok=True)
            shutil.copy2(ROOT / name, tree / name, follow_symlinks=False)
        found.put(tree)
    return found


def pytest(tree: Path, files: list[str], seconds: float, *options: str) -> int | None:
    """Exit status of test files in a tree, None where the time is up."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(tree), os.environ.get("PYTHONPATH", "")]),
        "OMP_NUM_THREADS": "1",
    }
    command = [sys.executable, *options, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
    try:
        return subprocess.run(
            [*command, *files],
            cwd=tree,
            env=environment,
            timeout=seconds,
            capture_output=True,
            check=False,
        ).returncode
    except subprocess.TimeoutExpired:
        return None


def cover(workers: int) -> None:
    """Run each test file by itself, and keep which lines it runs and how long it takes."""
    free, times = trees(workers), KEPT / "times.json"
    known: dict[str, float] = json.loads(times.read_text()) if times.exists() else {}
    files = [str(path.relative_to(ROOT)) for path in sorted((ROOT / "tests").rglob("test_*.py"))]

    def one(file: str) -> None:
        tree = free.get()
        data = KEPT / f"{file.replace('/', '-')}.coverage"
        settings = ("-m", "coverage", "run", f"--data-file={data}", "--source=vanelock")
        began = time.perf_counter()
        status = pytest(tree, [file], 3600.0, *settings)
        known[file] = time.perf_counter() - began
        print(f"{file}: {known[file]:.0f} s, status {status}", flush=True)
        times.write_text(json.dumps(known))
        free.put(tree)

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(one, [file for file in files if file not in known]))


def drawn(count: int, seed: int) -> list[Mutant]:
    """Changes drawn from all of the program's."""
    found = []
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            tree = get_ast(path.read_text())
            for kind in KINDS:
                operator, seen = get_operator(f"core/{kind}")(), 0
                for node in ast_nodes(tree):
                    for (line, _), _ in operator.mutation_positions(node):
                        found.append(Mutant(str(path.relative_to(ROOT)), kind, seen, line))
                        seen += 1
    random.Random(seed).shuffle(found)
    of_kind: Counter[str] = Counter()
    kept = []
    for mutant in found:
        of_kind[mutant.kind] += 1
        if of_kind[mutant.kind] <= MOST * count:
            kept.append(mutant)
    return kept[:count]


def relevant() -> tuple[dict[str, dict[int, set[str]]], dict[str, float]]:
    """Test files by file and line, and their seconds."""
    times: dict[str, float] = json.loads((KEPT / "times.json").read_text())
    found: dict[str, dict[int, set[str]]] = defaultdict(lambda: defaultdict(set))
    for test in times:
        data = CoverageData(str(KEPT / f"{test.replace('/', '-')}.coverage"))
        data.read()
        for measured in data.measured_files():
            path = Path(measured).resolve().relative_to(KEPT)
            name = "/".join(path.parts[1:])
            for line in data.lines(measured) or ():
                found[name][line].add(test)
    return found, times


def chosen(mutant: Mutant, lines: Any, times: dict[str, float]) -> list[str]:
    """Test files for a change, in the order in which they run."""
    mirror = f"tests/{Path(mutant.file).parent}/"
    tests = set(lines[mutant.file].get(mutant.line, ()))
    if not tests:
        tests = {test for test in times if test.startswith(f"tests/{mutant.file.split('/')[0]}/")}
    return sorted(tests, key=lambda t: (not t.startswith(mirror), times[t]))


def attempt(mutants: list[Mutant], seconds: float, workers: int) -> None:
    """Try changes, and print what no test noticed."""
    lines, times = relevant()
    free, kept = trees(workers), KEPT / "outcomes.jsonl"
    known: dict[Any, dict[str, Any]] = {
        tuple(record["mutant"]): record
        for record in map(json.loads, kept.read_text().splitlines() if kept.exists() else ())
    }

    def one(mutant: Mutant) -> dict[str, Any]:
        if mutant in known:
            return known[mutant]
        tree = free.get()
        record = {
            "mutant": mutant,
            **outcome(tree, mutant, chosen(mutant, lines, times), times, seconds),
        }
        free.put(tree)
        with kept.open("a") as file:
            file.write(json.dumps(record) + "\n")
        return record

    with ThreadPoolExecutor(workers) as pool:
        records = list(pool.map(one, mutants))
    print("\n".join(summary(records)))


def outcome(
    tree: Path, mutant: Mutant, tests: list[str], times: dict[str, float], seconds: float
) -> dict[str, Any]:
    """Whether a test notices a change, and what was run."""
    place = tree / mutant.file
    whole = place.read_text()
    changed = mutate_code(whole, get_operator(f"core/{mutant.kind}")(), mutant.occurrence)
    if changed is None or changed == whole:
        return {"noticed": "no change", "by": "", "ran": 0, "of": len(tests)}
    place.write_text(changed)
    spent, ran = 0.0, 0
    try:
        for group in batches(tests, times):
            if spent >= seconds:
                break
            allowed = START + 5 * sum(times[test] for test in group)
            began = time.perf_counter()
            status = pytest(tree, group, allowed)
            spent += time.perf_counter() - began
            ran += len(group)
            if status != 0:
                why = "time" if status is None else "failure"
                return {"noticed": why, "by": group[0], "ran": ran, "of": len(tests)}
        return {"noticed": "", "by": "", "ran": ran, "of": len(tests)}
    finally:
        place.write_text(whole)


def batches(tests: list[str], times: dict[str, float], size: float = 40.0) -> Iterator[list[str]]:
    """Test files in groups of at most so many seconds: starting Python takes some, too."""
    group: list[str] = []
    for test in tests:
        if group and sum(times[each] for each in group) + times[test] > size:
            yield group
            group = []
        group.append(test)
    if group:
        yield group


def summary(records: list[dict[str, Any]]) -> Iterator[str]:
    """A line a folder, and one for each change that no test noticed."""
    tried = [record for record in records if record["noticed"] != "no change"]
    yield "| folder | changes | noticed |\n|---|---|---|"
    for folder in (*FOLDERS, ""):
        own = [each for each in tried if each["mutant"][0].startswith(f"{folder}/") or not folder]
        noticed = sum(bool(each["noticed"]) for each in own)
        if own:
            share = 100 * noticed / len(own)
            yield f"| {folder or 'all'} | {len(own)} | {noticed} ({share:.0f} %) |"
    for each in tried:
        if not each["noticed"]:
            file, kind, _, line = each["mutant"]
            ran = f"{each['ran']} of {each['of']} test files ran"
            yield f"not noticed: {file}:{line} {kind} ({ran})"


if __name__ == "__main__":
    main()
