"""Numbers, words, values and lines that do not belong where `mutations` puts them."""

NUMBERS = [
    b"nan", b"inf", b"-inf", b"1e999", b"-1", b"0", b"-0.0", b"1e-320", b"1e308", b"4294967296",
    b"-2147483648", b"9223372036854775807", b"18446744073709551616", b"1" * 5000,
    b"0x" + b"f" * 5000, b"1_0", b".5", b"1e", b"99999999", b"0b1", b"1D5", b"1+5", b"--1",
    b"\xd9\xa3", b"0.1.1",
]  # fmt: skip

WORDS = [
    b"", b" ", b"\0", b"\x1b[31mred\x1b[0m", b"\x07", b"\r", b"\t", b"\x7f", b"\xe2\x80\xa8",
    b"\xe2\x80\xae", b"\xff\xfe", b"\xed\xa0\x80", b"<script>alert(1)</script>", b"$\\frac$",
    b"%s%n{0}{x}", b"../../../../etc/passwd", b"/etc/passwd", b"/dev/zero", b"=cmd|' /C calc'!A0",
    b"a" * 300, b"a" * 70000, b"\xf0\x9f\x92\xa3", b"'", b'"', b'"""', b"\\", b"\\u0000", b"[",
    b"]", b"[[", b"{", b"}", b",", b"=", b"#", b"*", b"$", b"<", b">", b"&lol;", b"None", b"true",
    b"__import__('os').system('x')", b"1979-05-27T07:32:00Z",
]  # fmt: skip

VALUES = [
    b'"9^9^9^9 m"', b'"9\xe2\x81\xb9\xe2\x81\xb9\xe2\x81\xb9\xe2\x81\xb9 m"', b'"1e999 mm"',
    b'"1 cubed cubed cubed m"', b"1e400", b"-1e400", b"nan", b"inf", b"9223372036854775808",
    b"-9223372036854775809", b"[" + b"1," * 5000 + b"]", b"[[1,2],[3,[4,[5]]]]", b"{a={b={c=1}}}",
    b"[nan]", b"[]", b"{}", b"''", b'"\\u001b[2J"', b'"\\u0000"', b'"\\U0010FFFF\\u2028</script>"',
    b'"../secret.csv"', b'"/etc/passwd"', b'"link/secret.csv"', b'"."', b'"/dev/zero"', b"true",
    b"1979-05-27", b"07:32:00", b'"5 m"', b'"1 kg"', b"'''\nmany\nlines'''", b"1000000000",
    b"[1, 'a', true, 2020-01-01]", b'"$\\\\frac{$ {0} %s"', b'"' + b"y" * 5000 + b'"', b"1e-320",
    b"0.1", b"1", b"2", b'"coarse"', b'["a","a"]', b"[[1e3,1e9],[2e3,1e9]]",
]  # fmt: skip
"""Of a TOML file."""

KEYS = [
    b"[a.b.c]", b"[[vane]]", b"[sweep]", b'"" = 1', b'"\\n" = 1', b"[measured]", b"[]",
    b'"../x" = 1', b"__proto__ = 1", b"x = 1\n" * 2000, b'"a\\u001b" = 2', b"[ring.x]", b"[vane]",
    b"chord = 1", b"aerofoils = 2", b'mesh.size = "coarse"', b"[joints.interlock]", b"[response]",
]  # fmt: skip
"""Tables and keys that do not belong there, or are there already."""

CARDS = [
    b"*NSET, NSET=A, GENERATE\n1, 9999999, 1", b"*NSET, NSET=A\nA",
    b"*NSET, NSET=A\nB\n*NSET, NSET=B\nA", b"*ELEMENT, TYPE=C3D4\n1, 1, 1, 1, 1",
    b"*NODE\n1, nan, inf, 1e400", b"*INCLUDE, INPUT=/etc/passwd",
    b"*ELEMENT, TYPE=C3D10, ELSET=x\n9,", b"*SURFACE, NAME=x\nx, S9",
    b"*NSET, NSET=hook_front, ELSET=x", b"SET1,1,1,THRU,9999999",
    b"SET 1 = 1 THRU 9999999, EXCEPT 5", b"GRID,1,1.+400,nan,inf", b"+,1,2,3",
    b"CTETRA,1,1,1,1,1,1", b"INCLUDE '/dev/zero'", b"SET1,1,EXCEPT,EXCEPT,THRU", b"ENDDATA",
    b"GRID*", b"$Nodes\n1 99999999 1 99999999", b"$Elements\n1 1 1 99999999999",
    b"$PhysicalNames\n999999999", b"$Periodic\n999999", b"$EndNodes", b"$MeshFormat\n4.1 1 8",
    b"POINTS 99999999 double", b"CELLS 9999999 99999999", b"$Comments", b"$Nodes\n-1 -1 -1 -1",
    b"*NSET, NSET=A, GENERATE\n5,1,-1",
]  # fmt: skip
"""Of mesh files as text."""

ROWS = [
    b"1 1 1e400", b"99999999 99999999 1",
    b"%%MatrixMarket matrix array real general\n99999999 99999999", b"1 1 nan", b"-1 -1 -1",
    b"0 0 0", b"%", b"DMIG,K,0,6,1,0,,9999999", b"DMIG*   K", b"1,1,1,1,1",
    b"*MATRIX, TYPE=STIFFNESS", b"*USER ELEMENT, NODES=9999999, LINEAR",
    b"99999999999999999999 1 1", b"%%MatrixMarket matrix coordinate pattern symmetric",
    b"3 3 999999999", b"RSA 999999999 999999999", b"(99999999I99999999)", b"1,x\n1,x",
    b"node,direction", b"9999999999,z", b"1;2;3", b"DMI,K,0,2,1,1,9,9",
]  # fmt: skip
"""Of files of matrices as text."""
BOMB = (
    b'<!DOCTYPE l [<!ENTITY a "aaaaaaaaaa">'
    + b"".join(b'<!ENTITY %c "%s">' % (c, b"&%c;" % (c - 1) * 10) for c in range(98, 110))
    + b"]>"
)
