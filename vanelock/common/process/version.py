"""Which vanelock this is: the version that it was installed as, which a tag in git gives."""

from importlib.metadata import distributions


def installed(distribution: str) -> str:
    """Installed version of a distribution, "none" where it is not there.

    A build leaves vanelock.egg-info in the source, which is found first from there; only what was
    installed has a RECORD.
    """
    found = [*distributions(name=distribution)]
    recorded = (each for each in found if each.read_text("RECORD") is not None)
    chosen = next(recorded, found[0] if found else None)
    return "none" if chosen is None else chosen.version


def release(of: str) -> str:
    """A version without what counts commits since a tag: "0.1.0" of "0.1.0.dev12".

    What is kept on the disk is known by this and by a digest of the code, so that a commit that
    changes no code of a step leaves what the step has computed valid.
    """
    return of.partition(".dev")[0]


__version__ = installed("vanelock")
