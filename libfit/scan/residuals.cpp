#include "libfit/scan/residuals.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace palpate::scan {
namespace {

using runtime::kRings;

// Derivatives of the force of one row by the numbers at its contact point.
struct RowDerivative {
  Nodes::CellPlace at;
  Eigen::Matrix<double, 3, Eigen::Dynamic> increment;  // by each increment [1]
  Eigen::Matrix<double, 3, Nodes::kHeights> height;    // by each height [N/m]
  Vec3 friction, friction_slope;
};

// Stiffnesses c_i of the rings as rows of weights of the control values (B0).
Eigen::MatrixXd ring_weights(const runtime::RingTable& table, int controls) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(kRings, controls);
  for (int i = 0; i < kRings; ++i)
    for (int k = 0; k < table.order; ++k) {
      out(i, table.first[i] + k) += table.slope[i][k];
      if (i + 1 < kRings) out(i + 1, table.first[i] + k) -= table.slope[i][k];
    }
  return out;
}

Vec3 vec3(const runtime::Vec3d& v) { return {v.x, v.y, v.z}; }

// The law of rings at the contact point of a row, and its derivatives.
class Differentiator {
 public:
  Differentiator(const Nodes& nodes, const PlayedBody& body, const ScanParameters& at)
      : nodes_(nodes),
        body_(body),
        parameters_(at),
        table_(body.asset().curves.rings),
        fast_(body.asset().curves.relaxation.fast),
        ring_(ring_weights(table_, body.asset().curves.view[0].size())) {}

  // Nothing where nothing touches.
  bool differentiate(const RowState& state, const Vec3& tip, RowDerivative& out) const {
    if (state.place.triangle < 0) return false;
    const runtime::AssetView& asset = body_.asset();
    const Vec3 u = vec3(runtime::blended_normal(asset, state.place.triangle, state.place.weight));
    Vec3 c = Eigen::Map<const Vec3>(asset.origin_m);
    double kappa[6] = {};
    Eigen::VectorXd b = Eigen::VectorXd::Zero(ring_.cols());
    double friction = 0, friction_slope = 0;
    for (int k = 0; k < 3; ++k) {
      const double n = state.place.weight[k];
      const int vertex = asset.corner(state.place.triangle, k);
      const float* node = asset.node(vertex);
      c += n * vec3(asset.vertex_at(vertex));
      for (int i = 0; i < 6; ++i)
        kappa[i] += n * double(node[asset.control_offset[runtime::kCurvature] + i]);
      for (Eigen::Index j = 0; j < b.size(); ++j) b[j] += n * double(node[j]);
      friction += n * double(node[asset.control_offset[runtime::kFriction]]);
      friction_slope += n * double(node[asset.control_offset[runtime::kFrictionSlope]]);
    }
    const Vec3 delta = tip - c, q = delta - delta.dot(u) * u;
    const Vec3 curved = vec3(runtime::curvature_times(kappa, runtime::Vec3d{q.x(), q.y(), q.z()}));
    const double d = delta.dot(u) - 0.5 * q.dot(curved);
    if (!(d > 0)) return false;
    const Vec3 along = u - (curved - curved.dot(u) * u);
    const Vec3 place = nodes_.coordinates(c);
    // The triangle lies in one cell, whose mesh has two triangles a square.
    out.at = nodes_.at(place[0], place[1], body_.mesh().triangle_cell[state.place.triangle]);

    const runtime::SplineView& spline = asset.curves.view[0];
    const auto weights = runtime::spline_weights(spline, runtime::find_piece(spline, d), d);
    Eigen::VectorXd value = Eigen::VectorXd::Zero(b.size()), slope = value;
    for (int k = 0; k <= spline.degree; ++k) {
      value[weights.first + k] = weights.value[k];
      slope[weights.first + k] = weights.slope[k];
    }
    const double normal_N = value.dot(b), stiffness_N_m = slope.dot(b);
    const Eigen::VectorXd c_N_m = ring_ * b;
    double at_0 = 0;
    for (int k = 0; k < table_.order; ++k) at_0 += b[table_.first_at_0 + k] * table_.slope_at_0[k];
    at_0 = c_N_m[0] > 0 ? std::clamp(at_0 / c_N_m[0], 0.0, 1.0) : 0.0;

    double carried = 0;  // sum c_i h_i
    Eigen::VectorXd carried_by = Eigen::VectorXd::Zero(b.size());
    for (int i = 0; i < kRings; ++i) {
      const double reach = std::max(d - table_.threshold_m[i], 0.0);
      carried += c_N_m[i] * reach;
      carried_by += reach * ring_.row(i).transpose();
    }
    const double share = carried > 0 ? std::min(normal_N / carried, runtime::kMaxLimitShare) : 1,
                 mu = std::max(friction + friction_slope * d, 0.0),
                 lambda = parameters_.recording.lambda();
    Eigen::Matrix<double, 3, Eigen::Dynamic> by_control = along * value.transpose();
    Vec3 slipping = Vec3::Zero();
    const auto& creep = state.memory.creep;
    const bool relaxes = asset.curves.relaxation.branches > 0;
    for (int i = 0; i < kRings; ++i) {
      if (!(c_N_m[i] > 0)) continue;
      const auto press = runtime::ring_press(table_, at_0, i, d);
      const double rest = relaxes ? creep.rests[0][i] : 0;
      const double creeping =
          relaxes ? (std::max(press.value_m - rest, 0.0) * fast_ - press.value_m) * press.slope : 0;
      Vec3 deflection = q - vec3(state.memory.at(i));
      if (relaxes) deflection -= vec3(creep.rest(i));
      const double limit_m = relaxes
                                 ? mu / lambda *
                                       ((share * std::max(d - table_.threshold_m[i], 0.0) +
                                         press.value_m * (fast_ - 1)) /
                                            fast_ -
                                        rest)
                                 : mu / lambda * share * std::max(d - table_.threshold_m[i], 0.0);
      const Vec3 lateral = lambda * fast_ * deflection;
      by_control += (creeping * along + lateral) * ring_.row(i);
      // Slipping rings are at their limit but for the share that later ticks take.
      if (deflection.norm() > 0.98 * limit_m) slipping += c_N_m[i] * lateral;
    }
    if (normal_N > 0 && carried > 0 && share < runtime::kMaxLimitShare)
      by_control += slipping * (value / normal_N - carried_by / carried).transpose();
    // Increment j raises every control value from j + 1 on.
    out.increment.resize(3, b.size() - 1);
    Vec3 sum = Vec3::Zero();
    for (Eigen::Index j = b.size() - 1; j > 0; --j)
      out.increment.col(j - 1) = (sum += by_control.col(j));
    out.friction = mu > 0 ? Vec3(slipping / mu) : Vec3::Zero();
    out.friction_slope = d * out.friction;
    differentiate_by_height(c, u, d, normal_N, stiffness_N_m, slipping, out);
    return true;
  }

