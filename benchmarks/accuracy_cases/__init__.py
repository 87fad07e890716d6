"""The cases of the accuracy table: a scene, its exact answer, and how far we are from it.

Every case takes a `Stage` and returns errors by name, relative unless said otherwise. Only the
public Python face is used. `Watch` keeps the worst solver residual and energy gain of every step.
"""

from .free_motion import free_body as free_body
from .grooves import box_in_groove as box_in_groove
from .grooves import groove_normals as groove_normals
from .grooves import sphere_in_groove as sphere_in_groove
from .impacts import bouncing_ball as bouncing_ball
from .impacts import elastic_ball as elastic_ball
from .impacts import newtons_cradle as newtons_cradle
from .impacts import oblique_bounce as oblique_bounce
from .sliding import box_down_incline as box_down_incline
from .sliding import box_on_incline as box_on_incline
from .sliding import box_slides_to_rest as box_slides_to_rest
from .sliding import sphere_starts_to_roll as sphere_starts_to_roll
from .stacks import heap_of_balls as heap_of_balls
from .stacks import tower as tower
from .watch import Watch as Watch
