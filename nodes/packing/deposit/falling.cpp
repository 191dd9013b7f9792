#include "nodes/packing/deposit/falling.h"

#include <BulletCollision/CollisionDispatch/btSimulationIslandManager.h>
#include <BulletCollision/CollisionShapes/btShapeHull.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "graph/diagnostic.h"
#include "nodes/common/geometry/mesh/convex_hull.h"
#include "nodes/common/geometry/mesh/mesh.h"
#include "nodes/packing/rigid/contact/distance_field.h"

namespace terrazzo::packing {
namespace {

constexpr btScalar kGravity = 10;     // usual diameters per s²
constexpr btScalar kStep = 1.0 / 60;  // s
constexpr btScalar kMostSpeed = 8;    // usual diameters per s; faster bodies would pass through others
constexpr btScalar kFriction = 0.6;   // of stone on stone
constexpr btScalar kRolling = 0.02;   // balls would roll forever
constexpr double kMargin = 0.02;      // radii around hulls, within which contacts are found fast
constexpr btScalar kAir = 0.1, kAirTurning = 0.3;  // shares of speed that air takes per second
constexpr btScalar kCalm = 0.6;                    // the same once bodies are to come to rest
constexpr int kIterations = 20;                    // of the contact solver
constexpr int kFloor = 1, kBody = 2, kCopy = 4;    // collision groups

btVector3 to_bullet(const Vec3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

btQuaternion to_bullet_turn(const Quat& q) {
  return {static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()), static_cast<btScalar>(q.z()),
          static_cast<btScalar>(q.w())};
}

}  // namespace

// Of World, whose fields may not have types without linkage.
namespace falling {

// A body's copy one period farther.
struct Copy {
  std::unique_ptr<btCollisionObject> object;
  btVector3 shift;
};

struct FallingBody {
  std::unique_ptr<btCollisionShape> shape;
  std::unique_ptr<btRigidBody> rigid;
  std::array<Copy, 4> copies;  // of each pair of opposite neighbors one, so that contacts are found once
  btScalar reach = 0;
};

// Bodies touch copies of others. The solver is given these contacts as those of the bodies themselves.
class PeriodicSolver : public btSequentialImpulseConstraintSolver {
 public:
  explicit PeriodicSolver(const std::vector<FallingBody>& bodies) : bodies_(bodies) {}

  btScalar solveGroup(btCollisionObject** objects, int count, btPersistentManifold** contacts,
                      int contact_count, btTypedConstraint** constraints, int constraint_count,
                      const btContactSolverInfo& info, btIDebugDraw* draw,
                      btDispatcher* dispatcher) override {
    // In an order that does not depend on addresses, as that of Bullet's tree does.
    std::vector<btPersistentManifold*> order;
    std::copy_if(contacts, contacts + contact_count, std::back_inserter(order),
                 [](const btPersistentManifold* m) { return m->getNumContacts() > 0; });
    const auto ids = [](const btPersistentManifold* m) {
      return std::pair(m->getBody0()->getBroadphaseHandle()->m_uniqueId,
                       m->getBody1()->getBroadphaseHandle()->m_uniqueId);
    };
    std::sort(order.begin(), order.end(), [&](const auto* x, const auto* y) { return ids(x) < ids(y); });
    std::vector<Moved> moved;
    for (btPersistentManifold* contact : order) {
      const btCollisionObject *a = contact->getBody0(), *b = contact->getBody1();
      if (a->getUserIndex() < 0 && b->getUserIndex() < 0) continue;
      moved.push_back({contact, a, b, shift_of(a), shift_of(b)});
      moved.back().shift_points(-1);
      contact->setBodies(body_of(a), body_of(b));
    }
    const btScalar result = btSequentialImpulseConstraintSolver::solveGroup(
        objects, count, order.data(), static_cast<int>(order.size()), constraints, constraint_count, info,
        draw, dispatcher);
    for (Moved& m : moved) {
      m.contact->setBodies(m.a, m.b);
      m.shift_points(1);
    }
    return result;
  }

