/* One ODE world behind a handful of plain functions, so that a step needs no callback into Python. */
#include <ode/ode.h>
#include <stdlib.h>

enum { POINTS = 8, LARGEST = 8192 };

static dWorldID world;
static dSpaceID space;
static dJointGroupID joints;
static dBodyID bodies[LARGEST];
static int count, quick;
static double dt, friction, restitution;

void start(double step, double mu, double bounce, int use_quick) {
  dInitODE2(0);
  world = dWorldCreate();
  space = dHashSpaceCreate(0);
  joints = dJointGroupCreate(0);
  dWorldSetGravity(world, 0, 0, -9.81);
  dWorldSetAutoDisableFlag(world, 0);
  count = 0;
  quick = use_quick;
  dt = step;
  friction = mu;
  restitution = bounce;
}

static const double* hull_planes;
static const unsigned int* hull_polygons;
static int hull_plane_count;

/* Faces of the next body of kind 2; ODE keeps the pointers. */
void hull(const double* planes, int n, const unsigned int* polygons) {
  hull_planes = planes;
  hull_plane_count = n;
  hull_polygons = polygons;
}

void plane(double x, double y, double z, double offset) { dCreatePlane(space, x, y, z, offset); }

void body(int kind, const double* shape, int numbers, double mass, const double* inertia,
          const double* x, const double* q, const double* v, int kinematic) {
  dBodyID b = dBodyCreate(world);
  dMass m;
  dMassSetParameters(&m, mass, 0, 0, 0, inertia[0], inertia[1], inertia[2], 0, 0, 0);
  dBodySetMass(b, &m);
  dGeomID g = kind == 0   ? dCreateSphere(space, shape[0])
              : kind == 1 ? dCreateBox(space, 2 * shape[0], 2 * shape[1], 2 * shape[2])
                          : dCreateConvex(space, hull_planes, hull_plane_count, shape, numbers,
                                          hull_polygons);
  dGeomSetBody(g, b);
  const dQuaternion wxyz = {q[3], q[0], q[1], q[2]};
  dBodySetPosition(b, x[0], x[1], x[2]);
  dBodySetQuaternion(b, wxyz);
  dBodySetLinearVel(b, v[0], v[1], v[2]);
  if (kinematic) dBodySetKinematic(b);
  bodies[count++] = b;
}

static void near(void* data, dGeomID a, dGeomID b) {
  (void)data;
  dContact contact[POINTS];
  const int n = dCollide(a, b, POINTS, &contact[0].geom, sizeof(dContact));
  for (int i = 0; i < n; ++i) {
    contact[i].surface.mode = dContactApprox1 | (restitution > 0 ? dContactBounce : 0);
    contact[i].surface.mu = friction;
    contact[i].surface.bounce = restitution;
    contact[i].surface.bounce_vel = 0.01;
    dJointAttach(dJointCreateContact(world, joints, &contact[i]), dGeomGetBody(a),
                 dGeomGetBody(b));
  }
}

void step_once(void) {
  dSpaceCollide(space, 0, near);
  if (quick) dWorldQuickStep(world, dt); else dWorldStep(world, dt);
  dJointGroupEmpty(joints);
}

void step(int n) {
  for (int i = 0; i < n; ++i) step_once();
}

void push(double x, double y, double z) { dBodyAddForce(bodies[0], x, y, z); }

void poses(double* x, double* q) {
  for (int i = 0; i < count; ++i) {
    const dReal *p = dBodyGetPosition(bodies[i]), *r = dBodyGetQuaternion(bodies[i]);
    for (int k = 0; k < 3; ++k) x[3 * i + k] = p[k];
    for (int k = 0; k < 4; ++k) q[4 * i + k] = r[(k + 1) % 4];
  }
}
