#include "libfit/io/files/files.hpp"

#include <cmath>
#include <limits>

#include "libfit/io/files/columns.hpp"
#include "libfit/runtime/asset/shape.hpp"

namespace palpate {

using namespace h5;

namespace {

// M: Model or const Model.
template <class M, class F>
void columns(M& model, F& f) {
  f.first("surface/triangles", model.surface.triangles);
  f.first("surface/vertices", model.surface.vertices, {"m"});
  f("inward_normal", model.inward_normal);
  f("is_covered", model.is_covered);
  f("blend_point", model.blend_point);
  f("blend_weight", model.blend_weight);
}

// S: ShapeResponse or const ShapeResponse.
template <class S, class Lengths, class F>
bool shape_columns(S& shape, Lengths& lengths_m, F& f) {
  if (!f.first("shape/point", shape.point, {.is_optional = true})) return false;
  f.first("shape/lengths", lengths_m, {"m"});
  f.first("shape/drag", shape.drag);
  f.first("shape/mode", shape.mode, {.is_optional = true});
  return true;
}

ShapeResponse read_shape(const h5::Reader& reader) {
  ShapeResponse shape;
  ColumnReader in(reader);
  Eigen::VectorXd lengths_m;
  if (!shape_columns(shape, lengths_m, in)) return shape;
  const auto integer = [&](const char* name) {
    return static_cast<int>(reader.integer_attribute("shape", name));
  };
  shape.intervals = integer("intervals");
  shape.modes = integer("modes");
  shape.radius_power = integer("radius_power");
  if (lengths_m.size() != 2) throw reader.error("shape/lengths", "are not two");
  shape.depth_m = lengths_m[0];
  shape.radius_m = lengths_m[1];
  return shape;
}

void write_shape(h5::Writer& writer, const ShapeResponse& shape) {
  const Eigen::VectorXd lengths_m = Eigen::Vector2d(shape.depth_m, shape.radius_m);
  ColumnWriter out(writer);
  if (!shape_columns(shape, lengths_m, out)) return;
  writer.attribute("shape", "intervals", shape.intervals);
  writer.attribute("shape", "modes", shape.modes);
  writer.attribute("shape", "radius_power", shape.radius_power);
}

// As the engine will want it of the asset.
void check_shape(const h5::Complain& complain, const Model& model) {
  const ShapeResponse& shape = model.shape;
  if (shape.point.rows() == 0) return;
  if (shape.intervals < 1 || shape.intervals > runtime::kMaxShapeIntervals || shape.modes < 0 ||
      shape.modes > runtime::kMaxShapeModes || shape.radius_power < 0 || shape.radius_power > 2)
    throw complain("shape", "has intervals, modes or a radius_power that are out of range");
  if (!(shape.depth_m > 0 && shape.radius_m > 0))
    throw complain("shape/lengths", "are not positive");
  if (shape.point.cols() != runtime::shape_numbers(shape.intervals, shape.modes) ||
      shape.drag.size() != runtime::shape_drag_numbers(shape.intervals) ||
      (shape.modes > 0 && (shape.mode.rows() != model.surface.vertices.rows() ||
                           shape.mode.cols() != 3 * shape.modes)))
    throw complain("shape/point", "has other sizes than its intervals and modes say");
  if (model.blend_point.rows() > 0 && model.blend_point.maxCoeff() >= shape.point.rows())
    throw complain("shape/point", "has fewer points than vertices blend");
  const auto is_good = [](const auto& values) {
    return values.size() == 0 ||
           (values.allFinite() && values.cwiseAbs().maxCoeff() <= runtime::kMaxShapeNumber &&
            rounded_to_float(values) == values);
  };
  if (!is_good(shape.point)) throw complain("shape/point", "is not finite, small and a float32");
  if (!is_good(shape.drag)) throw complain("shape/drag", "is not finite, small and a float32");
  if (!is_good(shape.mode)) throw complain("shape/mode", "is not finite, small and a float32");
}

void check_blend(const h5::Complain& complain, const Model& model) {
  const Eigen::Index vertices = model.surface.vertices.rows();
  check_indices(complain, "blend_point", model.blend_point,
                std::numeric_limits<std::int32_t>::max());
  for (Eigen::Index v = 0; v < vertices; ++v) {
    const double sum = model.is_covered[v] != 0 ? 1 : 0;
    const auto weight = model.blend_weight.row(v);
    if (!(weight.minCoeff() >= 0) || !(std::abs(weight.sum() - sum) <= 1e-12))
      throw complain("blend_weight", "row " + std::to_string(v) +
                                         " is negative or does not sum to " +
                                         std::to_string(static_cast<int>(sum)));
  }
}

void check(const Model& model, const h5::Complain& complain) {
  const Eigen::Index vertices = model.surface.vertices.rows();
  ColumnChecker all(complain);
  columns(model, all);
  check_indices(complain, "surface/triangles", model.surface.triangles, vertices);
  check_unit_length(complain, "inward_normal", model.inward_normal, true);
  check_curve_set(complain, model.curves, vertices);
  check_blend(complain, model);
  check_shape(complain, model);
}

}  // namespace

Model read_model(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kModelSchema);
  Model model;
  ColumnReader in(reader);
  columns(model, in);
  model.curves = read_curve_set(reader, model.is_covered.size());
  model.probe = read_probe(reader);
  model.shape = read_shape(reader);
  check(model, complain_about(reader));
  return model;
}

void write_model(const std::filesystem::path& path, const Model& model,
                 const Attributes& attributes) {
  check(model, h5::complain_about(path));
  h5::Writer writer = h5::create(path, kModelSchema, attributes);
  ColumnWriter out(writer);
  columns(model, out);
  write_curve_set(writer, model.curves);
  write_probe(writer, model.probe, complain_about(path));
  write_shape(writer, model.shape);
  writer.commit();
}

}  // namespace palpate
