"""YAML whose errors name file, line, field, value and what is allowed.

Reads the plain part of YAML 1.2 (so ``1e-3`` is a number and ``no`` is text), refuses tags,
duplicate keys, non-finite numbers and input that unfolds to something huge, remembers the line of
every value, and checks documents against a JSON schema.
"""

from __future__ import annotations

import difflib
import math
import re
import reprlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import yaml

Path = tuple[str | int, ...]  # keys and indices that lead to a value

MAX_CHARACTERS = 64_000_000  # about a million mesh vertices
MAX_VALUES = 10_000_000  # after aliases are followed: stops "billion laughs"
MAX_DEPTH = 64  # legal documents need about ten

_INTEGER = re.compile(r"[-+]?[0-9]+")
_NUMBER = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_WORDS = {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}
_NULLS = ("", "~", "null", "Null", "NULL")
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def field_name(path: Path) -> str:
    """``("shape", "half_extents", 0)`` as ``shape.half_extents[0]``."""
    text = "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in path)
    return text.removeprefix(".")


@dataclass(frozen=True)
class Document:
    """The data of a YAML text, with the line (from 1) of every value."""

    name: str  # for messages: usually the path of the file
    data: Any
    lines: dict[Path, int]

    def line(self, path: Path) -> int:
        """Line of a value, or of the nearest thing around it that has one."""
        while path not in self.lines:
            path = path[:-1]
        return self.lines[path]

    def error(self, path: Path, sentence: str) -> ValueError:
        """An error that starts with file and line."""
        return ValueError(f"{self.name}:{self.line(path)}: {sentence}")


# Splits the path of a value into who it belongs to ("body 'crate'" or "") and the field within.
Subject = Callable[[Any, Path], tuple[str, Path]]


def parse(
    text: str,
    name: str,
    schema: dict[str, Any],
    subject: Subject = lambda data, path: ("", path),
) -> Document:
    """Reads one YAML document and checks it against a JSON schema.

    Args:
        name: what messages call the text, usually its path.
        subject: called with the whole data and a path, for messages.

    Raises:
        ValueError: anything but plain, finite data that keeps to the schema; the message is about
            the first such place.
    """
    if len(text) > MAX_CHARACTERS:
        raise ValueError(f"{name}: {len(text)} characters; at most {MAX_CHARACTERS} are read")
    try:
        parser = _Parser(text, name)
        document = parser.document()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line = mark.line + 1 if mark else 1
        raise ValueError(f"{name}:{line}: not valid YAML: {error.problem}") from None
    except yaml.YAMLError as error:
        raise ValueError(f"{name}: not valid YAML: {str(error).splitlines()[0]}") from None
    broken = [
        (path, f"{{field}} is {_shown(given)[1:-1]}; it must be a finite number")
        for path, given in parser.not_finite
    ]
    if not broken:  # the schema has nothing to say about infinities
        broken = _broken_rules(document, schema)
    if broken:
        path, sentence = min(broken, key=lambda pair: (document.line(pair[0]), len(pair[0])))
        who, inner = subject(document.data, path)
        sentence = sentence.replace("{field}", field_name(inner) or "the document", 1)
        raise document.error(path, (who + ": " if who else "") + sentence)
    return document


class _Parser:
    def __init__(self, text: str, name: str) -> None:
        self.events: Iterator[Any] = iter(yaml.parse(text, Loader=_LOADER))
        self.name = name
        self.lines: dict[Path, int] = {}
        self.anchors: dict[str, tuple[Any, int]] = {}  # value and how many values it unfolds to
        self.values = 0
        self.not_finite: list[tuple[Path, str]] = []

    def document(self) -> Document:
        next(self.events)  # stream start
        if isinstance(next(self.events), yaml.StreamEndEvent):
            raise ValueError(f"{self.name}: the file is empty")
        data = self.value(next(self.events), (), 0)
        next(self.events)  # document end
        event = next(self.events)
        if not isinstance(event, yaml.StreamEndEvent):
            raise self.error(event, "a second document starts here; only one is allowed")
        return Document(self.name, data, self.lines)

    @staticmethod
    def line(event: Any) -> int:
        return int(event.start_mark.line) + 1

    def error(self, event: Any, sentence: str) -> ValueError:
        return ValueError(f"{self.name}:{self.line(event)}: {sentence}")

    def value(self, event: Any, path: Path, depth: int) -> Any:
        if depth > MAX_DEPTH:
            raise self.error(event, f"nested deeper than {MAX_DEPTH} levels")
        self.lines.setdefault(path, self.line(event))
        if isinstance(event, yaml.AliasEvent):
            if event.anchor not in self.anchors:
                raise self.error(event, f"alias *{event.anchor} names no anchor that ended before")
            data, count = self.anchors[event.anchor]
            self.count(event, count)
            return data
        if event.tag not in (None, "!"):
            raise self.error(event, f"the tag {event.tag} is not allowed; only plain data is read")
        before = self.values
        self.count(event, 1)
        if isinstance(event, yaml.ScalarEvent):
            data = self.scalar(event, path)
        elif isinstance(event, yaml.SequenceStartEvent):
            data = []
            while not isinstance(item := next(self.events), yaml.SequenceEndEvent):
                data.append(self.value(item, (*path, len(data)), depth + 1))
        else:
            data = self.mapping(path, depth)
        if event.anchor:
            self.anchors[event.anchor] = (data, self.values - before)
        return data

    def count(self, event: Any, values: int) -> None:
        self.values += values
        if self.values > MAX_VALUES:
            raise self.error(event, f"more than {MAX_VALUES} values once aliases are followed")

    def mapping(self, path: Path, depth: int) -> dict[str, Any]:
        data: dict[str, Any] = {}
        while not isinstance(item := next(self.events), yaml.MappingEndEvent):
            if not isinstance(item, yaml.ScalarEvent):
                raise self.error(item, "a key must be text")
            key: str = item.value
            line = self.line(item)
            if key in data:
                first = self.lines[(*path, key)]
                raise self.error(item, f"the key {key!r} is given twice (first in line {first})")
            self.lines[(*path, key)] = line
            data[key] = self.value(next(self.events), (*path, key), depth + 1)
        return data

    def scalar(self, event: Any, path: Path) -> Any:
        text = event.value
        if not event.implicit[0]:  # quoted or block text
            return text
        if text in _NULLS:
            return None
        if text in _WORDS:
            return _WORDS[text]
        if _INTEGER.fullmatch(text) and len(text) < 300:  # more digits don't fit a double
            return int(text)
        if _NUMBER.fullmatch(text) and math.isfinite(number := float(text)):
            return number
        if _NUMBER.fullmatch(text) or _NOT_FINITE.fullmatch(text):
            self.not_finite.append((path, text))
        return text


