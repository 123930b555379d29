#pragma once

#include <optional>
#include <vector>

#include "libfit/assets/asset_bytes.hpp"
#include "libfit/core/curves.hpp"
#include "libfit/core/samples.hpp"
#include "libfit/runtime/engine.hpp"
#include "libfit/scan/nodes.hpp"
#include "libfit/scan/recording.hpp"

namespace palpate::scan {

/// The body at the nodes, N rows each, and the recording.
struct ScanParameters {
  Eigen::MatrixXd increment_N;  ///< N x K, >= 0, of the normal curves
  Eigen::VectorXd height_m;     ///< N, coefficients of Nodes
  Eigen::VectorXd friction, friction_slope_1_m;
  Recording recording;
};

/// Passes of a tool, one experiment each: of scans, and presses or drags beside them, whose bias
/// and drift are none.
struct Passes {
  std::vector<Eigen::Index> first;  ///< row of each pass, and the end of all
  std::vector<char> is_scan;        ///< N
  Points position_m, force_N;       ///< N x 3, force of the tool ON the body
  Eigen::VectorXd time_s;           ///< N, of the recording's clock; NaN: slow motion

  explicit Passes(const Samples& samples);
  Eigen::Index rows() const { return time_s.size(); }
  std::size_t count() const { return first.size() - 1; }
  /// Place of the tool when the force of a row acted.
  Vec3 tip(std::size_t pass, Eigen::Index row, const Recording& recording) const;
  Vec3 offset_N(Eigen::Index row, const Recording& recording) const;
  /// Force on the body behind a reading.
  Vec3 force_on_body(Eigen::Index row, const Recording& recording) const;
};

/// State of the contact after a row.
struct RowState {
  runtime::ContactPlace place;  ///< triangle -1: nothing touches
  runtime::RingMemory<double> memory;
};
struct Walked {
  Points force_N, reading_N;     ///< N x 3, ON THE BODY, and as the sensor reads it
  std::vector<char> is_sliding;  ///< N
  std::vector<RowState> state;   ///< N, where it was asked for
};

/// Forces on the body, a row each of passes, as the sensor reads them.
Points readings(const Points& force_N, const Passes& passes, const Recording& recording);

/// Curves of the law of rings at the vertices of a mesh; of those outside all cells 0.
CurveSet curves_of(const Nodes& nodes, const ScanParameters& p, const CurveBasis& basis,
                   const Nodes::NodeMesh& mesh, const Points& inward_normal);

/// The body of parameters as the engine plays it.
class PlayedBody {
 public:
  PlayedBody(const Nodes& nodes, const ScanParameters& parameters, const CurveBasis& basis,
             int parts);
  PlayedBody(const PlayedBody&) = delete;
  PlayedBody& operator=(const PlayedBody&) = delete;

  const runtime::AssetView& asset() const { return asset_; }
  const Nodes::NodeMesh& mesh() const { return mesh_; }
  const Model& model() const { return model_; }
  /// Passes along the engine, each on a body that nothing has touched. is_wanted: of each row,
  /// those of a pass alike; others stay 0. jobs: threads.
  Walked walk(const Passes& passes, const std::vector<char>& is_wanted, bool wants_states,
              int jobs) const;

 private:
  const Nodes& nodes_;
  const Eigen::VectorXd height_m_;
  const Recording recording_;
  Nodes::NodeMesh mesh_;
  Model model_;
  std::optional<AssetBytes> bytes_;
  runtime::Asset asset_;
};

/// Curvature of the surface at its vertices as the law of rings reads it, -du/dc at half of the
/// curves' depth (docs/method.md, M15c), V x 6: least squares over neighbouring normals.
Controls vertex_curvature(const Surface& surface, const Points& inward_normal, double depth_m);

}  // namespace palpate::scan
