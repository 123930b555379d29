#include <limits>
#include <nlohmann/json.hpp>

#include "libfit/assets/asset_file.hpp"
#include "libfit/core/error.hpp"
#include "libfit/fit/spline/monotone_least_squares.hpp"
#include "libfit/io/csv/tables.hpp"
#include "libfit/io/files/files.hpp"
#include "libfit/runtime/base/spline.hpp"
#include "tools/command.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

// Rows of one curve at `steps` equal abscissas up to the last knot. deviation: its error there.
template <class Control, class Deviation>
void append_curve(std::vector<CurveTableRow>& rows, std::int64_t point, const std::string& name,
                  CurveKind kind, const runtime::SplineView& spline, const Control* control,
                  int steps, Deviation deviation) {
  for (int step = 0; step <= steps; ++step) {
    const double at = spline.knots[spline.pieces] * step / steps;
    rows.push_back({point, name, kind, at, runtime::curve_value(spline, control, at),
                    runtime::curve_slope(spline, control, at), deviation(at)});
  }
}

// Curves of the points for which is_shown(kind, point) holds, with deviation(kind, point, spline,
// x). names: of the points; empty: they have none.
template <class IsShown, class Deviation>
std::vector<CurveTableRow> tabulate_set(const CurveSet& curves,
                                        const std::vector<std::string>& names, int steps,
                                        IsShown is_shown, Deviation deviation) {
  std::vector<CurveTableRow> rows;
  for (std::size_t k = 0; k < curves_of(curves.family); ++k) {
    const SplineTables tables = tabulate(curves.basis[k]);
    const runtime::SplineView spline = fit::view(tables);
    for (Eigen::Index point = 0; point < curves.points(); ++point)
      if (is_shown(k, point))
        append_curve(rows, point, names.empty() ? "" : names[point], static_cast<CurveKind>(k),
                     spline, curves.control[k].row(point).data(), steps,
                     [&](double at) { return deviation(k, point, spline, at); });
  }
  return rows;
}

constexpr auto kNoDeviation = [](auto&&...) { return std::numeric_limits<double>::quiet_NaN(); };

std::vector<CurveTableRow> tabulate_asset(const runtime::AssetView& asset, int steps) {
  std::vector<CurveTableRow> rows;
  for (int kind = 0; kind < runtime::row_of(static_cast<CurveFamily>(asset.curves.family)).curves;
       ++kind)
    for (int vertex = 0; vertex < asset.vertices; ++vertex) {
      if (asset.covered[vertex] != runtime::kMeasured) continue;
      const float* control = asset.node(vertex) + asset.control_offset[kind];
      append_curve(rows, vertex, "", static_cast<CurveKind>(kind), asset.curves.view[kind], control,
                   steps, kNoDeviation);
    }
  return rows;
}

class Tabulate final : public Command {
 public:
  explicit Tabulate(Arguments& arguments) {
    arguments.positional("file", file_, "File to read: curves.h5, model.h5 or asset.palp");
    arguments.output("-o,--output", output_,
                     "Table to write, T.csv: point,name,curve,at_m,value_N,slope_N_m",
                     {"point,name,curve,at_m"});
    arguments.flag("--band", has_band_,
                   "Add a column deviation_N, the standard error; curves.h5 alone holds it, and "
                   "curves without one are left out");
    arguments.option("--steps", steps_, "Number of intervals of a curve up to its last knot");
  }

  int run(Reply& reply) override {
    if (steps_ < 1 || steps_ > 100000)
      throw Error("--steps", "there must be 1 to 100000 steps", "Give a number in that range.");
    const std::vector<CurveTableRow> rows = read_and_tabulate();
    write_curve_rows(output_, rows);
    say("wrote {}: {} rows", output_, rows.size());
    reply.json = nlohmann::ordered_json{{"rows", rows.size()}};
    return kDone;
  }

 private:
  std::vector<CurveTableRow> read_and_tabulate() const {
    const std::string schema = is_asset_file(file_) ? "palp" : schema_of(file_);
    if (has_band_ && schema != kCurvesSchema.name)
      throw Error(file_, "holds no errors of its curves", "Give the curves.h5 it was made from.");
    if (schema == "palp") return tabulate_asset(read_asset_file(file_).asset(), steps_);
    if (schema == kCurvesSchema.name) {
      const FittedCurves fitted = read_curves(file_);
      if (!has_band_)
        return tabulate_set(
            fitted.curves, fitted.name, steps_, [](auto, auto) { return true; }, kNoDeviation);
      // Curves of which no row spoke have no standard error.
      const auto is_known = [&](std::size_t k, Eigen::Index point) {
        const Controls& covariance = fitted.covariance[k];
        return point < covariance.rows() && covariance.row(point).allFinite();
      };
      return tabulate_set(fitted.curves, fitted.name, steps_, is_known,
                          [&](std::size_t k, Eigen::Index point, const auto& spline, double at) {
                            return fit::curve_deviation(spline, fitted.covariance[k].row(point),
                                                        at);
                          });
    }
    if (schema == kModelSchema.name) {
      const Model model = read_model(file_);
      const auto is_covered = [&](std::size_t, Eigen::Index point) {
        return model.is_covered[point] != 0;
      };
      return tabulate_set(model.curves, {}, steps_, is_covered, kNoDeviation);
    }
    throw Error(file_, "holds no curves (" + schema + ")",
                "Give curves.h5, model.h5 or asset.palp.");
  }

  std::string file_, output_;
  int steps_ = 20;
  bool has_band_ = false;
};

}  // namespace

const CommandRow kTabulateCommand{"tabulate", "Write curves as a table", declared<Tabulate>,
                                  "Assets and files", "tabulate curves.h5 -o table.csv"};

}  // namespace palpate::tools
