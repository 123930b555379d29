#include "tools/report/moduli_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "tools/report/page.hpp"
#include "tools/report/svg_plot.hpp"

namespace palpate::tools {
namespace {

constexpr int kWidth = 380, kHeight = 275;  // of a plot [pt]
constexpr double kLeastSpan = 1.1;          // of the map's colours, stiffest over softest
constexpr Eigen::Index kShown = 300;        // readings of a plot
constexpr std::array<const char*, 4> kGrades{"refused", "poor", "fair", "good"};
constexpr std::array<const char*, 4> kColours{"#b00020", "#d9480f", "#b08900", "#2b8a3e"};

std::size_t rank(const ModulusPicture& p) {
  const auto at = std::ranges::find(kGrades, p.grade);
  return static_cast<std::size_t>(std::min(at - kGrades.begin(), std::ptrdiff_t{3}));
}

constexpr std::array kPrefixes{"f", "p", "n", "µ", "m", "", "k", "M", "G", "T"};

// Powers of a thousand of the prefix that suits a value.
int prefix_of(double value) {
  if (!(std::abs(value) > 0)) return 0;
  return std::clamp(static_cast<int>(std::floor(std::log10(std::abs(value)) / 3)), -5, 4);
}

// A number with a prefix, such as "1.2 kPa".
std::string prefixed(double value, const char* unit) {
  if (!std::isfinite(value)) return "unknown";
  const int k = prefix_of(value);
  return fmt::format("{:.4g} {}{}", value / std::pow(1e3, k),
                     kPrefixes[static_cast<std::size_t>(k + 5)], unit);
}

// "nN" and 1e9 for values about nanonewtons.
struct Scale {
  std::string unit;
  double factor = 1;
};
Scale scale_of(double largest, const char* unit) {
  const int k = prefix_of(largest);
  return {kPrefixes[static_cast<std::size_t>(k + 5)] + std::string(unit), std::pow(1e3, -k)};
}

// Readings, contact point and model above; what the model leaves below. Of long free travel twice
// the press is shown.
std::string plot(const ModulusPicture& p) {
  const Eigen::Index n = p.travel_m.size();
  const double last_m = p.travel_m.maxCoeff(),
               from_m = p.model.empty() ? p.travel_m.minCoeff()
                                        : p.contact_m - 2 * (last_m - p.contact_m);
  const Eigen::Index shown = (p.travel_m.array() >= from_m).count(),
                     stride = std::max<Eigen::Index>(1, shown / kShown);
  const Scale x = scale_of(p.travel_m.cwiseAbs().maxCoeff(), "m"),
              y = scale_of(p.push_N.cwiseAbs().maxCoeff(), "N");
  std::vector<double> travel, push, at, fitted, left;
  for (Eigen::Index i = 0; i < n; i += stride) {
    if (p.travel_m[i] < from_m) continue;
    travel.push_back(p.travel_m[i] * x.factor), push.push_back(p.push_N[i] * y.factor);
    if (p.fitted_N.size() != n || !std::isfinite(p.fitted_N[i])) continue;
    at.push_back(travel.back()), fitted.push_back(p.fitted_N[i] * y.factor);
    left.push_back(push.back() - fitted.back());
  }
  const auto range = [](const std::vector<double>& v, std::string label, bool has_ticks = true) {
    const auto [low, high] = std::ranges::minmax(v);
    const double margin = std::max(0.02 * (high - low), 1e-12);
    return Axis{std::move(label), low - margin, high + margin, has_ticks};
  };
  Svg svg(kWidth, kHeight, p.name);
  const Axis across = range(travel, "", false), up = range(push, "force, " + y.unit);
  Plot press(svg, 52, 8, kWidth - 8, 180, across, up);
  if (!at.empty()) {
    const double c = p.contact_m * x.factor;
    const double half =
        std::max(p.contact_deviation_m * x.factor, 2e-3 * (across.high - across.low));
    press.band({std::max(across.low, c - half), std::min(across.high, c + half)}, {up.low, up.low},
               {up.high, up.high}, "fill=\"#56b4e9\" fill-opacity=\"0.4\"");
  }
  press.marks("readings", travel, push, kMarkers[0], "fill=\"#888888\" stroke=\"none\"");
  if (!at.empty()) {
    press.line(at, fitted, "stroke=\"#d55e00\" stroke-width=\"1.5\"");
    Plot rest(svg, 52, 188, kWidth - 8, 240, range(travel, "travel, " + x.unit),
              range(left, "left"));
    rest.marks("residuals", at, left, kMarkers[0], "fill=\"#888888\" stroke=\"none\"");
  }
  return svg.str();
}

// A colour between blue and yellow for 0 to 1.
std::string colour(double t) {
  return fmt::format("rgb({:.0f},{:.0f},{:.0f})", 40 + 210 * t, 60 + 150 * t, 160 - 120 * t);
}

// Moduli where the points are, on a logarithmic scale of colours; nothing below two places.
std::string map(const std::vector<ModulusPicture>& pictures) {
  std::vector<const ModulusPicture*> placed;
  for (const auto& p : pictures)
    if (p.position_m && p.young_Pa > 0) placed.push_back(&p);
  if (placed.size() < 2) return "";
  Vec3 low = *placed[0]->position_m, high = low;
  double soft = placed[0]->young_Pa, stiff = soft;
  for (const auto* p : placed) {
    low = low.cwiseMin(*p->position_m), high = high.cwiseMax(*p->position_m);
    soft = std::min(soft, p->young_Pa), stiff = std::max(stiff, p->young_Pa);
  }
  stiff = std::max(stiff, kLeastSpan * soft);
  Eigen::Index across = 2;
  (high - low).minCoeff(&across);
  const Eigen::Index u = across == 0 ? 1 : 0, v = across == 2 ? 1 : 2;
  const double size = std::max({high[u] - low[u], high[v] - low[v], 1e-30});
  if (!(size > 1e-12)) return "";
  const double radius = std::clamp(180 / std::sqrt(static_cast<double>(placed.size())), 3., 24.);
  std::string svg = "<h2>Map</h2><svg viewBox='0 0 520 480' width='520' font-size='11'>";
  for (const auto* p : placed) {
    const double t = std::log(p->young_Pa / soft) / std::log(stiff / soft);
    svg += fmt::format(
        "<circle cx='{:.1f}' cy='{:.1f}' r='{:.1f}' fill='{}' stroke='{}'><title>{}: {} ± {}, "
        "{}</title></circle>",
        30 + 400 * ((*p->position_m)[u] - low[u]) / size,
        440 - 400 * ((*p->position_m)[v] - low[v]) / size, radius, colour(t), kColours[rank(*p)],
        escaped(p->point), prefixed(p->young_Pa, "Pa"), prefixed(p->young_deviation_Pa, "Pa"),
        p->grade);
  }
  for (int k = 0; k <= 10; ++k)
    svg += fmt::format("<rect x='470' y='{}' width='14' height='31' fill='{}'/>", 340 - 30 * k,
                       colour(k / 10.));
  return svg + fmt::format(
                   "<text x='515' y='385' text-anchor='end' fill='currentColor'>{}</text>"
                   "<text x='515' y='34' text-anchor='end' fill='currentColor'>{}</text>"
                   "</svg><p>{} wide; rings show grades.</p>",
                   prefixed(soft, "Pa"), prefixed(stiff, "Pa"), prefixed(size, "m"));
}

}  // namespace

std::string moduli_page(const std::string& title, std::vector<ModulusPicture> pictures) {
  std::string page = std::string(kPageKind) +
                     "<meta charset='utf-8'><meta name='viewport' content='width=device-width'>"
                     "<title>" +
                     escaped(title) +
                     "</title><style>body{font:14px sans-serif;margin:"
                     "1em;color-scheme:light dark}section{display:inline-block;vertical-align:top;"
                     "width:520px;margin:6px}b{font-weight:600}p{margin:2px 0}</style><h1>" +
                     escaped(title) + "</h1>";
  std::array<std::size_t, 4> count{};
  for (const auto& p : pictures) ++count[rank(p)];
  page += fmt::format(
      "<p>{} recordings: {} good, {} fair, {} poor, {} refused. Grey: readings; "
      "orange: the model; blue: contact ± its standard deviation; below: what the "
      "model leaves.</p>",
      pictures.size(), count[3], count[2], count[1], count[0]);
  page += map(pictures);
  std::ranges::stable_sort(pictures, {}, rank);
  page += "<h2>Recordings</h2>";
  for (const auto& p : pictures) {
    page += fmt::format("<section><p><b>{}</b> {} <span style='color:{}'>{}</span></p>",
                        escaped(p.name),
                        p.name.find(p.point) == std::string::npos ? escaped(p.point) : "",
                        kColours[rank(p)], p.grade);
    if (!p.model.empty())
      page += fmt::format("<p>{}: E = {} ± {}; contact {} ± {}</p>", p.model,
                          prefixed(p.young_Pa, "Pa"), prefixed(p.young_deviation_Pa, "Pa"),
                          prefixed(p.contact_m, "m"), prefixed(p.contact_deviation_m, "m"));
    if (p.travel_m.size() > 1) page += plot(p);
    for (const std::string& reason : p.reasons) page += "<p>" + escaped(reason) + "</p>";
    page += "</section>\n";
  }
  return page;
}

}  // namespace palpate::tools
