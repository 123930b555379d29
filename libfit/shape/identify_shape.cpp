#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "libfit/core/linear_algebra.hpp"
#include "libfit/shape/shape.hpp"

namespace palpate {
namespace {

using runtime::Deformation;
using runtime::DentState;
using runtime::ShapePlace;
using runtime::Vec3d;

constexpr int kDepths = runtime::kShapeDepths;
// Priors, of the mean diagonal of the normal equations.
constexpr double kSmoothness = 1e-3;  // of second differences of splines
// Functions that no datum bounds at the contact point go to 0 there: of a mesh whose cells are
// wider than the contact, they had no bound and moved vertices by twice the depth.
constexpr double kToZero = 1e-4;
constexpr double kToMean = 1e-3;  // of a point towards the body's mean

// Normal equations A x = b of a linear least squares problem whose rows have few entries.
struct NormalEquations {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;

  explicit NormalEquations(Eigen::Index size)
      : A(Eigen::MatrixXd::Zero(size, size)), b(Eigen::VectorXd::Zero(size)) {}

  bool is_empty() const { return !(A.trace() > 0); }

  // Adds weight (row . x - value)^2, row having `count` entries at these columns.
  void add(const double* row, const int* column, int count, double value, double weight) {
    for (int i = 0; i < count; ++i) {
      b[column[i]] += weight * row[i] * value;
      for (int j = 0; j < count; ++j) A(column[i], column[j]) += weight * row[i] * row[j];
    }
  }

  // The least of the sum of squares + s x'prior x + s to_mean |x - mean|^2, s the mean diagonal of
  // A: so the prior's weight does not depend on units. A ridge decides where there are no rows.
  Eigen::VectorXd solve(const Eigen::MatrixXd& prior, double to_mean,
                        const Eigen::VectorXd& mean) const {
    const double scale = is_empty() ? 1e-300 : A.trace() / double(A.rows());
    Eigen::MatrixXd all = A + scale * prior;
    all.diagonal().array() += scale * (to_mean + 1e-9);
    return ldlt_solve(all, b + scale * to_mean * mean);
  }
  Eigen::VectorXd solve(const Eigen::MatrixXd& prior) const {
    return solve(prior, 0, Eigen::VectorXd::Zero(b.size()));
  }
};

// The prior that uniform splines of `intervals` coefficients, `blocks` of them in turn, are
// smooth and go to 0 at their end: the squares of second differences.
Eigen::MatrixXd second_differences(int intervals, int blocks) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(intervals * blocks, intervals * blocks);
  for (int block = 0; block < blocks; ++block)
    for (int j = 0; j < intervals; ++j) {
      Eigen::VectorXd d = Eigen::VectorXd::Zero(intervals * blocks);
      for (int k = 0; k < 3; ++k)
        if (j + k < intervals) d[block * intervals + j + k] = k == 1 ? -2 : 1;
      out += d * d.transpose();
    }
  return out;
}

// Each point's own numbers, held to the mean of all points, which is that of points without rows,
// from column `at` on.
void store(const std::vector<NormalEquations>& of_points, const Eigen::MatrixXd& prior, int at,
           Controls& point) {
  NormalEquations all(prior.rows());
  for (const NormalEquations& one : of_points) {
    all.A += one.A;
    all.b += one.b;
  }
  const Eigen::VectorXd mean = all.solve(prior);
  for (std::size_t p = 0; p < of_points.size(); ++p)
    point.row(p).segment(at, prior.rows()) =
        of_points[p].is_empty() ? mean : of_points[p].solve(prior, kToMean, mean);
}

// The least squares fits that a shape response is made of (docs/method-body.md, section 20): the
// dent of each test point, how the surface follows a drag, and modes of the body. Keeps
// references to its arguments; arguments as identify_shape().
class ResponseFit {
 public:
  ResponseFit(const runtime::AssetView& asset, const Samples& samples, const Triangles& blend_point,
              const Points& blend_weight, const ShapeOptions& options)
      : asset_(asset),
        samples_(samples),
        blend_point_(blend_point),
        blend_weight_(blend_weight),
        mode_scale_(std::sqrt(double(asset.vertices))),
        contacts_(contact_states(asset, samples, options.depth_m)) {
    shape_.intervals = options.intervals;
    shape_.radius_power = options.radius_power;
    shape_.depth_m = options.depth_m;
    shape_.radius_m = options.radius_m;
  }

