#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "tools/workshop/rivals/coarse_body.hpp"
#include "tools/workshop/rivals/node_process.hpp"

namespace palpate::tools {

/// How MuJoCo steps a flex.
struct MujocoSettings {
  BallContact ball;  ///< no penalty: its contacts are constraints, as hard as the step allows
  double density_kg_m3 = 1000;
  double damping_s = 0.005;  ///< viscosity over modulus
  double step_s = 1e-3;
  std::string solver = "CG";
};

/// Whether a folder's node_modules has npm's @mujoco/mujoco.
bool has_mujoco(const std::filesystem::path& packages);

/// A rigid ball on a flex of MuJoCo (3.14), stepped in Node: tets of one modulus, the mean of the
/// body's, implicit in stiffness and contact. Force is what the constraints push the vertices with.
class MujocoBody {
 public:
  /// Throws Error where Node does not answer.
  MujocoBody(const CoarseBody& body, const MujocoSettings& settings,
             const std::filesystem::path& packages);

  void start();
  /// Force ON THE BODY [N] of the ball about centre_m, after a step with it there.
  Vec3 force(const Vec3& centre_m);
  std::size_t bytes() const { return bytes_; }
  double cpu_s() const { return cpu_s_; }  ///< that Node took for all steps so far

 private:
  std::unique_ptr<NodeProcess> node_;
  double cpu_s_ = 0;
  std::size_t bytes_ = 0;
};

}  // namespace palpate::tools
