"""The table of errors in docs/ros.md, taken from the sources of the nodes.

    python tests/nodes/sentences.py       # writes the table anew

Every text of three words and more that a node raises, answers a call with or logs as a warning or error is a
row; `…` stands for what is put in. A test compares the table with the sources.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
DOCUMENT = ROOT / "docs" / "ros.md"
HEADING = "## Errors, word for word"
SOURCES = [
    *sorted(p for p in (ROOT / "nodes").glob("*.py") if not p.name.startswith("demo")),
    ROOT / "rb_physics" / "recording" / "topics.py",
]
REFUSED = {  # by the exception that carries the text
    "MalformedMessageError": "refused_malformed",
    "UnknownFrameError": "refused_frame",
    "RefusedValueError": "refused_value",
    "WrongStampError": "refused_stamp",
    "RefusedBodyError": "refused_body",
}
SAID_BY = {  # by the function that is given the text
    "_tell": "warning",
    "_complain": "warning",
    "warning": "warning",
    "info": "line in the log",
    "error": "error line",
    "_log": "error line",
    "finish": "answer",
    "_answer": "answer",
    "_end": "answer",
    "refuse": "topics file, at the start",
}
AT_THE_START = ("start.py", "sim_node.py", "replay_node.py", "parameters.py")


def literals(node: ast.AST) -> Iterator[str]:
    """The texts below a node, f-strings with `…` for their values."""
    if isinstance(node, ast.JoinedStr):
        parts = [p.value if isinstance(p, ast.Constant) else "…" for p in node.values]
        yield "".join(map(str, parts))
    elif isinstance(node, ast.Constant):
        if isinstance(node.value, str):
            yield node.value
    else:
        for child in ast.iter_child_nodes(node):
            yield from literals(child)


def name_of(call: ast.AST) -> str:
    function = call.func if isinstance(call, ast.Call) else call
    return getattr(function, "attr", getattr(function, "id", ""))


def kind_of_raise(name: str, texts: list[str], file: str) -> str:
    if name in REFUSED:
        return f"refused, counted as `{REFUSED[name]}`"
    codes = [text for text in texts if re.fullmatch("[A-Z_]+", text)]
    if codes:
        return f"answer `{codes[0]}`"
    if name == "TopicError":
        return "topics file, at the start"
    return "at the start" if file in AT_THE_START else "at the start, or answer"


def sentences(path: Path) -> Iterator[tuple[str, str]]:
    """(text, how it is told) of a source file."""
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Raise) and isinstance(node.exc, ast.Call):
            if name_of(node.exc) == "AssertionError":
                continue  # can't happen
            texts = list(literals(node.exc))
            how = kind_of_raise(name_of(node.exc), texts, path.name)
        elif isinstance(node, ast.Call) and name_of(node) in SAID_BY:
            texts = [text for argument in node.args for text in literals(argument)]
            how = SAID_BY[name_of(node)]
        elif isinstance(node, ast.Return) and isinstance(node.value, ast.Tuple):
            first = node.value.elts[0]
            if not (isinstance(first, ast.Constant) and first.value is False):
                continue
            texts, how = list(literals(node.value)), "answer"
        elif isinstance(node, ast.FunctionDef) and node.returns is not None:
            if ast.unparse(node.returns) != "str | None" or not node.name.endswith(
                ("refusal", "mismatch")
            ):
                continue
            returned = [n for n in ast.walk(node) if isinstance(n, ast.Return) and n.value]
            texts = [text for n in returned for text in literals(n)]
            how = "at the start, or answer" if node.name == "refusal" else "warning"
        else:
            continue
        for text in texts:
            if len(text.split()) >= 3:
                yield " ".join(text.split()), how


def table() -> list[str]:
    """The lines of the table."""
    rows = sorted({row for path in SOURCES for row in sentences(path)})
    escaped = [(re.sub(r"([|<])", r"\\\1", text), how) for text, how in rows]
    lines = [f"| {text} | {how} |" for text, how in escaped]
    return ["| sentence | told as |", "|---|---|", *lines]


def written() -> list[str]:
    """The lines of the table as docs/ros.md has them."""
    section = DOCUMENT.read_text("utf-8").split(HEADING + "\n", 1)[1]
    section = re.split(r"^## ", section, maxsplit=1, flags=re.M)[0]
    return [line for line in section.splitlines() if line.startswith("|")]


def main() -> None:
    text = DOCUMENT.read_text("utf-8")
    old = "\n".join(written())
    DOCUMENT.write_text(text.replace(old, "\n".join(table())), "utf-8")


if __name__ == "__main__":
    main()
