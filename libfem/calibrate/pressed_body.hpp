#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libfem/calibrate/identify.hpp"
#include "libfem/solve/experiments/simulator.hpp"

namespace palpate::fem {

/// A press that was simulated: forces along the inward normal at equal steps of its depth [N], and
/// their stated errors. None where the simulator does not get so deep.
struct SimulatedPress {
  std::vector<double> force_N, error_N;
};

/// Which meshes a press is simulated on: one coarse one, or those of the scene.
enum class PressMesh { coarse, scene };

/// Presses on a body of known shape, and the same presses by the simulator with other materials of
/// the body. Every press is simulated once: `known` holds those that were, by their name.
/// Materials that differ by a common factor of their moduli are one where is_scaled()
/// (M43a).
class PressedBody {
 public:
  /// samples: good press rows along the inward normal are used, each simulated with the probe that
  /// made it; their points lie on the surface.
  /// Throws Error at `where` when there is none.
  PressedBody(SimulationSetup setup, const Samples& samples, const std::string& where, int jobs);

  const Observations& observed() const { return observed_; }
  std::size_t presses() const { return points_.size(); }
  /// Forces are in proportion to the moduli, unless an inclusion or a bed keeps its own.
  bool is_scaled() const {
    return setup_.materials.size() == 1 && !setup_.loads.bed_at &&
           setup_.loads.lumen_pressure_Pa == 0;
  }

  /// Forces at the rows, in parallel over materials and points; an empty vector where a press
  /// fails, and of all where progress stops it.
  std::vector<Eigen::VectorXd> forces(const std::vector<MaterialParameters>& materials,
                                      PressMesh mesh, const Progress& progress);
  /// Median over the rows of the relative error that the presses of a material state, which
  /// `forces` has simulated.
  double stated_error(const MaterialParameters& material, PressMesh mesh) const;

  std::map<std::string, SimulatedPress> known;
  std::function<void()> on_press;  ///< a press became known; one call at a time
  std::size_t simulated = 0;

 private:
  struct Point {
    Vec3 position, normal;
    std::optional<ProbeSpec> probe = std::nullopt;  ///< none: the setup's
    Experiments press;
    std::vector<std::pair<double, Eigen::Index>> rows;  ///< depth [m], number of the row
  };
  std::string name_of(const MaterialParameters& material, std::size_t point, PressMesh mesh) const;
  /// The material that is simulated for another, and the factor of its forces.
  std::pair<MaterialParameters, double> simulated_for(MaterialParameters material) const;

  /// What is not known of these, in parallel, as far as progress lets it.
  void simulate(const std::vector<MaterialParameters>& materials, PressMesh mesh,
                const Progress& progress);

  SimulationSetup setup_;
  int jobs_;
  std::vector<Point> points_;
  Observations observed_;
};

/// A material identified from presses: sought on the coarse mesh, whose forces are multiplied row
/// by row with what they lack of the scene's accuracy at the material found (M43b). Where one
/// common factor is all that is free, the scene's meshes alone are used, once.
Identification identify(PressedBody& body, const MaterialParameters& start,
                        IdentifyOptions options);

}  // namespace palpate::fem