  const Work* work = nullptr;

 private:
  // Once the work is canceled, the rest of the step takes no time.
  btScalar solveSingleIteration(int iteration, btCollisionObject** objects, int count,
                                btPersistentManifold** contacts, int contact_count,
                                btTypedConstraint** constraints, int constraint_count,
                                const btContactSolverInfo& info, btIDebugDraw* draw) override {
    if (work->cancelled()) return 0;
    return btSequentialImpulseConstraintSolver::solveSingleIteration(
        iteration, objects, count, contacts, contact_count, constraints, constraint_count, info, draw);
  }
  struct Moved {
    btPersistentManifold* contact;
    const btCollisionObject *a, *b;
    btVector3 shift_a, shift_b;

    void shift_points(btScalar sign) const {
      for (int p = 0; p < contact->getNumContacts(); ++p) {
        contact->getContactPoint(p).m_positionWorldOnA += sign * shift_a;
        contact->getContactPoint(p).m_positionWorldOnB += sign * shift_b;
      }
    }
  };
  const btCollisionObject* body_of(const btCollisionObject* object) const {
    return object->getUserIndex() < 0 ? object : bodies_[object->getUserIndex()].rigid.get();
  }
  btVector3 shift_of(const btCollisionObject* object) const {
    return object->getWorldTransform().getOrigin() - body_of(object)->getWorldTransform().getOrigin();
  }
  const std::vector<FallingBody>& bodies_;
};

struct Dispatcher : btCollisionDispatcher {
  explicit Dispatcher(btCollisionConfiguration* configuration) : btCollisionDispatcher(configuration) {
    setNearCallback([](btBroadphasePair& pair, btCollisionDispatcher& self, const btDispatcherInfo& info) {
      if (!static_cast<Dispatcher&>(self).work->cancelled()) defaultNearCallback(pair, self, info);
    });
  }
  const Work* work = nullptr;
};

}  // namespace falling

FallingShape::FallingShape(const Mesh& mesh) {
  for (const Vec3& v : mesh.vertices) reach = std::max(reach, v.norm());
  if (is_sphere(mesh)) {
    radius = reach;
    return;
  }
  const Mesh whole = convex_hull(mesh.vertices);
  btConvexHullShape all;
  for (const Vec3& v : whole.vertices) all.addPoint(to_bullet(v / reach), false);
  all.recalcLocalAabb();
  all.setMargin(0);
  btShapeHull hull(&all);
  const bool built = hull.buildHull(0);
  Mesh few;
  for (int k = 0; k < hull.numVertices(); ++k) {
    const btVector3& p = hull.getVertexPointer()[k];
    few.vertices.push_back(reach * Vec3(p.x(), p.y(), p.z()));
  }
  const unsigned int* index = hull.getIndexPointer();
  for (int t = 0; t < hull.numTriangles(); ++t, index += 3)
    few.triangles.push_back(
        {static_cast<int>(index[0]), static_cast<int>(index[1]), static_cast<int>(index[2])});
  // Few corners and the margin around them together have the volume of the whole hull.
  const double volume = mesh_volume(whole);
  const double usual = std::cbrt(0.75 / std::numbers::pi * volume);
  margin = kMargin * usual;
  const double larger = std::cbrt(volume / std::abs(mesh_volume(few))) * (1 - kMargin);
  if (!built || !std::isfinite(larger)) throw Error("bad-shape", "a shape is too thin to fall", "");
  for (const Vec3& v : few.vertices) corners.push_back(larger * v);
  for (const Vec3& v : corners) reach = std::max(reach, v.norm() + margin);
}

using namespace falling;

struct FallingBodies::World {
  btDefaultCollisionConfiguration configuration;
  Dispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  std::vector<FallingBody> bodies;
  PeriodicSolver solver{bodies};
  btDiscreteDynamicsWorld dynamics{&dispatcher, &broadphase, &solver, &configuration};
  btStaticPlaneShape plane{btVector3(0, 0, 1), 0};
  btRigidBody floor{0, nullptr, &plane};
  std::array<btScalar, 2> period{};
  btScalar largest = 0;  // reach
  double unit = 1;       // mm

