"""Change the program in many small ways, one at a time, and see whether its tests notice.

    python tools/mutants.py                     # the sample of tools/mutants.csv
    python tools/mutants.py --draw 300 --seed 1 # others

The sample was drawn once (seed 7; seed 8 for what stands in place of lines that went): 15 changes
of each of mesh, fem and rom, 30 of nonlinear, 45 of the rest. Changes are drawn evenly from all
places where cosmic-ray knows one, at most a quarter of them of one kind; of one seed always the
same. Tests run from the nearest file on - those of the file, of its folder, those that name its
module or package, those of the folders around it - until one fails or the time allowed is spent;
then a golden run that runs code of the file. What is found is kept in build/mutants and not done
again. Needs the extra "mutants".
"""

import argparse
import cProfile
import csv
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ElementTree
from collections import Counter, defaultdict
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from queue import SimpleQueue
from threading import Lock
from typing import Any, NamedTuple

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator

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
START = 300.0
"""Seconds that starting the tests may take beside their own time, compiling and golden runs too."""
LAYER, TOGETHER = ("-m", "not system"), ("-n", "2", "--dist", "loadfile")
SAMPLE = ROOT / "tools" / "mutants.csv"
GOLDEN = ("lap_joint", "shrouded_ring", "default", "accuracy", "sweep", "everything")
"""Golden runs, the quickest first."""
MAKING = Lock()


class Mutant(NamedTuple):
    """One change: file, kind, which of its places in the file, line."""

    file: str
    kind: str
    occurrence: int
    line: int


def main() -> None:
    """Try the sample, or changes drawn anew, and print what no test noticed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--draw", type=int, metavar="COUNT", help="so many instead of the sample")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=60.0, help="of the nearest tests")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--run", nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args()
    KEPT.mkdir(parents=True, exist_ok=True)
    if given.run:
        note_files(given.run[0], Path(given.run[1]))
    else:
        mutants = drawn(given.draw, given.seed) if given.draw else sample()
        attempt(mutants, given.seconds, given.workers)


def sample() -> list[Mutant]:
    """The changes of `tools/mutants.csv` that the program still has a place for."""
    found = []
    for row in csv.DictReader(SAMPLE.read_text().splitlines()):
        path = ROOT / row["file"]
        lines = path.read_text().splitlines() if path.exists() else []
        alike = [
            (occurrence, line)
            for occurrence, line in enumerate(places(path, row["kind"]) if lines else ())
            if lines[line - 1].strip() == row["text"]
        ]
        if len(alike) <= int(row["within"]):
            print(f"gone: {row['file']}: {row['text']}")
        else:
            found.append(Mutant(row["file"], row["kind"], *alike[int(row["within"])]))
    return found


def places(path: Path, kind: str) -> list[int]:
    """Line of each place of a file where a kind of change can be made."""
    operator = get_operator(f"core/{kind}")()
    nodes = ast_nodes(get_ast(path.read_text()))
    return [line for node in nodes for (line, _), _ in operator.mutation_positions(node)]


def note_files(name: str, place: Path) -> None:
    """Make a golden run and write down the files whose functions it calls."""
    sys.path.insert(0, str(ROOT))
    from tests.golden.runs import golden_run

    with tempfile.TemporaryDirectory() as folder, cProfile.Profile() as profile:
        golden_run(name, Path(folder))
    codes = [entry.code for entry in profile.getstats() if not isinstance(entry.code, str)]
    files = {Path(code.co_filename).resolve() for code in codes}
    known = sorted(str(file.relative_to(ROOT)) for file in files if file.is_relative_to(ROOT))
    place.write_text(json.dumps(known))


def golden_of(file: str) -> str | None:
    """The quickest golden run that runs code of a file."""
    for name in GOLDEN:
        place = KEPT / f"{name}.json"
        with MAKING:
            if not place.exists():
                subprocess.run([sys.executable, __file__, "--run", name, str(place)], check=True)
        if file in json.loads(place.read_text()):
            return name
    return None


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


def pytest(tree: Path, files: list[str], seconds: float | None, *options: str) -> int | None:
    """Exit status of test files in a tree, None where the time is up."""
    environment = {
        **os.environ,
        "PYTHONPATH": os.pathsep.join([str(tree), os.environ.get("PYTHONPATH", "")]),
        "OMP_NUM_THREADS": "1",
    }
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", *options, *files]
    process = subprocess.Popen(
        command, cwd=tree, env=environment, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    try:
        return process.wait(seconds)
    except subprocess.TimeoutExpired:
        return None
    finally:  # and what its tests have started
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def drawn(count: int, seed: int) -> list[Mutant]:
    """Changes drawn from all of the program's."""
    found = []
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            file = str(path.relative_to(ROOT))
            for kind in KINDS:
                found += [Mutant(file, kind, i, line) for i, line in enumerate(places(path, kind))]
    random.Random(seed).shuffle(found)
    of_kind: Counter[str] = Counter()
    kept = []
    for mutant in found:
        of_kind[mutant.kind] += 1
        if of_kind[mutant.kind] <= MOST * count:
            kept.append(mutant)
    return kept[:count]


