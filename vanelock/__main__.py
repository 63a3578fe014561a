"""Command line: `vanelock run | mesh | converge | compare | page | fit | check | init | ...`.

Errors are one plain line on standard error. Exit status: 0; 1 if some cases of a sweep failed; 2
for input that cannot be used; 128 and a signal's number when stopped by one, so 130 by Ctrl-C; 141
when nobody reads the output any more.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from typer._completion_classes import completion_init
from typer._completion_shared import get_completion_script

import vanelock
from vanelock.commands.installed import (
    example_names,
    how_to_use,
    page_names,
    show,
    write_example,
    write_template,
)
from vanelock.commands.options import (
    FIRST_STUDY,
    AsJson,
    Insecure,
    Memory,
    Output,
    Outside,
    Quiet,
    Scheduler,
    Shell,
    StudyFile,
    Workers,
    add_guidance,
    given_path,
    setting_keys,
)
from vanelock.common import process
from vanelock.common.errors import InputError, cut_short, first_mistakes, printable
from vanelock.common.files.files import default_folder
from vanelock.common.process import is_shortage, keep_freed, refusal, require_least

if TYPE_CHECKING:
    from vanelock.files import Study
    from vanelock.pipeline.progress import Listener

app = typer.Typer(
    name="vanelock",
    help="Friction-damped vibration of turbine vane segments.",
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _version(asked: bool) -> None:
    if asked:
        print(f"vanelock {vanelock.__version__}")
        raise typer.Exit


@app.callback(invoke_without_command=True, epilog=FIRST_STUDY)
def _options(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Friction-damped vibration of turbine vane segments."""
    if context.invoked_subcommand is None:
        print(context.get_help())


@app.command()
def run(
    study: StudyFile,
    output: Output = None,
    allow_outside: Outside = False,
    quiet: Quiet = False,
    as_json: AsJson = False,
    workers: Workers = None,
    scheduler: Scheduler = None,
    memory: Memory = None,
    insecure_scheduler: Insecure = False,
) -> None:
    """Run a study or a scene of matrices; an earlier run's work is used again.

    Exit status 1 if some cases of a sweep could not be computed; they are listed.
    """
    from vanelock.files import load_given, read_text
    from vanelock.pipeline.progress import Event, Failed, choose_listener

    folder, text = output or default_folder(study), read_text(study)
    computing = workers or len(os.sched_getaffinity(0)), scheduler, insecure_scheduler
    loaded = load_given(study, allow_outside)
    # What a mistake in the file need not wait for.
    from vanelock.commands.run.study import run_study

    failed = 0
    with _going_on_later(folder), choose_listener(quiet, as_json) as listener:

        def counted(event: Event) -> None:
            nonlocal failed
            failed += isinstance(event, Failed)
            listener(event)

        run_study(loaded, folder, counted, text, *computing, memory)
        if failed:
            raise typer.Exit(1)


@app.command()
def mesh(
    study: StudyFile,
    output: Output = None,
    allow_outside: Outside = False,
    quiet: Quiet = False,
    as_json: AsJson = False,
) -> None:
    """Mesh both parts of a study: files for ParaView and Gmsh, figures, counts, a picture."""
    from vanelock.commands.mesh import mesh_study

    with _begun(study, output, allow_outside, quiet, as_json) as begun:
        mesh_study(*begun)


@app.command()
def converge(
    study: StudyFile,
    output: Output = None,
    allow_outside: Outside = False,
    quiet: Quiet = False,
    as_json: AsJson = False,
    setting: Annotated[
        list[str] | None,
        typer.Option(
            help="Key of a setting, such as mesh.size; may be repeated; default: all.",
            autocompletion=setting_keys,
        ),
    ] = None,
    dofs: Annotated[
        int | None, typer.Option(min=1, help="Largest meshes tried, degrees of freedom.")
    ] = None,
) -> None:
    """Measure error against cost: run a study again with each of its settings raised alone."""
    from vanelock.commands.converge.converge import converge_study

    limits = {} if dofs is None else {"dofs": dofs}
    with _begun(study, output, allow_outside, quiet, as_json) as (loaded, folder, listener):
        converge_study(loaded, folder, listener, setting or (), **limits)


@app.command()
def compare(
    one: Annotated[Path, typer.Argument(help="Folder of a run.", parser=given_path, metavar="A")],
    other: Annotated[
        Path, typer.Argument(help="Folder of another.", parser=given_path, metavar="B")
    ],
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            help="Folder for compare.html; default compare_<A>_<B>.",
            parser=given_path,
            metavar="PATH",
        ),
    ] = None,
    quiet: Quiet = False,
    as_json: AsJson = False,
) -> None:
    """Compare two runs: inputs that differ, results side by side, curves over one another."""
    from vanelock.commands.compare import compare_runs
    from vanelock.pipeline.progress import choose_listener

    with choose_listener(quiet, as_json) as listener:
        compare_runs(one, other, output, listener)


@app.command()
def page(
    folder: Annotated[Path, typer.Argument(help="Folder of a run.", parser=given_path)],
    quiet: Quiet = False,
    as_json: AsJson = False,
) -> None:
    """Draw a run's tables, pictures and page again, from its results alone."""
    from vanelock.commands.stored.run import show_again
    from vanelock.pipeline.progress import choose_listener

    with choose_listener(quiet, as_json) as listener:
        show_again(folder, listener)


