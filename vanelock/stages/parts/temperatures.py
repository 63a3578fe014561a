"""Young's modulus of the parts at their temperatures."""

from vanelock.common.errors import InputError
from vanelock.input.schema.structure.temperature import PARTS
from vanelock.input.schema.study import Study


def modulus(study: Study, part: str, speed: float | None = None) -> float:
    """Young's modulus of a part, Pa: at a rotor speed, rpm, or that of the study's response."""
    heat, metal = study.temperature, getattr(study.material, part)
    if getattr(heat, part) is None or not metal.moduli:
        return float(metal.modulus(heat.reference))
    speed = heat.speed if speed is None else speed
    if speed is None and isinstance(getattr(heat, part), tuple):
        raise InputError("temperature.speed: must be given: the temperatures depend on the speed")
    temperature = heat.of(part, 0.0 if speed is None else speed)
    assert temperature is not None
    return float(metal.modulus(temperature))


def reference(study: Study, part: str) -> float:
    """Young's modulus at which a part is reduced, Pa; other moduli scale what comes of it.

    With an accuracy that of the response, whose meshes and reductions are chosen by their errors.
    """
    if study.accuracy is not None:
        return modulus(study, part)
    return float(getattr(study.material, part).modulus(study.temperature.reference))


def described(study: Study) -> str:
    """What a run says of a study's temperatures; "" without any."""
    heat = study.temperature
    if not heat.given:
        return ""
    words = []
    for part in PARTS:
        E = f"E = {1e-9 * modulus(study, part):.5g} GPa"
        temperature = heat.of(part, heat.speed or 0.0)
        words.append(
            f"{part} {E}" if temperature is None else f"{part} {temperature:.4g} degC, {E}"
        )
    where = "" if heat.speed is None else f" at {heat.speed:,.0f} rpm"
    return f"temperatures of the response{where}: {'; '.join(words)}"
