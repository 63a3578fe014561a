"""The hysteresis loop of the contact that dissipates most at a case's peak."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from vanelock import nonlinear, render
from vanelock.input.cases.names import of_case, slug, words
from vanelock.nonlinear import Response
from vanelock.quantities.contacts.wear import exact
from vanelock.quantities.run_result import Floats, RunResult
from vanelock.report import Picture
from vanelock.stages.parts.places import tangents
from vanelock.stages.plan import Planned


@dataclass(frozen=True)
class Loop:
    """A contact's period at the only point of a response.

    Attributes
    ----------
    top : Response
        One point.
    contact : int
        Which contact.
    tangents : (str, str)
        What its friction directions are called.
    """

    top: Response
    contact: int
    tangents: tuple[str, str] = ("tangent 1", "tangent 2")

    @cached_property
    def history(self) -> tuple[Floats, Floats]:
        """(s, 3) displacements, m, and forces, N, at equal steps of the period."""
        found: tuple[Floats, Floats] = nonlinear.contact_loop(self.top, 0, self.contact)
        return found

    @property
    def mu(self) -> float:
        """Friction coefficient."""
        return float(self.top.mu[self.contact])

    @property
    def bounding(self) -> Floats | None:
        """(s,) normal force that bounds friction where it is not the instant's, N."""
        if self.top.coupling != "constant-load":
            return None
        return np.full(len(self.history[1]), self.top.force[0, 0, self.contact, 0].real)

    @property
    def isotropic(self) -> bool:
        """Whether friction is bounded in the plane of both directions."""
        return bool(self.top.friction == "isotropic")

    @property
    def bound(self) -> Floats:
        """(s,) what bounds friction, N."""
        load = self.history[1][:, 0] if self.bounding is None else self.bounding
        return self.mu * load

    def columns(self) -> Mapping[str, ArrayLike]:
        """The period as columns."""
        u, f = self.history
        return {
            "time / period (-)": np.arange(len(u)) / len(u),
            "normal displacement v (µm)": 1e6 * u[:, 0],
            **{f"displacement, {d} (µm)": 1e6 * u[:, i + 1] for i, d in enumerate(self.tangents)},
            "normal force n (N)": f[:, 0],
            **{f"friction force, {d} (N)": f[:, i + 1] for i, d in enumerate(self.tangents)},
            "friction limit mu n (N)": self.bound,
        }


def loops(run: RunResult, each: Planned) -> list[Picture]:
    """The loop of a case, where there is one."""
    top, name = run.top(each), each.case.name
    contacts = run.stages.get(each.system).contacts
    own = np.flatnonzero(contacts.opens & contacts.springs).tolist()
    if not exact(top) or not own or not top.dissipation[0, own].any():
        return []
    contact = max(own, key=lambda i: float(top.dissipation[0, i]))
    joint = contacts.joints[contact]
    loop = Loop(top, contact, tangents(run.given, joint))
    frequency = run.peak(name).frequency
    heading = f"contact {contacts.joints[: contact + 1].count(joint)} of {joint}"
    title = f"C{heading[1:]} at {frequency:.2f} Hz"
    shows = [each.response.key, title, name, run.monitor.name]
    given: dict[str, Any] = {"isotropic": loop.isotropic, "tangents": loop.tangents}

    def draw(path: Path) -> None:
        given["bounding"] = loop.bounding
        render.loop_picture(path, *loop.history, loop.mu, title, words(name), **given)

    notes = [f"{run.given.name}: {title}{of_case(name)}, one period"]
    caption = (
        f"C{heading[1:]}, the one that dissipates most, over one "
        f"period at the peak, {frequency:.2f} Hz{of_case(name)}. Left: friction force over "
        "relative displacement; the enclosed area is the energy dissipated per cycle. On the "
        "dashed limits ±μn the contact slips, on the steep flanks it sticks. Right: normal and "
        "friction force over the period; the limits follow the normal force."
    )
    file, heading = f"figures/loop_{slug(name)}", f"Hysteresis of {heading}"
    return [run.picture(file, heading, shows, draw, loop.columns, notes, caption)]
