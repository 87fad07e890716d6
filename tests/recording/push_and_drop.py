"""A scene of the recording tests: a box to push and a ball that bounces."""

SCENE = """
dt: 0.002
bodies:
  - {name: ground, type: static, shape: {type: half_space, normal: [0, 0, 1], offset: 0}}
  - {name: box, shape: {type: box, half_extents: [0.1, 0.1, 0.1]}, mass: 2.0, position: [0, 0, 0.1]}
  - {name: ball, shape: {type: sphere, radius: 0.05}, mass: 0.5, position: [1, 0, 0.3], restitution: 0.5}
"""