  // The response with so many modes at most; no points where no row shows it.
  ShapeResponse found(int modes) {
    take_rows();
    if (rows_.empty()) return {};
    shape_.modes = 0;
    shape_.mode.resize(asset_.vertices, 0);
    shape_.point.setZero(samples_.points(), runtime::shape_numbers(shape_.intervals, 0));
    shape_.drag.setZero(runtime::shape_drag_numbers(shape_.intervals));
    fit_presses();
    fit_drags();
    if (modes > 0) {
      find_modes(modes);
      for (int round = 0; round < 2; ++round) {  // near functions and modes by turns
        fit_amplitudes();
        fit_presses();
        fit_drags();
      }
    }
    shape_.point = rounded_to_float(shape_.point);
    shape_.drag = rounded_to_float(shape_.drag);
    shape_.mode = rounded_to_float(shape_.mode);
    return shape_;
  }

 private:
  // True where a row touches where measured curves answer alone.
  bool is_measured(std::size_t row) const {
    if (!contacts_[row]) return false;
    double answered = 0;
    for (int k = 0; k < 3; ++k)
      if (asset_.covered[asset_.corner(contacts_[row]->triangle, k)] == runtime::kMeasured)
        answered += contacts_[row]->weight[k];
    return answered > 0.99;
  }
  // A row that the response is found from.
  struct Row {
    Eigen::Index row;
    bool is_press;
    const runtime::Contact* contact;
    runtime::DentState state;
  };

  void take_rows() {
    rows_.clear();
    for (std::size_t row = 0; row < contacts_.size(); ++row) {
      DentState state;
      if (!is_measured(row)) continue;
      if (!runtime::shape_state(asset_, *contacts_[row], 0, state)) continue;
      state.radius_m = 0;  // what the ball pushes out is not the response's
      rows_.push_back({Eigen::Index(row), samples_.kind[row] == ExperimentKind::press,
                       &*contacts_[row], state});
    }
  }

  // Motion of a vertex minus the engine's response [m].
  Vec3d residual_of(const Deformation& shown, const Row& row, int v) const {
    const float* moved = samples_.surface.data() + row.row * samples_.surface.cols() + 3 * v;
    return Vec3d{double(moved[0]), double(moved[1]), double(moved[2])} - shown.at(v);
  }

  // Residuals of all vertices, 3V.
  Eigen::VectorXf residual_of(const runtime::AssetView& shown, const Row& row) const {
    const Deformation deformation(shown, *row.contact, row.state);
    Eigen::VectorXf out(3 * asset_.vertices);
    for (int v = 0; v < asset_.vertices; ++v) {
      const Vec3d left = residual_of(deformation, row, v);
      out.segment<3>(3 * v) = Vec3(left.x, left.y, left.z).cast<float>();
    }
    return out;
  }

  // use(v, place, weight) of vertices near a contact point: those under the tool count most.
  template <class Use>
  void each_near(const DentState& state, const Use& use) const {
    runtime::ShapeView lengths{};
    lengths.depth_m = shape_.depth_m;
    lengths.radius_m = shape_.radius_m;
    lengths.radius_power = shape_.radius_power;
    const double a = runtime::shape_radius_m(lengths, state.normal_m);
    ShapePlace place;
    for (int v = 0; v < asset_.vertices; ++v) {
      const Vec3d X = asset_.vertex_at(v);
      if (!find_place(state, a, shape_.intervals, X, asset_.normal_at(v), place)) continue;
      const Vec3d offset = X - state.point;
      const double s2 = runtime::dot(offset, offset) / (a * a);
      use(v, place, 1 / ((1 + s2 / 9) * state.normal_m * state.normal_m));
    }
  }

