#include <fmt/core.h>

#include "tools/report/figure_parts.hpp"

namespace palpate::tools {
namespace {

constexpr const char* kSample = "fill=\"white\" stroke=\"black\" stroke-width=\"0.8\"";
constexpr const char* kUnsolved = "fill=\"none\" stroke=\"#999999\"";
constexpr const char* kCurve = "stroke=\"#0072b2\" stroke-width=\"1.3\"";
constexpr const char* kBand = "fill=\"#56b4e9\" fill-opacity=\"0.45\"";
constexpr const char* kAnswer =
    "stroke=\"#d55e00\" stroke-width=\"0.9\" stroke-dasharray=\"4 1.5\"";
constexpr const char* kKnot = "stroke=\"#0072b2\" stroke-width=\"1.2\"";
constexpr const char* kKnotMarker = "M0 0v-5";

/// Rows of one experiment.
struct DrawnExperiment {
  bool is_press;
  std::vector<Eigen::Index> rows;
};

std::vector<std::vector<DrawnExperiment>> experiments_of(const Json& contents, std::size_t points) {
  const auto point = unpacked<std::int32_t>(contents["rows"]["point"]);
  const auto number = unpacked<std::int32_t>(contents["rows"]["experiment"]);
  const auto kind = unpacked<std::uint8_t>(contents["rows"]["kind"]);
  std::vector<std::vector<DrawnExperiment>> out(points);
  for (std::size_t row = 0; row < point.size(); ++row) {
    if (point[row] < 0) continue;
    auto& own = out[static_cast<std::size_t>(point[row])];
    if (own.empty() || row == 0 || number[row] != number[row - 1])
      own.push_back({kind[row] == 0, {}});
    own.back().rows.push_back(static_cast<Eigen::Index>(row));
  }
  return out;
}

struct PlottedSeries {
  Numbers x, y;  ///< [mm], [N] until they are drawn
  void add(double at, double value) {
    x.push_back(at);
    y.push_back(value);
  }
};

class CurvesFigure {
 public:
  explicit CurvesFigure(const Json& contents)
      : contents_(contents),
        name_(contents["points"]["name"].get<std::vector<std::string>>()),
        value_(numbers(contents["points"]["curves"][0]["value_N"])),
        deviation_(numbers(contents["points"]["curves"][0]["deviation_N"])),
        knots_(contents["points"]["curves"][0]["knots_m"].get<Numbers>()),
        steps_(value_.size() / name_.size()),
        normal_(rows(contents["points"]["inward_normal"])),
        deflection_(rows(contents["rows"]["deflection_m"])),
        force_(rows(contents["rows"]["force_N"])),
        fitted_(rows(contents["rows"]["fitted_N"])),
        status_(unpacked<std::uint8_t>(contents["rows"]["status"])),
        experiments_(experiments_of(contents, name_.size())) {}

  std::string svg() const {
    const auto chosen = choose();
    const double step = 140;
    Svg svg(
        kWidth_pt, step * static_cast<double>(chosen.size()) + 40,
        "Force over deflection at three test points of " + contents_["name"].get<std::string>());
    double y = 20;
    for (const auto& [point, words] : chosen) {
      press(svg, point, y, name_[point] + ": " + words);
      drags(svg, point, y);
      y += step;
    }
    double x = 40;
    svg.legend(x, y, kMarkers[0], kSample, "reference row");
    svg.legend(x, y, "M-7 0h14", kAnswer, "the law's answer to it");
    svg.legend(x, y, "M-7 0h14", kCurve, "normal curve");
    if (!deviation_.empty()) svg.legend(x, y, "M-7-3h14v6h-14z", kBand, "its 90 % band");
    svg.legend(x, y, "M0 2.8v-6", kKnot, "its knot");
    return svg.str();
  }

 private:
  // Softest, middle and stiffest of the points that were dragged, if enough were.
  std::vector<std::pair<std::size_t, std::string>> choose() const {
    std::vector<std::size_t> order, dragged;
    for (std::size_t p = 0; p < name_.size(); ++p) {
      const auto& own = experiments_[p];
      if (contents_["points"]["status"][p] == "failed" || own.empty()) continue;
      order.push_back(p);
      if (std::any_of(own.begin(), own.end(), [](const DrawnExperiment& e) { return !e.is_press; }))
        dragged.push_back(p);
    }
    if (dragged.size() >= 3) order = dragged;
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return value_[a * steps_ + steps_ - 1] < value_[b * steps_ + steps_ - 1];
    });
    if (order.size() < 3) {
      std::vector<std::pair<std::size_t, std::string>> few;
      for (const std::size_t p : order) few.emplace_back(p, "test point");
      return few;
    }
    return {{order.front(), "softest"},
            {order[order.size() / 2], "middle of all"},
            {order.back(), "stiffest"}};
  }

  /// A panel: rows, the curve with its band if there is one, the law's answers to the rows.
  struct Panel {
    double left, top;
    std::string title, xlabel, what;
    PlottedSeries curve, samples, unsolved;
    std::vector<PlottedSeries> answers;
    Numbers band_N;
    Numbers knots_mm;
  };

