"""The report of a session is written whole, whatever its runs hold."""

from __future__ import annotations

import base64
import csv
import hashlib
import json
import re
import subprocess
import sys
from dataclasses import replace
from datetime import UTC, datetime
from html.parser import HTMLParser
from importlib import resources
from pathlib import Path
from urllib.parse import unquote

import pytest
from pypdf import PdfReader
from support.pdf_text import pdf_bookmarks, pdf_pages, pdf_words
from support.results import default_setup, drop_result, quiet_result

from radargui.model.errors import CancelledError, FileError
from radargui.model.recording import Block, Excerpt, Gap, Recording
from radargui.model.rounding import quantity
from radargui.processing.result_of_run import result_of_run
from radargui.report.content import Grid
from radargui.report.curves import COMPACT
from radargui.report.facts import RunProvenance, SessionFacts, provenance_of, report_facts
from radargui.report.findings_section import front_chapters
from radargui.report.plots import page_style
from radargui.report.report import REPORT_FILES, PageLayout, WrittenReport, write_report
from radargui.report.run_facts import take_facts
from radargui.report.run_section import run_page
from radargui.report.typesetting import Paper, Typesetter
from radargui.session.session import Session

NOW = datetime(2026, 11, 20, 15, 4, 5, tzinfo=UTC)
EVIL = '<script>alert("1")</script>'
MARKUP = '#panic("x") *a* _b_ $x^2$ \\ [c] `d` @e <f> // g /* h */ ~ -- 20 °C'


