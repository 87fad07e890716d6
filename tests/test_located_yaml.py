"""YAML with line numbers: what is a number, what is refused, and where."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rb_physics.located_yaml import Document, field_name, parse

ANYTHING: dict[str, Any] = {}


def read(text: str) -> Any:
    return parse(text, "file.yaml", ANYTHING).data


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1", 1),
        ("-12", -12),
        ("012", 12),
        ("1e-3", 1e-3),
        ("1E3", 1000.0),
        (".5", 0.5),
        ("5.", 5.0),
        ("-9.81", -9.81),
        ("0.1", 0.1),
        ("true", True),
        ("False", False),
        ("no", "no"),
        ("on", "on"),
        ("null", None),
        ("~", None),
        ("12:30", "12:30"),
        ("0x10", "0x10"),
        ("1_000", "1_000"),
        ("2026-01-01", "2026-01-01"),
        ("'1'", "1"),
        ('"true"', "true"),
    ],
)
def test_scalar_is_read_as_yaml_1_2_does(text: str, value: object) -> None:
    data = read(f"key: {text}")["key"]
    assert data == value
    assert type(data) is type(value)


def test_lines_are_those_of_the_keys_and_items() -> None:
    document: Document = parse("a: 1\nb:\n  - x\n  - {c: 2,\n     d: 3}\n", "f", ANYTHING)
    assert document.line(("a",)) == 1
    assert document.line(("b",)) == 2
    assert document.line(("b", 0)) == 3
    assert document.line(("b", 1)) == 4
    assert document.line(("b", 1, "d")) == 5
    assert document.line(("b", 1, "missing", "deeper")) == 4


def test_aliases_repeat_plain_data() -> None:
    assert read("a: &x [1, {b: 2}]\nc: *x\n") == {"a": [1, {"b": 2}], "c": [1, {"b": 2}]}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "file.yaml: the file is empty"),
        ("# only a comment\n", "file.yaml: the file is empty"),
        ("a: 1\na: 2\n", "file.yaml:2: the key 'a' is given twice (first in line 1)"),
        ("a: [1\nb: 2", "not valid YAML"),
        ("\ta: 1", "not valid YAML"),
        ("a: 1\n---\nb: 2\n", "file.yaml:2: a second document starts here"),
        ("? [1, 2]\n: 3\n", "file.yaml:1: a key must be text"),
        ("a: *nothing\n", "file.yaml:1: alias *nothing names no anchor"),
        ("a: &me [*me]\n", "alias *me names no anchor that ended before"),
        ("a: !!python/object/apply:os.system ['true']\n", "the tag tag:yaml.org,2002:python"),
        ("a: !!binary abcd\n", "tag:yaml.org,2002:binary is not allowed"),
        ("a: .nan\n", "file.yaml:1: a is .nan; it must be a finite number"),
        ("a: [1,\n  -.inf]\n", "file.yaml:2: a[1] is -.inf; it must be a finite number"),
        ("a: 1e999\n", "a is 1e999; it must be a finite number"),
        ("a: " + "9" * 5000, "it must be a finite number"),
        ("a: \0", "file.yaml: not valid YAML"),
        ("[" * 100_000, "nested deeper than 64 levels"),
        ("a: " + "{b: " * 100_000, "nested deeper than 64 levels"),
    ],
)
def test_refused_with_file_line_and_reason(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=r"^file\.yaml") as error:
        read(text)
    assert message in str(error.value)
    assert len(str(error.value)) < 400


def test_billion_laughs_is_refused() -> None:
    lines = ["a0: &a0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]"]
    lines += [f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 10)}]" for n in range(1, 30)]
    with pytest.raises(ValueError, match="values once aliases are followed"):
        read("\n".join(lines))


def test_text_beyond_the_limit_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rb_physics.located_yaml.MAX_CHARACTERS", 10)
    with pytest.raises(ValueError, match="file.yaml: 12 characters; at most 10 are read"):
        read("key: 1234567")


SCHEMA = {
    "type": "object",
    "additionalProperties": False,
    "required": ["mass"],
    "properties": {
        "mass": {"type": "number", "exclusiveMinimum": 0, "description": "kg"},
        "kind": {"enum": ["box", "ball"]},
        "where": {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3},
        "count": {"type": "integer", "minimum": 1, "maximum": 9},
        "part": {
            "type": "object",
            "additionalProperties": False,
            "properties": {"on": {"type": "boolean"}, "label": {"type": "string"}},
        },
    },
}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "mass: 1\nkindd: box",
            "2: unknown key kindd (did you mean kind?); allowed are mass, kind",
        ),
        ("mass: 1\npart: {labl: 1}", "2: unknown key part.labl (did you mean label?)"),
        ("kind: box", "1: mass is missing (kg)"),
        ("mass: 0", "1: mass is 0; it must be greater than 0 (kg)"),
        ("mass: heavy", "1: mass is 'heavy'; it must be a number (kg)"),
        ("mass: true", "1: mass is True; it must be a number (kg)"),
        ("mass: null", "1: mass is None; it must be a number (kg)"),
        ("mass: 1\nkind: bal", "2: kind is 'bal' (did you mean ball?); allowed are box, ball"),
        ("mass: 1\nwhere: [1, 2]", "2: where is [1, 2]; it must be a list of at least 3, not 2,"),
        ("mass: 1\nwhere: [1, 2, 3, 4]", "it must be a list of at most 3, not 4, values"),
        ("mass: 1\nwhere:\n- 1\n- x\n- 2", "4: where[1] is 'x'; it must be a number"),
        ("mass: 1\ncount: 0", "2: count is 0; it must be at least 1"),
        ("mass: 1\ncount: 10", "2: count is 10; it must be at most 9"),
        ("mass: 1\ncount: 1.5", "2: count is 1.5; it must be a whole number"),
        ("mass: 1\npart: 3", "2: part is 3; it must be a mapping (key: value)"),
        ("mass: 1\npart: {on: 1}", "2: part.on is 1; it must be true or false"),
        ("mass: 1\npart: {label: 1}", "2: part.label is 1; it must be text"),
        ("- 1", "1: the document is [1]; it must be a mapping (key: value)"),
        ("mass: .nan\nkindd: 1", "1: mass is .nan"),
        ("count: 0\nmass: 0", "1: count is 0"),  # the first by line
    ],
)
def test_schema_violations_are_sentences(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=r"^file\.yaml:") as error:
        parse(text, "file.yaml", SCHEMA)
    assert message in str(error.value)


def test_subject_names_whom_a_field_belongs_to() -> None:
    with pytest.raises(ValueError, match=r"^f:1: part 7: on is 1; it must be true or false$"):
        parse("{mass: 1, part: {on: 1}}", "f", SCHEMA, lambda data, path: ("part 7", path[1:]))


def test_field_names_read_like_code() -> None:
    assert field_name(("shape", "points", 3, 0)) == "shape.points[3][0]"
    assert field_name(()) == ""


@settings(max_examples=300, deadline=None, derandomize=True)
@given(
    st.text(max_size=60)
    | st.text(alphabet="ab:-[]{}&*!|>'\"#%@,? \n\t0.e", max_size=60)
    | st.binary(max_size=40).map(lambda data: data.decode("latin-1"))
)
def test_no_text_causes_anything_but_data_or_value_error(text: str) -> None:
    try:
        read(text)
    except ValueError as error:
        assert str(error).startswith("file.yaml")
