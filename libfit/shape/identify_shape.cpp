#include "libfit/shape/identify_shape.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "libfit/shape/contact_states.hpp"
#include "libfit/shape/shape_error.hpp"

namespace palpate {
namespace {

using runtime::Deformation;
using runtime::DentState;
using runtime::ShapePlace;

constexpr int kDepths = runtime::kShapeDepths;
constexpr double kSmoothness = 1e-3;  // of second differences of splines, of the mean diagonal
constexpr double kEven = 1e3;         // that the dent has no tip, likewise
// Functions that no datum bounds at the contact point go to 0 there: of a mesh whose cells are
// wider than the contact, they had no bound and moved vertices by twice the depth.
constexpr double kToZero = 1e-4;
constexpr double kToMean = 1e-3;   // of a point towards the body's mean, likewise
constexpr double kSlight = 1e-9;   // ridge where nothing is told, likewise
constexpr int kMaxGramRows = 400;  // that modes are found from
constexpr std::array kModeCounts{0, 2, 4, 6, 8, 12, 16, 24};
constexpr int kRounds = 2;        // near functions and modes are found by turns
constexpr double kKnown = 0.99;   // share of a contact point that test points must answer for
constexpr double kAsGood = 1.05;  // the fewest modes whose error is within this of the best

/// A row that can be used.
struct Known {
  Eigen::Index row;
  bool is_press;
  const runtime::Contact* contact;
  DentState state;
};

/// Normal equations of a least squares problem.
struct Normal {
  Eigen::MatrixXd A;
  Eigen::VectorXd b;

  explicit Normal(Eigen::Index size)
      : A(Eigen::MatrixXd::Zero(size, size)), b(Eigen::VectorXd::Zero(size)) {}
  double scale() const { return A.rows() ? A.trace() / double(A.rows()) : 0; }
};

/// What splines of `blocks` functions in turn should be like without data: smooth.
Eigen::MatrixXd smoothness(int intervals, int blocks) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(intervals * blocks, intervals * blocks);
  for (int block = 0; block < blocks; ++block)
    for (int j = 0; j < intervals; ++j) {
      Eigen::VectorXd d = Eigen::VectorXd::Zero(intervals * blocks);
      const double difference[3] = {1, -2, 1};
      for (int k = 0; k < 3; ++k)
        if (j + k < intervals) d[block * intervals + j + k] = difference[k];
      out += d * d.transpose();
    }
  return out;
}

Eigen::VectorXd solve(const Normal& normal, const Eigen::MatrixXd& shape, double to_mean,
                      const Eigen::VectorXd& mean) {
  const double scale = std::max(normal.scale(), 1e-300);
  Eigen::MatrixXd A = normal.A + scale * shape;
  A.diagonal().array() += scale * (to_mean + kSlight);
  return A.ldlt().solve(normal.b + scale * to_mean * mean);
}

runtime::Vec3d motion(const SurfaceMotion& surface, Eigen::Index row, int v) {
  const float* at = surface.data() + row * surface.cols() + 3 * v;
  return {double(at[0]), double(at[1]), double(at[2])};
}

/// Vertices near a row's contact point, with their weight: those under the tool count most.
template <class Use>
void each_near(const runtime::AssetView& asset, const ShapeResponse& shape, const DentState& state,
               const Use& use) {
  runtime::ShapeView lengths;
  lengths.depth_m = shape.depth_m;
  lengths.radius_m = shape.radius_m;
  lengths.radius_power = shape.radius_power;
  const double a = runtime::shape_radius_m(lengths, state.normal_m);
  ShapePlace place;
  for (int v = 0; v < asset.vertices; ++v) {
    const runtime::Vec3d X = asset.vertex_at(v);
    if (!see_place(state, a, shape.intervals, X, asset.normal_at(v), place)) continue;
    const runtime::Vec3d way = X - state.point;
    const double s2 = runtime::dot(way, way) / (a * a);
    use(v, place, 1 / ((1 + s2 / 9) * state.normal_m * state.normal_m));
  }
}

class Identification {
 public:
  Identification(const runtime::AssetView& asset, const Samples& samples,
                 const Triangles& blend_point, const Points& blend_weight,
                 const ShapeOptions& options)
      : asset_(asset),
        samples_(samples),
        blend_point_(blend_point),
        blend_weight_(blend_weight),
        contacts_(contact_states(asset, samples, options.depth_m)) {
    shape_.intervals = options.intervals;
    shape_.radius_power = options.radius_power;
    shape_.depth_m = options.depth_m;
    shape_.radius_m = options.radius_m;
  }

