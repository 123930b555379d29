#include "static_problem.hpp"

#include <Eigen/CholmodSupport>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include "record.hpp"
#include "tests/libfem/matrix_entries.hpp"

namespace palpate::fem {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<std::array<int, 2>, 6> kEdges{
    {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
// Corners, then middles of (0,1) (1,2) (2,0) of each face of a ten-node tet.
constexpr int kFaces[4][6] = {
    {0, 2, 1, 6, 5, 4}, {0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {2, 0, 3, 6, 7, 9}};

/// The free rows and columns of K.
class FreeMatrix {
 public:
  explicit FreeMatrix(const Eigen::VectorXd& prescribed) : index_(prescribed.size(), -1) {
    for (Eigen::Index i = 0; i < prescribed.size(); ++i)
      if (std::isnan(prescribed[i])) index_[i] = size_++;
  }
  int size() const { return size_; }
  int index(Eigen::Index i) const { return index_[i]; }

  Eigen::SparseMatrix<double> lower(const SymmetricBlockMatrix& K) const {
    Eigen::SparseMatrix<double> out(size_, size_);
    out.reserve(static_cast<Eigen::Index>(K.values().size()));
    visit_entries(K, [&](int row, int column, double value) {
      if (index_[column] < 0) return;
      if (row == column) out.startVec(index_[column]);
      if (index_[row] >= 0) out.insertBack(index_[row], index_[column]) = value;
    });
    out.finalize();
    return out;
  }
  Eigen::VectorXd restricted(const Points& field) const {
    Eigen::VectorXd out(size_);
    for (Eigen::Index i = 0; i < field.size(); ++i)
      if (index_[i] >= 0) out[index_[i]] = field(i / 3, i % 3);
    return out;
  }
  void add(const Eigen::VectorXd& by, double factor, Points& field) const {
    for (Eigen::Index i = 0; i < field.size(); ++i)
      if (index_[i] >= 0) field(i / 3, i % 3) += factor * by[index_[i]];
  }

 private:
  std::vector<int> index_;
  int size_ = 0;
};

class Newton {
 public:
  explicit Newton(const StaticProblem& problem)
      : problem_(problem),
        body_(problem.mesh, {problem.material}, nullptr),
        K_(body_.pattern()),
        free_(problem.prescribed) {
    solver_.cholmod().print = 0;
  }

  /// From equilibrium at share `from` to share `to` of prescribed displacement and load.
  bool step(double from, double to, StaticOutcome& out) {
    Points u = out.u, change = Points::Zero(u.rows(), 3);
    for (Eigen::Index i = 0; i < u.size(); ++i)
      if (!std::isnan(problem_.prescribed[i]))
        change(i / 3, i % 3) = (to - from) * problem_.prescribed[i];
    Points force;
    Eigen::VectorXd direction;
    if (!tangent_direction(u, to, change, force, direction)) return false;
    u += change;
    free_.add(direction, 1, u);
    for (int iteration = 0; iteration < 30; ++iteration) {
      ++out.newton;
      if (!std::isfinite(body_.energy(u))) return false;
      const bool is_direction =
          tangent_direction(u, to, Points::Zero(u.rows(), 3), force, direction);
      const double scale = force.cwiseAbs().maxCoeff() + to * problem_.load.cwiseAbs().maxCoeff();
      const Eigen::VectorXd residual = free_.restricted(to * problem_.load - force);
      if (residual.cwiseAbs().maxCoeff() <= 1e-10 * scale) {
        out.u = u;
        out.min_J = body_.min_J();
        out.reaction = force - to * problem_.load;
        return true;
      }
      if (!is_direction || !search(direction, residual, to, u)) return false;
    }
    return false;
  }

 private:
  double potential(const Points& u, double share) const {
    return body_.energy(u) - share * problem_.load.cwiseProduct(u).sum();
  }

  // K d = load - force - K change, with less of the indefinite part of K where it has to be.
  bool tangent_direction(const Points& u, double share, const Points& change, Points& force,
                         Eigen::VectorXd& direction) {
    for (const double geometric_scale : {1.0, 0.5, 0.0}) {
      force = Points::Zero(u.rows(), 3);
      K_.set_zero();
      body_.add_stiffness(u, geometric_scale, force, K_);
      Points right = share * problem_.load - force;
      visit_entries(K_, [&](int row, int column, double value) {
        right(row / 3, row % 3) -= value * change(column / 3, column % 3);
        if (row != column) right(column / 3, column % 3) -= value * change(row / 3, row % 3);
      });
      const Eigen::SparseMatrix<double> K = free_.lower(K_);
      if (!is_analysed_) {
        solver_.analyzePattern(K);
        is_analysed_ = true;
      }
      solver_.factorize(K);
      if (solver_.info() != Eigen::Success) continue;
      direction = solver_.solve(free_.restricted(right));
      return direction.allFinite();
    }
    return false;
  }

  bool search(const Eigen::VectorXd& direction, const Eigen::VectorXd& residual, double share,
              Points& u) {
    const double start = potential(u, share), slope = -residual.dot(direction);
    double length = 1;
    for (int cut = 0; cut < 15; ++cut, length /= 2) {
      Points trial = u;
      free_.add(direction, length, trial);
      if (potential(trial, share) <= start + 1e-4 * length * slope + 1e-12 * std::abs(start)) {
        u = trial;
        return true;
      }
    }
    return false;
  }

  const StaticProblem& problem_;
  ElasticBody body_;
  SymmetricBlockMatrix K_;
  FreeMatrix free_;
  Eigen::CholmodSupernodalLLT<Eigen::SparseMatrix<double>, Eigen::Lower> solver_;
  bool is_analysed_ = false;
};

/// Fourteen points, exact to degree 5. Source: Walkington 2000, quadrature on simplices of
/// arbitrary dimension.
std::vector<ElementPoint> fine_rule() {
  std::vector<ElementPoint> out;
  for (const auto& [far, weight] : {std::pair(0.310885919263300610, 0.112687925718015850),
                                    std::pair(0.0927352503108912264, 0.0734930431163619495)})
    for (int c = 0; c < 4; ++c) {
      Eigen::Vector4d L = Eigen::Vector4d::Constant(far);
      L[c] = 1 - 3 * far;
      out.push_back(element_point(L, weight));
    }
  constexpr double kNear = 0.0455037041256496495;
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < a; ++b) {
      Eigen::Vector4d L = Eigen::Vector4d::Constant(0.5 - kNear);
      L[a] = L[b] = kNear;
      out.push_back(element_point(L, 0.0425460207770814664));
    }
  return out;
}

template <class Visit>
void visit_points(const StaticProblem& problem, const Visit& visit) {
  for (Eigen::Index t = 0; t < problem.mesh.tets.rows(); ++t)
    for (const ElementPoint& point : fine_rule()) {
      Vec3 X = Vec3::Zero();
      Mat3 jacobian = Mat3::Zero();
      for (int a = 0; a < kElementNodes; ++a) {
        const Vec3 node = problem.mesh.nodes.row(problem.mesh.tets(t, a));
        X += point.shape[a] * node;
        jacobian += node * point.by_xi.row(a);
      }
      visit(t, point.shape, X, point.weight * jacobian.determinant() / 6);
    }
}

}  // namespace

QuadraticMesh quadratic(const TetMesh& parameters, const std::function<Vec3(const Vec3&)>& place) {
  QuadraticMesh out;
  std::vector<Vec3> nodes;
  for (Eigen::Index n = 0; n < parameters.nodes.rows(); ++n)
    nodes.push_back(place(parameters.nodes.row(n).transpose()));
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
  out.tets.resize(parameters.tets.rows(), 10);
  for (Eigen::Index t = 0; t < parameters.tets.rows(); ++t) {
    for (int c = 0; c < 4; ++c) out.tets(t, c) = parameters.tets(t, c);
    for (int e = 0; e < 6; ++e) {
      const std::int32_t a = parameters.tets(t, kEdges[e][0]), b = parameters.tets(t, kEdges[e][1]);
      const auto [at, is_new] = middles.try_emplace({std::min(a, b), std::max(a, b)},
                                                    static_cast<std::int32_t>(nodes.size()));
      if (is_new)
        nodes.push_back(place((parameters.nodes.row(a) + parameters.nodes.row(b)).transpose() / 2));
      out.tets(t, 4 + e) = at->second;
    }
  }
  out.nodes.resize(static_cast<Eigen::Index>(nodes.size()), 3);
  for (std::size_t n = 0; n < nodes.size(); ++n)
    out.nodes.row(static_cast<Eigen::Index>(n)) = nodes[n];
  out.is_held.assign(nodes.size(), 0);
  const Triangles boundary = boundary_triangles(parameters.tets);
  out.faces.resize(boundary.rows(), 6);
  for (Eigen::Index f = 0; f < boundary.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const std::int32_t a = boundary(f, k), b = boundary(f, (k + 1) % 3);
      out.faces(f, k) = a;
      out.faces(f, 3 + k) = middles.at({std::min(a, b), std::max(a, b)});
    }
  return out;
}

StaticProblem::StaticProblem(QuadraticMesh mesh_of_body, const Material& of)
    : mesh(std::move(mesh_of_body)),
      material(of),
      prescribed(Eigen::VectorXd::Constant(3 * mesh.nodes.rows(), kNaN)),
      load(Points::Zero(mesh.nodes.rows(), 3)) {}

void StaticProblem::prescribe(const std::function<bool(const Vec3&)>& here, int component,
                              double value_m) {
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n)
    if (here(mesh.nodes.row(n).transpose())) prescribed[3 * n + component] = value_m;
}

void StaticProblem::add_traction(const std::function<bool(const Vec3&)>& here,
                                 const Vec3& traction_Pa) {
  // A flat face of six nodes: a third of the area at each middle, nothing at the corners.
  for (Eigen::Index t = 0; t < mesh.tets.rows(); ++t)
    for (const auto& face : kFaces) {
      const auto node = [&](int k) {
        return Vec3(mesh.nodes.row(mesh.tets(t, face[k])).transpose());
      };
      bool is_here = true;
      for (int k = 0; k < 6; ++k) is_here = is_here && here(node(k));
      if (!is_here) continue;
      const double area = (node(1) - node(0)).cross(node(2) - node(0)).norm() / 2;
      for (int k = 3; k < 6; ++k)
        load.row(mesh.tets(t, face[k])) += area / 3 * traction_Pa.transpose();
    }
}

void StaticProblem::add_body_force(const std::function<Vec3(const Vec3&)>& force_N_m3) {
  visit_points(*this,
               [&](Eigen::Index t, const Eigen::VectorXd& shape, const Vec3& X, double volume) {
                 const Vec3 force = volume * force_N_m3(X);
                 for (int a = 0; a < kElementNodes; ++a)
                   load.row(mesh.tets(t, a)) += shape[a] * force.transpose();
               });
}

StaticOutcome solve(const StaticProblem& problem, int steps) {
  const double start = palpate::validation::cpu_seconds();
  StaticOutcome out;
  out.u = Points::Zero(problem.mesh.nodes.rows(), 3);
  Newton newton(problem);
  double share = 0, step = 1.0 / steps;
  while (share < 1 && step > 1e-3 / steps) {
    const double next = share + step > 1 - 1e-9 ? 1 : share + step;
    ++out.steps;
    if (newton.step(share, next, out))
      share = next;
    else
      step /= 2;
  }
  out.is_solved = share == 1;
  out.cpu_s = palpate::validation::cpu_seconds() - start;
  return out;
}

double l2_error(const StaticProblem& problem, const Points& u,
                const std::function<Vec3(const Vec3&)>& exact) {
  double sum = 0;
  visit_points(problem,
               [&](Eigen::Index t, const Eigen::VectorXd& shape, const Vec3& X, double volume) {
                 Vec3 error = -exact(X);
                 for (int a = 0; a < kElementNodes; ++a)
                   error += shape[a] * u.row(problem.mesh.tets(t, a)).transpose();
                 sum += volume * error.squaredNorm();
               });
  return std::sqrt(sum);
}

}  // namespace palpate::fem
