#include "tools/stages/samples/sample_cache.hpp"

#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/simulate.hpp"

namespace palpate::tools {
namespace {

// Of the time, spent on keeping: a process that is killed loses the points in flight and those done
// within twenty times what keeping takes.
constexpr double kKeepShare = 0.05;

}  // namespace

std::filesystem::path partial_of(const std::filesystem::path& output) {
  return output.string() + ".partial";
}

void KeepClock::keep(const std::function<void()>& write) {
  const double from_s = wall_seconds();
  if (from_s < next_s_) return;
  write();
  next_s_ = from_s + (wall_seconds() - from_s) / kKeepShare;
}

PointBatch taken(const PointBatch& batch, const std::vector<std::int32_t>& which) {
  PointBatch out;
  out.points.position = batch.points.position(which, Eigen::all);
  out.points.normal = batch.points.normal(which, Eigen::all);
  out.points.triangles.resize(0, 3);
  out.quick = batch.quick;
  for (const std::int32_t i : which) {
    out.points.name.push_back(batch.points.name[static_cast<std::size_t>(i)]);
    out.effort.push_back(batch.effort[static_cast<std::size_t>(i)]);
  }
  return out;
}

int experiments_per_point(const fem::Experiments& experiments) {
  return 1 + static_cast<int>(experiments.drag_depths_m.size()) * experiments.drag_directions;
}

// Samples of a file whose points come from the same things; none otherwise.
Samples SampleCache::read_known(const std::filesystem::path& path) const {
  if (stored_in_hdf5(path, kPointFingerprintAttribute) != request_.fingerprint) return {};
  try {
    return request_.has_surface ? read_with_surface(path) : read_samples(path);
  } catch (const Error&) {  // damaged, or without a surface: simulated anew
    return {};
  }
}

SampleCache::SampleCache(const SimulateRequest& request) : request_(request) {
  if (request.output.empty()) return;
  const auto partial = partial_of(request.output);
  const bool has_partial = std::filesystem::exists(partial);
  if (!request.resume) {
    if (has_partial) say("  {} of an interrupted run is not used (no --resume)", partial.string());
    return;
  }
  if (has_partial) {
    interrupted_ = read_known(partial);
    if (interrupted_.points() == 0)
      say("  {} was made from something else and is not used", partial.string());
    else
      say("  resuming: {} points are done",
          interrupted_.points() -
              static_cast<Eigen::Index>(points_without_rows(interrupted_).size()));
  }
  if (!std::filesystem::exists(request.output)) return;
  earlier_ = read_known(request.output);
  if (earlier_.points() != 0)
    say("  {} points of {} need not be simulated again where they are wanted", earlier_.points(),
        request.output.string());
}

SampleCache::SampleCache(const SimulateRequest& request, Samples known)
    : request_(request), interrupted_(std::move(known)) {}

Samples SampleCache::known_at(const TestPoints& points, int per_point,
                              const std::vector<Effort>& effort) const {
  const Samples& known = interrupted_.points() == 0 ? earlier_
                         : earlier_.points() == 0   ? interrupted_
                                                    : joined(interrupted_, earlier_, per_point);
  return take_points(known, points, per_point, effort);
}

Samples SampleCache::at(const fem::Simulator& simulator, const TestPoints& points,
                        const fem::Experiments& experiments, const std::string& what,
                        std::vector<Effort> effort, const fem::QuickScale& quick) {
  const int per_point = experiments_per_point(experiments);
  if (effort.empty())
    effort.assign(static_cast<std::size_t>(points.position.rows()), {per_point > 1, 0});
  Samples known = known_at(points, per_point, effort);
  add_origin(known, simulator);
  const std::vector<std::int32_t> missing = points_without_rows(known);
  if (missing.empty()) return known;
  if (request_.only_known) throw PointsMissing{taken({points, effort, quick}, missing)};
  // What is known of other points stays known: rounds of a placement come back to them.
  const Samples others = samples_beyond(interrupted_, points, per_point, effort);
  KeepClock clock;
  const auto on_done = [&](const std::function<Samples()>& so_far) {
    clock.keep([&] { keep(joined(so_far(), others, per_point)); });
  };
  ConsoleProgress progress(what);
  Samples samples = fem::simulate(simulator, points, experiments,
                                  {.jobs = job_count(request_.jobs),
                                   .already_done = std::move(known),
                                   .effort = effort,
                                   .quick = quick},
                                  on_done, progress.progress());
  add_origin(samples, simulator);
  interrupted_ = joined(samples, others, per_point);
  if (is_interrupted()) {
    keep(interrupted_);
    throw Interrupted(
        fmt::format("{}: what is done is kept in {}; go on with --resume (run does so by itself)",
                    what, partial_of(request_.output).string()));
  }
  return samples;
}

void SampleCache::keep(const Samples& samples) const {
  if (request_.output.empty()) return;
  write_with_surface(partial_of(request_.output), samples,
                     {{kPointFingerprintAttribute, request_.fingerprint}});
}

void write_with_surface(const std::filesystem::path& path, const Samples& samples,
                        const Attributes& attributes) {
  std::error_code ignored;
  if (samples.surface.rows() > 0)
    write_surface_motion(surface_path(path), samples, attributes);
  else
    std::filesystem::remove(surface_path(path), ignored);
  write_samples(path, samples, attributes);
}

Samples read_with_surface(const std::filesystem::path& path) {
  Samples samples = read_samples(path);
  read_surface_motion(surface_path(path), samples);
  return samples;
}

void remove_partial(const std::filesystem::path& output) {
  std::error_code ignored;
  std::filesystem::remove(surface_path(partial_of(output)), ignored);
  std::filesystem::remove(partial_of(output), ignored);
}

}  // namespace palpate::tools
