"""What a PDF says: its words, page by page, and its bookmarks."""

from __future__ import annotations

from pathlib import Path

from pypdf import PdfReader


def pdf_pages(path: Path) -> list[str]:
    """Return the words of each page, one line of text a line."""
    return [page.extract_text().replace("\u200b", "") for page in PdfReader(path).pages]


def pdf_words(path: Path) -> str:
    """Return the words of all pages, with one blank where a line ends."""
    return " ".join(" ".join(pdf_pages(path)).split())


def pdf_bookmarks(path: Path) -> dict[str, int]:
    """Return the titles of the bookmarks in their order, with the page that each leads to, from 0."""
    reader = PdfReader(path)
    flat = [one for entry in reader.outline for one in (entry if isinstance(entry, list) else [entry])]
    return {str(one.title): reader.get_destination_page_number(one) for one in flat}