  ~World() {
    // Without pairs, no removal has to search for them.
    btOverlappingPairCache& pairs = *broadphase.getOverlappingPairCache();
    while (const int n = pairs.getNumOverlappingPairs()) {
      const btBroadphasePair last = pairs.getOverlappingPairArray()[n - 1];
      pairs.removeOverlappingPair(last.m_pProxy0, last.m_pProxy1, &dispatcher);
    }
    for (FallingBody& body : bodies) {
      dynamics.removeRigidBody(body.rigid.get());
      for (Copy& copy : body.copies)
        if (copy.object->getBroadphaseHandle()) dynamics.removeCollisionObject(copy.object.get());
    }
    dynamics.removeRigidBody(&floor);
  }
  void wrap(FallingBody&);
  void place_copies(FallingBody&);
};

FallingBodies::FallingBodies(const Vec2& period, double usual) : world_(std::make_unique<World>()) {
  World& w = *world_;
  w.unit = usual;
  w.period = {static_cast<btScalar>(period.x() / usual), static_cast<btScalar>(period.y() / usual)};
  w.dynamics.setGravity(btVector3(0, 0, -kGravity));
  w.dynamics.getSolverInfo().m_numIterations = kIterations;
  w.broadphase.m_cupdates = 100;  // percent: which pairs are near must not depend on their order
  w.dynamics.getSimulationIslandManager()->setSplitIslands(false);
  w.floor.setFriction(kFriction);
  w.floor.setUserIndex(-1);
  w.dynamics.addRigidBody(&w.floor, kFloor, kBody);
}

FallingBodies::~FallingBodies() = default;

void FallingBodies::add(const FallingShape& shape, double scale, const Vec3& position,
                        const Quat& orientation) {
  World& w = *world_;
  const double by = scale / w.unit;
  FallingBody body;
  if (shape.radius > 0) {
    body.shape = std::make_unique<btSphereShape>(static_cast<btScalar>(shape.radius * by));
  } else {
    auto hull = std::make_unique<btConvexHullShape>();
    for (const Vec3& corner : shape.corners) hull->addPoint(to_bullet(corner * by), false);
    hull->recalcLocalAabb();
    hull->setMargin(static_cast<btScalar>(shape.margin * by));
    body.shape = std::move(hull);
  }
  body.reach = static_cast<btScalar>(shape.reach * by);
  w.largest = std::max(w.largest, body.reach);
  const btScalar mass = body.reach * body.reach * body.reach;
  btVector3 inertia;
  body.shape->calculateLocalInertia(mass, inertia);
  const btTransform at(to_bullet_turn(orientation), to_bullet(position / w.unit));
  const auto rough = [](btCollisionObject& object) {
    object.setFriction(kFriction);
    object.setRollingFriction(kRolling);
    object.setSpinningFriction(kRolling);
    object.setActivationState(DISABLE_DEACTIVATION);
  };
  body.rigid = std::make_unique<btRigidBody>(mass, nullptr, body.shape.get(), inertia);
  body.rigid->setWorldTransform(at);
  body.rigid->setInterpolationWorldTransform(at);
  body.rigid->setUserIndex(-1);
  body.rigid->setDamping(kAir, kAirTurning);
  rough(*body.rigid);
  w.dynamics.addRigidBody(body.rigid.get(), kBody, kFloor | kBody | kCopy);
  const btScalar x = w.period[0], y = w.period[1];
  const std::array<btVector3, 4> shifts{btVector3(x, 0, 0), {0, y, 0}, {x, y, 0}, {-x, y, 0}};
  for (std::size_t k = 0; k < shifts.size(); ++k) {
    Copy& copy = body.copies[k];
    copy.shift = shifts[k];
    copy.object = std::make_unique<btCollisionObject>();
    copy.object->setCollisionShape(body.shape.get());
    copy.object->setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    copy.object->setUserIndex(static_cast<int>(w.bodies.size()));
    rough(*copy.object);
  }
  w.bodies.push_back(std::move(body));
}

// Moves a body back that has left the space by more than its copies allow for.
void FallingBodies::World::wrap(FallingBody& body) {
  btTransform at = body.rigid->getWorldTransform();
  bool moved = false;
  for (int k = 0; k < 2; ++k) {
    btScalar& x = at.getOrigin()[k];
    const btScalar beyond = std::clamp((period[k] - 2 * largest) / 2, btScalar(0), largest);
    if (x >= -beyond && x < period[k] + beyond) continue;
    x -= period[k] * std::floor(x / period[k]);
    moved = true;
  }
  if (!moved) return;
  body.rigid->setWorldTransform(at);
  body.rigid->setInterpolationWorldTransform(at);
  // Its contacts are elsewhere now.
  broadphase.getOverlappingPairCache()->cleanProxyFromPairs(body.rigid->getBroadphaseProxy(), &dispatcher);
}

// Copies that no body can reach take no part.
void FallingBodies::World::place_copies(FallingBody& body) {
  const btTransform& at = body.rigid->getWorldTransform();
  const btScalar near = body.reach + 2 * largest;
  for (Copy& copy : body.copies) {
    btTransform shifted = at;
    shifted.getOrigin() += copy.shift;
    const btVector3& p = shifted.getOrigin();
    const bool present = copy.object->getBroadphaseHandle() != nullptr;
    const btScalar far = present ? near + largest : near;  // so that few come and go
    const bool needed = p.x() > -far && p.x() < period[0] + far && p.y() < period[1] + far;
    copy.object->setWorldTransform(shifted);
    copy.object->setInterpolationWorldTransform(shifted);
    if (needed && !present) dynamics.addCollisionObject(copy.object.get(), kCopy, kBody);
    if (!needed && present) dynamics.removeCollisionObject(copy.object.get());
  }
}

void FallingBodies::step(const Work& work) {
  World& w = *world_;
  w.solver.work = w.dispatcher.work = &work;
  for (FallingBody& body : w.bodies) {
    w.wrap(body);
    w.place_copies(body);
  }
  w.dynamics.stepSimulation(kStep, 0);
  work.check();
  for (FallingBody& body : w.bodies) {
    const btVector3& v = body.rigid->getLinearVelocity();
    if (const btScalar speed = v.length(); speed > kMostSpeed)
      body.rigid->setLinearVelocity(v * (kMostSpeed / speed));
  }
}

void FallingBodies::calm() {
  for (FallingBody& body : world_->bodies) body.rigid->setDamping(kCalm, kCalm);
}

double FallingBodies::speed() const {
  double sum = 0;
  for (const FallingBody& body : world_->bodies) sum += body.rigid->getLinearVelocity().length2();
  return world_->bodies.empty() ? 0 : std::sqrt(sum / static_cast<double>(world_->bodies.size()));
}

double FallingBodies::fastest() const {
  double most = 0;
  for (const FallingBody& body : world_->bodies)
    most = std::max<double>(most, body.rigid->getLinearVelocity().length());
  return most;
}

Vec3 FallingBodies::position(std::size_t body) const {
  const btVector3& p = world_->bodies[body].rigid->getWorldTransform().getOrigin();
  Vec3 at = world_->unit * Vec3(p.x(), p.y(), p.z());
  for (int k = 0; k < 2; ++k) {
    const double period = world_->unit * world_->period[k];
    at[k] -= period * std::floor(at[k] / period);
    if (at[k] >= period) at[k] = 0;
  }
  return at;
}

Quat FallingBodies::orientation(std::size_t body) const {
  const btQuaternion q = world_->bodies[body].rigid->getWorldTransform().getRotation();
  return Quat(q.w(), q.x(), q.y(), q.z()).normalized();
}

}  // namespace terrazzo::packing
