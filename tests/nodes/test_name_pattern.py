"""Patterns for names: against Python's re, and in bounded time."""

import random
import re
import time

import pytest
from rb_physics_nodes.name_pattern import NamePattern

NAMES = [
    "",
    "a",
    "b",
    "aa",
    "ab",
    "ba",
    "abab",
    "a1",
    "robot_1",
    "robot_12/left",
    "x.y",
    "-",
    "]",
    "c^",
]


def agree(pattern):
    ours, theirs = NamePattern(pattern), re.compile(pattern)
    for name in NAMES:
        assert ours.search(name) == bool(theirs.search(name)), (pattern, name)


@pytest.mark.parametrize(
    "pattern",
    ["", "^$", "a", "^a", "a$", "a|b", "^(a|b)+$", "(ab){2}", "^a{2}$", "^a{1,}b?$", "a{0,1}1", ".*_[0-9]+$",
     r"\d", r"^\w+$", r"x\.y", "[^a]", "[]a]", "[^]a]", "[a-b]$", "[-x]", "[.^]", "(|a)b", "()", "(a*)*b", "(^a|b$)",
     "robot_(1|12)/", "a**", "}", "]", "^*a"],
)  # fmt: skip
def test_what_fits_is_what_fits_for_python(pattern):
    if pattern in ("a**", "^*a"):  # POSIX leaves these open; Python refuses the first
        NamePattern(pattern)
        return
    agree(pattern)


def test_random_patterns_fit_as_for_python():
    rng = random.Random(5)

    def some(depth):
        kind = rng.randrange(7 if depth else 3)
        if kind < 3:
            return rng.choice(["a", "b", ".", "[ab]", "[^a]", "1", "^", "$"])
        if kind < 5:
            return some(depth - 1) + some(depth - 1)
        if kind == 5:
            return f"({some(depth - 1)}|{some(depth - 1)})"
        return f"({some(depth - 1)}){rng.choice(['*', '+', '?', '{2}', '{1,2}', '{0,}'])}"

    for _ in range(2000):
        agree(some(4))


def test_classes_of_posix():
    assert NamePattern("^[[:alpha:]_]+[[:digit:]]$").search("robot_1")
    assert not NamePattern("[^[:alnum:]_]").search("robot_1")
    assert NamePattern("[[:punct:]]").search("a]")


@pytest.mark.parametrize(
    "pattern", ["(a+)+$b", "(a|a)*$b", "a*" * 40 + "b", "(a|a|aa)+b", "((a*)*)*b", "(a?){100}b"]
)
def test_patterns_that_backtracking_never_ends_with(pattern):
    fits = NamePattern(pattern)
    begun = time.process_time()
    assert not any(fits.search("a" * 240 + str(i)) for i in range(100))
    assert time.process_time() - begun < 5.0  # measured: 0.1 s; by backtracking, for ever


@pytest.mark.parametrize(
    ("pattern", "words"),
    [("(", "not closed"), (")", "closes no group"), ("*a", "nothing that"), ("a{3,2}", "count up"), ("a{300}", "255"),
     ("[", "is none of"), ("a{", "is none of"), ("(?=a)", "is none of"), (r"(a)\1", "is none of"), ("\\", "is none of"),
     ("[[:no:]]", "is none of the classes"), ("[b-a]", "bad character range"), ("a" * 251, "251 characters"),
     ("(" * 40 + ")" * 40, "30 groups"), ("((a{99}){99}){99}", "500 places")],
)  # fmt: skip
def test_what_is_no_pattern_says_why(pattern, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        NamePattern(pattern)
