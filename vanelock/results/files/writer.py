"""Writes what a run leaves: an index, and files that are written once; see `results_file`."""

import os
import shutil
import time
from collections.abc import Generator
from contextlib import contextmanager, suppress
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import h5py
import numpy as np

from vanelock.common.errors import FolderError, InputError
from vanelock.common.files.digests import BLOCK, NAMED, NEEDS, file_digest, stamp
from vanelock.common.files.files import writing
from vanelock.common.files.hdf5 import written
from vanelock.common.process import held
from vanelock.common.product import Product
from vanelock.input.cases.names import slug
from vanelock.results.files.results_file import FORMAT, PARTS, VERSION, WHOLE, open_results
from vanelock.rom import Component, System

SELDOM = 20.0
"""Additions to the index appear when so many times what that took last has passed since."""
LONGEST = 150
"""Characters of a file's name before its digest."""


class Results:
    """The results of a run in progress.

    The index is added to in a copy beside it. The copy is copied over it when that is due: at the
    first addition, at the end, and between them so seldom that it takes little of the time. So all
    is whole at any moment; of a sweep the last cases may be lacking, whose products are in the
    cache.
    """

    def __init__(self, path: Path) -> None:
        self.path, self._folder = path, path.with_name(PARTS)
        self._own = path.with_name(f".{path.name}.{os.getpid()}.tmp")
        self._begun = self._behind = self._waits = False
        self._flushed = self._took = 0.0
        self._parts: dict[str, str] = {}
        """File of each place."""
        self._needs: dict[str, set[str]] = {}
        """Files that each of these needs."""
        self._used: set[str] = set()
        """Files that the one under way needs."""
        self._taken: dict[str, str] = {}
        """File of each product that cases may share."""

    def wait_for_the_end(self, settings: str) -> None:
        """Keep a complete file of the same settings until this one is complete, too."""
        with suppress(InputError), open_results(self.path, complete=False) as file:
            known = file.get("provenance")
            earlier = None if known is None else known.attrs.get("settings")
            self._waits = bool(file.attrs.get("complete")) and earlier == settings

    @contextmanager
    def edit(self, *places: str) -> Generator[h5py.File, None, None]:
        """A file, open for additions that appear all at once or not at all, if not at once."""
        with held(), self._opened() as index:
            if not places:
                yield index
                return
            known = self._parts.get(places[0], "")
            self._used = set(self._needs.get(known, ()))
            with self._new(places[0].removeprefix("response/"), known) as (file, name):
                yield file
                file.attrs[NEEDS] = "/".join(sorted(self._used))
            self._needs[name[0]] = self._used
            former = [p for p, part in self._parts.items() if part == known] if known else []
            for place in dict.fromkeys((*former, *places)):
                self._parts[place] = name[0]
                if place in former:
                    del index[place]
                index[place] = h5py.ExternalLink(f"{PARTS}/{name[0]}", f"/{place}")

    @contextmanager
    def _new(self, label: str, template: str = "") -> Generator[tuple[h5py.File, list[str]]]:
        """A file of the folder, beginning as a known one, and its name when all is written."""
        label, name = slug(label)[:LONGEST], list[str]()
        temporary = self._folder / f".{label}.{os.getpid()}.tmp"
        with writing(self._folder):
            self._folder.mkdir(exist_ok=True)
            try:
                if template:
                    shutil.copyfile(self._folder / template, temporary)
                with written(temporary, "a" if template else "w") as file:
                    yield file, name
                name.append(f"{label}-{file_digest(temporary)}.h5")
                os.replace(temporary, self._folder / name[0])
            finally:
                temporary.unlink(missing_ok=True)

    def put(self, file: h5py.File, where: str, product: Product) -> None:
        """Write a product at a path of a file; of one that the cache holds, links to its parts."""
        group = file.require_group(where)
        name = None if product.stored is None else self._take(product.stored)
        if name is None:
            product.save(group)
        else:
            self._used.add(name)
            with h5py.File(self._folder / name, "r") as found:
                group.attrs.update(found["product"].attrs)
                for each in found["product"]:
                    group[each] = h5py.ExternalLink(name, f"/product/{each}")

    def put_system(self, file: h5py.File, where: str, system: System) -> None:
        """Write a system; its matrices into a file that all systems with the same ones share."""
        key = _digest(system)
        if key not in self._taken:
            with self._new("matrices") as (shared, name):
                system.save(shared.create_group("product"))
            self._taken[key] = name[0]
        self._used.add(self._taken[key])
        self.put(file, where, replace(system, diameters={}))
        file[where]["nd"] = h5py.ExternalLink(self._taken[key], "/product/nd")

    def put_component(self, file: h5py.File, where: str, component: Component) -> None:
        """Write a reduced part; of one that the cache has the matrices, and where it is as a whole.

        Its matrices can be reached as `<where>/<nodal diameter>` too.
        """
        slim = component
        if component.stored is not None:
            without = {"vectors": None, "neglected": None}
            diameters = {k: replace(each, **without) for k, each in component.diameters.items()}
            slim = replace(component, vectors=None, diameters=diameters)
        self.put(file, where, slim)
        group = file[where]
        if component.stored is not None:
            group.attrs[WHOLE] = os.path.relpath(component.stored, self.path.parent)
        for k in component.diameters:
            group[str(k)] = group[f"diameters/{k}"]

    def _take(self, stored: Path) -> str | None:
        """Name a file of the cache in the folder, too; None where it is gone."""
        place = self._folder / stored.name
        if stored.name in self._taken:
            return stored.name
        temporary = self._folder / f".{stored.name}.{os.getpid()}.tmp"
        with writing(self._folder):
            try:
                if not (place.exists() and place.samefile(stored)):
                    try:
                        os.link(stored, temporary)
                    except OSError:  # a file system without such links
                        shutil.copyfile(stored, temporary)
                    os.replace(temporary, place)
            except FileNotFoundError:
                return None
            finally:
                temporary.unlink(missing_ok=True)
        return self._taken.setdefault(stored.name, stored.name)

    def _tidy(self) -> None:
        """Remove files that no case needs: they are of other results, or were written anew."""
        current = {*self._parts.values()}
        for part in {*current}:
            current |= self._needs[part]
        for path in self._folder.glob("*.h5"):
            if NAMED.search(path.name) and path.name not in current:
                path.unlink(missing_ok=True)

    @contextmanager
    def _opened(self) -> Generator[h5py.File, None, None]:
        with writing(self.path):
            try:
                if (self._behind or (self._begun and self._waits)) and not self._own.exists():
                    raise FolderError(f"{self._own}: was removed while the run was writing it")
                if self._begun and not self._own.exists():
                    shutil.copyfile(self.path, self._own)
                with written(self._own, "a" if self._begun else "w", BLOCK) as file:
                    if not self._begun:
                        file.attrs["format"] = FORMAT
                        file.attrs["version"] = VERSION
                        file.attrs["complete"] = False
                    yield file
            except BaseException:
                self.abandon()
                raise
        self._begun = self._behind = True
        self.flush_if_due()

    def flush_if_due(self) -> None:
        """Let additions appear, if showing them last took little of the time since then."""
        if self._waits:
            return
        if self._behind and time.perf_counter() - self._flushed >= SELDOM * self._took:
            self.flush()

    def flush(self) -> None:
        """Let all additions appear."""
        if not self._behind or self._waits:
            return
        began = time.perf_counter()
        shown = self._own.with_name(f"{self._own.name.removesuffix('.tmp')}.shown.tmp")
        with writing(self.path):
            try:
                shutil.copyfile(self._own, shown)
                stamp(shown)
                os.replace(shown, self.path)
            finally:
                shown.unlink(missing_ok=True)
        self._behind = False
        self._flushed = time.perf_counter()
        self._took = self._flushed - began

    def end(self) -> None:
        """Let all additions appear; there are no more for now. Files of earlier results go."""
        self._waits = False
        if self._behind and not self._own.exists():
            raise FolderError(f"{self._own}: was removed while the run was writing it")
        if self._own.exists():
            with writing(self.path):
                stamp(self._own)
                os.replace(self._own, self.path)
                self._tidy()
        self._behind = False

    def abandon(self) -> None:
        """Drop what has not appeared."""
        self._own.unlink(missing_ok=True)
        self._behind = False


def _digest(system: System) -> str:
    """Digest of a system's matrices."""
    digest = sha256()
    for k, matrices in sorted(system.diameters.items()):
        for name, value in vars(matrices).items():
            if isinstance(value, np.ndarray):
                digest.update(f"{k} {name} {value.dtype.str} {value.shape} ".encode())
                digest.update(np.ascontiguousarray(value).data)
    return digest.hexdigest()
