// One correction of an equilibrium: contact and friction solved on the factor's own tangent,
// condensed to the nodes near the probe. The springs of an elastic bed follow.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <vector>

#include "libfem/mesh/topology.hpp"
#include "libfem/solve/equilibrium/equilibrium.hpp"
#include "libfem/solve/factor/dense_kernels.hpp"

namespace palpate::fem {
namespace {

// A tangent of an earlier place serves for as long as a step with it brings the residual down to
// this share: a step with a fresh one costs as much as five.
constexpr double kKeptTangent = 0.6;

Eigen::VectorXf symmetric_product(const Eigen::MatrixXf& A, const Eigen::VectorXf& x) {
  Eigen::VectorXf out(A.rows());
  dense_kernels().multiply_symmetric(A.data(), static_cast<int>(A.rows()), x.data(), out.data());
  return out;
}

Eigen::VectorXd product(const Eigen::MatrixXd& A, const Eigen::VectorXd& x) {
  Eigen::VectorXd out(A.rows());
  dense_kernels().multiply(A.data(), static_cast<int>(A.rows()), x.data(), out.data());
  return out;
}

}  // namespace

void CondensedTangent::cover(const Eigen::MatrixXf& flexibility,
                             const std::vector<Eigen::Index>& touching) {
  const bool holds =
      std::includes(unknowns_.begin(), unknowns_.end(), touching.begin(), touching.end());
  // Condensing anew is due when the kept unknowns are this many times those that touch: a
  // factorization of theirs costs twice as much.
  if (holds && unknowns_.size() <= 1.25 * touching.size()) return;
  unknowns_ = touching;
  stiffness_ = flexibility(unknowns_, unknowns_);
  const int size = static_cast<int>(unknowns_.size());
  dense_kernels().factor_front(stiffness_.data(), size, size);
  dense_kernels().invert_from_factor(stiffness_.data(), size);
}

void CondensedTangent::set_contact(Eigen::MatrixXd C) {
  C_ = std::move(C);
  factor_ = stiffness_ + C_.cast<float>();
  exchanges_.resize(unknowns_.size());
  dense_kernels().factor_general(factor_.data(), static_cast<int>(unknowns_.size()),
                                 exchanges_.data());
}

CondensedTangent::CondensedStep CondensedTangent::step(const Eigen::MatrixXf& flexibility,
                                                       const Eigen::VectorXd& residual) const {
  Eigen::VectorXf own = residual(unknowns_).cast<float>();
  Eigen::VectorXd elsewhere = residual;
  elsewhere(unknowns_).setZero();
  if (!elsewhere.isZero(0)) {
    const Eigen::VectorXf driven = symmetric_product(flexibility, elsewhere.cast<float>());
    own += symmetric_product(stiffness_, driven(unknowns_));
  }
  dense_kernels().solve_general(factor_.data(), static_cast<int>(unknowns_.size()),
                                exchanges_.data(), own.data());
  CondensedStep out{{}, -residual};
  out.z(unknowns_) += product(C_, own.cast<double>());
  out.w = -symmetric_product(flexibility, out.z.cast<float>()).cast<double>();
  return out;
}

// Stiffness of the latest contact terms on some unknowns of the dense block, all entries.
Eigen::MatrixXd Equilibrium::condensed_stiffness(const std::vector<Eigen::Index>& unknowns) const {
  const auto size = static_cast<std::int32_t>(unknowns.size());
  std::vector<std::int32_t> place(3 * factor_.contact_nodes().size(), -1);
  for (std::int32_t k = 0; k < size; ++k) place[unknowns[k]] = k;
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(size, size);
  using Block = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;
  for (const FaceTerms& face : contact_.terms()) {
    std::array<std::int32_t, kFaceNodes> at;
    for (int a = 0; a < kFaceNodes; ++a) {
      const std::int32_t i = contact_place(face.face, a);
      at[a] = i < 0 ? -1 : place[3 * i];
    }
    for (int a = 0; a < kFaceNodes; ++a)
      for (int b = 0; b <= a && at[a] >= 0; ++b) {
        if (at[b] < 0) continue;
        const Block block(face.stiffness + 9 * (a * (a + 1) / 2 + b));
        C.block<3, 3>(at[a], at[b]) += block;
        if (a != b) C.block<3, 3>(at[b], at[a]) += block;
      }
  }
  return C;
}

// Contact on the factor's dense block, solved by Newton's method with friction coupled; the other
// unknowns follow linearly. Where that stalls, friction is lagged until a descent in energy has
// come close.
class Equilibrium::CondensedContact {
 public:
  CondensedContact(Equilibrium& of, const Step& now)
      : of_(of),
        at_(now.at),
        node_of_(of.factor_.contact_nodes().size()),
        u_(now.at.u),
        trial_{u_, now.pose, now.from.history} {
    for (Eigen::Index n = 0; n < at_.u.rows(); ++n)
      if (const std::int32_t i = of_.body_.free_index()[n]; i >= 0 && of_.contact_index_[i] >= 0)
        node_of_[of_.contact_index_[i]] = n;
    // Contact forces are added behind the reduction, whose single precision small residuals
    // survive.
    of_.factor_.reduce(at_.residual, load_);
    force_before_ = force();
    load_ += force_before_;
    sum_ = {Eigen::VectorXd::Zero(load_.size()), load_};
  }

