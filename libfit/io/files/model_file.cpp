#include "libfit/io/files/files.hpp"

#include <cmath>
#include <limits>

#include "libfit/io/files/columns.hpp"

namespace palpate {

using namespace h5;

namespace {

constexpr double kWeightSumTolerance = 1e-12;

// Unit length, or zero at a vertex without triangle.
void check_normals(const h5::Complain& complain, const Points& normals) {
  for (Eigen::Index v = 0; v < normals.rows(); ++v)
    if (const double length = normals.row(v).norm(); !(std::abs(length - 1) < 1e-6 || length == 0))
      throw complain("inward_normal", "row " + std::to_string(v) + " is not a unit vector");
}

void check_blend(const h5::Complain& complain, const Model& model) {
  const Eigen::Index vertices = model.surface.vertices.rows();
  check_rows(complain, "blend_point", model.blend_point.rows(), vertices);
  check_rows(complain, "blend_weight", model.blend_weight.rows(), vertices);
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
  check_finite(complain, "surface/vertices", model.surface.vertices);
  check_indices(complain, "surface/triangles", model.surface.triangles.data(),
                model.surface.triangles.rows(), 3, vertices);
  check_rows(complain, "inward_normal", model.inward_normal.rows(), vertices);
  check_normals(complain, model.inward_normal);
  check_flags(complain, "is_covered", model.is_covered, vertices);
  check_curve_set(complain, model.curves, vertices);
  check_blend(complain, model);
}

}  // namespace

Model read_model(const std::filesystem::path& path) {
  const h5::Reader reader = h5::open(path, kModelSchema);
  Model model;
  model.surface.vertices = read_points(reader, "surface/vertices", "m", h5::kAny);
  model.surface.triangles = read_triangles(reader, "surface/triangles", h5::kAny);
  const auto vertices = static_cast<std::size_t>(model.surface.vertices.rows());
  model.inward_normal = read_points(reader, "inward_normal", h5::kNoUnit, vertices);
  model.curves = read_curve_set(reader, vertices);
  model.is_covered = read_flags(reader, "is_covered", vertices);
  model.blend_point = read_triangles(reader, "blend_point", vertices);
  model.blend_weight = read_points(reader, "blend_weight", h5::kNoUnit, vertices);
  model.probe = read_probe(reader);
  check(model, complain_about(reader));
  return model;
}

void write_model(const std::filesystem::path& path, const Model& model,
                 const Attributes& attributes) {
  check(model, h5::complain_about(path));
  h5::Writer writer = h5::create(path, kModelSchema, attributes);
  write_points(writer, "surface/vertices", "m", model.surface.vertices);
  write_triangles(writer, "surface/triangles", model.surface.triangles);
  write_points(writer, "inward_normal", h5::kNoUnit, model.inward_normal);
  write_curve_set(writer, model.curves);
  write_flags(writer, "is_covered", model.is_covered);
  write_triangles(writer, "blend_point", model.blend_point);
  write_points(writer, "blend_weight", h5::kNoUnit, model.blend_weight);
  write_probe(writer, model.probe, complain_about(path));
  writer.commit();
}

}  // namespace palpate
