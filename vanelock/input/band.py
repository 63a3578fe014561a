"""Up to which frequency reduced models have to answer, and what is refused beyond it.

The band follows what a study or a scene asks for, unless a band or numbers of modes are given.
Higher harmonics of the response may lie beyond it: they are small, and what reduced models leave
out of them is inertia alone (docs/theory/reduction.md has figures).
"""

import math
from collections.abc import Mapping
from typing import Any

from vanelock.common.errors import InputError
from vanelock.input.schema.structure.temperature import PARTS
from vanelock.rom.system.system import MARGIN, wider_band

STEPS = 3
"""Bands are chosen in so many steps an octave, so that a little wider range needs no new models."""
LEAST = 1024.0
"""Least band of a vane and its casing, Hz: any range below it needs no new models."""


def asked_for(response: Any) -> dict[str, float]:
    """Highest frequency that each key of a table `[response]` asks for, Hz, where it is given."""
    given = {name: getattr(response, name) for name in ("range", "frequencies")}
    return {f"response.{name}": max(each) for name, each in given.items() if each is not None}


def asked_by(study: Any) -> dict[str, float]:
    """The same of a study or scene, with what a study's Campbell diagram asks for."""
    found, keys = asked_for(study.response), getattr(study, "campbell", None)
    if keys is not None and keys.speeds is not None:
        order = max(abs(each) for each in (*keys.engine_orders, study.excitation.engine_order))
        found["campbell.speeds"] = keys.speeds[1] * order / 60
    return found


def least_band(
    asked: Mapping[str, float], softest: float = 1.0, least: float = 0.0
) -> float | None:
    """Frequency that a band reaches at least, Hz; None where nothing is asked for."""
    least = max(least, MARGIN * max(asked.values(), default=0.0) / math.sqrt(softest))
    if not least:
        return None
    return float(2 ** (math.ceil(STEPS * math.log2(least)) / STEPS))


def softest(study: Any) -> float:
    """The lowest modulus that a part of a `Study` may come to over that of its reduction, or 1."""
    if study.accuracy is not None:  # reduced at the modulus of the response
        return 1.0
    heated = [
        getattr(study.material, p) for p in PARTS if getattr(study.temperature, p) is not None
    ]
    cold = study.temperature.reference
    return min([1.0, *(float(E / m.modulus(cold)) for m in heated for _, E in m.moduli)])


def refuse_beyond(what: str, highest: float, band: float | None, study: Any) -> None:
    """Refuse a frequency, Hz, beyond what reduced models of a study or scene answer."""
    if band is not None and highest > band:
        raise InputError(
            f"{what} reaches {highest:.6g} Hz, and the reduced models answer up to {band:.6g} Hz: "
            + _advice(study, wider_band(highest))
        )


def _advice(study: Any, band: float) -> str:
    """What to write into a study or scene for a wider band, Hz."""
    if not hasattr(study, "rom"):
        where = "for the reduced components, instead of modes or a cutoff if any"
        return f'write band = "{band:g} Hz" {where}'
    if study.rom.route != "cyclic":
        return 'give more rom.modes, or choose rom.route = "cyclic"'
    if study.rom.modes:
        return "leave out rom.modes, and they answer as far as is asked for"
    return "write response.range: they answer as far as it reaches"
