"""Arguments and options that commands share, and what may be given for them.

What `--help` says below the options of each command: examples, exit statuses, where to read.

A line with a backspace alone keeps the lines of the paragraph below it as they are.
"""

from collections.abc import Iterable
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from typer.models import CommandInfo

from vanelock.common.errors import InputError
from vanelock.common.files.files import possible

STATUSES = """Exit status: 0 done; {failed}2 input that cannot be used, one line for each
mistake; 130 stopped by Ctrl-C, 143 by SIGTERM, 129 by SIGHUP; 141 nobody reads the output."""
FAILED = "1 done, but some cases of a sweep failed, and they are listed; "

FIRST_STUDY = """\b
A first study:
  vanelock init my.toml           the keys to set first; --all: every key
  vanelock check my.toml          mistakes, or what it would compute
  vanelock mesh my.toml           look at the meshes: runs/my/mesh
  vanelock run my.toml            everything, into runs/my: report.html
  vanelock converge my.toml       how far it is off, measured
  vanelock compare runs/a runs/b  two runs side by side

Stopped? The same command goes on from where it was.

\b
`vanelock COMMAND --help` has examples. `vanelock manual` lists the
pages of the manual, and `vanelock manual PAGE` prints one:
start/first_study, keys, not_converged, trust.
"""

_MORE = {
    "run": (
        "Run a study: meshes to report.",
        """Meshes, reduced models, responses, pictures and a report come into one folder. What an
earlier run has computed is used again as far as it does not depend on what changed
since, also where that run was stopped.""",
        ["vanelock run my.toml", "vanelock run my.toml --output runs/today --quiet"],
        "start/first_study, keys, accuracy",
    ),
    "mesh": (
        "Mesh both parts and look at them.",
        """Nothing is solved: this is the place to find out whether dimensions fit each other, and
whether the node sets of your own meshes are found and meet.""",
        ["vanelock mesh my.toml", "vanelock mesh my.toml --output look"],
        "geometry, own_mesh",
    ),
    "converge": (
        "Measure error against cost of every setting.",
        """The study runs once as it is, and again with mesh, modes, harmonics, points and samples
raised, each alone; the table says how far amplitude and frequency of the peak move and
what it costs. Takes several times as long as the study.""",
        [
            "vanelock converge my.toml",
            "vanelock converge my.toml --setting mesh.size --setting response.harmonics",
        ],
        "accuracy, trust",
    ),
    "page": (
        "Make tables, pictures and page of a run again.",
        """They are made from results.h5 and results/ alone: neither the cache nor the files that
the study names are needed.""",
        ["vanelock page runs/my"],
        "outputs",
    ),
    "compare": (
        "Put two runs side by side.",
        """Cases are paired by name, else by the values they share, else by their order, which a
note says. Neither run is changed.""",
        ["vanelock compare runs/a runs/b"],
        "outputs",
    ),
    "fit": (
        "Fit friction, stiffness, ... to measured curves.",
        """The study needs [[measured]], the CSV files with the curves, and [fit], the keys to
vary. Best values come with standard errors, and with a warning where the data
do not determine them; fitted.toml is the study with the best values.""",
        ["vanelock fit my.toml"],
        "measured",
    ),
    "optimise": (
        "Find the joints whose largest peak is smallest.",
        """[optimise] names the keys of joints to vary, and their bounds. The peaks of the range are
followed by their gradients; optimised.toml is the study with the best values.""",
        ["vanelock optimise my.toml"],
        "optimise",
    ),
    "check": (
        "Check a file without computing anything.",
        """Of a study or a scene: every mistake, a line each, and otherwise what would be
computed. Of a results file or the folder of a run: whether it is whole, and what it holds.""",
        ["vanelock check my.toml", "vanelock check runs/my"],
        "keys, scene_file",
    ),
    "init": (
        "Write a commented study file, or an example.",
        """The keys that are set first are in it, each with its unit; with --all every key with its
default, to delete from. A file that is there already is left alone. An example comes with
its data: vane, coupling, engine_orders, loads_at_rest, mistuning, paper (whose paper.py
makes the figures of a published study), the scenes brake_reuss (whose matrices its make.py
writes), ground_damper, lap_joint and shrouded_ring, and notebooks.""",
        [
            "vanelock init my.toml",
            "vanelock init my_scene.toml --scene",
            "vanelock init --example lap_joint",
        ],
        "keys, scene_file",
    ),
    "manual": (
        "Print a page of the manual, or list them.",
        """The pages are in Markdown, laid out where a terminal shows them. Pictures, and the
reference of Python names, are in the manual that `make docs` makes of the source.""",
        ["vanelock manual keys | less", "vanelock manual start/first_study"],
        "start/first_study, glossary",
    ),
    "completion": (
        "Make the Tab key complete words.",
        "It completes commands, options, study files and, for `converge --setting`, keys.",
        [
            "vanelock completion bash >> ~/.bashrc",
            'vanelock completion zsh > "${fpath[1]}/_vanelock"',
            "vanelock completion fish > ~/.config/fish/completions/vanelock.fish",
        ],
        "start/install",
    ),
}