  Correction solve() {
    // A tenth of the residual of the body, or of its goal.
    const double goal =
        0.1 * std::max(of_.options_.residual, at_.residual.norm() / at_.contact_scale_N);
    relative_ = evaluate();
    is_kept_ = !of_.tangent_.is_empty();
    for (int iteration = 0; iteration < 20; ++iteration) {
      if (is_coupled_ && relative_ <= goal) break;
      ++of_.counts_.model;
      if (is_coupled_)
        iterate_coupled();
      else
        iterate_lagged();
    }
    of_.contact_.lag_friction_limit(trial_);
    Correction out;
    out.load = at_.residual;
    const auto& nodes = of_.factor_.contact_nodes();
    for (std::size_t i = 0; i < nodes.size(); ++i)
      out.load.segment<3>(3 * nodes[i]) += (force_before_ - sum_.z).segment<3>(3 * i);
    of_.factor_.expand(sum_.w, out.displacement);
    return out;
  }

 private:
  using CondensedStep = CondensedTangent::CondensedStep;
  using Tangent = ContactInterface::Tangent;

  // Force of the latest contact terms over the dense block.
  Eigen::VectorXd force() const {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(3 * std::ssize(node_of_));
    for (const FaceTerms& face : of_.contact_.terms())
      for (int a = 0; a < kFaceNodes; ++a)
        if (const std::int32_t i = of_.contact_place(face.face, a); i >= 0)
          force.segment<3>(3 * i) += Eigen::Map<const Vec3>(face.force + 3 * a);
    return force;
  }

  // Unknowns of the dense block on faces of the latest contact terms, increasing.
  std::vector<Eigen::Index> touching_unknowns() const {
    std::vector<Eigen::Index> out;
    for (const FaceTerms& face : of_.contact_.terms())
      for (int a = 0; a < kFaceNodes; ++a)
        if (const std::int32_t i = of_.contact_place(face.face, a); i >= 0)
          for (int c = 0; c < 3; ++c) out.push_back(3 * i + c);
    sort_unique(out);
    return out;
  }

  void advance(const CondensedStep& step, double length) {
    sum_.w += length * step.w;
    sum_.z += length * step.z;
    for (std::size_t i = 0; i < node_of_.size(); ++i)
      u_.row(node_of_[i]) = at_.u.row(node_of_[i]) + sum_.w.segment<3>(3 * i).transpose();
  }

  // Sets the residual and returns its relative size; 0 where nothing touches and nothing is
  // exerted.
  double evaluate(Tangent uncoupled = Tangent::lagged) {
    of_.contact_.evaluate(trial_, is_coupled_ ? Tangent::coupled : uncoupled);
    const Eigen::VectorXd exerted = force();
    residual_ = sum_.z - exerted;
    return residual_.norm() > 0 ? residual_.norm() / exerted.norm() : 0;
  }

  void refactor() {
    of_.tangent_.cover(of_.factor_.flexibility(), touching_unknowns());
    of_.tangent_.set_contact(of_.condensed_stiffness(of_.tangent_.unknowns()));
  }

  CondensedStep newton_step() const {
    return of_.tangent_.step(of_.factor_.flexibility(), residual_);
  }
  double energy() const { return -0.5 * sum_.w.dot(load_ + sum_.z) + of_.contact_.energy(trial_); }

  // Halves a step until the energy for the lagged limit falls.
  bool falls(const CondensedStep& step) {
    const double start = energy(), slope = -residual_.dot(step.w);
    if (!(slope < 0)) return false;
    double length = 1;
    advance(step, 1);
    for (int cut = 0; cut < 8; ++cut, length /= 2) {
      if (energy() <= start + 1e-4 * length * slope) return true;
      advance(step, -length / 2);
    }
    advance(step, -length);
    return false;
  }

