#include "tools/stages/samples/sample_cache.hpp"

#include <fmt/core.h>

#include <set>

#include "libfit/io/files/files.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/experiment_table.hpp"

namespace palpate::tools {

namespace {

// The file that keeps the finished part of an output until all of it is done.
std::filesystem::path partial_of(const std::filesystem::path& output) {
  return output.string() + ".partial";
}

}  // namespace

Attributes attributes_of(const SimulateRequest& request) {
  Attributes out{{kPointFingerprintAttribute, request.fingerprint}};
  if (!request.tool.empty()) out[kToolFingerprintAttribute] = request.tool;
  return out;
}

// A process that is killed loses the points in flight and those done within fifty times what
// keeping takes, half a minute on the liver phantom.
void KeepClock::keep(const std::function<void()>& write) {
  const double from_s = wall_seconds();
  if (from_s < next_s_) return;
  write();
  next_s_ = from_s + (wall_seconds() - from_s) / 0.02;
}

// Samples of a file whose points come from the same things; none otherwise.
Samples SampleCache::read_known(const std::filesystem::path& path) const {
  if (stored_in_hdf5(path, kPointFingerprintAttribute) != request_.fingerprint) return {};
  try {
    const Samples all = request_.surface_columns > 0 ? read_with_surface(path) : read_samples(path);
    if (stored_in_hdf5(path, kToolFingerprintAttribute).value_or("") == request_.tool) return all;
    return of_kinds(all, {ExperimentKind::press, ExperimentKind::drag, ExperimentKind::path,
                          ExperimentKind::cycle, ExperimentKind::pair});
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
      say("  resuming: {} experiments are done",
          std::set<std::int32_t>(interrupted_.experiment.begin(), interrupted_.experiment.end())
              .size());
  }
  if (!std::filesystem::exists(request.output)) return;
  earlier_ = read_known(request.output);
  if (earlier_.points() != 0)
    say("  {} points of {} need not be simulated again where they are wanted", earlier_.points(),
        request.output.string());
}

SampleCache::SampleCache(const SimulateRequest& request, Samples known)
    : request_(request), interrupted_(std::move(known)) {}

Samples SampleCache::at(const fem::SimulatorOf& simulator, const ExperimentList& list,
                        const fem::Experiments& each, const std::string& what,
                        const fem::QuickScale& quick) {
  const int per_point = fem::experiments_per_point(each);
  Samples known = known_rows(list, joined(interrupted_, earlier_), per_point);
  const std::vector<std::size_t> missing = without_rows(list, known, per_point);
  if (missing.empty()) {
    add_body_and_probe(known, simulator, list);
    return known;
  }
  if (request_.only_known) throw ExperimentsMissing{{taken(list, missing), quick}};
  // Experiments of other lists stay known: rounds of a placement come back to them.
  const Samples others = beyond(interrupted_, list);
  const auto on_done = [&](const std::function<Samples()>& so_far) {
    clock_.keep([&] {
      Samples now = so_far();
      add_body_and_probe(now, simulator, list);
      keep(joined(now, others));
    });
  };
  ConsoleProgress progress(what);
  Samples samples = fem::simulate(simulator, list, each,
                                  {.jobs = job_count(request_.jobs),
                                   .already_done = std::move(known),
                                   .quick = quick,
                                   .surface_columns = request_.surface_columns},
                                  on_done, progress.progress());
  add_body_and_probe(samples, simulator, list);
  interrupted_ = joined(samples, others);
  if (is_interrupted()) {
    keep(interrupted_);
    throw Interrupted(
        request_.output.empty()
            ? fmt::format("{}: what was done is lost, for there is no folder to keep it in", what)
            : fmt::format("{}: what is done is kept in {}; the same command goes on (simulate with "
                          "--resume)",
                          what, partial_of(request_.output).string()));
  }
  return samples;
}

void SampleCache::keep(const Samples& samples) const {
  if (request_.output.empty()) return;
  write_with_surface(partial_of(request_.output), samples, attributes_of(request_));
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
