"""What a page shows: its tables and cards, as text and numbers."""

import html
import re


def plain(text):
    text = html.unescape(re.sub(r"<[^>]*>", " ", text))
    return text.replace("\xa0", " ").replace("−", "-").strip()


def number(cell):
    return float(cell.replace(",", "")) if re.fullmatch(r"-?[\d.,e+-]+", cell) else cell


def on_page(page, title):
    """Header cells, with their units, and rows of a table."""
    start = page.index(html.escape(title).replace("&#x27;", "&#39;"))
    whole = page[start : page.index("</table>", start)]
    head = [plain(cell) for cell in re.findall(r"<th[^>]*>(.*?)</th>", whole)]
    rows = [
        [number(plain(cell)) for cell in re.findall(r"<td[^>]*>(.*?)</td>", row)]
        for row in re.findall(r"<tr>(.*?)</tr>", whole)
    ]
    return [" ".join(cell.split()) for cell in head], [row for row in rows if row]


def card(page, label):
    found = re.search(
        rf'<div class="label">{label}</div>\s*<div class="value">(.*?)</div>(.*?)</li>', page, re.S
    )
    assert found is not None
    return plain(found[1]), plain(found[2])
