#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"
#include "libfit/core/probe.hpp"

namespace palpate {

/// Places of experiments, and how they triangulate the reachable surface.
/// position P x 3 [m] on the fine surface, normal P x 3 inward unit, name P.
/// triangles: rows index the points; empty when a rig's scattered points await `refine`.
struct TestPoints {
  Points position;
  Points normal;
  std::vector<std::string> name;
  Triangles triangles;
};

/// A mesh of a file that a scene names, of triangles or tets. is_painted: of one that is painted a
/// flag for each corner of a cell.
struct SceneMesh {
  Points vertices;
  Triangles triangles;
  Tets tets;
  std::vector<char> is_painted;
};

/// The result of `prepare` (body.h5): the rest surface, the test points on it and the filled
/// volume, and how experiments are made on it.
struct Body {
  Surface surface;                 ///< fine, mended, outward; closed unless made --surface-only
  std::vector<char> in_region;     ///< per surface vertex: curves are wanted here
  std::vector<char> is_reachable;  ///< of these, where the tool can touch; the rest are gaps
  TestPoints test_points;
  TetMesh volume;                   ///< base mesh, coarse; empty when made --surface-only
  std::vector<char> is_held;        ///< per volume node: held fixed
  std::vector<std::string> mended;  ///< what was changed in the input, a sentence each
  std::optional<ProbeSpec> probe;   ///< that experiments are made with
  std::string scene;                ///< the scene's text, defaults filled in; empty: there is none
  std::vector<SceneMesh> scene_meshes;  ///< in the order in which the text names their files
};

}  // namespace palpate
