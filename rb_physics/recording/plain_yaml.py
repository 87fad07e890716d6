"""YAML of bags, which anybody may have written: plain values only, in bounded memory and depth."""

from __future__ import annotations

from typing import Any

import yaml

_DEEPEST = 32  # lists and mappings inside one another; a bag's metadata has 8


def load_plain(text: str) -> Any:
    """The value of a document. Raises ValueError, in one line, for anything but plain YAML.

    The nesting is looked at first, because the loaders recurse (libyaml's until the stack is gone),
    and aliases are refused, because a page of them can stand for more than fits into memory.
    """
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # the fast one where it is built
    depth = 0
    try:
        for event in yaml.parse(text, Loader=loader):
            if isinstance(event, (yaml.SequenceStartEvent, yaml.MappingStartEvent)):
                depth += 1
                if depth > _DEEPEST:
                    raise ValueError(f"it is nested more than {_DEEPEST} deep")
            elif isinstance(event, (yaml.SequenceEndEvent, yaml.MappingEndEvent)):
                depth -= 1
            elif isinstance(event, yaml.AliasEvent):
                raise ValueError("it holds an alias (*), which no bag needs")
        return yaml.load(text, Loader=loader)
    except yaml.YAMLError as error:
        raise ValueError(str(error).splitlines()[0]) from None
