#include "libfit/io/files/files.hpp"

#include <cmath>
#include <limits>

#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

constexpr double kWeightSumTolerance = 1e-12;

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

// Unit length, or zero at a vertex without triangle.
void check_normals(const h5::Complain& complain, const Points& normals) {
  for (Eigen::Index v = 0; v < normals.rows(); ++v)
    if (const double length = normals.row(v).norm(); !(std::abs(length - 1) < 1e-6 || length == 0))
      throw complain("inward_normal", "row " + std::to_string(v) + " is not a unit vector");
}

void check_blend(const h5::Complain& complain, const Model& model) {
  const Eigen::Index vertices = model.surface.vertices.rows();
  check_indices(complain, "blend_point", model.blend_point.data(), vertices, 3,
                std::numeric_limits<std::int32_t>::max());
  for (Eigen::Index v = 0; v < vertices; ++v) {
    const double sum = model.is_covered[static_cast<std::size_t>(v)] != 0 ? 1 : 0;
    const auto weight = model.blend_weight.row(v);
    if (!(weight.minCoeff() >= 0) || !(std::abs(weight.sum() - sum) <= kWeightSumTolerance))
      throw complain("blend_weight", "row " + std::to_string(v) +
                                         " is negative or does not sum to " +
                                         std::to_string(static_cast<int>(sum)));
  }
}

void check(const Model& model, const h5::Complain& complain) {
  const Eigen::Index vertices = model.surface.vertices.rows();
  RowChecker rows(complain);
  columns(model, rows);
  check_finite(complain, "surface/vertices", model.surface.vertices);
  check_indices(complain, "surface/triangles", model.surface.triangles.data(),
                model.surface.triangles.rows(), 3, vertices);
  check_normals(complain, model.inward_normal);
  check_flags(complain, "is_covered", model.is_covered);
  check_curve_set(complain, model.curves, vertices);
  check_blend(complain, model);
}

}  // namespace

Model read_model(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kModelSchema);
  Model model;
  ColumnReader in(reader);
  columns(model, in);
  model.curves = read_curve_set(reader, model.is_covered.size());
  model.probe = read_probe(reader);
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
  writer.commit();
}

}  // namespace palpate
