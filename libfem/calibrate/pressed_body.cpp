#include "libfem/calibrate/pressed_body.hpp"

#include <fmt/core.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <set>

#include "libfit/core/error.hpp"
#include "libfit/core/statistics.hpp"

namespace palpate::fem {
namespace {

constexpr int kSteps = 10, kMaxSteps = 12;  // of a simulated press
constexpr int kRounds = 3;

bool is_press(const Samples& samples, Eigen::Index row, const Vec3& inward) {
  const ExperimentKind kind = samples.kind[row];
  const Vec3 deflection = samples.deflection.row(row);
  const double depth = deflection.dot(inward);
  // Rows of another probe may be those of a path: they stay within a tenth of the depth.
  return depth > 0 &&
         (kind == ExperimentKind::press ||
          (kind == ExperimentKind::other && (deflection - depth * inward).norm() < 0.1 * depth));
}

// Force at a depth from forces at equal steps from 0: a power law to the first step, cubic in
// force over that power beyond.
double force_at(double depth, double step, const std::vector<double>& force) {
  const auto n = static_cast<int>(force.size());
  const double power = n > 1 && force[0] > 0 && force[1] > force[0]
                           ? std::clamp(std::log2(force[1] / force[0]), 1.0, 3.0)
                           : 1.5;
  const auto reduced = [&](int k) {  // k from 1
    return force[k - 1] / std::pow(k, power);
  };
  const double x = depth / step;
  if (x <= 1 || n < 4) {
    const int k = std::clamp(static_cast<int>(x), 1, n);
    const double t = std::clamp(x - k, 0.0, 1.0);
    return std::pow(x, power) * ((1 - t) * reduced(k) + t * reduced(std::min(k + 1, n)));
  }
  const int first = std::clamp(static_cast<int>(x) - 1, 1, n - 3);
  double sum = 0;
  for (int k = first; k < first + 4; ++k) {
    double weight = 1;
    for (int m = first; m < first + 4; ++m)
      if (m != k) weight *= (x - m) / (k - m);
    sum += weight * reduced(k);
  }
  return std::pow(x, power) * sum;
}

// Slope of the force over depth at each row of an experiment: of the line through the rows within a
// fifth of the largest depth.
Eigen::VectorXd slopes_of(const Eigen::VectorXd& depth, const Eigen::VectorXd& force) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(depth.size());
  for (Eigen::Index i = 0; i < depth.size(); ++i) {
    const Eigen::VectorXd near =
        ((depth.array() - depth[i]).abs() <= 0.2 * depth.maxCoeff()).cast<double>();
    const double count = near.sum(), middle = near.dot(depth) / count,
                 level = near.dot(force) / count;
    const Eigen::VectorXd off = near.array() * (depth.array() - middle);
    if (off.squaredNorm() > 0)
      out[i] = off.dot((force.array() - level).matrix()) / off.squaredNorm();
  }
  return out.cwiseMax(0);
}

}  // namespace

PressedBody::PressedBody(SimulationSetup setup, const Samples& samples, const std::string& where,
                         int jobs)
    : setup_(std::move(setup)), jobs_(jobs) {
  setup_.keeps_surface = false;
  std::vector<double> value, deviation, depth_of_row;
  std::map<std::pair<std::int32_t, std::int32_t>, Point> presses;  // of a point, by a probe
  std::map<std::pair<std::int32_t, std::int32_t>, std::set<long>> depths;
  for (Eigen::Index i = 0; i < samples.rows(); ++i) {
    const std::int32_t p = samples.point[i];
    const Vec3 normal = samples.point_normal.row(p);
    const double depth = samples.deflection.row(i).dot(normal);
    if (!is_press(samples, i, normal) || samples.status[i] != RowStatus::good) continue;
    const std::pair by(p, samples.probe_of(i));
    Point& point = presses[by];
    point.position = samples.point_position.row(p);
    point.normal = normal;
    if (by.second > 0) point.probe = samples.other_probes[by.second - 1];
    point.rows.emplace_back(depth, std::ssize(value));
    point.press.depth_m = point.rows.size() == 1 ? depth : std::max(point.press.depth_m, depth);
    depths[by].insert(std::lround(depth * 1e8));
    value.push_back(samples.force.row(i).dot(normal));
    depth_of_row.push_back(depth);
    deviation.push_back(samples.force_error[i]);
    observed_.group.push_back(samples.experiment[i]);
  }
  for (auto& [by, point] : presses) {
    const int count = static_cast<int>(depths[by].size());
    point.press.press_steps = count >= 4 && count <= kMaxSteps ? count : kSteps;
    points_.push_back(std::move(point));
  }
  if (value.empty())
    throw Error(where, "holds no good row of a press",
                "Give samples of presses: import them, or simulate them.");
  const Eigen::Index n = std::ssize(value);
  observed_.value = Eigen::Map<Eigen::VectorXd>(value.data(), n);
  observed_.deviation = Eigen::Map<Eigen::VectorXd>(deviation.data(), n);
  observed_.shared.setZero(n);
  const auto contacts_m = contact_deviations_m(samples.recordings);
  const Eigen::VectorXd depth_m = Eigen::Map<Eigen::VectorXd>(depth_of_row.data(), n);
  visit_groups(observed_.group, [&](Eigen::Index first, Eigen::Index rows) {
    const auto contact = contacts_m.find(observed_.group[first]);
    if (contact == contacts_m.end() || rows < 3) return;
    observed_.shared.segment(first, rows) =
        contact->second *
        slopes_of(depth_m.segment(first, rows), observed_.value.segment(first, rows));
  });
}

