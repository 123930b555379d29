#include "libfit/assets/changed_model.hpp"

#include <cmath>

#include "libfit/core/error.hpp"
#include "libfit/runtime/asset/shape.hpp"

namespace palpate {
namespace {

template <class Numbers>
void scale(Numbers&& numbers, double factor) {
  numbers = (numbers * factor).template cast<float>().template cast<double>();
}

void scale_curves(CurveSet& curves, double factor) {
  const auto parts = parts_of(curves.family);
  for (std::size_t part = 0; part < parts.size(); ++part)
    if (parts[part].force != 0)
      scale(curves.control[part], parts[part].force > 0 ? factor : 1 / factor);
  for (double& number : curves.coupling.isotropic_m_N) number /= factor;
  for (double& number : curves.coupling.tangential_m_N) number /= factor;
}

void check_bounds(const CurveSet& curves) {
  const auto parts = parts_of(curves.family);
  for (std::size_t part = 0; part < parts.size(); ++part)
    for (Eigen::Index v = 0; v < curves.points(); ++v)
      if (const auto row = curves.control[part].row(v); !runtime::is_good_part(
              parts[part], row.data(), int(row.size()) / parts[part].width, false))
        throw Error("--scale-stiffness",
                    "\"" + std::string(parts[part].name) + "\" leaves the bounds of an asset",
                    "Use a factor nearer to 1.");
}

void change_friction(Model& model, double friction) {
  if (model.curves.family != CurveFamily::rings)
    throw Error("--friction", "curves of the separable law hold no friction of their own",
                "Simulate drags with this friction.");
  if (!model.probe || !(model.probe->friction > 0))
    throw Error("--friction", "the model was made without friction, or does not say with which",
                "Simulate it with this friction in [probe].");
  const double ratio = friction / model.probe->friction;
  scale(model.curves.control[runtime::kFriction], ratio);
  scale(model.curves.control[runtime::kFrictionSlope], ratio);
  model.probe->friction = friction;
}

}  // namespace

void change_model(Model& model, const ModelChanges& changes) {
  if (changes.stiffness != 1) {
    scale_curves(model.curves, changes.stiffness);
    // Amplitudes of the body's fields are displacements by a force (M32).
    scale(model.shape.point.rightCols(model.shape.point.cols() > 0 ? 3 * model.shape.modes : 0),
          1 / changes.stiffness);
  }
  if (changes.friction) change_friction(model, *changes.friction);
  check_bounds(model.curves);
}

StiffnessFit fit_stiffness(const Eigen::VectorXd& answered_N, const Eigen::VectorXd& recorded_N) {
  const double power = answered_N.squaredNorm();
  if (recorded_N.size() < 2 || !(power > 0) || !(recorded_N.dot(answered_N) > 0))
    throw Error("--scale-to", "the asset answers nothing along this press",
                "Let the path begin outside the body and press it, in the scene's coordinates.");
  StiffnessFit fit;
  fit.factor = recorded_N.dot(answered_N) / power;
  const double squares = (recorded_N - fit.factor * answered_N).squaredNorm();
  fit.deviation = std::sqrt(squares / double(recorded_N.size() - 1) / power);
  fit.misfit = std::sqrt(squares / recorded_N.squaredNorm());
  return fit;
}

}  // namespace palpate
