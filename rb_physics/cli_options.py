"""Arguments and options that several commands have."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

Decorator = Callable[[Callable[..., Any]], Callable[..., Any]]

NEW_FOLDER = click.Path(path_type=Path)  # checked by what writes it


def recording_argument(name: str = "recording") -> Decorator:
    """The folder of a run."""
    return click.argument(name, type=click.Path(path_type=Path))


def new_png(option: str, help: str) -> Decorator:
    """An option for a picture, given to the command as `png`."""
    kind = click.Path(path_type=Path, dir_okay=False)
    return click.option(option, "png", type=kind, metavar="FILE", help=help)


def push_option(option: str, name: str, letter: str, what: str) -> Decorator:
    """Three components on a body, several times."""
    return click.option(
        option,
        name,
        multiple=True,
        type=(str, float, float, float),
        metavar=f"BODY {letter}X {letter}Y {letter}Z",
        help=f"{what} added from the start on; may be given several times.",
    )


no_rerun_option: Decorator = click.option("--no-rerun", is_flag=True, help="Record the bag only.")

layout_option: Decorator = click.option(
    "--layout",
    type=click.Choice(["overview", "contact", "debug"]),
    default="overview",
    show_default=True,
    help="How the views are arranged.",
)