std::string PressedBody::name_of(const MaterialParameters& material, std::size_t point,
                                 PressMesh mesh) const {
  std::string name = fmt::format("{} {}", mesh == PressMesh::coarse ? "coarse" : "scene", point);
  for (const double value : material.values) name += fmt::format(" {}", number(value, 12));
  return name;
}

std::pair<MaterialParameters, double> PressedBody::simulated_for(
    MaterialParameters material) const {
  if (!is_scaled()) return {material, 1};
  const double factor = sum_of_moduli(material) / sum_of_moduli(setup_.materials.front());
  for (const std::size_t m : moduli_of(material))
    material.values[m] = std::stod(number(material.values[m] / factor, 12));
  return {material, factor};
}

void PressedBody::simulate(const std::vector<MaterialParameters>& materials, PressMesh mesh,
                           const Progress& progress) {
  std::vector<std::pair<std::size_t, std::size_t>> missing;  // material, point
  std::set<std::string> named;
  for (std::size_t m = 0; m < materials.size(); ++m)
    for (std::size_t p = 0; p < points_.size(); ++p)
      if (const std::string name = name_of(materials[m], p, mesh);
          !known.contains(name) && named.insert(name).second)
        missing.emplace_back(m, p);
  std::mutex reporting;
  const std::size_t before = simulated;
  tbb::task_arena arena(jobs_ > 0 ? jobs_ : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, missing.size(), 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
          for (std::size_t i = range.begin(); i < range.end(); ++i) {
            if (progress.stopped()) return;
            const auto [m, p] = missing[i];
            SimulationSetup setup = setup_;
            setup.materials.front() = materials[m];
            const Point& point = points_[p];
            if (point.probe) setup.probe = *point.probe;
            const Simulator simulator(std::move(setup));
            const PointRows result =
                mesh == PressMesh::coarse
                    ? simulator.press_quickly(point.position, point.normal, point.press, progress)
                    : simulator.press_and_drag(point.position, point.normal, point.press, progress);
            if (!result.is_complete) return;
            SimulatedPress press;
            for (Eigen::Index row = 0; row < result.rows(); ++row)
              if (is_solved(result.status[row])) {
                press.force_N.push_back(result.force.row(row).dot(point.normal));
                press.error_N.push_back(result.force_error[row]);
              }
            if (std::ssize(press.force_N) != result.rows()) press = {};
            const std::lock_guard lock(reporting);
            known[name_of(materials[m], p, mesh)] = press;
            if (on_press) on_press();
            progress.report(++simulated, before + missing.size());
          }
        },
        tbb::simple_partitioner());
  });
}