  // The dent along u and the motion towards and away (M31), each by itself, since they are
  // perpendicular, from the residual of the modes.
  void fit_presses() {
    const int M = shape_.intervals, size = kDepths * M;
    const std::size_t points = samples_.points();
    std::vector<NormalEquations> dent(points, NormalEquations(size)), out = dent;
    shape_.point.leftCols(runtime::shape_numbers(M, 0)).setZero();
    shape_.drag.setZero();
    const ShapedAsset far(asset_, shape_, blend_point_, blend_weight_);
    for (const Row& row : rows_) {
      if (!row.is_press) continue;
      const Deformation shown(far.view(), *row.contact, row.state);
      const std::int32_t p = samples_.point[row.row];
      const double d = row.state.normal_m, x = d / shape_.depth_m;
      each_near(row.state, [&](int v, const ShapePlace& place, double weight) {
        const Vec3d left = residual_of(shown, row, v);
        const auto add = [&](NormalEquations& to, double scale, double value) {
          double entry[4 * kDepths];
          int column[4 * kDepths], count = 0;
          for (int power = 0; power < kDepths; ++power, scale *= x)
            for (int j = 0; j < 4 && place.first + j < M; ++j) {
              entry[count] = scale * place.w[j];
              column[count++] = power * M + place.first + j;
            }
          to.add(entry, column, count, value, weight);
        };
        const double length = std::sqrt(runtime::dot(place.out, place.out));
        add(dent[p], d * place.facing, runtime::dot(left, row.state.normal));
        if (length > 1e-9)
          add(out[p], d * place.facing * length, runtime::dot(left, place.out) / length);
      });
    }
    Eigen::MatrixXd smooth = kSmoothness * second_differences(M, kDepths), even = smooth;
    for (int block = 0; block < kDepths && M > 2; ++block) {
      Eigen::VectorXd tip = Eigen::VectorXd::Zero(size);
      tip[block * M] = 1;
      tip[block * M + 2] = -1;
      even += 1e3 * tip * tip.transpose();  // the dent has no tip
    }
    even.diagonal().tail(size - M).array() += kToZero;
    store(dent, even, 0, shape_.point);
    smooth.diagonal().array() += kToZero;
    store(out, smooth, size, shape_.point);
  }

  // Lateral motion of the surface with a tool (M31): functions of the body.
  void fit_drags() {
    const int M = shape_.intervals;
    NormalEquations equations(runtime::kShapeDragged * M);
    const ShapedAsset pressed(asset_, shape_, blend_point_, blend_weight_);
    for (const Row& row : rows_) {
      if (row.is_press) continue;
      const Deformation shown(pressed.view(), *row.contact, row.state);
      const Vec3d q = row.state.carried_m, u = row.state.normal;
      each_near(row.state, [&](int v, const ShapePlace& place, double weight) {
        const Vec3d left = residual_of(shown, row, v);
        const double along = runtime::dot(q, place.out);
        const Vec3d term[runtime::kShapeDragged] = {q, place.out * along, u * along};
        for (const auto part : {&Vec3d::x, &Vec3d::y, &Vec3d::z}) {
          double entry[4 * runtime::kShapeDragged];
          int column[4 * runtime::kShapeDragged], count = 0;
          for (int i = 0; i < runtime::kShapeDragged; ++i)
            for (int j = 0; j < 4 && place.first + j < M; ++j) {
              entry[count] = place.facing * term[i].*part * place.w[j];
              column[count++] = i * M + place.first + j;
            }
          equations.add(entry, column, count, left.*part, weight);
        }
      });
    }
    if (!equations.is_empty()) {
      Eigen::MatrixXd prior = kSmoothness * second_differences(M, runtime::kShapeDragged);
      prior.diagonal().array() += kToZero;
      shape_.drag = equations.solve(prior);
      return;
    }
    // Without a drag: what sticks to the tool goes as far as it dents.
    const auto dent = shape_.point.colwise().mean();
    for (int j = 0; j < M; ++j)
      for (int power = 0; power < kDepths; ++power) shape_.drag[j] += dent[power * M + j];
  }

