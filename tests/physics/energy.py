"""Total energy, which several tests of moving bodies watch."""


def energy(world):
    return world.kinetic_energy + world.potential_energy