class Reader(HTMLParser):
    """Notes every tag, address and open element of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.addresses: list[str] = []
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.addresses += [value or "" for name, value in attributes if name in ("src", "href", "srcset", "action")]
        if tag not in ("meta", "img", "link", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def new_session(folder: Path, *, operator: str = "", notes: str = "") -> Session:
    return Session.create(folder, default_setup(), operator=operator, notes=notes, now=NOW)


def add_run(session: Session, recording: Recording) -> None:
    with session.new_run(recording.digitisation, started_at=NOW.isoformat()) as writer:
        writer.write(Block(recording.raw, 0))


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> tuple[Session, WrittenReport, list[float]]:
    """A session of a drop, a quiet run and a broken file, and its report."""
    session = new_session(tmp_path_factory.mktemp("data"), operator=EVIL, notes=f"=1+1\n{MARKUP}")
    add_run(session, drop_result(rate_hz=8000.0).recording)
    add_run(session, quiet_result(samples=2000).recording)
    (session.path / "run-0003.h5").write_bytes(b"this is no run file")
    shares: list[float] = []
    return session, write_report(session, result_of_run, progress=shares.append, now=NOW), shares


def test_the_report_lies_in_the_sessions_own_folder_and_nothing_else_does(
    made: tuple[Session, WrittenReport, list[float]],
) -> None:
    session, report, _ = made
    names = sorted(path.name for path in (session.path / "report").iterdir())
    assert names == sorted(REPORT_FILES)
    assert report.pdf == session.path / "report" / "report.pdf"


def test_progress_rises_to_one(made: tuple[Session, WrittenReport, list[float]]) -> None:
    shares = made[2]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


def test_the_pdf_has_one_page_a_run_bookmarks_and_fonts_and_says_who_made_it(
    made: tuple[Session, WrittenReport, list[float]],
) -> None:
    reader = PdfReader(made[1].pdf)
    titles = ["Session 2026-11-20T15-04-05", "Runs and series", "Setup and provenance", "Methods and citation"]
    runs = ["Run 0001", "Run 0002 (no motion)", "Run 0003 (failed)"]
    leads = pdf_bookmarks(made[1].pdf)
    assert list(leads) == [*titles, *runs]
    assert list(leads.values()) == sorted(leads.values())
    # notes and script of the operator may take a line more, never a page
    assert [leads[run] for run in runs] == list(range(len(reader.pages) - len(runs), len(reader.pages)))
    for title, number in leads.items():
        assert title in reader.pages[number].extract_text()
    about = reader.metadata
    assert about is not None
    assert about.title == "RadarGUI report: 2026-11-20T15-04-05"
    assert about.author == EVIL
    assert about.subject.startswith("RadarGUI")
    fonts = [font for page in reader.pages for font in page["/Resources"]["/Font"].values()]
    assert all("FontFile" in str(one["/DescendantFonts"][0]["/FontDescriptor"].keys()) for one in fonts)


def test_every_page_has_its_number_and_the_title(made: tuple[Session, WrittenReport, list[float]]) -> None:
    pages = pdf_pages(made[1].pdf)
    for number, words in enumerate(pages, 1):
        assert f"{number} / {len(pages)}" in words
        assert "RadarGUI report: 2026-11-20T15-04-05" in words


def test_the_first_page_is_the_answer_with_its_budget_e_against_the_speed_and_the_track(
    made: tuple[Session, WrittenReport, list[float]],
) -> None:
    first, document = pdf_pages(made[1].pdf)[0], json.loads(made[1].json.read_text(encoding="utf-8"))
    e = document["series"]["e_first_bounce"]
    assert f"e = {quantity(e['mean'], e['combined'] or e['u_single'])}" in first
    for title in ("Standard uncertainty of a single drop", "e against the impact speed", "Track", "Height / mm"):
        assert title in first


def test_the_pdf_holds_the_numbers_of_the_json(made: tuple[Session, WrittenReport, list[float]]) -> None:
    words = pdf_words(made[1].pdf)
    document = json.loads(made[1].json.read_text(encoding="utf-8"))
    e, g = (document["series"][key] for key in ("e_first_bounce", "g_m_s2"))
    assert f"{quantity(e['mean'], e['combined'] or e['u_single'])} (" in words
    assert quantity(g["mean"], g["combined"] or g["u_single"], "m/s²") in words
    impacts = document["runs"][0]["bounces"]
    assert len(impacts) > 3
    for impact in impacts[:6]:
        assert f"{impact['time_s'] - document['runs'][0]['zero_time_s']:.5f}" in words
        assert quantity(impact["e"], impact["u_e_combined"] or impact["u_e"]) in words


def test_what_the_operator_wrote_is_text_on_paper_too(made: tuple[Session, WrittenReport, list[float]]) -> None:
    words = pdf_words(made[1].pdf)
    for text in (f"Operator {EVIL}", f"Notes =1+1 {MARKUP}", "$x^2$"):
        assert text in words
    assert "'=1+1" not in words


def test_the_same_session_makes_the_same_pdf(tmp_path: Path) -> None:
    session = new_session(tmp_path / "data")
    first, again = (write_report(session, result_of_run, tmp_path / name, now=NOW).pdf for name in "ab")
    assert first.read_bytes() == again.read_bytes()


def test_without_the_typesetter_all_is_written_but_the_pdf_and_one_sentence_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "typst", None)
    session = new_session(tmp_path / "data")
    with pytest.raises(FileError, match=r"could not be typeset: .*typst.* the other files of the report were\.$"):
        write_report(session, result_of_run, tmp_path / "out", now=NOW)
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == set(REPORT_FILES) - {"report.pdf"}


def test_the_html_needs_no_other_file_and_runs_only_its_own_script(
    made: tuple[Session, WrittenReport, list[float]],
) -> None:
    text = made[1].html.read_text(encoding="utf-8")
    reader = Reader()
    reader.feed(text)
    assert reader.open == []
    (script,) = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in text
    assert "link" not in reader.tags
    assert all(address.startswith(("data:image/svg+xml,", "#part-", "#run-")) for address in reader.addresses)
    assert EVIL not in text
    assert "&lt;script&gt;" in text
    # e against speed, track, falls, phase and fall of the drop, raw signals of the quiet run
    assert reader.tags.count("img") == 3 + 1 + 1
    assert "prefers-color-scheme: dark" in text


def test_the_pictures_are_svg_without_script_or_outside_address(
    made: tuple[Session, WrittenReport, list[float]],
) -> None:
    text = made[1].html.read_text(encoding="utf-8")
    pictures = re.findall(r"data:image/svg\+xml,([^\"]+)", text)
    assert len(pictures) == text.count("<img") == 5
    for encoded in pictures:
        picture = unquote(encoded)
        assert picture.rstrip().endswith("</svg>")
        assert "<script" not in picture
        assert not re.search(r"(href|src)\s*=\s*\"(?!#|data:)", picture)


@pytest.mark.parametrize(("paper", "size"), [("a4", (595.3, 841.9)), ("letter", (612.0, 792.0))])
def test_every_page_has_the_paper_that_was_asked_for(tmp_path: Path, paper: Paper, size: tuple[float, float]) -> None:
    session = new_session(tmp_path / "data")
    pages = PdfReader(write_report(session, result_of_run, layout=PageLayout(paper), now=NOW).pdf).pages
    assert len(pages) > 1
    for page in pages:
        assert tuple(map(float, page.mediabox[2:])) == pytest.approx(size, abs=0.1)


def test_a_report_that_is_cancelled_leaves_the_one_before_and_no_part(tmp_path: Path) -> None:
    session = new_session(tmp_path / "data")
    add_run(session, quiet_result(samples=2000).recording)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "report.pdf").write_text("the one before", encoding="utf-8")

    def cancel(_share: float) -> None:
        raise CancelledError

    with pytest.raises(CancelledError):
        write_report(session, result_of_run, tmp_path / "out", cancel, now=NOW)
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["report.pdf"]
    assert (tmp_path / "out" / "report.pdf").read_text(encoding="utf-8") == "the one before"


def test_a_broken_run_says_why_and_the_others_are_there(made: tuple[Session, WrittenReport, list[float]]) -> None:
    session, report, _ = made
    runs = json.loads(report.json.read_text(encoding="utf-8"))["runs"]
    assert [run["status"] for run in runs] == ["ok", "no_motion", "failed"]
    assert runs[2]["reason"].startswith("run-0003.h5")
    assert runs[0]["bounces"][0]["e"] == pytest.approx(0.8, abs=0.02)
    text = report.html.read_text(encoding="utf-8")
    assert "Run 0003 (failed)" in text
    assert "No result:" in text
    assert "Run 0002 (no motion)" in text
    # it lies on this computer, and nobody knows whether anything fell in it
    assert str(session.path) not in text
    assert "was dropped once" in text


def test_the_csv_lists_the_impacts_of_the_drop(made: tuple[Session, WrittenReport, list[float]]) -> None:
    rows = list(csv.DictReader(made[1].csv.read_text(encoding="utf-8").splitlines()))
    drop = [row for row in rows if row["run"] == "run-0001"]
    assert [row["impact"] for row in drop] == [str(k) for k in range(1, len(drop) + 1)]
    assert float(drop[0]["e"]) == pytest.approx(0.8, abs=0.02)
    assert [row["verdict"] for row in rows if row["run"] != "run-0001"] == ["no motion", "failed"]


def test_a_report_can_be_written_elsewhere_and_replaces_the_one_there(tmp_path: Path) -> None:
    session = new_session(tmp_path / "data")
    first = write_report(session, result_of_run, tmp_path / "out" / "here", now=NOW)
    first.html.write_text("old", encoding="utf-8")
    write_report(session, result_of_run, tmp_path / "out" / "here", now=NOW)
    assert "holds no run" in first.html.read_text(encoding="utf-8")
    assert not (session.path / "report").exists()


def test_a_folder_that_cannot_be_written_is_told_in_plain_words(tmp_path: Path) -> None:
    session = new_session(tmp_path / "data")
    (tmp_path / "file").write_text("in the way", encoding="utf-8")
    with pytest.raises(FileError, match="cannot be written"):
        write_report(session, result_of_run, tmp_path / "file")


def test_a_pdf_that_cannot_be_replaced_leaves_no_half_file(tmp_path: Path) -> None:
    session = new_session(tmp_path / "data")
    output = tmp_path / "out"
    (output / "report.pdf").mkdir(parents=True)
    with pytest.raises(FileError, match=r"report\.pdf"):
        write_report(session, result_of_run, output)
    assert not list(output.glob("*.part"))


def test_one_receiver_is_reported_without_track_and_bounces(tmp_path: Path) -> None:
    setup = default_setup()
    setup = setup.model_copy(
        update={"receiver": setup.receiver[:1], "daq": setup.daq.model_copy(update={"channels": None})}
    )
    session = Session.create(tmp_path, setup, now=NOW)
    add_run(session, drop_result(rate_hz=8000.0, n_receivers=1).recording)
    document = json.loads(write_report(session, result_of_run, now=NOW).json.read_text(encoding="utf-8"))
    assert document["runs"][0]["status"] == "ok"
    assert document["runs"][0]["bounces"] == []
    assert document["condition_number"] is None


def test_an_imported_session_names_file_and_program_and_claims_no_device(tmp_path: Path) -> None:
    setup = default_setup()
    setup = setup.model_copy(
        update={"receiver": setup.receiver[:1], "daq": setup.daq.model_copy(update={"channels": None})}
    )
    recording = drop_result(rate_hz=8000.0, n_receivers=1).recording
    session = Session.create(tmp_path, setup, now=NOW)
    origin = {"source": "import", "imported_from": "plate.mat", "imported_format": "MATLAB"}
    with session.new_run(
        replace(recording.digitisation, device=""),
        started_at="2017-10-05T10:34:56",
        attributes={**origin, "imported_program": "Scope 3"},
    ) as writer:
        writer.write(Block(recording.raw, 0))
    page = write_report(session, result_of_run, now=NOW).html.read_text(encoding="utf-8")
    assert "plate.mat (MATLAB), written by Scope 3" in page
    assert "2017-10-05 10:34:56" in page
    assert "Imported with" in page
    for claim in ("Dev1", "ai0", "Recorded with", "<dt>Device", ">Device<", "No impact was found"):
        assert claim not in page


def test_the_report_never_loads_pyplot_or_qt() -> None:
    names = ("matplotlib.pyplot", "PySide6", "pyqtgraph", "tkinter", "typst")
    code = f"import sys, radargui.report.report; print([name for name in {names} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_the_templates_are_part_of_the_package() -> None:
    names = {item.name for item in (resources.files("radargui.report") / "templates").iterdir()}
    assert {"begin.html", "blocks.html", "section.html", "sort.js", "report.typ"} <= names


def test_gaps_of_an_excerpt_are_told_where_they_lie_in_the_whole() -> None:
    result = drop_result(rate_hz=1000.0)
    excerpt = Excerpt(first_stored=5000, last_stored=6600, first_index=5000, of_samples=9000, reason="long")
    recording = replace(result.recording, gaps=(Gap(700, 20, "late"),), excerpt=excerpt, trigger_index=None)
    facts = take_facts(replace(result, recording=recording), "run-0001")
    assert [(gap.first_index, gap.count) for gap in facts.gaps] == [(5700, 20)]
    assert facts.curves is not None
    ((first_s, last_s),) = facts.curves.gaps_s
    assert (first_s + facts.zero_s, last_s + facts.zero_s) == pytest.approx((5.700, 5.720))


def test_e_of_time_and_of_height_have_no_more_digits_than_its_uncertainty() -> None:
    result = drop_result(rate_hz=1000.0)
    impact = replace(result.bounces.impacts[0], e=0.80012, u_e=0.0021, e_flight_time=0.80047, e_height=0.79969)
    bounces = replace(result.bounces, impacts=(impact,))
    facts = take_facts(replace(result, bounces=bounces), "run-0001")
    grid = next(one for one in run_page(facts).blocks if isinstance(one, Grid))
    assert [grid.rows[0][column] for column in (4, 7, 8)] == ["0.8001 ± 0.0021", "0.8005", "0.7997"]
    facts = take_facts(replace(result, bounces=replace(bounces, impacts=(replace(impact, u_e=0.031),))), "run-0001")
    grid = next(one for one in run_page(facts).blocks if isinstance(one, Grid))
    assert [grid.rows[0][column] for column in (4, 7, 8)] == ["0.800 ± 0.031", "0.800", "0.800"]


@pytest.mark.slow
def test_a_report_of_ten_drops_has_fourteen_pages_at_the_most(tmp_path: Path) -> None:
    session = new_session(tmp_path, notes="what the operator noted " * 40)
    one = take_facts(drop_result(rate_hz=4000.0), "run-0001", COMPACT)
    runs = tuple(replace(one, name=f"run-{number:04d}", label=str(number)) for number in range(1, 11))
    provenance = provenance_of(session, {}, NOW.isoformat())
    files = tuple(RunProvenance(run.name, f"{run.name}.h5", source="device") for run in runs)
    facts = SessionFacts(session.info, runs, replace(provenance, runs=files))
    chapters = [*front_chapters(report_facts([facts], NOW.isoformat())), *map(run_page, runs)]
    papers: tuple[Paper, ...] = ("a4", "letter")
    (tmp_path / "work").mkdir()
    with page_style():
        pages = Typesetter(tmp_path / "work")
        pages.put_in_front(chapters)
        for paper in papers:
            pages.write(tmp_path / "report.pdf", paper, "ten drops", "", NOW.isoformat())
            assert len(PdfReader(tmp_path / "report.pdf").pages) <= 14