  // Modes, fields of the body (M32): principal components of the residuals of rows, over their
  // depth.
  void find_modes(int modes) {
    const ShapedAsset near(asset_, shape_, blend_point_, blend_weight_);
    const std::size_t stride = (rows_.size() + 399) / 400;  // 400 rows at most
    Eigen::MatrixXf left((rows_.size() + stride - 1) / stride, 3 * asset_.vertices);
    for (std::size_t i = 0; i < rows_.size(); i += stride)
      left.row(i / stride) =
          residual_of(near.view(), rows_[i]).transpose() / float(rows_[i].state.normal_m);
    const Eigen::MatrixXd gram = (left * left.transpose()).cast<double>();
    const SymmetricEigen eigen = symmetric_eigen(gram);
    const int count = std::min<Eigen::Index>(modes, gram.rows());
    modes_.resize(3 * asset_.vertices, count);
    int found = 0;
    for (int k = 0; k < count; ++k) {
      const Eigen::Index at = gram.rows() - 1 - k;
      if (!(eigen.values[at] > 1e-12 * eigen.values[gram.rows() - 1])) break;
      modes_.col(found++) = (left.transpose() * eigen.vectors.col(at).cast<float>()).normalized();
    }
    modes_.conservativeResize(Eigen::NoChange, found);
    shape_.modes = found;
    shape_.mode.resize(asset_.vertices, 3 * found);
    for (int v = 0; v < asset_.vertices; ++v)
      for (int k = 0; k < found; ++k)
        for (int i = 0; i < 3; ++i)
          shape_.mode(v, 3 * k + i) = rounded_to_float(mode_scale_ * double(modes_(3 * v + i, k)));
    shape_.point.conservativeResize(Eigen::NoChange,
                                    runtime::shape_numbers(shape_.intervals, found));
    shape_.point.rightCols(3 * found).setZero();
  }

  // Amplitude of each mode by the force, by test point, from the residual of the near functions;
  // each is held to all points' mean, which decides where a point's own forces do not.
  void fit_amplitudes() {
    const auto found = modes_.cols();
    const int at = runtime::shape_numbers(shape_.intervals, 0);
    shape_.point.rightCols(3 * found).setZero();
    const ShapedAsset near(asset_, shape_, blend_point_, blend_weight_);
    const std::size_t points = samples_.points();
    std::vector<Mat3> A(points, Mat3::Zero());
    std::vector<Eigen::MatrixXd> b(points, Eigen::MatrixXd::Zero(3, found));
    Mat3 all_A = Mat3::Zero();
    Eigen::MatrixXd all_b = Eigen::MatrixXd::Zero(3, found);
    for (const Row& row : rows_) {
      const std::int32_t p = samples_.point[row.row];
      const double weight = 1 / (row.state.normal_m * row.state.normal_m);
      const Vec3 force(row.state.force_N.x, row.state.force_N.y, row.state.force_N.z);
      A[p] += weight * force * force.transpose();
      b[p] += weight * force * (residual_of(near.view(), row).transpose() * modes_).cast<double>() /
              mode_scale_;
    }
    for (std::size_t p = 0; p < points; ++p) {
      all_A += A[p];
      all_b += b[p];
    }
    if (!(all_A.trace() > 0)) return;
    const double hold = kToMean * all_A.trace() / double(points);
    const Eigen::MatrixXd mean = (all_A + hold * Mat3::Identity()).ldlt().solve(all_b);
    for (std::size_t p = 0; p < points; ++p) {
      const Eigen::MatrixXd amplitude =
          (A[p] + hold * Mat3::Identity()).ldlt().solve(b[p] + hold * mean);
      for (int axis = 0; axis < 3; ++axis)
        shape_.point.row(p).segment(at + axis * found, found) = amplitude.row(axis);
    }
  }

  const runtime::AssetView& asset_;
  const Samples& samples_;
  const Triangles& blend_point_;
  const Points& blend_weight_;
  const double mode_scale_;  // of a mode's entries, so that they are about 1
  std::vector<std::optional<runtime::Contact>> contacts_;
  std::vector<Row> rows_;
  Eigen::MatrixXf modes_;  // 3V x modes, orthonormal
  ShapeResponse shape_;
};

}  // namespace

ShapeResponse identify_shape(const runtime::AssetView& asset, const Samples& samples,
                             const Triangles& blend_point, const Points& blend_weight,
                             const ShapeOptions& options) {
  return ResponseFit(asset, samples, blend_point, blend_weight, options).found(options.modes);
}

}  // namespace palpate
