#include "libfit/recordings/signal/signal.hpp"

#include <algorithm>
#include <cmath>

namespace palpate::recordings {
namespace {

constexpr Eigen::Index kMaxRows = 400;
constexpr double kParts = 40;  // of depth, force and time that a row may span

// Rows where the way of the tool over time bends by more than tolerance_m (Ramer, Douglas and
// Peucker), first and last included.
std::vector<Eigen::Index> corners_of(const Eigen::VectorXd& time, const Eigen::VectorXd& depth,
                                     double tolerance_m) {
  std::vector<char> is_corner(time.size(), 0);
  std::vector<std::pair<Eigen::Index, Eigen::Index>> open{{0, time.size() - 1}};
  is_corner.front() = is_corner.back() = 1;
  while (!open.empty()) {
    const auto [a, b] = open.back();
    open.pop_back();
    const double speed = (depth[b] - depth[a]) / (time[b] - time[a]);
    double most = tolerance_m;
    Eigen::Index at = -1;
    for (Eigen::Index i = a + 1; i < b; ++i)
      if (const double off = std::abs(depth[i] - depth[a] - speed * (time[i] - time[a]));
          off > most)
        most = off, at = i;
    if (at < 0) continue;
    is_corner[at] = 1;
    open.emplace_back(a, at), open.emplace_back(at, b);
  }
  std::vector<Eigen::Index> rows;
  for (Eigen::Index i = 0; i < time.size(); ++i)
    if (is_corner[i]) rows.push_back(i);
  return rows;
}

// Limits of a row. stands_s: when the tool came to stand, where it does.
struct Spans {
  double depth_m = 0, force_N = 0, time_s = 0, noise_N = 0;
  std::optional<double> stands_s = std::nullopt;

  double time_at(double begin_s) const {  // a stand's relaxation goes by the logarithm of time
    return stands_s ? std::min(time_s, 0.15 * (begin_s - *stands_s)) : time_s;
  }
};

struct Readings {
  Eigen::VectorXd time_s, depth_m, push_N;
  std::vector<char> is_good;

