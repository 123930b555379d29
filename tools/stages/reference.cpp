#include "tools/stages/reference.hpp"

#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/content_hash.hpp"
#include "libfit/io/files/samples_file.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/sample_cache.hpp"
#include "tools/stages/simulate.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

std::string path_fingerprint(const ReferenceRequest& request, const HeldOut& held_out) {
  ContentHash hash;
  hash.add(request.fingerprint);
  const auto add = [&](const Points& rows) {
    hash.add({reinterpret_cast<const char*>(rows.data()),
              static_cast<std::size_t>(rows.size()) * sizeof(double)});
  };
  add(held_out.points.position);
  if (request.settings.force_tolerance > 0)
    hash.add(fmt::format("{}", request.settings.force_tolerance));
  for (const ToolPath& path : held_out.paths) add(path.deflections);
  return hash.hex();
}

Samples read_if_same(const std::filesystem::path& path, const std::string& fingerprint) {
  if (stored_in_hdf5(path) != fingerprint) return {};
  try {
    return read_samples(path);
  } catch (const Error&) {  // damaged: simulated anew
    return {};
  }
}

Samples simulate_held_out_paths(const fem::Simulator& simulator, const HeldOut& held_out,
                                const ReferenceRequest& request) {
  const std::string fingerprint = path_fingerprint(request, held_out);
  const std::filesystem::path output = request.folder / "reference.h5";
  const bool is_kept = !request.folder.empty();
  fem::SimulateOptions options{.jobs = job_count(request.jobs), .already_done = {}};
  if (is_kept && request.resume) options.already_done = read_if_same(output, fingerprint);
  Samples samples;
  {
    ConsoleProgress progress("validate");
    samples = fem::simulate_paths(simulator, held_out.points, held_out.paths, options, {},
                                  progress.progress());
  }
  add_origin(samples, simulator);
  // An interrupted file has rows of some paths only: the rest is simulated next time.
  if (is_kept) write_samples(output, samples, {{kInputsAttribute, fingerprint}});
  if (is_interrupted()) throw Interrupted("validate: there is no statement yet");
  return samples;
}

}  // namespace

Reference simulate_reference(const Scene& scene, const Body& body,
                             const ReferenceRequest& request) {
  Reference reference;
  reference.held_out =
      draw_held_out(body, {scene.experiments.each.depth_m, scene.experiments.each.drag_distance_m},
                    request.settings.points, static_cast<std::uint64_t>(request.settings.seed));
  const double tolerance = request.settings.force_tolerance;
  reference.paths = simulate_held_out_paths(
      make_simulator(scene, body, tolerance > 0 ? tolerance : scene.experiments.force_tolerance),
      reference.held_out, request);
  if (!request.settings.causes) return reference;
  const fem::Simulator simulator = make_simulator(scene, body);
  const std::filesystem::path output =
      request.folder.empty() ? request.folder : request.folder / "reference_own.h5";
  SampleCache known({request.jobs, output, request.fingerprint, request.resume});
  reference.own = known.at(simulator, reference.held_out.points, experiments_of(scene),
                           "validate, at the points themselves");
  if (output.empty()) return reference;
  write_samples(output, reference.own, {{kPointFingerprintAttribute, request.fingerprint}});
  remove_partial(output);
  return reference;
}

}  // namespace palpate::tools