  double descend() {
    refactor();
    if (falls(newton_step())) return evaluate();
    evaluate(Tangent::lagged_flat);
    refactor();
    const CondensedStep step = newton_step();
    if (!falls(step)) advance(step, 1.0 / 256);
    return evaluate();
  }

  void iterate_lagged() {
    relative_ = descend();
    if (relative_ > 0.1) return;
    of_.contact_.lag_friction_limit(trial_);
    is_coupled_ = true;
    is_kept_ = false;
    relative_ = evaluate();
  }

  void iterate_coupled() {
    if (!is_kept_) refactor();
    const CondensedStep step = newton_step();
    const double before = relative_;
    double length = 1;
    advance(step, 1);
    relative_ = evaluate();
    if (is_kept_ && relative_ > kKeptTangent * before) {
      advance(step, -1);
      relative_ = evaluate();
      is_kept_ = false;
      return;
    }
    for (int cut = 0; cut < 4 && relative_ > (1 - 0.1 * length) * before; ++cut, length /= 2) {
      advance(step, -length / 2);
      relative_ = evaluate();
    }
    is_kept_ = relative_ <= kKeptTangent * before;
    // A step of coupled friction that leaves this share of the residual has met its match.
    if (relative_ <= 0.98 * before) return;
    of_.contact_.lag_friction_limit(trial_);
    is_coupled_ = false;
    relative_ = evaluate();
  }

  Equilibrium& of_;
  const Local& at_;
  std::vector<Eigen::Index> node_of_;  // of each contact node
  Eigen::VectorXd load_, force_before_, residual_;
  CondensedStep sum_;  // of all steps, from at_
  Points u_;
  const ContactTrial trial_;
  double relative_ = 0;  // size of the residual z - f(w) over that of f
  bool is_coupled_ = true, is_kept_ = false;
};

// The correction after which a body with the factor's tangent would rest.
Equilibrium::Correction Equilibrium::correction(const Step& now) {
  return CondensedContact(*this, now).solve();
}

ElasticBed::ElasticBed(const QuadraticMesh& mesh, const BedAt& bed_at) {
  if (!bed_at) return;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    BedFace face;
    for (int a = 0; a < kFaceNodes; ++a) face.node[a] = mesh.faces(f, a);
    const FaceNodes nodes = nodes_of_face(mesh.nodes, face.node);
    face.block.fill(Mat3::Zero());
    bool has_bed = false;
    for (const FacePoint& point : kFaceRule) {
      const BedStiffness bed = bed_at(place_at(point, nodes));
      if (bed.along_N_m3 == 0 && bed.across_N_m3 == 0) continue;
      has_bed = true;
      const Vec3 area = area_normal_at(point, nodes);
      const Vec3 normal = area.normalized();
      const Mat3 stiffness = point.weight * area.norm() *
                             ((bed.along_N_m3 - bed.across_N_m3) * normal * normal.transpose() +
                              bed.across_N_m3 * Mat3::Identity());  // (M13f)
      for (int a = 0, pair = 0; a < kFaceNodes; ++a)
        for (int b = 0; b <= a; ++b, ++pair)
          face.block[pair] += point.shape[a] * point.shape[b] * stiffness;
    }
    if (has_bed) faces_.push_back(face);
  }
}

double ElasticBed::add_force(const Points& u, Points& force) const {
  double energy = 0;
  for (const BedFace& face : faces_)
    for (int a = 0, pair = 0; a < kFaceNodes; ++a)
      for (int b = 0; b <= a; ++b, ++pair) {
        const Vec3 at_a = u.row(face.node[a]), at_b = u.row(face.node[b]);
        const Vec3 pull = face.block[pair] * at_b;
        force.row(face.node[a]) += pull;
        energy += (a == b ? 0.5 : 1.0) * at_a.dot(pull);
        if (a != b) force.row(face.node[b]) += face.block[pair] * at_a;
      }
  return energy;
}

void ElasticBed::add_stiffness(const std::vector<std::int32_t>& free_index,
                               SymmetricBlockMatrix& K) const {
  for (const BedFace& face : faces_)
    for (int a = 0, pair = 0; a < kFaceNodes; ++a)
      for (int b = 0; b <= a; ++b, ++pair) {
        const std::int32_t i = free_index[face.node[a]], j = free_index[face.node[b]];
        // A block is symmetric, so it need not be turned.
        if (i >= 0 && j >= 0) K.add(K.place(i, j), face.block[pair].data());
      }
}

}  // namespace palpate::fem
