#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "libfit/assets/changed_model.hpp"
#include "libfit/assets/exporters.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/io/csv/tables.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/refine/refine.hpp"
#include "tools/scene/scene.hpp"
#include "tools/stages/samples/experiment_table.hpp"

namespace palpate::tools {

/// Samples, with how the surface moved where that is known.
Samples read_known(const std::filesystem::path& samples);

/// Curves on every fine node of the body's surface, with the probe of the curves; coverage is said
/// on stderr. samples: those of the curves, which tell how the surface moves and, of a scene with
/// pairs or a [tool], how contacts feel each other. scene: null of points that were measured.
Model refine_body(const FittedCurves& curves, const Body& body, const Samples& samples,
                  const Scene* scene);

/// The largest depth of rows [m]; 0 where none is inward.
double deepest_m(const Samples& samples);

/// True if rows are of scans: their fit has curves at every vertex, and nothing is interpolated.
bool are_scanned(const Samples& samples);

/// The attribute of model.h5 that says how many test points have no curves of their own, in words.
inline constexpr const char* kGuessedAttribute = "points_without_curves_of_their_own";

/// Attributes of a model.h5 of these curves: what it was made from, and kGuessedAttribute where
/// some points are underdetermined or failed.
Attributes model_attributes(const FittedCurves& curves, const std::string& made_from);

struct ExportRequest {
  std::string fingerprint;            ///< put into the asset's meta; empty for none
  std::filesystem::path engine;       ///< folder to copy the engine into; empty for none
  std::vector<NamedTool> tools = {};  ///< of the scene, put into the asset's meta
  ModelChanges changes = {};          ///< made already; put into the asset's meta
  /// kGuessedAttribute of the model: warned of, and put into the asset's meta; empty for none.
  std::string guessed_points = {};
};

/// Changes as an asset's meta has them: `stiffness`, `friction`; null where nothing is changed.
nlohmann::ordered_json json_of(const ModelChanges& changes);

/// The factor on the model's forces by which its asset answers a recorded press best: path is of a
/// tip, with force_N.
StiffnessFit stiffness_of_press(const Model& model, const PosePath& path);

/// Writes the model in the format of the output's name; says what and how large.
ExportReport export_model(const Model& model, const std::filesystem::path& output,
                          const ExportRequest& request);

/// The probe that curves were made with, as an asset's meta says it (docs/formats/asset.md): JSON,
/// in SI; of a mesh how large it is, not all of it.
std::string probe_meta(const ProbeSpec& probe);

/// Puts a statement of error, a JSON object, into an asset's meta data; nothing else changes.
void put_statement(const std::filesystem::path& asset, const std::string& statement);

/// Writes an asset that moves the vertices of a mesh file with its surface: nothing else changes.
/// unit_of_mesh: a unit or a length; empty: the one of m, cm and mm in which the mesh is most
/// nearly as large as the body. Returns what a reply says of it. Throws Error where a vertex is far
/// from the surface.
nlohmann::ordered_json put_visual(const std::filesystem::path& asset,
                                  const std::filesystem::path& mesh,
                                  const std::filesystem::path& output,
                                  const std::string& unit_of_mesh);

}  // namespace palpate::tools
