"""The nodes' numbers in a Gmsh file, which meshio does not keep."""

import numpy as np
from numpy.typing import NDArray


def node_numbers(data: bytes) -> NDArray[np.int64] | None:
    """Numbers of the nodes in the order of a .msh file of version 2 or 4.1; None of any other."""
    words = _after(data, b"$MeshFormat", 200)[:200].split()
    try:
        version, binary = words[0].decode(), words[1] == b"1"
        nodes = _after(data, b"$Nodes", None)
        if version.startswith("2"):
            return _version_2(nodes, binary)
        if version in ("4", "4.1"):
            return _binary(nodes) if binary else _text(nodes)
    except (ValueError, IndexError, UnicodeDecodeError, OverflowError, MemoryError):
        pass
    return None


def _after(data: bytes, name: bytes, count: int | None) -> bytes:
    start = data.find(name + b"\n")
    skip = len(name) + 1
    if start < 0:
        start, skip = data.find(name + b"\r\n"), len(name) + 2
    if start < 0:
        return b""
    begin = start + skip
    return data[begin:] if count is None else data[begin : begin + count]


def _version_2(nodes: bytes, binary: bool) -> NDArray[np.int64]:
    first, _, rest = nodes.partition(b"\n")
    count = int(first)
    if binary:
        record = np.dtype([("number", "<i4"), ("place", "<f8", 3)])
        return np.frombuffer(rest, record, count)["number"].astype(np.int64)
    lines = rest.split(b"\n", count)[:count]
    return np.array([int(line.split(None, 1)[0]) for line in lines], np.int64)


def _text(nodes: bytes) -> NDArray[np.int64]:
    lines = iter(nodes[: max(nodes.find(b"$EndNodes"), 0)].splitlines())
    blocks = int(next(lines, b"").split()[0])
    found: list[int] = []
    for _ in range(blocks):
        count = int(next(lines, b"").split()[3])
        found += [int(next(lines, b"")) for _ in range(count)]
        for _ in range(count):
            next(lines, b"")
    return np.array(found, np.int64)


def _binary(nodes: bytes) -> NDArray[np.int64]:
    blocks = int(np.frombuffer(nodes, "<u8", 4)[0])
    at, found = 32, [np.empty(0, np.int64)]
    for _ in range(blocks):
        parametric = int(np.frombuffer(nodes, "<i4", 3, at)[2])
        count = int(np.frombuffer(nodes, "<u8", 1, at + 12)[0])
        found.append(np.frombuffer(nodes, "<u8", count, at + 20).astype(np.int64))
        at += 20 + count * (8 + 24)
        if parametric:
            raise ValueError
    return np.concatenate(found)