def nearest(mutant: Mutant) -> list[tuple[int, str]]:
    """Test files of the file's part of the program and their ranks, the nearest first."""
    file = Path(mutant.file)
    module = ".".join(file.with_suffix("").parts).removesuffix(".__init__")
    module = module.removeprefix("vanelock.")
    package = module.rpartition(".")[0]
    folder = Path("tests", file.parent)
    around = [folder, *folder.parents][:-2]
    ranked = []
    for path in (ROOT / "tests").rglob("test_*.py"):
        test, text = path.relative_to(ROOT), path.read_text()
        rank = next((i for i, one in enumerate(around) if one in test.parents), 9)
        if test.stem == f"test_{file.stem}" or module in text:
            rank = min(rank, 0 if folder in test.parents else 1)
        elif "." in package and package in text:
            rank = min(rank, 1)
        ranked.append((rank, "verification" in test.parts, len(text), str(test)))
    return [(rank, test) for rank, *_, test in sorted(ranked) if rank < 9]


def measured(tree: Path) -> dict[str, float]:
    """Seconds of the tests of each file that passes as the program is."""
    place, report = KEPT / "times.json", tree / "times.xml"
    if not place.exists():
        options = (f"--junitxml={report}", "-o", "junit_family=xunit1")
        pytest(tree, ["tests"], None, *LAYER, *TOGETHER, *options)
        place.write_text(json.dumps(passed(report)))
    known: dict[str, float] = json.loads(place.read_text())
    return known


def passed(report: Path) -> dict[str, float]:
    """Seconds of each file of a report of pytest of which nothing failed or was skipped."""
    found: dict[str, float] = defaultdict(float)
    for case in ElementTree.parse(report).iter("testcase"):
        missed = any(part.tag in ("failure", "error", "skipped") for part in case)
        found[case.attrib["file"]] += -1e9 if missed else float(case.attrib["time"])
    return {test: seconds for test, seconds in found.items() if seconds >= 0}


def attempt(mutants: list[Mutant], seconds: float, workers: int) -> None:
    """Try changes, and print what no test noticed."""
    free, kept = trees(workers), KEPT / "outcomes.jsonl"
    tree = free.get()
    times = measured(tree)
    free.put(tree)
    known: dict[Any, dict[str, Any]] = {
        tuple(record["mutant"]): record
        for record in map(json.loads, kept.read_text().splitlines() if kept.exists() else ())
    }

    def one(mutant: Mutant) -> dict[str, Any]:
        if mutant in known:
            return known[mutant]
        tree = free.get()
        record = {"mutant": mutant, **outcome(tree, mutant, times, seconds)}
        free.put(tree)
        with kept.open("a") as file:
            file.write(json.dumps(record) + "\n")
        return record

    with ThreadPoolExecutor(workers) as pool:
        records = list(pool.map(one, mutants))
    print("\n".join(summary(records)))


def outcome(tree: Path, mutant: Mutant, times: dict[str, float], seconds: float) -> dict[str, Any]:
    """Whether a test notices a change, and what was run."""
    place, near = tree / mutant.file, nearest(mutant)
    whole = place.read_text()
    changed = mutate_code(whole, get_operator(f"core/{mutant.kind}")(), mutant.occurrence)
    if changed is None or changed == whole:
        return {"noticed": "no change", "by": "", "ran": 0}
    ran = 0
    place.write_text(changed)
    try:
        for group in batches([test for _, test in near if test in times], times, seconds):
            allowed = START + 5 * sum(times[test] for test in group)
            status = pytest(tree, group, allowed, "-x", *LAYER)
            ran += len(group)
            if status != 0:
                why = "failure" if status else "time"
                return {"noticed": why, "by": group[0], "ran": ran}
        name = golden_of(mutant.file)
        if name and pytest(tree, ["tests/golden"], 4 * START, "-x", "-k", f"[{name}]") != 0:
            return {"noticed": "failure", "by": f"golden run {name}", "ran": ran + 1}
        return {"noticed": "", "by": "", "ran": ran}
    finally:
        place.write_text(whole)


def batches(
    tests: list[str], times: dict[str, float], most: float, size: float = 20.0
) -> Iterator[list[str]]:
    """Test files of `most` seconds together, in groups of some: starting Python takes time, too."""
    group: list[str] = []
    spent = held = 0.0
    for test in tests:
        if group and held + times[test] > size:
            yield group
            group, held = [], 0.0
        if spent + times[test] > most and spent > 0:
            break
        group.append(test)
        spent, held = spent + times[test], held + times[test]
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
            yield f"not noticed: {file}:{line} {kind} ({each['ran']} test files ran)"


if __name__ == "__main__":
    main()
