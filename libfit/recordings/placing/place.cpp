#include <algorithm>
#include <cmath>
#include <tuple>

#include "libfit/core/text.hpp"
#include "libfit/recordings/placing/assemble.hpp"

// Recordings on the body, and presses at one place and rate as one experiment.

namespace palpate::recordings {
namespace {

void refuse(PlacedRecording& c, const std::string& what, const std::string& remedy) {
  c.failure = Error(c.item->file.string() + (c.name.empty() ? "" : "#" + c.name), what, remedy);
}

// Contact points that the rig itself measured, in its frame.
Points measured_contacts(const std::vector<PlacedRecording>& candidates) {
  std::vector<Vec3> points;
  for (const PlacedRecording& c : candidates)
    if (!c.failure && c.recording->contact_m && !c.recording->is_axial)
      points.push_back(*c.recording->contact_m);
  Points out(points.size(), 3);
  for (std::size_t i = 0; i < points.size(); ++i) out.row(i) = points[i];
  return out;
}

// Position before projection: the manifest's, which is the body's, else where the rig touched.
bool find_position(const RigidMotion& motion, const BatchOptions& options, PlacedRecording& c) {
  const BatchItem& item = *c.item;
  const auto& contact = c.recording->contact_m;
  if (!item.position_m && !contact) {
    refuse(c, "has no position",
           "Say `position` in the manifest: where on the body it was recorded.");
    return false;
  }
  // Positions of a pass are those of its scan.
  const bool is_measured = contact && (item.signal.is_pass && !c.recording->is_axial);
  c.position_m = item.position_m && !is_measured ? *item.position_m : motion(*contact);
  if (item.position_m && contact && !c.recording->is_axial) {
    const double off_m = (motion(*contact) - *item.position_m).norm();
    if (off_m > options.place_tolerance_m) {
      refuse(c,
             "touches " + millimetres(off_m) +
                 " from the position that the manifest names: it is a recording of another point",
             "Correct `position`, or raise place_tolerance (" +
                 millimetres(options.place_tolerance_m) + ").");
      return false;
    }
  }
  return true;
}

Eigen::VectorXd depths(const Pooled& p, const Vec3& inward) { return p.deflection_m * inward; }

struct At {
  Vec3 deflection = Vec3::Zero(), force = Vec3::Zero(), torque = Vec3::Zero();
  double error_N = 0;
};

At row_of(const Pooled& p, Eigen::Index i) {
  return {p.deflection_m.row(i), p.force_N.row(i),
          p.torque_Nm.rows() > 0 ? Vec3(p.torque_Nm.row(i)) : Vec3(Vec3::Zero()), p.error_N[i]};
}

// Row values at a depth, linear between good rows and through the origin; nothing beyond the last.
std::optional<At> interpolate(const Pooled& p, const Eigen::VectorXd& depth_m, double at_m) {
  double before_m = 0;
  At before;
  for (Eigen::Index i = 0; i < depth_m.size(); ++i) {
    if (p.status[i] != RowStatus::good) continue;
    if (depth_m[i] < at_m) {
      before_m = depth_m[i];
      before = row_of(p, i);
      continue;
    }
    const double share = depth_m[i] > before_m ? (at_m - before_m) / (depth_m[i] - before_m) : 1;
    At at = row_of(p, i);
    at.deflection = (1 - share) * before.deflection + share * at.deflection;
    at.force = (1 - share) * before.force + share * at.force;
    at.torque = (1 - share) * before.torque + share * at.torque;
    return at;
  }
  return std::nullopt;
}

// Means of presses at common depths, their scatter as error. Depths run as far as two of them
// reach.
Pooled together(const std::vector<Pooled>& repeats, const Vec3& inward) {
  std::vector<double> reach;
  std::vector<Eigen::VectorXd> depth;
  Eigen::Index rows = 0;
  for (const Pooled& p : repeats) {
    depth.push_back(depths(p, inward));
    double deepest = 0;
    for (Eigen::Index i = 0; i < depth.back().size(); ++i)
      if (p.status[i] == RowStatus::good) deepest = std::max(deepest, depth.back()[i]);
    reach.push_back(deepest);
    rows = std::max(rows, depth.back().size());
  }
  std::sort(reach.rbegin(), reach.rend());
  Pooled out;
  for (const Pooled& p : repeats) {
    out.member.push_back(p.member[0]);
    out.speed_m_s += p.speed_m_s / static_cast<double>(repeats.size());
  }
  const bool has_torque =
      std::ranges::all_of(repeats, [](const Pooled& p) { return p.torque_Nm.rows() > 0; });
  out.deflection_m.resize(rows, 3), out.force_N.resize(rows, 3), out.torque_Nm.resize(rows, 3);
  out.error_N.resize(rows);
  Eigen::Index filled = 0;
  for (Eigen::Index i = 1; i <= rows; ++i) {
    const double at_m = reach[1] * static_cast<double>(i) / static_cast<double>(rows);
    At sum;
    double squares = 0, own = 0;
    int n = 0;
    for (std::size_t k = 0; k < repeats.size(); ++k) {
      const auto at = interpolate(repeats[k], depth[k], at_m * (1 - 1e-12));
      if (!at) continue;
      sum.deflection += at->deflection, sum.force += at->force, sum.torque += at->torque;
      squares += std::pow(at->force.dot(inward), 2);
      own += at->error_N * at->error_N;
      ++n;
    }
    if (n < 2) continue;
    const Vec3 mean = sum.force / n;
    out.deflection_m.row(filled) = sum.deflection / n;
    out.force_N.row(filled) = mean;
    out.torque_Nm.row(filled) = sum.torque / n;
    out.error_N[filled++] =
        std::sqrt(std::max(0.0, (squares - n * std::pow(mean.dot(inward), 2)) / (n - 1)) + own / n);
  }
  for (Points* vectors : {&out.deflection_m, &out.force_N}) vectors->conservativeResize(filled, 3);
  out.torque_Nm.conservativeResize(has_torque ? filled : 0, 3);
  out.error_N.conservativeResize(filled);
  out.status.assign(filled, RowStatus::good);
  return out;
}

}  // namespace

std::string shown(const PlacedRecording& c) {
  return c.item->shown + (c.name.empty() ? "" : "#" + c.name);
}

std::optional<Registration> place_on_body(const BatchOptions& options,
                                          std::vector<PlacedRecording>& candidates) {
  std::optional<Registration> registration;
  RigidMotion motion = options.motion.value_or(RigidMotion{});
  if (options.fits_to_surface && options.surface) {
    registration = register_to_surface(measured_contacts(candidates), *options.surface, motion);
    motion = registration->motion;
  }
  Points wanted = Points::Zero(candidates.size(), 3);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    PlacedRecording& c = candidates[i];
    if (c.failure || !find_position(motion, options, c)) continue;
    wanted.row(i) = c.position_m;
    if (c.item->normal)
      c.inward = *c.item->normal;
    else if (c.recording->inward)
      c.inward = motion.rotation * *c.recording->inward;
    else if (!options.surface)
      refuse(c, "has no normal",
             "Say `normal`, the inward direction, or `surface` in the manifest.");
    c.to_body = motion.rotation;
  }
  if (options.surface) {
    const auto places = project(wanted, *options.surface);
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      PlacedRecording& c = candidates[i];
      if (c.failure) continue;
      if (!places[i] || places[i]->distance_m > options.place_tolerance_m) {
        refuse(c,
               "lies " + (places[i] ? millimetres(places[i]->distance_m) : std::string("nowhere")) +
                   " from the surface",
               "Register the rig to the body ([registration] of the manifest), say positions = "
               "\"center\" where they are a ball's centre, or raise place_tolerance (" +
                   millimetres(options.place_tolerance_m) + ").");
        continue;
      }
      c.surface_distance_m = places[i]->distance_m;
      c.position_m = places[i]->position_m;
      if (!c.item->normal) c.inward = places[i]->inward;
    }
  }
  for (PlacedRecording& c : candidates)  // one-axis signals lie along the first axis
    if (!c.failure && c.recording->is_axial) c.to_body = c.inward * Vec3::UnitX().transpose();
  return registration;
}

