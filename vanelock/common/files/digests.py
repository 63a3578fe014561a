"""Digests of what an HDF5 file holds, so that damage and mix-ups are noticed.

A sealed group has the digest of its attributes and of all that lies in it, names included, as an
attribute; a group in it that was sealed before counts with its own. So a group can be added to a
file, or lie at two places of it, without its numbers being read again. One that was sealed with its
place says whether it lies where it was written.

No protection from intent: whoever alters a file can write digests that fit. The library's inner
interface is used for its speed: files hold many small data sets.
"""

import hashlib
from collections.abc import Callable
from typing import Any

import h5py
import numpy as np

from vanelock.common.errors import InputError, printable

DIGEST, PLACE = "digest", "written at"


def seal(group: h5py.Group, placed: bool = True) -> bytes:
    """Write the digest of a group, and of those below it that have none.

    Parameters
    ----------
    group : Group
        What it holds may change no more, unless it is sealed again.
    placed : bool
        Whether it belongs where it is; one that lies at several places belongs to the first.

    Returns
    -------
    bytes
        The digest.
    """
    if placed:
        group.attrs[PLACE] = group.name

    def below(inner: h5py.h5g.GroupID) -> bytes:
        if h5py.h5a.exists(inner, DIGEST.encode()):
            return h5py.Group(inner).attrs[DIGEST].tobytes()  # type: ignore[no-any-return]
        return seal(h5py.Group(inner), False)

    found = _digest(group.id, below)
    group.attrs[DIGEST] = np.frombuffer(found, np.uint8)
    return found


def verify(group: h5py.Group, complete: bool = True) -> None:
    """Refuse a group that does not hold what was written, or does not lie where it was.

    Parameters
    ----------
    group : Group
        A sealed one, or a file.
    complete : bool
        Whether all groups must be sealed; else the root and those that hold nothing but groups
        need not be.

    Raises
    ------
    InputError
        Naming the file and the innermost group that differs.
    """
    known: dict[int, bytes] = {}

    def checked(inner: h5py.h5g.GroupID) -> bytes:
        address = h5py.h5o.get_info(inner).addr
        if address not in known:
            try:
                known[address] = _checked(h5py.Group(inner), complete, checked)
            except InputError:
                raise
            except (KeyError, OSError, RuntimeError, TypeError, UnicodeError, ValueError) as error:
                reason = printable((str(error).splitlines() or [""])[0])
                raise InputError(f"{_where(inner)}: cannot be checked ({reason})") from None
        return known[address]

    above = group
    while above.name != "/":
        above = above.parent
        _refuse_moved(above)
    checked(group["/"].id if isinstance(group, h5py.File) else group.id)


def _refuse_moved(group: h5py.Group) -> None:
    place = group.attrs.get(PLACE)
    if place is not None and group.file.get(place) != group:
        told = f"was written as {printable(str(place))}, and moved since"
        raise InputError(f"{_where(group.id)}: {told}")


def _where(group: h5py.h5g.GroupID) -> str:
    name = (h5py.h5i.get_name(group) or b"?").decode("utf-8", "replace")
    return f"{h5py.Group(group).file.filename}: {printable(name)}"


def _checked(
    group: h5py.Group, complete: bool, below: Callable[[h5py.h5g.GroupID], bytes]
) -> bytes:
    _refuse_moved(group)
    where, stated = _where(group.id), group.attrs.get(DIGEST)
    found = _digest(group.id, below)
    if stated is None:
        holds = group.name != "/" and (
            len(group.attrs) > 0 or any(isinstance(each, h5py.Dataset) for each in group.values())
        )
        if complete or holds:
            raise InputError(f"{where}: lacks the digest that it was written with")
    elif np.asarray(stated).tobytes() != found:
        raise InputError(f"{where}: is not what was written: damaged, or altered since")
    return found


def _digest(group: h5py.h5g.GroupID, below: Callable[[h5py.h5g.GroupID], bytes]) -> bytes:
    digest = hashlib.sha256()
    _add_attributes(digest, group)
    for name in sorted(group):
        item = h5py.h5o.open(group, name)
        if isinstance(item, h5py.h5g.GroupID):
            _add(digest, b"group", name, below(item))
        else:
            value = np.empty(item.shape, item.dtype)
            if value.size:
                item.read(h5py.h5s.ALL, h5py.h5s.ALL, value)
            _add_array(digest, name, value)
            _add_attributes(digest, item)
    return digest.digest()


def _add_attributes(digest: Any, item: Any) -> None:
    names: list[bytes] = []
    h5py.h5a.iterate(item, names.append)
    for name in sorted(names):
        if name != DIGEST.encode():
            attribute = h5py.h5a.open(item, name)
            value = np.empty(attribute.shape, attribute.dtype)
            if value.size:
                attribute.read(value)
            _add_array(digest, name, value)


def _add_array(digest: Any, name: bytes, value: Any) -> None:
    _add(digest, name, value.dtype.str.encode(), str(value.shape).encode())
    if value.dtype.kind == "O":
        texts = [each if isinstance(each, bytes) else str(each).encode() for each in value.flat]
        _add(digest, *texts)
    else:
        digest.update(value)


def _add(digest: Any, *parts: bytes) -> None:
    for each in parts:
        digest.update(b"%d:" % len(each) + each)
