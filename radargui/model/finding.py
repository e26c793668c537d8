"""Findings: what is said of a run, as data with a code, a severity, perhaps a receiver, and facts.

The words stand in `resources/findings.toml` and are made where people read them. Nothing in the chain reads a sentence.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from string import Formatter
from typing import Any, Literal, TypeVar, get_args

from radargui.model.errors import ProcessingError
from radargui.model.rounding import concise, plain
from radargui.model.words import counted, sentence

Severity = Literal["info", "warn", "refuse"]

STORED = "stored"
"""Code of what was kept as a sentence alone: by an older version, or by a step that is no part of this program."""
_SCALES = {"mm": 1e3, "mm/s": 1e3, "ms": 1e3, "%": 1e2, "µs": 1e6, "GHz": 1e-9}
"""Units that words may show a fact in, and the factor to them."""

_Error = TypeVar("_Error", bound=ProcessingError)


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that is found of a run.

    Attributes
    ----------
    code
        Its name in `resources/findings.toml`.
    severity
        info; warn: the operator must know it; refuse: no result stands.
    receiver
        Which one it is about, counted from 1; None: the run.
    facts
        What its words need, by name: words, keys of the setup, numbers in SI units, findings, or tuples of these.
    """

    code: str
    severity: Severity = "warn"
    receiver: int | None = None
    facts: Mapping[str, Any] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """What is said, without the receiver where its words do not name it."""
        words = _words(self.code)
        return _filled(str(words["text"]), words, {"receiver": self.receiver, **self.facts})

    @property
    def is_of_receiver(self) -> bool:
        """Whether the receiver has to be said before the words."""
        return self.receiver is not None and "{receiver}" not in str(_words(self.code)["text"])

    def with_facts(self, **facts: object) -> Finding:
        """Return it with some facts changed."""
        return replace(self, facts={**self.facts, **facts})

    def document(self) -> dict[str, object]:
        """Return what JSON can hold of it; `finding_in` reads it again."""
        facts = {name: _stored(fact) for name, fact in self.facts.items()}
        return {"code": self.code, "severity": self.severity, "receiver": self.receiver, "facts": facts}


def warn(code: str, /, **facts: object) -> Finding:
    """Return a finding that the operator must know."""
    return Finding(code, "warn", None, facts)


def refuse(code: str, /, **facts: object) -> Finding:
    """Return a finding with which no result stands."""
    return Finding(code, "refuse", None, facts)


def as_stored(text: str, severity: Severity = "warn") -> Finding:
    """Return a finding of which only the sentence is known."""
    return Finding(STORED, severity, None, {"text": text})


def finding_in(document: Any) -> Finding:
    """Return the finding in a document of JSON.

    Raises
    ------
    KeyError, TypeError, ValueError
        The document holds no finding.
    """
    code, severity, receiver, facts = (document[key] for key in ("code", "severity", "receiver", "facts"))
    if not isinstance(code, str) or severity not in get_args(Severity) or not isinstance(receiver, int | None):
        raise ValueError(document)
    return Finding(code, severity, receiver, {str(name): _fact(fact) for name, fact in facts.items()})


def texts(findings: Iterable[Finding]) -> tuple[str, ...]:
    """Return findings in words; a sentence that holds for several receivers is given once."""
    said: dict[object, tuple[Finding, list[int]]] = {}
    for place, one in enumerate(findings):
        alike = (one.severity, one.text) if one.is_of_receiver else place
        said.setdefault(alike, (one, []))[1].append(one.receiver or 0)
    return tuple(_of_receivers(one, receivers) if one.is_of_receiver else one.text for one, receivers in said.values())


def _of_receivers(finding: Finding, receivers: Sequence[int]) -> str:
    *others, last = map(str, receivers)
    who, are = (f"receivers {', '.join(others)} and {last}", "are") if others else (f"receiver {last}", "is")
    return f"{who}: {finding.text}" if finding.severity == "refuse" else f"{who} {are} usable: {finding.text}"


def error_of(
    kind: type[_Error], code: str, /, *, reasons: Sequence[str] = (), remedy: str = "", **facts: object
) -> _Error:
    """Return the error of a step that cannot be done; its reason is a finding (`ProcessingError.finding`)."""
    finding = refuse(code, **facts)
    error = kind(sentence(finding.text), reasons=reasons, remedy=remedy)
    error.finding = finding
    return error


def why_of(error: ProcessingError) -> Finding:
    """Return the finding that says why a step could not be done, made of the words where the error has none."""
    return error.finding or as_stored(error.message.rstrip("."), "refuse")


def _words(code: str) -> Mapping[str, Any]:
    # read when there is something to say: no command waits for it
    from radargui.system.resources import resource_table

    try:
        table = resource_table("findings")
    except OSError:
        # a process that may open no more files cannot read them: the code alone
        table = {}
    # a newer version may have stored what this one has no words for
    words: Mapping[str, Any] = table.get(code) or {"text": code.replace("_", " ")}
    return words


def _filled(text: str, words: Mapping[str, Any], facts: Mapping[str, Any]) -> str:
    """Return a text with facts in its braces; a fact of which the table has phrases by its value stands for its phrase.

    Beside Python's, formats are "± other" (a value with its uncertainty, another fact), "4 digits GHz", "counted gap",
    and any number's with a unit behind it: ".2f mm".
    """
    out = []
    for literal, name, how, _ in Formatter().parse(text):
        out.append(literal)
        if name is None:
            continue
        phrases, fact = words.get(name), facts.get(name, "")
        if isinstance(phrases, Mapping):
            key = str(fact).lower() if isinstance(fact, bool) else str(fact)
            # the phrase itself may name the fact
            others = {other: own for other, own in words.items() if other != name}
            out.append(_filled(phrases.get(key, phrases.get("other", "")), others, facts))
        else:
            out.append(_shown(fact, how or "", facts))
    return "".join(out)


def _shown(fact: Any, how: str, facts: Mapping[str, Any]) -> str:
    if isinstance(fact, Finding):
        return fact.text
    if isinstance(fact, (tuple, list)):
        return ", ".join(_shown(one, how, facts) for one in fact)
    first, _, rest = how.partition(" ")
    if first == "±":
        return concise(fact, facts[rest])
    if first == "counted":
        return counted(fact, rest)
    if rest.startswith("digits"):
        unit = rest.removeprefix("digits").strip()
        return plain(fact, int(first), unit, _SCALES.get(unit, 1.0))
    return f"{fact * _SCALES.get(rest, 1.0):{first}} {rest}" if rest else format(fact, how)


def _stored(fact: Any) -> Any:
    if isinstance(fact, Finding):
        return fact.document()
    return [_stored(one) for one in fact] if isinstance(fact, tuple) else fact


def _fact(stored: Any) -> Any:
    if isinstance(stored, dict):
        return finding_in(stored)
    return tuple(_fact(one) for one in stored) if isinstance(stored, list) else stored