Pooled on_body(PlacedRecording& c) {
  Pooled out{*c.recording, {&c}, c.recording->speed_m_s};
  for (Points* vectors : {&out.deflection_m, &out.force_N, &out.torque_Nm})
    *vectors *= c.to_body.transpose();
  return out;
}

std::vector<Pooled> pool(const Members& members) {
  std::vector<Pooled> experiments;
  Members presses;
  for (PlacedRecording* m : members) {
    if (m->item->signal.kind == ExperimentKind::press && !m->item->signal.is_pass)
      presses.push_back(m);
    else
      experiments.push_back(on_body(*m));
  }
  // By tip and speed; recordings without a clock belong together.
  const auto speed = [](const PlacedRecording* m) { return m->recording->speed_m_s; };
  const auto key = [](const PlacedRecording* m) {
    const UsedTip t = tip_of(*m);
    return std::tuple(t.tip, t.radius_m, t.half_angle_rad);
  };
  std::ranges::stable_sort(presses, [&](const PlacedRecording* a, const PlacedRecording* b) {
    if (key(a) != key(b)) return key(a) < key(b);
    return std::isnan(speed(b)) ? !std::isnan(speed(a)) : speed(a) < speed(b);
  });
  for (std::size_t first = 0, last = 0; first < presses.size(); first = last) {
    std::vector<Pooled> repeats;
    for (last = first; last < presses.size(); ++last) {
      const double v0 = speed(presses[first]), v = speed(presses[last]);
      if (std::isnan(v0) != std::isnan(v) || v > kSameRate * v0) break;
      if (key(presses[first]) != key(presses[last])) break;
      repeats.push_back(on_body(*presses[last]));
    }
    if (repeats.size() > 1) {
      Pooled pooled = together(repeats, presses[first]->inward);
      if (pooled.force_N.rows() >= 3) {
        experiments.push_back(std::move(pooled));
        continue;
      }
    }
    for (Pooled& one : repeats) experiments.push_back(std::move(one));
  }
  std::stable_sort(experiments.begin(), experiments.end(), [](const Pooled& a, const Pooled& b) {
    return *std::min_element(a.member.begin(), a.member.end()) <
           *std::min_element(b.member.begin(), b.member.end());
  });
  // Rows are of slow motion unless relaxation is applied (experiments_in_time).
  for (Pooled& one : experiments)
    if (!one.member[0]->item->signal.is_pass) one.time_s.resize(0);
  return experiments;
}

