#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libfit/core/geometry.hpp"
#include "libfit/core/probe.hpp"
#include "libfit/runtime/law/relaxation.hpp"

namespace palpate {

/// Places of experiments, and how they triangulate the reachable surface.
/// position P x 3 [m] on the fine surface, normal P x 3 inward unit, name P.
/// triangles: rows index the points; empty when a rig's scattered points await `refine`.
struct TestPoints {
  Points position;
  Points normal;
  std::vector<std::string> name;
  Triangles triangles;

  void add(const Vec3& at, const Vec3& inward, const std::string& called) {
    const Eigen::Index end = position.rows();
    position.conservativeResize(end + 1, 3);
    normal.conservativeResize(end + 1, 3);
    position.row(end) = at;
    normal.row(end) = inward;
    name.push_back(called);
  }
};

/// A mesh of a file that a scene names, of triangles or tets. is_painted: of one of which
/// a part is meant, a flag for each cell.
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

/// Relaxation of a body's forces as a Prony series (docs/method-body.md, section 24). At time t
/// after a step the body is 1 + sum_k share_k e^{-t/time_k} times as stiff as in slow motion. K <=
/// runtime::kMaxBranches; none: the body has no memory of time.
struct Relaxation {
  Eigen::VectorXd share;   ///< K, > 0: of the stiffness of slow motion
  Eigen::VectorXd time_s;  ///< K, > 0, rising
  double radius_m = 0;     ///< of the ball that slides; 0: not known, and slides renew no material

  Eigen::Index branches() const { return share.size(); }
};

/// As the law reads it.
inline runtime::RelaxationView relaxation_view(const Relaxation& relaxation) {
  runtime::RelaxationView out;
  out.branches = static_cast<int>(relaxation.branches());
  out.radius_m = relaxation.radius_m;
  for (int k = 0; k < out.branches; ++k) {
    out.share[k] = relaxation.share[k];
    out.time_s[k] = relaxation.time_s[k];
    out.fast += out.share[k];
  }
  return out;
}

}  // namespace palpate