  double mean_force(Eigen::Index a, Eigen::Index b) const {
    return push_N.segment(a, b - a).mean();
  }
  bool is_short(Eigen::Index a, Eigen::Index b, const Spans& spans) const {
    const Eigen::Index middle = (a + b) / 2;
    const double seen_N = 3 * spans.noise_N * std::sqrt(4 / static_cast<double>(b - a));
    return std::max(depth_m[b - 1], 0.) - std::max(depth_m[a], 0.) <= spans.depth_m &&
           std::max(depth_m[a], 0.) - std::max(depth_m[b - 1], 0.) <= spans.depth_m &&
           time_s[b - 1] - time_s[a] <= spans.time_at(time_s[a]) &&
           std::abs(mean_force(middle, b) - mean_force(a, middle)) <=
               std::max(spans.force_N / 2, seen_N);
  }
};

void divide(const Readings& r, Eigen::Index a, Eigen::Index b, const Spans& spans,
            std::vector<RowRange>& parts) {
  if (b <= a) return;
  if (b - a < 2 || r.is_short(a, b, spans)) return parts.push_back({a, b});
  divide(r, a, (a + b) / 2, spans, parts);
  divide(r, (a + b) / 2, b, spans, parts);
}

Readings readings_of(const Signal& signal) {
  Readings r;
  r.time_s = Eigen::Map<const Eigen::VectorXd>(signal.time_s.data(), signal.rows());
  r.depth_m = signal.travel_m().array() - signal.contact_m;
  r.push_N = signal.push_N();
  r.is_good.resize(signal.time_s.size());
  for (std::size_t i = 0; i < r.is_good.size(); ++i)
    r.is_good[i] = !signal.is_spike[i] && !signal.is_saturated[i];
  return r;
}

// Spans on the straight way between two corners: some of each, and on a stand ever longer ones.
Spans spans_of_way(const Readings& r, Eigen::Index a, Eigen::Index b, const Spans& spans) {
  Spans own = spans;
  const double whole_s = r.time_s[b] - r.time_s[a];
  own.time_s = std::min(spans.time_s, whole_s / 8);
  if (r.depth_m[b] > 0 && std::abs(r.depth_m[b] - r.depth_m[a]) < spans.depth_m)
    own.stands_s = r.time_s[a];
  return own;
}

// Parts that become one row each: the corners of the path, and short ones between them, or twice or
// four times as long where those would be more than kMaxRows.
std::vector<RowRange> parts_of(const Readings& r, double noise_N) {
  const double range_m = r.depth_m.maxCoeff() - r.depth_m.minCoeff();
  const double tolerance_m = std::max(0.003 * range_m, 4 * neighbour_scatter(r.depth_m));
  const auto corners = corners_of(r.time_s, r.depth_m, tolerance_m);
  std::vector<RowRange> parts;
  Spans spans{r.depth_m.maxCoeff() / kParts, r.push_N.maxCoeff() / kParts,
              (r.time_s[r.time_s.size() - 1] - r.time_s[0]) / kParts, noise_N};
  for (int coarser = 0; coarser < 3; ++coarser) {
    parts.clear();
    for (std::size_t c = 0; c < corners.size(); ++c) {
      parts.push_back({corners[c], corners[c] + 1});
      if (c + 1 < corners.size())
        divide(r, corners[c] + 1, corners[c + 1],
               spans_of_way(r, corners[c], corners[c + 1], spans), parts);
    }
    if (std::ssize(parts) <= kMaxRows) break;
    spans.depth_m *= 2, spans.force_N *= 2, spans.time_s *= 2;
  }
  return parts;
}

}  // namespace

double touch_time_s(const Eigen::VectorXd& time_s, const Eigen::VectorXd& depth_m,
                    Eigen::Index first) {
  if (first == 0) return time_s[0];
  return time_s[first] - depth_m[first] / (depth_m[first] - depth_m[first - 1]) *
                             (time_s[first] - time_s[first - 1]);
}

TimedPress timed_press(const Signal& signal, const std::optional<Vec3>& contact_m, double noise_N) {
  TimedPress out;
  const Eigen::Index n = signal.rows();
  if (signal.time_s.empty() || n < 3) return out;
  const Readings r = readings_of(signal);
  Eigen::Index touched = 0;
  while (touched < n && r.depth_m[touched] <= 0) ++touched;
  if (touched == n) return out;
  const double touch_s = touch_time_s(r.time_s, r.depth_m, touched);
  const std::vector<RowRange> parts = parts_of(r, noise_N);
  const Eigen::Index rows = parts.size();
  if (rows > kMaxRows) return out;
  for (Eigen::VectorXd* column : {&out.time_s, &out.depth_m, &out.push_N, &out.readings})
    column->setZero(rows);
  if (contact_m) out.deflection_m.setZero(rows, 3), out.force_N.setZero(rows, 3);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const auto [a, b] = parts[i];
    out.time_s[i] = r.time_s.segment(a, b - a).mean() - touch_s;
    out.depth_m[i] = r.depth_m.segment(a, b - a).mean();
    if (contact_m)
      out.deflection_m.row(i) =
          signal.position_m.middleRows(a, b - a).colwise().mean() - contact_m->transpose();
    double good = 0;
    for (Eigen::Index k = a; k < b; ++k)
      if (r.is_good[k]) {
        out.push_N[i] += r.push_N[k], good += 1;
        if (contact_m) out.force_N.row(i) += signal.force_N.row(k);
      }
    if (good == 0) continue;
    out.push_N[i] /= good;
    if (contact_m) out.force_N.row(i) /= good;
    out.readings[i] = std::max(1., good * (1 - signal.correlation) / (1 + signal.correlation));
  }
  return out;
}

double held_share(const TimedPress& press) {
  const auto each_step_in_contact = [&](const auto& take) {
    for (Eigen::Index i = 1; i < press.rows(); ++i)
      if (press.depth_m[i] > 0)
        take(press.time_s[i] - press.time_s[i - 1], press.depth_m[i] - press.depth_m[i - 1]);
  };
  double in_m = 0, in_s = 0, all_s = 0, fast_m = 0, fast_s = 0, held_s = 0;
  each_step_in_contact([&](double dt, double gone_m) {
    all_s += dt;
    if (gone_m > 0) in_m += gone_m, in_s += dt;
  });
  // Speed of the way in without its stands: the median of what is gone per time would need rows of
  // equal length, so steps faster than the mean count.
  const double mean = in_s > 0 ? in_m / in_s : 0;
  each_step_in_contact([&](double dt, double gone_m) {
    if (gone_m >= mean * dt) fast_m += gone_m, fast_s += dt;
  });
  const double speed = fast_s > 0 ? fast_m / fast_s : 0;
  each_step_in_contact([&](double dt, double gone_m) {
    if (std::abs(gone_m) < 0.1 * speed * dt) held_s += dt;
  });
  return all_s > 0 ? held_s / all_s : 0;
}

}  // namespace palpate::recordings
