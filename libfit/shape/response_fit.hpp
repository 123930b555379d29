#pragma once

#include <optional>
#include <vector>

#include "libfit/shape/identify_shape.hpp"

namespace palpate {

/// The least squares fits that a shape response is made of (docs/method-body.md, section 20): the
/// dent of each test point, how the surface follows a drag, and modes of the whole body. Keeps
/// references to what it is given; arguments as identify_shape().
class ResponseFit {
 public:
  ResponseFit(const runtime::AssetView& asset, const Samples& samples, const Triangles& blend_point,
              const Points& blend_weight, const ShapeOptions& options);

  /// The response of rows for which `counts` is set (empty: all), with so many modes at most.
  ShapeResponse of(const std::vector<char>& counts, int modes);

  /// The engine's contact at each row of the samples; see contact_states().
  const std::vector<std::optional<runtime::Contact>>& contacts() const { return contacts_; }
  /// Whether a row touches where measured curves answer alone.
  bool is_measured(std::size_t row) const;
  /// Rows that the latest response was found from.
  std::size_t rows() const { return rows_.size(); }

 private:
  /// A row that the response is found from.
  struct Row {
    Eigen::Index row;
    bool is_press;
    const runtime::Contact* contact;
    runtime::DentState state;
  };

  void take_rows(const std::vector<char>& counts);
  void fit_presses();
  void fit_drags();
  void find_modes(int modes);
  void fit_amplitudes();
  runtime::Vec3d residual_of(const runtime::Deformation& shown, const Row& row, int v) const;
  Eigen::VectorXf residual_of(const runtime::AssetView& shown, const Row& row) const;
  template <class Use>
  void each_near(const runtime::DentState& state, const Use& use) const;

  const runtime::AssetView& asset_;
  const Samples& samples_;
  const Triangles& blend_point_;
  const Points& blend_weight_;
  const double mode_scale_;  // of a mode's entries, so that they are about 1
  std::vector<std::optional<runtime::Contact>> contacts_;
  std::vector<Row> rows_;
  Eigen::MatrixXf modes_;  // 3V x modes, orthonormal
  ShapeResponse shape_;
};

}  // namespace palpate