 private:
  // The surface under the contact rises: depth is lost, and the normal turns with the slope.
  void differentiate_by_height(const Vec3& c, const Vec3& u, double d, double normal_N,
                               double stiffness_N_m, const Vec3& slipping,
                               RowDerivative& out) const {
    const Mat3 gradient = nodes_.gradients(c);
    const Vec3 w = gradient.col(2);
    const double steep = u.dot(w);
    Vec3 by_depth = stiffness_N_m * u;
    if (normal_N > 0) by_depth += std::min(stiffness_N_m / normal_N, 2 / d) * slipping;
    for (int k = 0; k < Nodes::kHeights; ++k) {
      const Vec3 slope = out.at.slope1[k] * gradient.col(0) + out.at.slope2[k] * gradient.col(1);
      // u = (w - grad H) steep, of unit length.
      const Vec3 turned = -steep * (slope - slope.dot(u) * u);
      out.height.col(k) = -steep * out.at.height[k] * by_depth + normal_N * turned;
    }
  }

  const Nodes& nodes_;
  const PlayedBody& body_;
  const ScanParameters& parameters_;
  const runtime::RingTable& table_;
  double fast_;
  Eigen::MatrixXd ring_;
};

}  // namespace

Eigen::VectorXd Unknowns::vector_of(const ScanParameters& p) const {
  Eigen::VectorXd x = Eigen::VectorXd::Zero(size());
  for (int n = 0; n < nodes; ++n) {
    for (int j = 0; j < increments; ++j) x[increment(n, j)] = p.increment_N(n, j) / force_N;
    x[height(n)] = p.height_m[n] / spacing_m;
    x[friction(n)] = p.friction[n];
    x[friction_slope(n)] = p.friction_slope_1_m[n] * depth_m;
  }
  x.tail<kShared>() = p.recording.number;
  return x;
}

ScanParameters Unknowns::parameters_of(const Eigen::VectorXd& x) const {
  ScanParameters p;
  p.increment_N.resize(nodes, increments);
  p.height_m.resize(nodes), p.friction.resize(nodes), p.friction_slope_1_m.resize(nodes);
  for (int n = 0; n < nodes; ++n) {
    for (int j = 0; j < increments; ++j) p.increment_N(n, j) = x[increment(n, j)] * force_N;
    p.height_m[n] = x[height(n)] * spacing_m;
    p.friction[n] = x[friction(n)];
    p.friction_slope_1_m[n] = x[friction_slope(n)] / depth_m;
  }
  p.recording.number = x.tail<kShared>();
  return p;
}

