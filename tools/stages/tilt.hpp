#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/runtime/turning_tool.hpp"
#include "tools/scene/scene.hpp"

namespace palpate::tools {

/// Radius of the ball that the scene's tool ends with [m]; 0: see round_end_m.
double end_radius_m(const Scene& scene);

/// The nodes of [experiments] tilts.
runtime::TiltNodes tilt_nodes(const Scene& scene);

/// Throws Error where the scene asks for tilts of a tool that has none (round_end_m).
void check_tilts(const Scene& scene);

struct TiltRequest {
  int jobs = 0;
  std::filesystem::path folder;  ///< of the run: samples.h5, curves.h5 are there
  bool resume = true;
};

/// Simulates the tool leaning at every test point (samples.tilts.h5), fits curves at each lean on
/// the knots of curves.h5, and writes an asset for each node of the tilt, asset.tilt-0.palp and on,
/// whose curves are the control curves of (M59). body: with the test points that were simulated.
/// Throws Error where the curves are of another family than rings.
void make_tilt_assets(const Scene& scene, const Body& body, const TiltRequest& request);

/// Of what make_tilt_assets reads: the files of the folder and the scene.
std::string tilt_fingerprint(const Scene& scene, const std::filesystem::path& folder);
/// Stored in the folder's tilt assets; nothing where one is missing or they are not alike.
std::optional<std::string> stored_in_tilts(const Scene& scene, const std::filesystem::path& folder);

/// The tilt assets of a folder, opened.
class TiltAssets {
 public:
  /// Throws Error where one cannot be read, or they do not belong together.
  TiltAssets(const Scene& scene, const std::filesystem::path& folder);
  const runtime::TiltedBody& body() const { return body_; }

 private:
  std::vector<std::unique_ptr<AssetFile>> files_;
  runtime::TiltedBody body_;
};

}  // namespace palpate::tools