std::vector<std::string> compare_rates(const std::string& point,
                                       const std::vector<Pooled>& experiments) {
  std::vector<std::string> notes;
  const Pooled *slow = nullptr, *fast = nullptr;
  for (const Pooled& p : experiments) {
    if (p.member[0]->item->signal.kind != ExperimentKind::press || std::isnan(p.speed_m_s))
      continue;
    if (slow && !(tip_of(*p.member[0]) == tip_of(*slow->member[0]))) continue;
    if (!slow || p.speed_m_s < slow->speed_m_s) slow = &p;
    if (!fast || p.speed_m_s > fast->speed_m_s) fast = &p;
  }
  if (slow && fast->speed_m_s > kSameRate * slow->speed_m_s) {
    const Vec3 inward = slow->member[0]->inward;
    const Eigen::VectorXd slow_depth = depths(*slow, inward), fast_depth = depths(*fast, inward);
    double difference = 0, force = 0, error = 0;
    for (Eigen::Index i = 0; i < slow_depth.size(); ++i) {
      if (slow->status[i] != RowStatus::good) continue;
      const auto at = interpolate(*fast, fast_depth, slow_depth[i]);
      if (!at) continue;
      difference += (at->force - Vec3(slow->force_N.row(i))).dot(inward);
      force += slow->force_N.row(i).norm();
      error += std::hypot(at->error_N, slow->error_N[i]);
    }
    if (std::abs(difference) > kSeenInErrors * error && std::abs(difference) > kMinEffect * force)
      notes.push_back("point " + point + ": the force at " + millimetres(fast->speed_m_s) +
                      "/s is " + percent(std::abs(difference) / force, 0) +
                      (difference > 0 ? " above" : " below") + " that at " +
                      millimetres(slow->speed_m_s) + "/s, more than the noise");
  }
  double loss = 0;
  int n = 0;
  for (const Pooled& p : experiments)
    for (const PlacedRecording* m : p.member)
      if (const Conditioned& r = *m->recording;
          std::isfinite(r.hysteresis) &&
          r.noise_N * kMinForceInNoise < r.force_N.rowwise().norm().maxCoeff()) {
        loss += r.hysteresis;
        ++n;
      }
  if (n > 0 && loss / n > kMinEffect)
    notes.push_back("point " + point + ": " + percent(loss / n, 0) +
                    " of the work of pressing is not given back on the way out");
  return notes;
}

}  // namespace palpate::recordings
