"""Every file of the program is written beside its place, which it takes when it is whole."""

import ast
from pathlib import Path

import vanelock

WRITES = {"write_text", "write_bytes", "savez", "savetxt", "tofile", "savefig", "mmwrite", "dump"}
BESIDE = ("placed(", "os.replace(")
"""What a function that writes a file has in it: the file is written beside its place."""
ELSEWHERE = {
    "common/files/hdf5.py:written": "the others call it",
    "pipeline/cache.py:__init__": "grows by records with checksums",
    "results/files/run_folder.py:claimed": "an empty file that is locked",
    "render/style.py:_repr_png_": "in memory",
    "fem/matrix_files/ansys_full.py:_child": "a temporary file, for the parent alone",
    "fem/matrix_files/ansys_full.py:main": "a temporary file, for the parent alone",
}


def test_every_file_is_written_beside_its_place() -> None:
    root = Path(vanelock.__file__).resolve().parent
    found, unknown = 0, []
    stages = [init.parent for init in root.glob("*/__init__.py")]
    for path in sorted([*root.glob("*.py"), *(p for stage in stages for p in stage.rglob("*.py"))]):
        text = path.read_text("utf-8")
        if not any(each in text for each in (*WRITES, "open(", "File(")):
            continue
        for node in ast.walk(ast.parse(text)):
            if not isinstance(node, ast.FunctionDef):
                continue
            calls = [each for each in ast.walk(node) if isinstance(each, ast.Call)]
            if not any(writes(each) for each in calls):
                continue
            own = ast.get_source_segment(text, node) or ""
            found += 1
            place = str(path.relative_to(root))
            known = {place, f"{place}:{node.name}"} & ELSEWHERE.keys()
            if not known and not any(each in own for each in BESIDE):
                unknown.append(f"{place}:{node.name}")
    assert unknown == []
    assert found > 6


def writes(call: ast.Call) -> bool:
    """Whether a call writes a file."""
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if name in WRITES:
        return True
    modes = [each.value for each in call.args if isinstance(each, ast.Constant)]
    modes += [each.value.value for each in call.keywords if isinstance(each.value, ast.Constant)]
    opens = name in ("open", "File")
    return opens and any(m in ("w", "a", "x", "wb", "ab", "xb", "a+b", "r+", "w+b") for m in modes)
