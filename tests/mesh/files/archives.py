"""Ansys archives written by hand."""

from pathlib import Path

import numpy as np

from vanelock.mesh import Part


def real(x: float) -> str:
    """E21.13E3: an exponent of three digits."""
    mantissa, exponent = f"{x:.13E}".split("E")
    return f"{mantissa}E{int(exponent):+04d}".rjust(21)


def degenerated(path: Path, part: Part, first: int = 11) -> Path:
    """Quadratic tetrahedra as Ansys writes those of a SOLID186: by the manuals, not a library."""
    numbers = np.arange(first, first + len(part.points))
    lines = ["/PREP7", "ET,1,186", f"NBLOCK,6,SOLID,{len(numbers):9d},{len(numbers):9d}"]
    lines.append("(3i9,6e21.13e3)")
    for number, place in zip(numbers.tolist(), 1e3 * part.points, strict=True):
        lines.append(f"{number:9d}{0:9d}{0:9d}" + "".join(map(real, place.tolist())))
    lines += ["N,R5.3,LOC,       -1,", f"EBLOCK,19,SOLID,{len(part.cells):9d},{len(part.cells):9d}"]
    lines.append("(19i9)")
    for element, cell in enumerate(numbers[part.cells].tolist(), 1):
        i, j, k, m, ij, jk, ki, im, jm, km = cell
        corners = [i, j, k, k, m, m, m, m]
        middles = [ij, jk, k, ki, m, m, m, m, im, jm, km, km]
        head = [1, 1, 1, 1, 0, 0, 0, 0, 20, 0, element]
        lines.append("".join(f"{each:9d}" for each in [*head, *corners]))
        lines.append("".join(f"{each:9d}" for each in middles))
    lines.append("       -1")
    for name, nodes in part.node_sets.items():
        own = np.sort(numbers[nodes]).tolist()
        lines.append(f"CMBLOCK,{name.upper():8s},NODE,{len(own):8d}  ! users node component")
        lines.append("(8i10)")
        rows = [own[i : i + 8] for i in range(0, len(own), 8)]
        lines += ["".join(f"{each:10d}" for each in row) for row in rows]
    path.write_text("\n".join([*lines, "/GO", "FINISH"]) + "\n")
    return path
