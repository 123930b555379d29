// (e): compiled where Bullet is there.

#include "tools/workshop/rivals/bullet_body.hpp"

#include <BulletCollision/BroadphaseCollision/btDbvtBroadphase.h>
#include <BulletCollision/CollisionShapes/btConvexHullShape.h>
#include <BulletSoftBody/btDeformableBodySolver.h>
#include <BulletSoftBody/btDeformableMultiBodyConstraintSolver.h>
#include <BulletSoftBody/btDeformableMultiBodyDynamicsWorld.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>
#include <BulletSoftBody/btSoftBodyHelpers.h>
#include <BulletSoftBody/btSoftBodyRigidBodyCollisionConfiguration.h>
#include <LinearMath/btDefaultMotionState.h>

#include <cmath>
#include <vector>

namespace palpate::tools {
namespace {

constexpr double kLength = 100;  // of Bullet's units in a metre: its tolerances are for such bodies
constexpr double kMargin_m = 1e-5;    // around the shapes
constexpr double kVoxel_radii = 0.1;  // of the ball's distance field
constexpr int kHullPoints = 400;      // 0.4 % of the radius beneath the ball at most
constexpr double kGoldenAngle = 2.399963229728653;

btVector3 bullet(const Vec3& x_m) {
  return {btScalar(kLength * x_m[0]), btScalar(kLength * x_m[1]), btScalar(kLength * x_m[2])};
}

// What has no setters: iterations, and a tolerance (squared) that double precision would set to
// 1e-16.
struct NewtonSolver : btDeformableBodySolver {
  explicit NewtonSolver(const BulletSettings& settings) {
    m_maxNewtonIterations = settings.newton;
    m_cg.setTolerance(btScalar(settings.tolerance * settings.tolerance));
  }
};

// Nodes that move first: an implicit step of Bullet 3.24 counts forces past held ones wrongly.
std::vector<int> moving_first(const std::vector<char>& is_held) {
  std::vector<int> order;
  for (const char held : {0, 1})
    for (std::size_t n = 0; n < is_held.size(); ++n)
      if (is_held[n] == held) order.push_back(static_cast<int>(n));
  return order;
}

CoarseBody reordered(CoarseBody body) {
  const std::vector<int> order = moving_first(body.is_held);
  std::vector<int> place(order.size());
  const CoarseBody old = body;
  for (std::size_t n = 0; n < order.size(); ++n) {
    place[static_cast<std::size_t>(order[n])] = static_cast<int>(n);
    body.nodes.row(static_cast<Eigen::Index>(n)) = old.nodes.row(order[n]);
    body.is_held[n] = old.is_held[static_cast<std::size_t>(order[n])];
  }
  for (auto& node : body.tets.reshaped()) node = place[static_cast<std::size_t>(node)];
  return body;
}

}  // namespace

// Masses are kg, lengths centimetres, times seconds: a pressure of 1 Pa is 1 / kLength.
struct BulletBody::World {
  btSoftBodyRigidBodyCollisionConfiguration configuration;
  btCollisionDispatcher dispatcher{&configuration};
  btDbvtBroadphase broadphase;
  NewtonSolver solver;
  btDeformableMultiBodyConstraintSolver constraints;
  btDeformableMultiBodyDynamicsWorld world;
  btConvexHullShape shape;  // contacts with faces take a sphere's margin, its radius, twice
  btDefaultMotionState motion;
  btRigidBody ball;
  btDeformableNeoHookeanForce elements;
  btSoftBody* soft = nullptr;  // the world's
  btAlignedObjectArray<btVector3> pull;
  bool is_placed = false;

