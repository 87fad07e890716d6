"""Patterns for names: extended regular expressions of POSIX, without backtracking.

The time is bounded by the length of the pattern times that of the name, whatever the pattern: an
automaton keeps the set of places in the pattern that the text so far can have come to.

Known are . * + ? {m,n} | ( ) ^ $ [...] with classes such as [:digit:], \\ before a punctuation
mark, and \\d \\D \\w \\W \\s \\S.

Source: Thompson, "Regular expression search algorithm", CACM 11(6), 1968; IEEE 1003.1 section 9.4.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, NoReturn

_LONGEST = 250  # characters of a pattern; a name has no more
_DEEPEST = 30  # groups in each other
_MOST = 500  # places, once repetitions are written out
_REMEMBERED = 10_000  # steps of the automaton: names are alike
_TOKEN = re.compile(
    r"(?P<single>\\[dDwWsS.^$*+?()\[\]{}|\\/-]|\[\^?\]?(?:\[:\w+:\]|[^\]])*\]|[^\\\[*+?{()|^$])"
    r"|(?P<repeat>[*+?]|\{\d+(?:,\d*)?\})|(?P<mark>[()|^$])"
)
_CLASSES = {
    "alpha": "a-zA-Z", "digit": "0-9", "alnum": "a-zA-Z0-9", "upper": "A-Z", "lower": "a-z",
    "punct": r"!-/:-@\[-`{-~", "space": r"\s", "blank": r" \t", "xdigit": "0-9a-fA-F",
}  # fmt: skip


class NamePattern:
    """Whether a name holds a part that the pattern describes. Raises ValueError for no pattern."""

    def __init__(self, pattern: str) -> None:
        if len(pattern) > _LONGEST:
            raise ValueError(f"it has {len(pattern)} characters, and may have {_LONGEST}")
        self._tokens = _tokens(pattern)
        # Each place: ("single", test, next), ("^" or "$", next), ("split", next, next), ("end",).
        self._places: list[tuple[Any, ...]] = [("end",)]
        self._steps: dict[tuple[frozenset[int], bool, str], frozenset[int] | None] = {}
        tree = self._alternatives(0)
        if self._tokens:
            raise ValueError("a ) closes no group")
        self._start = self._append(tree, 0)

    def search(self, name: str) -> bool:
        """Whether some part of `name` fits."""
        here: frozenset[int] = frozenset()
        for at in range(len(name) + 1):
            after = self._step(here, at == 0, name[at : at + 1])
            if after is None:
                return True
            here = after
        return False

    def _step(self, before: frozenset[int], first: bool, character: str) -> frozenset[int] | None:
        """The places after a character ("" at the end); None once the end of the pattern is reached."""
        key = (before, first, character)
        if key not in self._steps:
            here = self._reached(before | {self._start}, first, not character)
            places = [self._places[i] for i in here] if character else []
            after = frozenset(p[2] for p in places if p[0] == "single" and p[1](character))
            if len(self._steps) >= _REMEMBERED:
                self._steps.clear()
            self._steps[key] = None if 0 in here else after
        return self._steps[key]

    def _reached(self, places: frozenset[int], first: bool, last: bool) -> set[int]:
        """The places that can be come to without a character of the name."""
        waiting, seen = list(places), set(places)
        while waiting:
            kind, *rest = self._places[waiting.pop()]
            if kind == "split" or (kind == "^" and first) or (kind == "$" and last):
                new = [i for i in rest if i not in seen]
                seen.update(new)
                waiting += new
        return seen

    def _alternatives(self, depth: int) -> tuple[Any, ...]:
        if depth > _DEEPEST:
            raise ValueError(f"more than {_DEEPEST} groups are in each other")
        branches = [self._sequence(depth)]
        while self._tokens and self._tokens[0] == ("mark", "|"):
            self._tokens.pop(0)
            branches.append(self._sequence(depth))
        return ("either", *branches)

    def _sequence(self, depth: int) -> tuple[Any, ...]:
        parts: list[tuple[Any, ...]] = []
        while self._tokens and self._tokens[0] not in (("mark", "|"), ("mark", ")")):
            kind, text = self._tokens.pop(0)
            if kind == "repeat":
                if not parts:
                    raise ValueError(f"there is nothing that {text} repeats")
                parts[-1] = ("repeat", parts[-1], *_counts(text))
            elif text == "(" and kind == "mark":
                parts.append(self._alternatives(depth + 1))
                if not self._tokens:
                    raise ValueError("a ( is not closed")
                self._tokens.pop(0)
            else:
                parts.append((kind, text))
        return ("sequence", *parts)

    def _append(self, tree: tuple[Any, ...], after: int) -> int:
        """The places of a part before the place `after`; returns the first of them."""
        kind, *rest = tree
        if kind == "either":
            firsts = [self._append(branch, after) for branch in rest]
            return firsts[0] if len(firsts) == 1 else self._place("split", *firsts)
        if kind == "sequence":
            for part in reversed(rest):
                after = self._append(part, after)
            return after
        if kind == "single":
            return self._place("single", _test(rest[0]), after)
        if kind == "mark":
            return self._place(rest[0], after)
        part, least, most = rest
        if most is None:
            loop = self._place("split", after)
            self._places[loop] = ("split", after, self._append(part, loop))
            after = loop
        for _ in range(0 if most is None else most - least):
            after = self._place("split", self._append(part, after), after)
        for _ in range(least):
            after = self._append(part, after)
        return after

    def _place(self, *place: Any) -> int:
        self._places.append(place)
        if len(self._places) > _MOST:
            raise ValueError(f"it has more than {_MOST} places, its repetitions written out")
        return len(self._places) - 1


def _tokens(pattern: str) -> list[tuple[str, str]]:
    tokens, at = [], 0
    while at < len(pattern):
        found = _TOKEN.match(pattern, at)
        if found is None or pattern.startswith("(?", at):
            _refuse(pattern[at : at + 10])
        tokens.append((str(found.lastgroup), found.group()))
        at = found.end()
    return tokens


def _refuse(at: str) -> NoReturn:
    raise ValueError(f"'{at}' is none of . * + ? {{m,n}} | ( ) ^ $ [...] and characters")


def _counts(text: str) -> tuple[int, int | None]:
    if text in ("*", "+", "?"):
        return int(text == "+"), 1 if text == "?" else None
    least, comma, most = text[1:-1].partition(",")
    counts = int(least), int(most) if most else (None if comma else int(least))
    if max(counts[0], counts[1] or 0) > 255 or (counts[1] is not None and counts[1] < counts[0]):
        raise ValueError(f"{text} must count up, to 255 at most")
    return counts


def _test(text: str) -> Callable[[str], Any]:
    """Whether a character is what a part for a single character means."""
    if text.startswith("["):
        _, negated, inside = re.fullmatch(r"(\[)(\^?)(.*)\]", text, re.S).groups()  # type: ignore[union-attr]
        parts = re.split(r"\[:(\w+):\]", inside)  # every second one is the name of a class
        unknown = [name for name in parts[1::2] if name not in _CLASSES]
        if unknown:
            raise ValueError(f"[:{unknown[0]}:] is none of the classes {', '.join(_CLASSES)}")
        parts[::2] = [re.sub(r"([\\\[\]^&~|])", r"\\\1", part) for part in parts[::2]]
        parts[1::2] = [_CLASSES[name] for name in parts[1::2]]
        text = f"[{negated}{''.join(parts)}]"
    try:
        return re.compile(text, re.S).fullmatch
    except re.error as error:
        raise ValueError(f"{text}: {error}") from None
