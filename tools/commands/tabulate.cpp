#include <cmath>
#include <limits>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/fit/spline/curve_band.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"
#include "libfit/io/csv/tables.hpp"
#include "libfit/io/files/curves_file.hpp"
#include "libfit/io/files/describe.hpp"
#include "libfit/io/files/model_file.hpp"
#include "libfit/runtime/spline.hpp"
#include "tools/command.hpp"
#include "tools/commands/inspect_asset.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

// Rows of one curve at `steps` equal abscissas up to the last knot. deviation: its error there.
template <class Control, class Deviation>
void append_curve(std::vector<CurveRow>& rows, std::int64_t point, CurveKind kind,
                  const runtime::SplineView& spline, const Control* control, int steps,
                  Deviation deviation) {
  for (int step = 0; step <= steps; ++step) {
    const double at = spline.knots[spline.pieces] * step / steps;
    rows.push_back({point, kind, at, runtime::curve_value(spline, control, at),
                    runtime::curve_slope(spline, control, at), deviation(at)});
  }
}

// Without a known error.
double unknown_deviation(double) { return std::numeric_limits<double>::quiet_NaN(); }

std::vector<CurveRow> tabulate_set(const CurveSet& curves, const std::vector<char>* is_covered,
                                   int steps) {
  std::vector<CurveRow> rows;
  for (int kind = 0; kind < static_cast<int>(curves_of(curves.family)); ++kind) {
    const auto k = static_cast<std::size_t>(kind);
    const SplineTables tables = tabulate(curves.basis[k]);
    const runtime::SplineView spline{tables.degree, tables.pieces, tables.knots.data(),
                                     tables.weights.data(), tables.integrals.data()};
    for (Eigen::Index point = 0; point < curves.points(); ++point) {
      if (is_covered && !(*is_covered)[static_cast<std::size_t>(point)]) continue;
      append_curve(rows, point, static_cast<CurveKind>(kind), spline,
                   curves.control[k].row(point).data(), steps, unknown_deviation);
    }
  }
  return rows;
}

std::vector<CurveRow> tabulate_asset(const runtime::AssetView& asset, int steps) {
  std::vector<CurveRow> rows;
  for (int kind = 0; kind < runtime::row_of(static_cast<CurveFamily>(asset.curves.family)).curves;
       ++kind)
    for (int vertex = 0; vertex < asset.vertices; ++vertex) {
      if (!asset.covered[vertex]) continue;
      const float* control = asset.control + std::ptrdiff_t{vertex} * asset.controls_per_vertex +
                             asset.control_offset[kind];
      append_curve(rows, vertex, static_cast<CurveKind>(kind), asset.curves.view[kind], control,
                   steps, unknown_deviation);
    }
  return rows;
}

// Curves with a standard error; those that no row spoke of are left out.
std::vector<CurveRow> tabulate_bands(const FittedCurves& fitted, int steps) {
  std::vector<CurveRow> rows;
  for (std::size_t k = 0; k < curves_of(fitted.curves.family); ++k) {
    const SplineTables tables = tabulate(fitted.curves.basis[k]);
    const runtime::SplineView spline = fit::view(tables);
    for (Eigen::Index point = 0; point < fitted.covariance[k].rows(); ++point) {
      const Eigen::VectorXd covariance = fitted.covariance[k].row(point);
      if (!covariance.allFinite()) continue;
      append_curve(rows, point, static_cast<CurveKind>(k), spline,
                   fitted.curves.control[k].row(point).data(), steps,
                   [&](double at) { return fit::curve_deviation(spline, covariance, at); });
    }
  }
  return rows;
}

class Tabulate final : public Command {
 public:
  explicit Tabulate(Arguments& arguments) {
    arguments.positional("file", file_, "File to read: curves.h5, model.h5 or asset.palp");
    arguments.output("-o,--output", output_,
                     "Table to write, T.csv: point,curve,at_m,value_N,slope_N_m",
                     {"point,curve,at_m"});
    arguments.flag(
        "--band", has_band_,
        "Add a column deviation_N, the standard error; curves.h5 alone holds it, and curves "
        "without one are left out");
    arguments.option("--steps", steps_, "Number of intervals of a curve up to its last knot");
  }

  int run() override {
    if (steps_ < 1 || steps_ > 100000)
      throw Error("--steps", "there must be 1 to 100000 steps", "Give a number in that range.");
    const std::vector<CurveRow> rows = read_and_tabulate();
    write_curve_rows(output_, rows);
    say("wrote {}: {} rows", output_, rows.size());
    return kDone;
  }

 private:
  std::vector<CurveRow> read_and_tabulate() const {
    if (is_asset_file(file_)) {
      if (has_band_)
        throw Error(file_, "holds no errors of its curves", "Give the curves.h5 it was made from.");
      const AssetFile asset = read_asset_file(file_);
      return tabulate_asset(asset.asset(), steps_);
    }
    const std::string schema = schema_of(file_);
    if (has_band_ && schema != kCurvesSchema.name)
      throw Error(file_, "holds no errors of its curves", "Give the curves.h5 it was made from.");
    if (has_band_) return tabulate_bands(read_curves(file_), steps_);
    if (schema == kCurvesSchema.name)
      return tabulate_set(read_curves(file_).curves, nullptr, steps_);
    if (schema == kModelSchema.name) {
      const Model model = read_model(file_);
      return tabulate_set(model.curves, &model.is_covered, steps_);
    }
    throw Error(file_, "holds no curves (" + schema + ")",
                "Give curves.h5, model.h5 or asset.palp.");
  }

  std::string file_, output_;
  int steps_ = 20;
  bool has_band_ = false;
};

}  // namespace

std::unique_ptr<Command> declare_tabulate(Arguments& arguments) {
  return std::make_unique<Tabulate>(arguments);
}

}  // namespace palpate::tools