@app.command(
    "optimise",
    help="Find the friction, interference or stiffness with which the largest peak is smallest.",
)
@app.command(
    "fit", help="Fit friction, stiffness, interference, load or damping to measured curves."
)
def search(
    context: typer.Context,
    study: StudyFile,
    output: Output = None,
    allow_outside: Outside = False,
    quiet: Quiet = False,
    as_json: AsJson = False,
) -> None:
    """Find values of a study's keys."""
    from vanelock.files import read_text

    found_by = getattr(vanelock, f"{context.info_name}_study")
    with _begun(study, output, allow_outside, quiet, as_json, searches=True) as begun:
        found_by(*begun, read_text(study), study.parent)


@app.command()
def check(
    file: Annotated[
        Path,
        typer.Argument(
            help="Study file, results.h5 or the folder of a run.", parser=given_path, metavar="FILE"
        ),
    ],
    allow_outside: Outside = False,
    quiet: Quiet = False,
    as_json: AsJson = False,
) -> None:
    """Check a file without computing: what a study would compute, what results hold."""
    from vanelock.commands.check.file import check_file
    from vanelock.pipeline.progress import choose_listener

    with choose_listener(quiet, as_json) as listener:
        listener(check_file(file, allow_outside))


@contextmanager
def _begun(
    study: Path,
    output: Path | None,
    outside: bool,
    quiet: bool,
    as_json: bool,
    searches: bool = False,
) -> "Iterator[tuple[Study, Path, Listener]]":
    """A study, the folder of its run and a listener, for a command that works with them."""
    from vanelock.files import load_study
    from vanelock.pipeline.progress import choose_listener

    loaded, folder = load_study(study, outside), output or default_folder(study)
    searched = study if searches else None
    with _going_on_later(folder, searched), choose_listener(quiet, as_json) as listener:
        yield loaded, folder, listener


@contextmanager
def _going_on_later(folder: Path, searched: Path | None = None) -> Iterator[None]:
    require_least()
    try:
        yield
    except process.Stopped as stopped:
        process.answered()
        on = "begins the search anew, with these" if searched else "goes on from there"
        kept = "meshes and reduced models are" if searched else "finished work is"
        _say(f"stopped; {kept} kept in {folder}, and the same command {on}")
        raise typer.Exit(stopped.status) from None
    except InputError as error:
        if searched and str(error).startswith(("fit", "optimise")):
            raise InputError(f"{searched}: {error}") from None
        raise


@app.command()
def init(
    path: Annotated[
        Path | None,
        typer.Argument(
            help="File to write, of some examples a folder; default study.toml, or the example's.",
            parser=given_path,
            metavar="PATH",
        ),
    ] = None,
    scene: Annotated[
        bool, typer.Option("--scene", help="A scene of your own matrices instead of a study.")
    ] = False,
    all_keys: Annotated[
        bool, typer.Option("--all", help="Every key with its default, not only the first to set.")
    ] = False,
    example: Annotated[
        str | None,
        typer.Option(
            help="One of the examples instead, with its data.",
            autocompletion=example_names,
            metavar="NAME",
        ),
    ] = None,
) -> None:
    """Write a commented study file, or an example."""
    if example is not None:
        if scene or all_keys:
            raise InputError("--example: expected without --scene and --all")
        written = write_example(example, path)
        print(f"{written} written; {how_to_use(written)}")
        return
    path = path or Path("study.toml")
    write_template(path, "scene" if scene else "study", all_keys)
    print(f"{path} written; run it with: vanelock run {path}")


@app.command()
def manual(
    page: Annotated[
        str | None,
        typer.Argument(
            help="Page to print; default: the list of them.",
            autocompletion=page_names,
            metavar="PAGE",
        ),
    ] = None,
) -> None:
    """Print a page of the manual, or list them."""
    show(page)


@app.command()
def completion(
    shell: Annotated[Shell, typer.Argument(help="The shell that you type in.", metavar="SHELL")],
) -> None:
    """Print what makes the Tab key complete vanelock's words in bash, zsh or fish."""
    print(
        get_completion_script(
            prog_name="vanelock", complete_var="_VANELOCK_COMPLETE", shell=shell.value
        )
    )


add_guidance(app.registered_commands)


def main(arguments: list[str] | None = None) -> None:
    """Run the command line and exit with its status."""
    completion_init()
    # The matrices are small: a second thread gains little on an idle machine, and where other
    # programs run too the threads wait for one another (three times slower, measured).
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ.setdefault(f"{library}_NUM_THREADS", "1")
    keep_freed()
    with process.guarded(), process.raised():
        status = _status(arguments)
    sys.exit(status)


def _status(arguments: list[str] | None) -> int:
    try:
        status: int = app(arguments, prog_name="vanelock", standalone_mode=False) or 0
        process.raise_dropped()
        sys.stdout.flush()
        return status
    except InputError as error:
        lines = str(error).splitlines()
    except process.Stopped as stopped:
        process.answered()
        _say("stopped")
        return stopped.status
    except process.Lost as lost:
        if lost.unread:
            return 141
        lines = [str(lost)]
    except MemoryError as error:
        lines = [refusal(error)]
    except (ImportError, OSError) as error:  # LLVM's is the latter
        if not is_shortage(error):
            raise
        lines = [refusal(MemoryError("a library cannot be loaded"))]
    except Exception as error:
        # typer's own errors (unknown option, missing argument); it does not export their class.
        if not hasattr(error, "format_message"):
            raise
        lines = [error.format_message()]
    for line in first_mistakes(lines):
        _say(cut_short(printable(line)))
    return 2


def _say(line: str) -> None:
    """A line on standard error, if that can be written."""
    with suppress(process.Lost):
        print(f"vanelock: {line}", file=sys.stderr)


if __name__ == "__main__":
    main()
