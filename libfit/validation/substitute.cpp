#include "libfit/validation/substitute.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace palpate::validation {
namespace {

// One vertex's controls as an asset holds them, part by part.
std::vector<float> row_of(const CurveSet& curves, Eigen::Index row) {
  std::vector<float> values;
  const auto append = [&](const Controls& control) {
    for (Eigen::Index j = 0; j < control.cols(); ++j)
      values.push_back(static_cast<float>(control(row, j)));
  };
  for (const Controls& control : curves.control) append(control);
  return values;
}

std::vector<float> controls_of(const runtime::AssetView& asset) {
  return {asset.control,
          asset.control + std::size_t(asset.records) * std::size_t(asset.controls_per_vertex)};
}

// Faded vertices at a border are all zero and vertices without test points answer with the mean:
// they stay so.
bool answers(const runtime::AssetView& asset, int vertex) {
  const float* first = asset.node(vertex);
  return asset.covered[vertex] == runtime::kMeasured &&
         std::any_of(first, first + asset.controls_per_vertex,
                     [](float value) { return value != 0; });
}

}  // namespace

CurveBasis basis_of(const runtime::AssetView& asset, int part) {
  const runtime::SplineView& view = asset.curves.view[part];
  if (view.pieces == 0) return {2, {}};
  return {view.degree, {view.knots, view.knots + view.pieces + 1}};
}

SubstitutedAsset SubstitutedAsset::with_one_response(const runtime::AssetView& asset,
                                                     const CurveSet& curves, Eigen::Index row) {
  SubstitutedAsset out(asset);
  const std::vector<float> values = row_of(curves, row);
  out.bases_ = std::unique_ptr<fit::Bases>(new fit::Bases(fit::bases_of(curves)));
  out.view_.curves = out.bases_->views;
  out.view_.controls_per_vertex = static_cast<int>(values.size());
  int offset = 0;
  for (std::size_t part = 0; part < curves.control.size(); ++part) {
    out.view_.control_offset[part] = offset;
    offset += static_cast<int>(curves.control[part].cols());
  }
  out.control_ = values;
  out.record_.assign(asset.vertices, 0);
  out.covered_.assign(asset.vertices, 1);
  out.view_.control = out.control_.data();
  out.view_.record = out.record_.data();
  out.view_.records = 1;
  out.view_.covered = out.covered_.data();
  return out;
}

SubstitutedAsset SubstitutedAsset::with_mean_response(const runtime::AssetView& asset) {
  SubstitutedAsset out(asset);
  const auto stride = static_cast<std::size_t>(asset.controls_per_vertex);
  std::vector<double> sum(stride, 0.0);
  double count = 0;
  for (int v = 0; v < asset.vertices; ++v) {
    if (!answers(asset, v)) continue;
    ++count;
    for (std::size_t j = 0; j < stride; ++j) sum[j] += asset.node(v)[j];
  }
  out.control_ = controls_of(asset);
  for (int v = 0; v < asset.vertices; ++v)
    for (std::size_t j = 0; j < stride && answers(asset, v); ++j)
      out.control_[std::size_t(asset.record[v]) * stride + j] = static_cast<float>(sum[j] / count);
  out.view_.control = out.control_.data();
  return out;
}

SubstitutedAsset SubstitutedAsset::with_nearest_point(const runtime::AssetView& asset,
                                                      const CurveSet& curves, const Model& model) {
  SubstitutedAsset out(asset);
  out.control_ = controls_of(asset);
  const auto stride = static_cast<std::size_t>(asset.controls_per_vertex);
  for (int v = 0; v < asset.vertices; ++v) {
    if (!answers(asset, v)) continue;
    Eigen::Index strongest = 0;
    model.blend_weight.row(v).maxCoeff(&strongest);
    const std::vector<float> values = row_of(curves, model.blend_point(v, strongest));
    std::copy(
        values.begin(), values.end(),
        out.control_.begin() + static_cast<std::ptrdiff_t>(std::size_t(asset.record[v]) * stride));
  }
  out.view_.control = out.control_.data();
  return out;
}

SubstitutedAsset SubstitutedAsset::linear(const runtime::AssetView& asset, double at_m) {
  SubstitutedAsset out(asset);
  out.control_ = controls_of(asset);
  const auto stride = static_cast<std::size_t>(asset.controls_per_vertex);
  const auto parts = parts_of(static_cast<CurveFamily>(asset.curves.family));
  for (std::size_t part = 0; part < parts.size(); ++part) {
    const CurveBasis basis = basis_of(asset, static_cast<int>(part));
    if (basis.knots_m.empty()) continue;
    for (int r = 0; r < asset.records; ++r) {
      float* control = out.control_.data() + std::size_t(r) * stride + asset.control_offset[part];
      const std::vector<double> values(control, control + basis.size());
      const double slope =
          runtime::curve_value(asset.curves.view[part], values.data(), at_m) / at_m;
      for (int j = 0; j < basis.size(); ++j)
        control[j] = static_cast<float>(slope * greville_m(basis, j));
    }
  }
  out.view_.control = out.control_.data();
  return out;
}

SubstitutedAsset SubstitutedAsset::nudged(const runtime::AssetView& asset, std::uint64_t seed) {
  SubstitutedAsset out(asset);
  std::mt19937_64 random(seed);
  const auto nudge = [&](std::vector<float>& values) {
    for (float& value : values)
      if (value != 0)
        value =
            std::nextafter(value, (random() & 1) != 0 ? std::numeric_limits<float>::infinity()
                                                      : -std::numeric_limits<float>::infinity());
  };
  const auto coordinates = 3 * std::size_t(asset.vertices);
  out.vertex_.assign(asset.vertex, asset.vertex + coordinates);
  out.normal_.assign(asset.normal, asset.normal + coordinates);
  out.control_ = controls_of(asset);
  for (auto* values : {&out.vertex_, &out.normal_, &out.control_}) nudge(*values);
  out.view_.vertex = out.vertex_.data();
  out.view_.normal = out.normal_.data();
  out.view_.control = out.control_.data();
  return out;
}

}  // namespace palpate::validation
