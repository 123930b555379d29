#include "tools/setup/propose.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "libfem/mesh/grade/smooth_surface.hpp"
#include "libfem/mesh/repair/facts.hpp"
#include "libfem/mesh/repair/mend.hpp"
#include "libfem/mesh/repair/wall.hpp"
#include "libfit/core/error.hpp"
#include "libfit/core/perception.hpp"
#include "libfit/core/text.hpp"
#include "libfit/core/units.hpp"
#include "tools/scene/canonical.hpp"
#include "tools/scene/tissues.hpp"
#include "tools/setup/check.hpp"
#include "tools/stages/body/prepare.hpp"

namespace palpate::tools {
namespace {

// wrap_m: what it was wrapped with, 0 where it was closed without.
Mended mended(const Surface& surface, const std::string& mesh, bool may_move, double& wrap_m) {
  try {
    return mend_surface(surface, {}, mesh);
  } catch (const Error& error) {
    const double diagonal_m = extent_m(surface.vertices).norm();
    wrap_m = rounded_m(diagonal_m * 0.02);
    Mended wrapped = mend_surface(surface, {.wrap_alpha_m = wrap_m}, mesh);
    if (wrapped.moved_m <= kMostMoved * diagonal_m || may_move) return wrapped;
    throw Error(mesh,
                fmt::format("{}, and a wrap moves its surface by {}, more than {} of its diagonal",
                            error.fact(), millimetres(wrapped.moved_m), percent(kMostMoved, 0)),
                "Repair it in a mesh editor, or have it wrapped all the same with --wrap.");
  }
}

// In millimetres; 0 where it is that within the rounding of a body of some size.
double in_mm_of(double length_m, double size_m) {
  return std::abs(length_m) < 1e-9 * size_m ? 0.0 : 1e3 * length_m;
}

// A tissue, and the sentence that says where it comes from.
struct ChosenTissue {
  const Tissue& tissue;
  std::string origin;
  bool is_doubtful = false;
  bool is_organ = false;  // by its mesh's name
};

ChosenTissue choose_tissue(const std::string& asked, const std::filesystem::path& mesh,
                           bool has_lumen) {
  const auto chosen = [](const Tissue& tissue, const std::string& because, bool is_doubtful) {
    return ChosenTissue{
        tissue,
        fmt::format("tissue: {} ({:.3g} kPa), {}", tissue.name, tissue.young_Pa / 1e3, because),
        is_doubtful};
  };
  if (!asked.empty()) return chosen(find_tissue(asked, "--tissue"), "as asked for", false);
  const std::string file = mesh.filename().string();
  const Tissue* meant = tissue_of_name(mesh.stem().string());
  const HollowOrgan* organ = hollow_organ_of_name(mesh.stem().string());
  if (meant == nullptr)
    return chosen(find_tissue(kUnnamedTissue, "--tissue"),
                  organ == nullptr
                      ? fmt::format("since neither --tissue nor the name {} says which", file)
                      : fmt::format("as for anything that the table of tissues does not have, and "
                                    "it has no {}: --tissue gives another",
                                    organ->name),
                  true);
  if (meant->name.ends_with("-wall") && !has_lumen)
    return chosen(
        *meant,
        fmt::format("by the name {}, and the whole mesh is filled with it: --tissue gives another",
                    file),
        true);
  ChosenTissue named =
      chosen(*meant, fmt::format("by the name {}: --tissue gives another", file), false);
  named.is_organ = true;
  return named;
}

// The hollow organ that a file's name means, where its mesh is solid and its wall leaves a lumen:
// notes what is made of it.
const HollowOrgan* hollow_organ(const Surface& surface, const SurfaceFacts& facts,
                                const std::filesystem::path& mesh, ProposedScene& scene) {
  const HollowOrgan* organ = hollow_organ_of_name(mesh.stem().string());
  if (organ == nullptr || facts.cavities > 0) return nullptr;
  const std::string wall = fmt::format("{:.3g} mm", 1e3 * organ->wall_m);
  if (!leaves_lumen(surface, organ->wall_m)) {
    scene.warnings.push_back(
        fmt::format("a {} is hollow, but a wall of {} leaves no lumen in this mesh: it stays solid",
                    organ->name, wall));
    return nullptr;
  }
  scene.warnings.push_back(fmt::format(
      "a {} is hollow: it gets a wall of {} ({}). Give yours, and the pressure of what fills it",
      organ->name, wall, organ->source));
  return organ;
}

std::string material_text(const Tissue& tissue) {
  const std::string deviation =
      tissue.deviation_Pa > 0 ? fmt::format(" +- {:.3g}", tissue.deviation_Pa / 1e3) : "";
  return fmt::format(
      "[material]                      # {}: {:.4g}{} kPa, {}\n"
      "law = \"{}\"             # {}{}{}\n"
      "young = \"{:.4g} kPa\"\n"
      "poisson = {}\n{}",
      tissue.name, tissue.young_Pa / 1e3, deviation, tissue.measured, tissue.law, tissue.source,
      tissue.doi.empty() ? "" : ", doi:", tissue.doi, tissue.young_Pa / 1e3, tissue.poisson,
      tissue.relaxation.empty()
          ? ""
          : fmt::format(
                "# relaxation = [[SHARE, \"TIME\"], ...]   # measure the shares; times: {}\n",
                tissue.relaxation));
}

// What a scene says of its body. wrap_m: 0 where the surface needs none.
struct ProposedBody {
  std::filesystem::path mesh, divided_from;  // the second empty where it is the file's own
  std::string unit;
  SurfaceFacts facts;
  double wrap_m = 0;
  const HollowOrgan* hollow = nullptr;  // where it gets a wall
};

// The faces that a volume mesh marks as held, by the group's name; empty: none is.
std::string held_group(const SceneChoices& choices) {
  for (const MeshGroup& group : choices.groups)
    for (const char* word :
         {"fix", "held", "hold", "clamp", "support", "dirichlet", "base", "bottom"})
      if (std::string name = group.name; group.dimension == 2 && choices.held.empty()) {
        std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
        if (name.find(word) != std::string::npos) return group.name;
      }
  return {};
}

// A body that is known to lie on what yields, and whose mesh marks nothing else.
bool lies_on_bed(const ChosenTissue& chosen, const SceneChoices& choices) {
  return held_group(choices).empty() && chosen.is_organ && !chosen.tissue.rests_on.empty();
}

// The groups of a volume mesh as a scene names them: all but the largest part are inclusions
// whose material only a person knows.
std::string groups_text(const std::vector<MeshGroup>& groups) {
  std::size_t largest = 0;
  std::vector<std::string> listed;
  for (const MeshGroup& group : groups) {
    if (group.dimension == 3) largest = std::max(largest, group.cells);
    listed.push_back(fmt::format("{} ({} {})", quoted(group.name), group.cells,
                                 group.dimension == 3 ? "tetrahedra" : "faces"));
  }
  if (groups.empty()) return "";
  std::string text = fmt::format("\n# The mesh marks {}.\n", fmt::join(listed, ", "));
  for (const MeshGroup& group : groups)
    if (group.dimension == 3 && group.cells < largest)
      text += fmt::format("# [[inclusion]]\n# group = {}\n# material = {{ young = \"20 kPa\" }}\n",
                          quoted(group.name));
  return text;
}

std::string body_text(const ProposedBody& body, const ChosenTissue& chosen, const Window& window,
                      const SceneChoices& choices) {
  const std::string marked = held_group(choices);
  const double size_m = body.facts.extent_m.maxCoeff();
  const std::string held = !marked.empty()
                               ? fmt::format("group = {}", quoted(marked))
                               : fmt::format("{} = {{ axis = \"{}\", at = \"{:.4g} mm\" }}",
                                             window.sign < 0 ? "below" : "above",
                                             "xyz"[window.axis], in_mm_of(window.held_m, size_m));
  // Springs stand for some 20 mm of tissue that is softer than the organ. A clamped quarter of a
  // liver of 181 mm makes it sway by 2 of 10 mm; on this bed its statement is off by 3.2 % (p95).
  const std::string rest =
      lies_on_bed(chosen, choices)
          ? fmt::format(
                "\n[[bed]]                         # it lies on {}: measure yours\n{}\n"
                "thickness = \"20 mm\"\nmaterial = {{ young = \"3 kPa\", poisson = 0.45 }}\n\n",
                chosen.tissue.rests_on, held)
          : fmt::format("fixed = [ {{ {} }} ]   # what the body rests on\n\n", held);
  const std::string wrap =
      body.wrap_m > 0
          ? fmt::format(
                "wrap = \"{:.3g} mm\"               # it has gaps; narrower ones are closed\n",
                1e3 * body.wrap_m)
          : "";
  const std::string wall =
      body.hollow == nullptr
          ? ""
          : fmt::format(
                "wall = \"{:.3g} mm\"              # {}; solid without\n"
                "# pressure = \"{:.2g} Pa\"           # of what fills it in this shape; some such "
                "stretches it by a tenth\n",
                1e3 * body.hollow->wall_m, body.hollow->source,
                // A sphere has a stress of p R / (2 t).
                0.1 * 4 * chosen.tissue.young_Pa * body.hollow->wall_m /
                    body.facts.extent_m.minCoeff());
  const std::string divided =
      body.divided_from.empty()
          ? ""
          : fmt::format(
                "# {} with its triangles divided at the window, where they were too large, in m.\n",
                body.divided_from.filename().string());
  return fmt::format(
      "# {}\n"
      "# {}, {}. Made by `palpate new`: every line is a proposal.\n"
      "# Next: palpate check THIS_FILE, then palpate run THIS_FILE -o out\n\n"
      "[body]\n"
      "{}{} = {}\n"
      "length_unit = \"{}\"              # of this file; mesh files do not say\n"
      "{}{}{}",
      chosen.origin, body.mesh.filename().string(),
      size_in_words(body.facts.extent_m, body.facts.volume_m3), divided,
      choices.is_volume ? "tetmesh" : "surface", quoted(body.mesh.string()), body.unit, wrap, wall,
      rest);
}

std::string experiments_text(const Window& window, const ProposedBall& ball, const Tissue& tissue) {
  const double radius_mm = 1e3 * window.radius_m, probe_mm = 1e3 * ball.radius_m;
  const auto middle = [&](int axis) { return in_mm_of(window.centre[axis], window.radius_m); };
  return fmt::format(
      "\n[probe]                         # the tool's tip\n"
      "shape = \"sphere\"\n"
      "radius = \"{:.3g} mm\"\n"
      "friction = 0.2                  # wet tissue on steel: 0.02 to 0.3\n\n"
      "[experiments]\n"
      "test_points = \"auto\"            # placed where prediction fails\n"
      "tolerance = 0.07                # relative force error at new points, p95\n"
      "budget = 200                    # most points simulated, a second or two each\n"
      "region = {{ sphere = {{ center = [\"{:.4g} mm\", \"{:.4g} mm\", \"{:.4g} mm\"], radius = "
      "\"{:.3g} mm\" }} }}   # the window that is touched\n"
      "depth = \"{:.3g} mm\"\n"
      "press_steps = 7\n"
      "drag_depths = [\"{:.3g} mm\", \"{:.3g} mm\"]\n"
      "drag_distance = \"{:.3g} mm\"      # long enough to slip\n"
      "drag_directions = 1\n"
      "drag_steps = 7\n"
      "# pairs = 6                     # of two tools side by side: several tools, or several "
      "balls\n\n"
      "# [[experiments.probe]]         # a second ball, for forces of tools that are like it\n"
      "# shape = \"sphere\"\n"
      "# radius = \"{:.3g} mm\"\n"
      "# points = 6\n\n"
      "[validate]\n"
      "points = 12                     # held-out places that the statement compares\n"
      "{}young_deviation = {:.2g}          # of people, over the value: how far this body may be "
      "from it\n"
      "friction_deviation = 0.4        # likewise, of 0.02 to 0.3\n",
      probe_mm, middle(0), middle(1), middle(2), radius_mm, probe_mm, 0.4 * probe_mm,
      0.85 * probe_mm, 0.8 * probe_mm, 0.5 * probe_mm, tissue.deviation_Pa > 0 ? "" : "# ",
      tissue.deviation_Pa > 0 ? tissue.deviation_Pa / tissue.young_Pa : 0.3);
}

// A window, the surface divided where that is coarse, and a ball for it.
struct Site {
  Window window;
  std::optional<Surface> divided;
  ProposedBall ball;
};

std::optional<Site> site_of(const Surface& surface, const Window& window, const Tissue& tissue,
                            bool is_volume) {
  Site site{window, std::nullopt, {}};
  const auto ball = [&](const Surface& on) {
    return ball_for(window, on, tissue.young_Pa, tissue.poisson);
  };
  const std::vector<char> is_in = vertices_in(window, surface);
  std::optional<ProposedBall> found;
  // `prepare` divides the boundary of a volume mesh, as it does any surface.
  if (is_volume || std::count(is_in.begin(), is_in.end(), 1) >= 40) found = ball(surface);
  if (!found && !is_volume) {
    site.divided =
        // Edges over the radius, so that it has some hundred vertices.
        fem::divided_near(surface, window.centre, window.radius_m, 0.3 * window.radius_m);
    if (site.divided->vertices.rows() == surface.vertices.rows()) return std::nullopt;
    found = ball(*site.divided);
  }
  if (!found) return std::nullopt;
  site.ball = *found;
  return site;
}

Site find_site(const Surface& surface, const std::string& mesh, const SceneChoices& choices,
               const Tissue& tissue) {
  for (const Window& window : windows_of(surface, choices.held))
    if (auto site = site_of(surface, window, tissue, choices.is_volume)) return std::move(*site);
  const std::string side =
      choices.held.empty() ? "no side of it" : fmt::format("opposite its {} side it", choices.held);
  throw Error(mesh,
              fmt::format("{} has {} that a ball can press: it is a sheet there, or too little of "
                          "it can be touched",
                          side, choices.held.empty() ? "a window" : "no window"),
              choices.held.empty()
                  ? "Give a closed surface with both its sides, or write a scene by hand with a "
                    "region that a tool comes to (docs/formats/scene.md)."
                  : "Give another side, or leave --held out.");
}

void note_site(const Site& site, const ChosenTissue& chosen, const SceneChoices& choices,
               ProposedScene& scene) {
  const Window& window = site.window;
  const Surface& surface = site.divided ? *site.divided : scene.surface;
  const std::string marked = held_group(choices);
  const std::string held =
      marked.empty()
          ? fmt::format("{} its {} side; the window lies opposite",
                        lies_on_bed(chosen, choices) ? "by a bed on" : "on", window.side())
          : fmt::format("where the mesh marks {}; the window lies opposite its {} side",
                        quoted(marked), window.side());
  scene.notes.push_back(
      fmt::format("held {}, where the body is {:.3g} mm "
                  "thick (median) and a ball of {:.3g} mm reaches {} vertices",
                  held, 1e3 * thickness_under_m(window, surface), 1e3 * site.ball.radius_m,
                  site.ball.reachable));
  if (site.ball.force_N < perception().force_floor_N)
    scene.warnings.push_back(fmt::format(
        "a press ends at about {:.2g} N, less than a hand notices ({} N): the body is thin for a "
        "material as soft as {}. Give its own with --tissue, or check --unit",
        site.ball.force_N, perception().force_floor_N, chosen.tissue.name));
}

}  // namespace

ProposedScene propose_scene(const std::filesystem::path& mesh, const Surface& in_file,
                            const SceneChoices& choices) {
  const Vec3 extent = extent_m(in_file.vertices);
  ProposedBody body{mesh, {}, choices.unit.empty() ? likely_unit(extent) : choices.unit, {}};
  if (!choices.held.empty() && std::ranges::find(kSides, choices.held) == kSides.end())
    throw Error("--held", fmt::format("\"{}\" is no side", choices.held),
                fmt::format("Use one of {}.", fmt::join(kSides, ", ")));
  const double unit_m = mesh_unit_m(body.unit, "--unit");

  ProposedScene scene;
  scene.unit = body.unit;
  Surface scaled = in_file;
  scaled.vertices *= unit_m;
  Mended closed = mended(scaled, mesh.string(), choices.wrap, body.wrap_m);
  scene.surface = std::move(closed.surface);
  body.facts = surface_facts(scene.surface);
  if (!choices.is_volume) body.hollow = hollow_organ(scene.surface, body.facts, mesh, scene);
  const ChosenTissue chosen =
      choose_tissue(choices.tissue, mesh, body.hollow != nullptr || body.facts.cavities > 0);
  const Tissue& tissue = chosen.tissue;
  scene.tissue = tissue.name;
  (chosen.is_doubtful ? scene.warnings : scene.notes).push_back(chosen.origin);
  for (const std::string& change : closed.changes) scene.notes.push_back("mended: " + change);
  scene.notes.push_back(fmt::format("in {} it measures {}", body.unit,
                                    size_in_words(body.facts.extent_m, body.facts.volume_m3)));
  const std::int64_t pieces = body.facts.components - body.facts.cavities;
  if (body.facts.cavities > 0)
    scene.notes.push_back("it has " + counted(body.facts.cavities, "cavity", "cavities"));
  if (pieces > 1)
    scene.notes.push_back(
        fmt::format("it has {} pieces; those that touch nothing held will float away", pieces));
  for (const auto& doubt : {doubt_of_size(extent, unit_m), doubt_of_lid(scaled, closed.changes)})
    if (doubt) scene.warnings.push_back(*doubt);

  const Site site = find_site(scene.surface, mesh.string(), choices, tissue);
  if (site.divided) {
    scene.notes.push_back(fmt::format(
        "its triangles are too large for the window of {:.3g} mm: divided there, from {} to {} "
        "vertices on the smooth surface through them",
        1e3 * site.window.radius_m, scene.surface.vertices.rows(), site.divided->vertices.rows()));
    body = {choices.divided_mesh, mesh, "m", body.facts, 0, body.hollow};
  }
  note_site(site, chosen, choices, scene);
  if (site.divided) scene.surface = *site.divided;
  scene.is_divided = site.divided.has_value();
  scene.text = body_text(body, chosen, site.window, choices) + material_text(tissue) +
               groups_text(choices.groups) + experiments_text(site.window, site.ball, tissue);
  return scene;
}

}  // namespace palpate::tools