def _broken_rules(document: Document, schema: dict[str, Any]) -> list[tuple[Path, str]]:
    """Every value that breaks the schema, with a sentence in which {field} is to be replaced."""
    import jsonschema

    broken = []
    for error in jsonschema.Draft202012Validator(schema).iter_errors(document.data):
        path = tuple(error.absolute_path)
        if error.validator == "additionalProperties":
            known = error.schema["properties"]
            key = next(key for key in error.instance if key not in known)
            broken.append(((*path, key), f"unknown key {{field}}{_hint(key, known)}"))
        elif error.validator == "required":
            key = next(key for key in error.validator_value if key not in error.instance)
            known = error.schema.get("properties", {})
            about = known.get(key, {}).get("description")
            missing = "{field} is missing" + (f" ({about})" if about else "")
            broken.append(((*path, key), missing + _near(key, error.instance, known)))
        else:
            broken.append((path, _sentence(error)))
    return broken


def _near(missing: str, given: Iterable[object], known: Iterable[object]) -> str:
    """Names a key that was meant to be the missing one."""
    if "<<" in given:
        return "; merge keys (<<) are not supported"
    unknown = [str(key) for key in given if key not in known]
    close = difflib.get_close_matches(missing, unknown, n=1)
    return f"; there is an unknown key {close[0]} (did you mean {missing}?)" if close else ""


def _hint(word: object, known: Iterable[object]) -> str:
    close = difflib.get_close_matches(str(word), map(str, known), n=1)
    hint = f" (did you mean {close[0]}?)" if close else ""
    return f"{hint}; allowed are {', '.join(map(str, known))}"


def _sentence(error: Any) -> str:
    """What is wrong with a value in the words of the reader, not of the schema."""
    rule, limit, about = error.validator, error.validator_value, error.schema.get("description")
    if rule == "enum":
        return f"{{field}} is {_shown(error.instance)}{_hint(error.instance, limit)}"
    if rule in _RULES:
        allowed = _RULES[rule](limit, error.instance) + (f" ({about})" if about else "")
    else:
        allowed = about or error.message
    return f"{{field}} is {_shown(error.instance)}; it must be {allowed}"


def _shown(value: object) -> str:
    if isinstance(value, dict):
        return "a mapping"
    if isinstance(value, str):
        return repr(value) if len(value) < 60 else repr(value[:57] + "...")
    return reprlib.repr(value)


_TYPES = {
    "number": "a number",
    "integer": "a whole number",
    "string": "text",
    "boolean": "true or false",
    "array": "a list",
    "object": "a mapping (key: value)",
}
_RULES: dict[str, Callable[[Any, Any], str]] = {
    "type": lambda limit, value: " or ".join(
        _TYPES[one] for one in ([limit] if isinstance(limit, str) else limit)
    ),
    "minimum": lambda limit, value: f"at least {limit}",
    "maximum": lambda limit, value: f"at most {limit}",
    "exclusiveMinimum": lambda limit, value: f"greater than {limit}",
    "exclusiveMaximum": lambda limit, value: f"less than {limit}",
    "minItems": lambda limit, value: f"a list of at least {limit}, not {len(value)}, values",
    "maxItems": lambda limit, value: f"a list of at most {limit}, not {len(value)}, values",
}