std::vector<Eigen::VectorXd> PressedBody::forces(const std::vector<MaterialParameters>& wanted,
                                                 PressMesh mesh, const Progress& progress) {
  std::vector<MaterialParameters> materials;
  std::vector<double> factor;
  for (const MaterialParameters& material : wanted) {
    const auto [simulated_material, its_factor] = simulated_for(material);
    materials.push_back(simulated_material);
    factor.push_back(its_factor);
  }
  simulate(materials, mesh, progress);
  std::vector<Eigen::VectorXd> out(materials.size());
  if (progress.stopped()) return out;
  for (std::size_t m = 0; m < materials.size(); ++m) {
    Eigen::VectorXd force(observed_.value.size());
    bool is_complete = true;
    for (std::size_t p = 0; p < points_.size() && is_complete; ++p) {
      const SimulatedPress& press = known.at(name_of(materials[m], p, mesh));
      is_complete = !press.force_N.empty();
      for (const auto& [depth, row] : points_[p].rows)
        if (is_complete)
          force[row] = force_at(depth, points_[p].press.depth_m / points_[p].press.press_steps,
                                press.force_N);
    }
    if (is_complete) out[m] = factor[m] * force;
  }
  return out;
}

double PressedBody::stated_error(const MaterialParameters& material, PressMesh mesh) const {
  std::vector<double> errors;
  for (std::size_t p = 0; p < points_.size(); ++p) {
    const SimulatedPress& press = known.at(name_of(simulated_for(material).first, p, mesh));
    for (std::size_t k = 0; k < press.force_N.size(); ++k)
      if (press.error_N[k] >= 0)
        errors.push_back(press.error_N[k] / std::max(press.force_N[k], 1e-300));
  }
  return median(errors);
}

Identification identify(PressedBody& body, const MaterialParameters& start,
                        IdentifyOptions options) {
  options.may_scale = options.may_scale && body.is_scaled();
  const auto responses_of = [&](PressMesh mesh, const Eigen::VectorXd& share) {
    return [&body, &options, mesh, share](const std::vector<MaterialParameters>& materials) {
      std::vector<Eigen::VectorXd> out = body.forces(materials, mesh, options.progress);
      for (Eigen::VectorXd& force : out)
        if (force.size() > 0 && share.size() > 0) force = force.cwiseProduct(share);
      return out;
    };
  };
  const std::vector<std::size_t> moduli = moduli_of(start);
  const bool is_one_factor = options.may_scale && options.free.size() == 1 &&
                             std::all_of(moduli.begin(), moduli.end(), [&](std::size_t m) {
                               return m == options.free.front() || start.values[m] == 0;
                             });
  if (is_one_factor) {
    if (body.forces({start}, PressMesh::scene, options.progress).front().size() > 0)
      options.common_error = body.stated_error(start, PressMesh::scene);
    return identify(start, body.observed(), responses_of(PressMesh::scene, {}), options);
  }
  Identification found;
  MaterialParameters from = start, compared;
  Eigen::VectorXd share;  // forces of the scene's meshes over the coarse one's
  for (int round = 0; round < kRounds; ++round) {
    found = identify(from, body.observed(), responses_of(PressMesh::coarse, share), options);
    if (found.is_stopped || found.response.size() == 0) return found;
    // Materials that differ by a factor alone lack the same.
    const auto size = [&](const MaterialParameters& material) {
      return !body.is_scaled() ? 1 : sum_of_moduli(material);
    };
    double moved = round == 0 ? 1 : 0;
    for (const std::size_t i : options.free)
      if (round > 0) {
        const bool is_modulus = std::find(moduli.begin(), moduli.end(), i) != moduli.end();
        const double now = found.material.values[i] / (is_modulus ? size(found.material) : 1),
                     then = compared.values[i] / (is_modulus ? size(compared) : 1);
        moved = std::max(moved, std::abs(now - then) / std::max(std::abs(then), 0.1));
      }
    // The meshes are compared anew once a parameter has moved by more.
    if (moved <= 0.1 || round + 1 == kRounds) return found;
    compared = from = found.material;
    const Eigen::VectorXd coarse =
        body.forces({compared}, PressMesh::coarse, options.progress).front();
    const Eigen::VectorXd fine =
        body.forces({compared}, PressMesh::scene, options.progress).front();
    found.is_stopped = options.progress.stopped();
    if (coarse.size() == 0 || fine.size() == 0) {  // the scene's meshes fail where one coarse works
      found.is_converged = false;
      return found;
    }
    share = fine.cwiseQuotient(coarse);
    options.common_error = body.stated_error(compared, PressMesh::scene);
  }
  return found;
}

}  // namespace palpate::fem