Eigen::VectorXd Unknowns::lower() const {
  Eigen::VectorXd out = Eigen::VectorXd::Constant(size(), -kInfinity);
  out.head(nodes * increments).setZero();
  out.segment(friction(0), nodes).setZero();
  for (const SharedUnknown& of : kSharedUnknowns) out[shared(of.first)] = of.min;
  return out;
}

ScanEquations linearise(const Nodes& nodes, const Unknowns& unknowns, const PlayedBody& body,
                        const Walked& walked, const Passes& passes, const ScanParameters& at,
                        const Eigen::VectorXd& weight, const std::map<int, Points>& changes) {
  const Differentiator law(nodes, body, at);
  const int K = unknowns.increments, corners = 4 * (K + 2);
  const int shared = static_cast<int>(changes.size());
  const int width = corners + Nodes::kHeights + shared;
  // Rows of each cell; those in the air, which know of the recording alone, are in the last.
  std::vector<std::vector<Eigen::Index>> rows(nodes.cells() + 1);
  std::vector<RowDerivative> derivative(passes.rows());
  std::vector<Eigen::Index> begin;
  for (std::size_t pass = 0; pass < passes.count(); ++pass)
    for (Eigen::Index row = passes.first[pass]; row < passes.first[pass + 1]; ++row) {
      if (!(weight[row] > 0)) continue;
      const Vec3 tip = passes.tip(pass, row, at.recording);
      const bool touches = law.differentiate(walked.state[row], tip, derivative[row]);
      rows[touches ? derivative[row].at.cell : nodes.cells()].push_back(row);
    }
  const Mat3 turn = at.recording.turn();
  std::vector<Eigen::MatrixXd> square(rows.size());
  tbb::parallel_for(std::size_t{0}, rows.size(), [&](std::size_t cell) {
    if (rows[cell].empty()) return;
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(3 * std::ssize(rows[cell]), width + 1);
    for (std::size_t i = 0; i < rows[cell].size(); ++i) {
      const Eigen::Index row = rows[cell][i];
      auto block = A.middleRows<3>(3 * static_cast<Eigen::Index>(i));
      const RowDerivative& by = derivative[row];
      if (by.at.cell >= 0 && cell < rows.size() - 1) {
        for (int k = 0; k < 4; ++k) {
          const double n = by.at.corner[k];
          block.middleCols(k * (K + 2), K) = n * unknowns.force_N * by.increment;
          block.col(k * (K + 2) + K) = n * by.friction;
          block.col(k * (K + 2) + K + 1) = n / unknowns.depth_m * by.friction_slope;
        }
        block.middleCols<Nodes::kHeights>(corners) = unknowns.spacing_m * by.height;
        block.leftCols(corners + Nodes::kHeights) =
            (turn * block.leftCols(corners + Nodes::kHeights)).eval();
      }
      Eigen::Index column = corners + Nodes::kHeights;
      for (const auto& [k, change] : changes) block.col(column++) = change.row(row).transpose();
      block.col(width) = (passes.force_N.row(row) - walked.reading_N.row(row)).transpose();
      block *= weight[row];
    }
    square[cell] = A.transpose() * A;
  });
  ScanEquations out;
  out.right = Eigen::VectorXd::Zero(unknowns.size());
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t c = 0; c < rows.size(); ++c) {
    if (rows[c].empty()) continue;
    std::vector<int> number(width, -1);
    if (c + 1 < rows.size()) {
      const Nodes::Cell& cell = nodes.cell(static_cast<int>(c));
      for (int k = 0; k < 4; ++k) {
        for (int j = 0; j < K; ++j) number[k * (K + 2) + j] = unknowns.increment(cell.corner[k], j);
        number[k * (K + 2) + K] = unknowns.friction(cell.corner[k]);
        number[k * (K + 2) + K + 1] = unknowns.friction_slope(cell.corner[k]);
      }
      for (int k = 0; k < Nodes::kHeights; ++k)
        number[corners + k] = unknowns.height(cell.height[k]);
    }
    int column = corners + Nodes::kHeights;
    for (const auto& [k, change] : changes) number[column++] = unknowns.shared(k);
    for (int i = 0; i < width; ++i) {
      if (number[i] < 0) continue;
      out.right[number[i]] += square[c](i, width);
      for (int j = 0; j < width; ++j)
        if (number[j] >= 0) entries.emplace_back(number[i], number[j], square[c](i, j));
    }
  }
  out.matrix.resize(unknowns.size(), unknowns.size());
  out.matrix.setFromTriplets(entries.begin(), entries.end());
  return out;
}

}  // namespace palpate::scan
