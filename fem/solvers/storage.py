"""How much memory a factorisation takes, known before it is made from its number of rows.

Nested dissection of a surface leaves O(n log n) entries in the factor, of a solid O(n^(4/3)); parts
with walls of one or two elements lie near the former:

    bytes(n) = B n (n / 30,000)^P

fitted to both parts of the example with elements of 4.8 to 25 mm (docs/benchmarks/memory.md).
"""

from vanelock.common.process import memory

BYTES, POWER = 2450.0, 0.1
"""B and P, of the real factor of a definite matrix by CHOLMOD."""
TIMES = {"cholmod": 1.3, "pardiso": 1.9, "superlu": 4.5}
"""Memory while factors are made, over that: docs/benchmarks/factorisation.md."""
SCHUR = 3.7
"""The same with a Schur complement, which is read from a copy of the factor."""


def factor_bytes(rows: int, is_complex: bool = False) -> float:
    """Bytes that CHOLMOD's factor of a symmetric matrix of so many rows holds, to about 30 %."""
    return (2 if is_complex else 1) * BYTES * rows * float((rows / 3e4) ** POWER)


def require(rows: int, is_complex: bool, times: float) -> None:
    """Refuse a factorisation that takes more memory than is left."""
    memory.require(times * factor_bytes(rows, is_complex), f"factorising {rows:,} rows")