  static void draw(Svg& svg, Panel panel) {
    std::vector<PlottedSeries*> all{&panel.curve, &panel.samples, &panel.unsolved};
    for (PlottedSeries& answer : panel.answers) all.push_back(&answer);
    double reach = 0, highest = 0, lowest = 0;
    for (const PlottedSeries* one : all) {
      reach = std::max(reach, most(one->x));
      highest = std::max(highest, most(one->y));
      for (const double y : one->y) lowest = std::min(lowest, std::isfinite(y) ? y : 0);
    }
    const ForceUnit unit(highest);
    for (PlottedSeries* one : all)
      for (double& y : one->y) y *= unit.factor;
    const double margin = 0.05 * (highest - lowest) * unit.factor;
    Plot plot(svg, panel.left, panel.top, panel.left + 185, panel.top + 92,
              {panel.xlabel, 0, 1.03 * reach},
              {fmt::format("{} [{}]", panel.what, unit.name),
               lowest * unit.factor - (lowest < 0 ? margin : 0), highest * unit.factor + margin},
              panel.title);
    if (!panel.band_N.empty()) {
      Numbers low = panel.curve.y, high = panel.curve.y;
      for (std::size_t i = 0; i < low.size(); ++i) {
        low[i] = std::max(0.0, low[i] - panel.band_N[i] * unit.factor);
        high[i] = std::min(highest * unit.factor + margin, high[i] + panel.band_N[i] * unit.factor);
      }
      plot.band(panel.curve.x, low, high, kBand);
    }
    plot.line(panel.curve.x, panel.curve.y, kCurve);
    for (const PlottedSeries& answer : panel.answers) plot.line(answer.x, answer.y, kAnswer);
    plot.marks("knots", panel.knots_mm, Numbers(panel.knots_mm.size(), 0), kKnotMarker, kKnot);
    plot.marks("samples", panel.samples.x, panel.samples.y, kMarkers[0], kSample);
    plot.marks("unsolved", panel.unsolved.x, panel.unsolved.y, kMarkers[4], kUnsolved);
  }

  void press(Svg& svg, std::size_t point, double top, const std::string& title) const {
    const Eigen::RowVector3d u = normal_.row(static_cast<Eigen::Index>(point));
    Panel panel{42, top, title, "depth [mm]", "normal force", {}, {}, {}, {}, {}, {}};
    for (std::size_t i = 0; i < steps_; ++i) {
      panel.curve.x.push_back(knots_.back() * 1e3 * static_cast<double>(i) /
                              static_cast<double>(steps_ - 1));
      panel.curve.y.push_back(value_[point * steps_ + i]);
      if (!deviation_.empty())
        panel.band_N.push_back(deviation_[point * steps_ + i] *
                               contents_["band_deviations"].get<double>());
    }
    for (const double knot : knots_) panel.knots_mm.push_back(knot * 1e3);
    for (const DrawnExperiment& drawn : experiments_[point])
      if (drawn.is_press) add(panel, drawn, Eigen::RowVector3d::Zero(), u);
    for (PlottedSeries& answer : panel.answers) {  // before it touches
      answer.x.insert(answer.x.begin(), 0);
      answer.y.insert(answer.y.begin(), 0);
    }
    draw(svg, std::move(panel));
  }

  void drags(Svg& svg, std::size_t point, double top) const {
    const Eigen::RowVector3d u = normal_.row(static_cast<Eigen::Index>(point));
    Panel panel{290, top, "dragged", "way [mm]", "lateral force", {}, {}, {}, {}, {}, {}};
    for (const DrawnExperiment& drawn : experiments_[point]) {
      if (drawn.is_press || drawn.rows.size() < 2) continue;
      const Eigen::RowVector3d first = deflection_.row(drawn.rows.front());
      const Eigen::RowVector3d way = deflection_.row(drawn.rows.back()) - first;
      add(panel, drawn, first, (way - way.dot(u) * u).normalized());
    }
    if (!panel.samples.x.empty()) draw(svg, std::move(panel));
  }

  // Rows by their way from a place and their force, both along a direction.
  void add(Panel& panel, const DrawnExperiment& drawn, const Eigen::RowVector3d& from,
           const Eigen::RowVector3d& along) const {
    PlottedSeries& answer = panel.answers.emplace_back();
    for (const Eigen::Index row : drawn.rows) {
      const double way_mm = (deflection_.row(row) - from).dot(along) * 1e3;
      const bool is_good = status_[static_cast<std::size_t>(row)] == 0;
      (is_good ? panel.samples : panel.unsolved).add(way_mm, force_.row(row).dot(along));
      answer.add(way_mm, fitted_.row(row).dot(along));
    }
  }

  const Json& contents_;
  std::vector<std::string> name_;
  Numbers value_, deviation_, knots_;
  std::size_t steps_;
  Rows normal_, deflection_, force_, fitted_;
  std::vector<std::uint8_t> status_;
  std::vector<std::vector<DrawnExperiment>> experiments_;
};

}  // namespace

std::string curves_svg(const Json& contents) { return CurvesFigure(contents).svg(); }

}  // namespace palpate::tools