  World(const CoarseBody& body, const BulletSettings& settings)
      : solver(settings),
        world(&dispatcher, &broadphase, with_solver(), &configuration, &solver),
        ball(0, &motion, &shape) {
    for (int k = 0; k < kHullPoints; ++k) {  // a spiral around it
      const double z = 1 - (2 * k + 1.0) / kHullPoints, around = k * kGoldenAngle;
      const double beside = std::sqrt(1 - z * z);
      shape.addPoint(bullet(settings.ball.radius_m *
                            Vec3(beside * std::cos(around), beside * std::sin(around), z)),
                     false);
    }
    shape.setMargin(btScalar(kLength * kMargin_m));
    shape.recalcLocalAabb();
    world.setImplicit(true);
    world.setLineSearch(false);
    world.setUseProjection(true);
    world.setGravity({0, 0, 0});
    world.getWorldInfo().m_gravity = {0, 0, 0};
    world.getWorldInfo().m_sparsesdf.setDefaultVoxelsz(
        btScalar(kVoxel_radii * kLength * settings.ball.radius_m));
    world.getWorldInfo().m_sparsesdf.Reset();
    world.getSolverInfo().m_deformable_erp = btScalar(0.3);
    world.getSolverInfo().m_deformable_cfm = 0;
    world.getSolverInfo().m_deformable_maxErrorReduction = 1e3;
    ball.setCollisionFlags(ball.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
    ball.setActivationState(DISABLE_DEACTIVATION);
    ball.setFriction(1);
    world.addRigidBody(&ball);
    add_body(body, settings);
  }
  ~World() {
    world.removeSoftBody(soft);
    world.removeRigidBody(&ball);
    delete soft;
  }

  btDeformableMultiBodyConstraintSolver* with_solver() {
    constraints.setDeformableSolver(&solver);
    return &constraints;
  }

  void add_body(const CoarseBody& body, const BulletSettings& settings) {
    btAlignedObjectArray<btVector3> place;
    for (const auto& node : body.nodes.rowwise()) place.push_back(bullet(node.transpose()));
    soft = new btSoftBody(&world.getWorldInfo(), place.size(), &place[0], nullptr);
    for (const auto& tet : body.tets.rowwise()) {
      soft->appendTetra(tet[0], tet[1], tet[2], tet[3]);
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < a; ++b) soft->appendLink(tet[a], tet[b], nullptr, true);
    }
    btSoftBodyHelpers::generateBoundaryFaces(soft);
    soft->initializeDmInverse();
    soft->m_tetraScratches.resize(soft->m_tetras.size());
    soft->m_tetraScratchesTn.resize(soft->m_tetras.size());
    soft->getCollisionShape()->setMargin(btScalar(kLength * kMargin_m));
    Eigen::VectorXd mass = Eigen::VectorXd::Zero(body.nodes.rows());
    const double young = body.young_Pa.mean(), poisson = body.poisson.mean();
    for (Eigen::Index t = 0; t < body.tets.rows(); ++t) {
      const double volume = edges_of(body.nodes, body.tets, t).determinant() / 6;
      for (const int node : body.tets.row(t)) mass[node] += settings.density_kg_m3 * volume / 4;
      // One material for a body: what is stiffer counts as more of it.
      soft->m_tetras[static_cast<int>(t)].m_element_measure *= btScalar(body.young_Pa[t] / young);
    }
    for (int n = 0; n < soft->m_nodes.size(); ++n)
      soft->setMass(n, body.is_held[static_cast<std::size_t>(n)] ? 0 : btScalar(mass[n]));
    soft->m_cfg.kKHR = soft->m_cfg.kCHR = 1;
    soft->m_cfg.kDF = btScalar(settings.ball.friction);
    soft->m_cfg.kDP = 0;
    soft->m_cfg.m_maxStress = 0;
    soft->m_cfg.collisions = btSoftBody::fCollision::SDF_RD | btSoftBody::fCollision::SDF_RDF;
    soft->setActivationState(DISABLE_DEACTIVATION);
    soft->setSelfCollision(false);
    world.addSoftBody(soft);
    // Smith, de Goes and Kim 2018, doi:10.1145/3180491: its mu and lambda of those at small strain.
    const double shear = young / (2 * (1 + poisson)),
                 lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
    elements.setLameParameters(btScalar(4.0 / 3 * shear / kLength),
                               btScalar((lame + 5.0 / 6 * shear) / kLength));
    elements.setDamping(btScalar(settings.damping_s));
    world.addForce(soft, &elements);
  }

  void place(const Vec3& centre_m) {
    btTransform at;
    at.setIdentity();
    at.setOrigin(bullet(centre_m));
    motion.setWorldTransform(at);
    if (!is_placed) {
      ball.setWorldTransform(at);
      ball.setInterpolationWorldTransform(at);
      ball.setLinearVelocity({0, 0, 0});
    }
    is_placed = true;
  }

  Vec3 held_N(const CoarseBody& body) {
    pull.resize(soft->m_nodes.size());
    for (int n = 0; n < pull.size(); ++n) pull[n].setZero();
    for (int n = 0; n < pull.size(); ++n) soft->m_nodes[n].m_q = soft->m_nodes[n].m_x;
    soft->updateDeformation();
    elements.addScaledElasticForce(1, pull);
    Vec3 sum = Vec3::Zero();
    for (int n = 0; n < pull.size(); ++n)
      if (body.is_held[static_cast<std::size_t>(n)])
        sum += Vec3(pull[soft->m_nodes[n].index][0], pull[soft->m_nodes[n].index][1],
                    pull[soft->m_nodes[n].index][2]);
    return sum / kLength;
  }
};

BulletBody::BulletBody(CoarseBody body, const BulletSettings& settings)
    : body_(reordered(std::move(body))), settings_(settings) {
  start();
}

BulletBody::~BulletBody() = default;

void BulletBody::start() { world_ = std::make_unique<World>(body_, settings_); }

std::size_t BulletBody::bytes() const {
  const btSoftBody& soft = *world_->soft;
  return static_cast<std::size_t>(soft.m_nodes.size()) * sizeof(btSoftBody::Node) +
         static_cast<std::size_t>(soft.m_tetras.size()) *
             (sizeof(btSoftBody::Tetra) + 2 * sizeof(btSoftBody::TetraScratch)) +
         static_cast<std::size_t>(soft.m_links.size()) * sizeof(btSoftBody::Link) +
         static_cast<std::size_t>(soft.m_faces.size()) * sizeof(btSoftBody::Face);
}

Vec3 BulletBody::force(const Vec3& centre_m) {
  world_->place(centre_m);
  world_->world.stepSimulation(btScalar(settings_.step_s), 1, btScalar(settings_.step_s));
  return world_->held_N(body_);
}

}  // namespace palpate::tools
