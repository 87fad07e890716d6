"""The bodies of the start of a run: what `reset` brings back when some were added or removed."""

from __future__ import annotations

from typing import Any

MATERIAL = (
    "friction", "static_friction", "restitution", "rolling_friction", "spinning_friction",
)  # fmt: skip


class InitialBodies:
    """Remembers the bodies of a world, their surfaces included, and puts them back."""

    def __init__(self, world: Any) -> None:
        self._world = world
        self._bodies = list(world.bodies)
        self._recipes = [_recipe(body) for body in self._bodies]

    def put_back(self) -> None:
        """The world has these bodies again, in their rows; their state is left to a snapshot."""
        world = self._world
        present = list(world.bodies)
        if present[: len(self._bodies)] == self._bodies:
            for body in present[len(self._bodies) :]:
                world.remove(body)
            for body, recipe in zip(self._bodies, self._recipes, strict=True):
                body.set_material(**{field: recipe[field] for field in MATERIAL})
            return
        for body in reversed(present):
            world.remove(body)
        self._bodies = [world.add_body(**recipe) for recipe in self._recipes]


def _recipe(body: Any) -> dict[str, Any]:
    """The arguments of `World.add_body` that make an equal body."""
    from .. import Particle

    recipe: dict[str, Any] = {"shape": body.shape, "type": body.type, "name": body.name}
    recipe |= {field: getattr(body, field) for field in MATERIAL}
    recipe |= {"layer": body.layer, "mask": body.mask}
    recipe |= {"position": body.position, "orientation": body.orientation}
    recipe["frames"] = dict(body.frames)
    if body.type == "dynamic":
        recipe["mass"] = body.mass
    if not isinstance(body.shape, Particle):
        recipe["center_of_mass"] = body.center_of_mass
        if body.type == "dynamic":
            recipe["inertia"] = body.inertia
    return recipe
