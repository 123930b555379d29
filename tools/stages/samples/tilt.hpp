#pragma once

#include <filesystem>
#include <string>

#include "libfit/core/body.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/runtime/tool/tilt.hpp"
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
/// the knots of curves.h5, and writes the asset of a tool that turns, kTurningAsset: the upright
/// tool's curves, as of the ball that it ends with, and the control curves of (M59). body: with the
/// test points that were simulated. Throws Error where the curves are of another family than rings.
void make_turning_asset(const Scene& scene, const Body& body, const TiltRequest& request);
constexpr const char* kTurningAsset = "asset.turning.palp";

/// Of what make_turning_asset reads: the files of the folder and the scene.
std::string tilt_fingerprint(const Scene& scene, const std::filesystem::path& folder);

}  // namespace palpate::tools