  /// The response of rows for which `counts` is set (empty: all), with so many modes at most.
  ShapeResponse of(const std::vector<char>& counts, int modes) {
    known_.clear();
    for (std::size_t row = 0; row < contacts_.size(); ++row) {
      DentState state;
      if (!can_tell(row) || (!counts.empty() && !counts[row])) continue;
      if (!runtime::shape_state(asset_, *contacts_[row], 0, state)) continue;
      state.radius_m = 0;  // what the ball pushes out is not the response's
      known_.push_back({static_cast<Eigen::Index>(row), samples_.kind[row] == ExperimentKind::press,
                        &*contacts_[row], state});
    }
    shape_.modes = 0;
    shape_.mode.resize(asset_.vertices, 0);
    shape_.point.setZero(samples_.points(), runtime::shape_numbers(shape_.intervals, 0));
    shape_.drag.setZero(runtime::shape_drag_numbers(shape_.intervals, 0));
    fit_presses();
    fit_drags();
    if (modes > 0 && !known_.empty()) {
      find_modes(modes);
      for (int round = 0; round < kRounds; ++round) {
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

  const std::vector<std::optional<runtime::Contact>>& contacts() const { return contacts_; }
  bool can_tell(std::size_t row) const { return contacts_[row] && is_known(*contacts_[row]); }
  std::size_t rows() const { return known_.size(); }

 private:
  // Whether test points answer for a contact point: in the skirt numbers fade.
  bool is_known(const runtime::Contact& contact) const {
    double known = 0;
    for (int k = 0; k < 3; ++k)
      if (asset_.covered[asset_.corner(contact.triangle, k)] == runtime::kMeasured)
        known += contact.weight[k];
    return known > kKnown;
  }

  // The dent along u and the way in and out (M31), each by itself: they are perpendicular.
  void fit_presses() {
    const int M = shape_.intervals, size = kDepths * M;
    const auto points = static_cast<std::size_t>(samples_.points());
    std::vector<Normal> dent(points, Normal(size)), out(points, Normal(size));
    // What the modes leave: their numbers stay, those of points and drags are found anew.
    const int near = runtime::shape_numbers(M, 0);
    shape_.point.leftCols(near).setZero();
    shape_.drag.head(runtime::shape_drag_numbers(M, 0)).setZero();
    const ShapedAsset far(asset_, shape_, blend_point_, blend_weight_);
    for (const Known& known : known_) {
      if (!known.is_press) continue;
      const Eigen::VectorXf left = residual(far.view(), known);
      const auto p = static_cast<std::size_t>(samples_.point[static_cast<std::size_t>(known.row)]);
      const double d = known.state.normal_m, x = d / shape_.depth_m;
      each_near(asset_, shape_, known.state, [&](int v, const ShapePlace& place, double weight) {
        const runtime::Vec3d moved{double(left[3 * v]), double(left[3 * v + 1]),
                                   double(left[3 * v + 2])};
        const double length = std::sqrt(runtime::dot(place.out, place.out));
        add(dent[p], place, weight, d * place.facing, x, runtime::dot(moved, known.state.normal));
        if (length > 1e-9)
          add(out[p], place, weight, d * place.facing * length, x,
              runtime::dot(moved, place.out) / length);
      });
    }
    Eigen::MatrixXd smooth = kSmoothness * smoothness(M, kDepths), even = smooth;
    for (int block = 0; block < kDepths && M > 2; ++block) {
      Eigen::VectorXd tip = Eigen::VectorXd::Zero(size);
      tip[block * M] = 1;
      tip[block * M + 2] = -1;
      even += kEven * tip * tip.transpose();
    }
    even.diagonal().tail(size - M).array() += kToZero;
    store(dent, even, 0);
    smooth.diagonal().array() += kToZero;
    store(out, smooth, size);
  }

  void add(Normal& normal, const ShapePlace& place, double weight, double scale, double x,
           double value) const {
    const int M = shape_.intervals;
    double row[4 * kDepths];
    int column[4 * kDepths], count = 0;
    for (int p = 0; p < kDepths; ++p, scale *= x)
      for (int j = 0; j < 4; ++j) {
        if (place.first + j >= M) continue;
        row[count] = scale * place.w[j];
        column[count++] = p * M + place.first + j;
      }
    for (int i = 0; i < count; ++i) {
      normal.b[column[i]] += weight * row[i] * value;
      for (int j = 0; j < count; ++j) normal.A(column[i], column[j]) += weight * row[i] * row[j];
    }
  }

  void store(const std::vector<Normal>& normal, const Eigen::MatrixXd& prior, int at) {
    const auto size = static_cast<Eigen::Index>(prior.rows());
    Normal all(size);
    for (const Normal& one : normal) {
      all.A += one.A;
      all.b += one.b;
    }
    const Eigen::VectorXd mean = solve(all, prior, 0, Eigen::VectorXd::Zero(size));
    for (std::size_t p = 0; p < normal.size(); ++p)
      shape_.point.row(static_cast<Eigen::Index>(p)).segment(at, size) =
          normal[p].scale() > 0 ? solve(normal[p], prior, kToMean, mean) : mean;
  }

  // What is left of a row, in metres, as the engine has it.
  Eigen::VectorXf residual(const runtime::AssetView& shaped, const Known& known) const {
    const Deformation deformation(shaped, *known.contact, known.state);
    Eigen::VectorXf out(3 * asset_.vertices);
    for (int v = 0; v < asset_.vertices; ++v) {
      const runtime::Vec3d left = motion(samples_.surface, known.row, v) - deformation.at(v);
      out[3 * v] = static_cast<float>(left.x);
      out[3 * v + 1] = static_cast<float>(left.y);
      out[3 * v + 2] = static_cast<float>(left.z);
    }
    return out;
  }

  // How the surface follows a tool sideways (M31): functions of the body.
  void fit_drags() {
    const int M = shape_.intervals;
    Normal normal(runtime::kShapeDragged * M);
    const ShapedAsset pressed(asset_, shape_, blend_point_, blend_weight_);
    for (const Known& known : known_) {
      if (known.is_press) continue;
      const Eigen::VectorXf left = residual(pressed.view(), known);
      const runtime::Vec3d q = known.state.carried_m, u = known.state.normal;
      each_near(asset_, shape_, known.state, [&](int v, const ShapePlace& place, double weight) {
        const double along = runtime::dot(q, place.out);
        const runtime::Vec3d term[runtime::kShapeDragged] = {q, place.out * along, u * along};
        for (int k = 0; k < 3; ++k) {
          double row[4 * runtime::kShapeDragged];
          int column[4 * runtime::kShapeDragged], count = 0;
          for (int i = 0; i < runtime::kShapeDragged; ++i)
            for (int j = 0; j < 4; ++j) {
              if (place.first + j >= M) continue;
              const double part = k == 0 ? term[i].x : k == 1 ? term[i].y : term[i].z;
              row[count] = place.facing * part * place.w[j];
              column[count++] = i * M + place.first + j;
            }
          for (int i = 0; i < count; ++i) {
            normal.b[column[i]] += weight * row[i] * double(left[3 * v + k]);
            for (int j = 0; j < count; ++j)
              normal.A(column[i], column[j]) += weight * row[i] * row[j];
          }
        }
      });
    }
    const auto size = normal.b.size();
    if (normal.scale() > 0) {
      Eigen::MatrixXd prior = kSmoothness * smoothness(M, runtime::kShapeDragged);
      prior.diagonal().array() += kToZero;
      shape_.drag.head(size) = solve(normal, prior, 0, Eigen::VectorXd::Zero(size));
      return;
    }
    // Without a drag: what sticks to the tool goes as far as it dents.
    const auto dent = shape_.point.colwise().mean();
    for (int j = 0; j < M; ++j)
      for (int p = 0; p < kDepths; ++p) shape_.drag[j] += dent[p * M + j];
  }

  // Fields of the whole body that what is left is made of (M32).
  void find_modes(int modes) {
    const ShapedAsset near(asset_, shape_, blend_point_, blend_weight_);
    const std::size_t stride = (known_.size() + kMaxGramRows - 1) / kMaxGramRows;
    std::vector<Eigen::VectorXf> left;
    for (const Known& known : known_) left.push_back(residual(near.view(), known));
    Eigen::MatrixXf rows((known_.size() + stride - 1) / stride, 3 * asset_.vertices);
    for (std::size_t i = 0; i < known_.size(); i += stride)
      rows.row(static_cast<Eigen::Index>(i / stride)) =
          left[i].transpose() / static_cast<float>(known_[i].state.normal_m);
    const Eigen::MatrixXd gram = (rows * rows.transpose()).cast<double>();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
    const auto count = static_cast<int>(std::min<Eigen::Index>(modes, gram.rows()));
    field_.resize(3 * asset_.vertices, count);
    int found = 0;
    for (int k = 0; k < count; ++k) {
      const Eigen::Index at = gram.rows() - 1 - k;
      if (!(solver.eigenvalues()[at] > 1e-12 * solver.eigenvalues()[gram.rows() - 1])) break;
      field_.col(found++) =
          (rows.transpose() * solver.eigenvectors().col(at).cast<float>()).normalized();
    }
    field_.conservativeResize(Eigen::NoChange, found);
    const int M = shape_.intervals;
    shape_.modes = found;
    shape_.mode.resize(asset_.vertices, 3 * found);
    for (int v = 0; v < asset_.vertices; ++v)
      for (int k = 0; k < found; ++k)
        for (int i = 0; i < 3; ++i)
          shape_.mode(v, 3 * k + i) = rounded_to_float(size() * double(field_(3 * v + i, k)));
    shape_.point.conservativeResize(Eigen::NoChange, runtime::shape_numbers(M, found));
    shape_.point.rightCols(kDepths * found).setZero();
    shape_.drag.conservativeResize(runtime::shape_drag_numbers(M, found));
    shape_.drag.tail(3 * found).setZero();
  }

  double size() const {
    return std::sqrt(double(asset_.vertices));
  }  // of a mode's entries: about 1

  // How far each mode goes, of what the near functions leave.
  void fit_amplitudes() {
    const auto found = field_.cols();
    const int at = runtime::shape_numbers(shape_.intervals, 0);
    shape_.point.rightCols(kDepths * found).setZero();
    shape_.drag.tail(3 * found).setZero();
    std::vector<Eigen::VectorXf> left;
    const ShapedAsset near(asset_, shape_, blend_point_, blend_weight_);
    for (const Known& known : known_)
      left.push_back(known.is_press ? residual(near.view(), known) : Eigen::VectorXf());
    for (Eigen::Index p = 0; p < samples_.points(); ++p) {
      Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
      Eigen::MatrixXd b = Eigen::MatrixXd::Zero(2, found);
      for (std::size_t i = 0; i < known_.size(); ++i) {
        if (!known_[i].is_press || samples_.point[static_cast<std::size_t>(known_[i].row)] != p)
          continue;
        const double d = known_[i].state.normal_m;
        const Eigen::Vector2d row(1, d / shape_.depth_m);
        A += row * row.transpose();
        b += row * (left[i].transpose() * field_).cast<double>() / (size() * d);
      }
      if (!(A.trace() > 0)) continue;
      A.diagonal().array() += 1e-6 * A.trace();
      const Eigen::MatrixXd amplitude = A.ldlt().solve(b);
      for (int depth = 0; depth < kDepths; ++depth)
        shape_.point.row(p).segment(at + depth * found, found) = amplitude.row(depth);
    }
    Mat3 A = Mat3::Zero();
    Eigen::MatrixXd b = Eigen::MatrixXd::Zero(3, found);
    const ShapedAsset pressed(asset_, shape_, blend_point_, blend_weight_);
    for (const Known& known : known_) {
      if (known.is_press) continue;
      const double d = known.state.normal_m;
      const Vec3 q =
          Vec3(known.state.carried_m.x, known.state.carried_m.y, known.state.carried_m.z) / d;
      A += q * q.transpose();
      b += q * (residual(pressed.view(), known).transpose() * field_).cast<double>() / (size() * d);
    }
    if (!(A.trace() > 0)) return;
    A.diagonal().array() += 1e-3 * A.trace();
    const Eigen::MatrixXd amplitude = A.ldlt().solve(b);
    for (Eigen::Index k = 0; k < found; ++k)
      shape_.drag.segment(runtime::kShapeDragged * shape_.intervals + 3 * k, 3) = amplitude.col(k);
  }

  const runtime::AssetView& asset_;
  const Samples& samples_;
  const Triangles& blend_point_;
  const Points& blend_weight_;
  std::vector<std::optional<runtime::Contact>> contacts_;
  std::vector<Known> known_;
  Eigen::MatrixXf field_;  // modes, orthonormal
  ShapeResponse shape_;
};

/// The same response with its first modes alone.
ShapeResponse with_modes(const ShapeResponse& shape, int modes) {
  ShapeResponse out = shape;
  const int M = shape.intervals, pressed = runtime::shape_numbers(M, 0);
  out.modes = modes;
  out.point.resize(shape.point.rows(), runtime::shape_numbers(M, modes));
  out.point.leftCols(pressed) = shape.point.leftCols(pressed);
  for (int depth = 0; depth < kDepths; ++depth)
    out.point.middleCols(pressed + depth * modes, modes) =
        shape.point.middleCols(pressed + depth * shape.modes, modes);
  out.drag = shape.drag.head(runtime::shape_drag_numbers(M, modes));
  out.mode = shape.mode.leftCols(3 * modes);
  return out;
}

constexpr bool is_left_out(Eigen::Index point) { return point % 3 == 1; }

/// Numbers of points left out: those of the three nearest others, by their squared distance.
ShapeResponse filled_in(ShapeResponse shape, const Points& position) {
  for (Eigen::Index p = 0; p < position.rows(); ++p) {
    if (!is_left_out(p)) continue;
    std::vector<std::pair<double, Eigen::Index>> near;
    for (Eigen::Index other = 0; other < position.rows(); ++other)
      if (!is_left_out(other))
        near.emplace_back((position.row(other) - position.row(p)).squaredNorm(), other);
    std::sort(near.begin(), near.end());
    near.resize(std::min<std::size_t>(near.size(), 3));
    shape.point.row(p).setZero();
    double sum = 0;
    for (const auto& [squared, other] : near) {
      shape.point.row(p) += shape.point.row(other) / squared;
      sum += 1 / squared;
    }
    shape.point.row(p) /= sum;
  }
  return shape;
}

}  // namespace

ShapeResponse identify_shape(const runtime::AssetView& asset, const Samples& samples,
                             const Triangles& blend_point, const Points& blend_weight,
                             const ShapeOptions& options, ShapeReport* report) {
  Identification identification(asset, samples, blend_point, blend_weight, options);
  int modes = options.modes.value_or(0);
  if (!options.modes) {
    // Every third point is held out: fields that only tell points apart help none between them.
    std::vector<char> is_held_out(samples.point.size()), is_told(is_held_out);
    for (std::size_t row = 0; row < is_held_out.size(); ++row)
      (is_left_out(samples.point[row]) ? is_held_out : is_told)[row] = identification.can_tell(row);
    const ShapeResponse most =
        filled_in(identification.of(is_told, kModeCounts.back()), samples.point_position);
    std::vector<ShapeReport::Count> tried;
    double best = std::numeric_limits<double>::infinity();
    for (const int count : kModeCounts) {
      if (count > most.modes) break;
      const ShapedAsset shaped(asset, with_modes(most, count), blend_point, blend_weight);
      const ShapeError error =
          shape_error(shaped.view(), samples, identification.contacts(), is_held_out);
      tried.push_back({count, error.near.p95_rel, error.all.p95_rel});
      best = std::min(best, error.near.p95_rel + error.all.p95_rel);
    }
    for (const ShapeReport::Count& count : tried)
      if (count.near_p95 + count.all_p95 <= kAsGood * best) {
        modes = count.modes;
        break;
      }
    if (report != nullptr) report->tried = tried;
  }
  ShapeResponse shape = identification.of({}, modes);
  if (report != nullptr) report->rows = static_cast<int>(identification.rows());
  if (identification.rows() == 0) return {};
  return shape;
}

}  // namespace palpate
