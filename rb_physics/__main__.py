"""``python -m rb_physics``: the command rb_physics."""

from importlib import import_module

import_module("rb_physics.cli").main(prog_name="rb_physics")