def add_guidance(commands: Iterable[CommandInfo]) -> None:
    """Append to every command's help what this module says of it."""
    for command in commands:
        name = command.name or getattr(command.callback, "__name__", "")
        if name in _MORE:
            command.short_help, about, examples, pages = _MORE[name]
            lines = "\n".join(f"  {each}" for each in examples)
            statuses = STATUSES.format(failed=FAILED if name == "run" else "")
            more = ", ".join(f"`vanelock manual {page}`" for page in pages.split(", "))
            command.epilog = f"{about}\n\n\b\nExamples:\n{lines}\n\n{statuses}\n\nMore: {more}"


def study_files(incomplete: str) -> list[str]:
    """Study files that a word may become; where there are none the shell looks for any file."""
    folder = Path(incomplete if incomplete.endswith("/") else Path(incomplete).parent)
    try:
        found = [str(path) for path in folder.glob("*.toml")]
    except OSError:
        return []
    return sorted(path for path in found if path.startswith(incomplete.removeprefix("./")))


def setting_keys(incomplete: str) -> list[str]:
    """Keys that `converge --setting` knows of some study."""
    keys = (
        *("mesh.size", "rom.accuracy", "rom.modes"),
        *("response.harmonics", "response.coupling", "response.points", "response.samples"),
        "joints.patch",
    )
    return [key for key in keys if key.startswith(incomplete)]


class Shell(StrEnum):
    """Shells with completion."""

    bash = "bash"
    zsh = "zsh"
    fish = "fish"


def given_path(text: str) -> Path:
    """A path that was given, not left out: an empty one would be the current folder."""
    if not text.strip():
        raise typer.BadParameter("must not be empty")
    try:
        possible(text, f"{text[:40]}...")
    except InputError as error:
        raise typer.BadParameter(str(error)) from None
    return Path(text)


def _bytes(text: str) -> float:
    """An amount of memory."""
    from vanelock.common.quantities import si

    try:
        found = float(str(si(text, "byte")))
    except ValueError:
        found = 0.0
    if not found > 0:
        raise typer.BadParameter(f'{text!r}: expected an amount such as "8 GB"')
    return found


StudyFile = Annotated[
    Path,
    typer.Argument(
        help="Study file (TOML).", parser=given_path, metavar="STUDY", autocompletion=study_files
    ),
]
Output = Annotated[
    Path | None,
    typer.Option(
        "--output",
        "-o",
        help="Folder; default runs/<name of the file>.",
        parser=given_path,
        metavar="PATH",
    ),
]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="Print errors only.")]
Outside = Annotated[
    bool,
    typer.Option("--allow-outside", help="Let the study name files outside of its own folder."),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object a line instead of text.")
]


Workers = Annotated[
    int | None,
    typer.Option(
        "--workers",
        "-w",
        min=1,
        max=1024,
        help="Processes that compute a sweep's cases; default: as many as there are cores to "
        "use; 1: none but this one.",
        metavar="N",
    ),
]
Scheduler = Annotated[
    str | None,
    typer.Option(
        help="Address of a Dask scheduler whose workers, which see the run's folder, compute the "
        "cases instead, such as tcp://host:8786 (`vanelock manual sweeps`).",
        metavar="ADDRESS",
    ),
]
Insecure = Annotated[
    bool,
    typer.Option(
        "--insecure-scheduler",
        help="Let the scheduler be on another machine without encryption (tcp://).",
    ),
]


Memory = Annotated[
    float | None,
    typer.Option(
        help="Memory that a study's processes, and the meshes chosen for its accuracy, may take, "
        'such as "8 GB"; default, and at most: seven tenths of what there is.',
        parser=_bytes,
        metavar="AMOUNT",
    ),
]
