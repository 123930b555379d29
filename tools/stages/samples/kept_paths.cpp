#include "tools/stages/samples/kept_paths.hpp"

#include <fmt/core.h>

#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/files/files.hpp"
#include "tools/console.hpp"
#include "tools/stages/fingerprint.hpp"
#include "tools/stages/samples/sample_cache.hpp"
#include "tools/stages/samples/simulate.hpp"

namespace palpate::tools {
namespace {

Samples read_if_same(const std::filesystem::path& path, const std::string& fingerprint,
                     bool has_surface) {
  if (stored_in_hdf5(path) != fingerprint) return {};
  try {
    return has_surface ? read_with_surface(path) : read_samples(path);
  } catch (const Error&) {  // damaged: simulated anew
    return {};
  }
}

}  // namespace

Samples simulate_kept_paths(const fem::Simulator& simulator, const TestPoints& points,
                            const std::vector<ToolPath>& paths, const KeptPaths& request) {
  const bool is_kept = !request.output.empty();
  const std::filesystem::path partial = partial_of(request.output);
  fem::SimulateOptions options{.jobs = job_count(request.jobs), .already_done = {}};
  if (is_kept && request.resume)
    for (const auto& path : {request.output, partial})
      if (options.already_done.rows() == 0)
        options.already_done =
            read_if_same(path, request.fingerprint, simulator.setup().keeps_surface);
  const auto keep = [&](const std::filesystem::path& path, const Samples& samples) {
    if (is_kept) write_with_surface(path, samples, {{kInputsAttribute, request.fingerprint}});
  };
  KeepClock clock;
  Samples samples;
  {
    ConsoleProgress progress(request.what);
    samples = fem::simulate_paths(
        simulator, points, paths, options,
        [&](const std::function<Samples()>& so_far) {
          clock.keep([&] { keep(partial, so_far()); });
        },
        progress.progress());
  }
  add_origin(samples, simulator);
  if (is_interrupted()) {
    keep(partial, samples);
    throw Interrupted(
        is_kept ? fmt::format("{}: what is done is kept in {}; run goes on with it by itself",
                              request.what, partial.string())
                : fmt::format("{}: what was done is lost, for there is no folder to keep it in",
                              request.what));
  }
  keep(request.output, samples);
  if (is_kept) remove_partial(request.output);
  return samples;
}

}  // namespace palpate::tools
