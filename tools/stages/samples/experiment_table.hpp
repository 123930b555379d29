#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libfem/probes/probes.hpp"
#include "libfem/solve/experiments/simulate.hpp"
#include "libfem/solve/experiments/simulator.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/experiments.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/experiments/draw.hpp"
#include "libfit/experiments/follow.hpp"
#include "tools/scene/scene.hpp"
#include "tools/stages/body/prepare.hpp"

namespace palpate::tools {

/// Refuses tools beside [probe] that the simulator or the engine does not know: balls in a row of
/// no capsule, a probe that is no ball, a tool that is neither balls nor round along its press.
/// Throws Error.
void check_tools(const Scene& scene);

/// A tool as the engine plays it: its balls, or the ball or tip that it ends with. Throws Error
/// where it is no shape.
PlayedTool tool_shape(const Scene& scene, const ToolSection& tool);

/// [tool] and each [[validate.tool]] of a scene, as the engine plays them.
struct NamedTool {
  std::string name;
  PlayedTool tool;
};
std::vector<NamedTool> played_tools(const Scene& scene);

/// The round end of the scene's own probe; nothing of one that is not round along its press, or no
/// shape at all.
std::optional<Indenter> own_end(const Scene& scene);

/// The round end with which the probe of a scene's file meets an asset. Throws Error where it has
/// none, or the asset knows no other than its own.
Indenter meeting_end(const std::string& scene_path, const runtime::AssetView& asset);

/// The scene whose probe is that tool.
Scene with_tool(const Scene& scene, const ToolSection& tool);

/// Paths on which the tool leans and none of its balls leaves what answers.
HeldOut draw_tool_paths(const Scene& scene, const ToolSection& tool, const Body& body, int paths,
                        std::uint64_t seed);

/// How deep a tool is pressed that is not played as balls: as the probe, or as it is known for.
double known_depth_m(const Scene& scene, const ToolSection& tool);

/// tool_shape() of each tool of a scene, found once.
using ToolShapes = std::map<const ToolSection*, PlayedTool>;

/// The tool as the engine plays a row that it made.
PlayedTool played_as_tool(const Scene& scene, const ToolSection& tool, ToolShapes& shapes,
                          const Samples& samples, Eigen::Index row);

/// Purpose of experiments: to identify curves and constants, or to be held out and compared
/// with the asset.
enum class Purpose { identify, hold_out };

/// Input from which experiments of a kind are drawn. points: the test points, or those held out.
struct Drawing {
  const Scene& scene;
  const Body& body;
  const TestPoints& points;
  Purpose purpose;
  std::vector<double> change = {};  ///< of an asset along each triangle (press_changes)

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

/// The simulator of a scene's body, material, inclusions and probe. It keeps how the surface moves
/// where the scene wants it; one of make_setup does not.
fem::Simulator make_simulator(const Scene& scene, const Body& body);

/// Columns of Samples::surface of a scene: 0 where its samples do not tell how the surface moves.
Eigen::Index surface_columns(const Scene& scene, const Body& body);

/// True if some material of the scene relaxes; if one softens where it was strained.
bool relaxes(const Scene& scene);
bool softens(const Scene& scene);

/// The Prony series of the body's contacts: the material's as it is felt through forces (M14c), by
/// presses at the first few test points of its samples. Empty of a body whose own material does not
/// relax.
Relaxation contact_relaxation(const Scene& scene, const Body& body, const Samples& samples);

/// Adds what later stages need to know of the simulators of a list: their probes, and the body's
/// Poisson's ratio.
void add_body_and_probe(Samples& samples, const fem::SimulatorOf& simulator,
                        const ExperimentList& list);

/// Says what error the rows' own estimates leave at the points, and whether it is what was asked
/// for (ExperimentsSection::force_tolerance).
void say_force_errors(const Samples& samples, double wanted);

/// Lists experiments with rows that are not good, at most a screenful. Returns how many there are.
std::size_t list_bad_experiments(const Samples& samples);

}  // namespace palpate::tools
