#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string_view>

#include "libfem/solve/experiments/simulate.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/experiments/follow.hpp"
#include "tools/scene/scene.hpp"
#include "tools/stages/samples/compound.hpp"

namespace palpate::tools {

/// Purpose of experiments: to identify curves and constants, or to be held out and compared
/// with the asset.
enum class Purpose { identify, hold_out };

/// Input from which experiments of a kind are drawn. points: the test points, or those held out.
struct Drawing {
  const Scene& scene;
  const Body& body;
  const TestPoints& points;
  Purpose purpose;

  /// Seed of a kind's random draws.
  std::uint64_t seed(std::uint64_t of_kind) const {
    return purpose == Purpose::identify ? of_kind : static_cast<std::uint64_t>(scene.validate.seed);
  }
};

/// A kind of experiment; a new kind is a new row of the table.
struct ExperimentRow {
  ExperimentKind kind;
  /// The tool that takes the place of the probe; null: the probe. number: of Samples::probe_number.
  const ToolSection* (*tool)(const Scene&, Purpose, std::int32_t number);
  /// Number of experiments that are wanted; 0: none.
  int (*count)(const Scene&, Purpose);
  ExperimentList (*draw)(const Drawing&);
};
extern const std::vector<ExperimentRow> kExperimentRows;

/// Refuses pairs of two tools of a probe that is no ball: the simulator has no other second tool.
/// Throws Error.
void check_pairs(const Scene& scene);

/// All experiments of a scene for a purpose but for presses at test points: those of each kind, in
/// the order of the table.
ExperimentList draw_experiments(const Drawing& drawing);

/// The held-out paths of the scene, with their kinds: those that draw_experiments() follows.
HeldOut draw_held_out_paths(const Drawing& drawing);

/// Which tool made a row, by its kind.
PlayedAs played_as(const Scene& scene, Purpose purpose, const Samples& samples);

/// Tools beside [probe], which rows are of by Samples::probe_number.
const std::vector<ToolSection>& other_tools(const Scene& scene, Purpose purpose);

/// The simulators of a scene, each made when it is first asked for; not thread-safe until then.
class Simulators {
 public:
  Simulators(const Scene& scene, const Body& body, Purpose purpose)
      : scene_(scene), body_(body), purpose_(purpose) {}
  const fem::Simulator& operator()(const Experiment& one) const;

 private:
  const Scene& scene_;
  const Body& body_;
  Purpose purpose_;
  mutable std::map<std::pair<ExperimentKind, std::int32_t>, std::unique_ptr<fem::Simulator>> made_;
};

}  // namespace palpate::tools
