#include <fmt/core.h>

#include <Eigen/Geometry>

#include "libfit/core/closest_point.hpp"
#include "libfit/core/error.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/validation/replay.hpp"
#include "tools/console.hpp"
#include "tools/workshop/bench/bench.hpp"

namespace palpate::tools {
namespace {

using namespace validation;

// The model's curves at a place of its surface, as a set of one row.
CurveSet curves_at(const Model& model, const SurfacePoint& hit) {
  CurveSet out = model.curves;
  const auto corner = model.surface.triangles.row(hit.triangle);
  const auto blend = [&](Controls& control) {
    const Controls all = std::move(control);
    control = Controls::Zero(1, all.cols());
    for (int k = 0; k < 3 && all.rows() > 0; ++k)
      control.row(0) += hit.weight[k] * all.row(corner[k]);
  };
  for (Controls& control : out.control) blend(control);
  return out;
}

class Predict final : public Command {
 public:
  explicit Predict(Arguments& arguments) {
    arguments.positional("model", model_, "Model that predicts, model.h5");
    arguments.positional("samples", samples_,
                         "Samples at other points of the same body, samples.h5");
    arguments.option("--without", curves_,
                     "curves.h5 whose points are left out, because the model was fitted there");
  }

  int run(Reply& reply) override {
    const Model model = read_model(model_);
    const Samples samples =
        of_kinds(read_samples(samples_),
                 {ExperimentKind::press, ExperimentKind::drag, ExperimentKind::path});
    const double size_m = extent_m(model.surface.vertices).norm();
    if (curves_.empty())
      warn("without --without, points that the model was fitted at count as predicted");
    const Points fitted = curves_.empty() ? Points(0, 3) : read_curves(curves_).position;
    const BoxTree boxes = triangle_boxes(model.surface);
    Replayed replayed(samples);
    std::size_t predicted = 0, uncovered = 0;
    for (std::int32_t point = 0; point < samples.points(); ++point) {
      const Vec3 at = samples.point_position.row(point);
      const bool is_fitted =  // as refinement pairs points
          fitted.rows() > 0 &&
          (fitted.rowwise() - at.transpose()).rowwise().norm().minCoeff() < 1e-6 * size_m;
      if (is_fitted) continue;
      const auto hit = find(model, boxes, at, samples.point_normal.row(point), size_m);
      if (!hit) {
        ++uncovered;
        continue;
      }
      replay_point(samples, point, curves_at(model, *hit), 0, replayed);
      ++predicted;
    }
    if (predicted == 0)
      throw Error(samples_, "none of its points can be predicted",
                  "Give samples at points that the model covers and was not fitted at.");
    Statement statement = summarize(compare(samples, replayed));
    statement.probes = predicted;
    reply.json = nlohmann::ordered_json::parse(to_json(statement));
    reply.text = fmt::format("{} points predicted, {} that the model does not cover\n{}", predicted,
                             uncovered, in_words(statement));
    return kDone;
  }

 private:
  // Where a point sits on covered surface that faces as it does.
  static std::optional<SurfacePoint> find(const Model& model, const BoxTree& boxes, const Vec3& at,
                                          const Vec3& inward, double size_m) {
    return closest_point(model.surface, boxes, at, 0.01 * size_m, [&](const SurfacePoint& point) {
      Vec3 normal = Vec3::Zero();
      for (int k = 0; k < 3; ++k) {
        const std::int32_t vertex = model.surface.triangles(point.triangle, k);
        if (point.weight[k] > 0 && !model.is_covered[vertex]) return false;
        normal += point.weight[k] * model.inward_normal.row(vertex).transpose();
      }
      return normal.dot(inward) > 0;
    });
  }

  std::string model_, samples_, curves_;
};

}  // namespace

const CommandRow kPredictCommand{
    "predict", "Compare a model with experiments at points where it was not fitted",
    declared<Predict>, "Studies", "predict model.h5 samples.h5"};

}  // namespace palpate::tools
