#include "tools/report/moduli_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "libfit/core/text.hpp"
#include "tools/report/page.hpp"

namespace palpate::tools {
namespace {

constexpr int kWidth = 380, kHeight = 200, kLeft = 60, kRest = 50;  // of a plot; of what is left
constexpr Eigen::Index kShown = 300;                                // readings of a plot
constexpr std::array<const char*, 4> kGrades{"refused", "poor", "fair", "good"};
constexpr std::array<const char*, 4> kColours{"#b00020", "#d9480f", "#b08900", "#2b8a3e"};

std::size_t rank(const ModulusPicture& p) {
  const auto at = std::ranges::find(kGrades, p.grade);
  return static_cast<std::size_t>(std::min(at - kGrades.begin(), std::ptrdiff_t{3}));
}

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

// A number with a prefix, such as "1.2 k" for kilo.
std::string prefixed(double value, const char* unit) {
  if (!std::isfinite(value)) return "unknown";
  if (value == 0) return fmt::format("0 {}", unit);
  static constexpr std::array kPrefixes{"f", "p", "n", "µ", "m", "", "k", "M", "G", "T"};
  const int k = std::clamp(static_cast<int>(std::floor(std::log10(std::abs(value)) / 3)), -5, 4);
  return fmt::format("{:.4g} {}{}", value / std::pow(1e3, k),
                     kPrefixes[static_cast<std::size_t>(k + 5)], unit);
}

// Places of a plot from quantities, both axes linear.
struct Axes {
  double x0, x1, y0, y1;
  double top, height;
  double x(double v) const { return kLeft + (v - x0) / (x1 - x0) * (kWidth - kLeft - 8); }
  double y(double v) const { return top + height - (v - y0) / (y1 - y0) * height; }
};

Axes axes_of(const Eigen::VectorXd& x, double y0, double y1, double top, double height) {
  if (!(y1 > y0)) y0 -= 1e-30, y1 += 1e-30;
  return {x.minCoeff(), std::max(x.maxCoeff(), x.minCoeff() + 1e-30), y0, y1, top, height};
}

std::string plot(const ModulusPicture& p) {
  const Eigen::Index stride = std::max<Eigen::Index>(1, p.travel_m.size() / kShown);
  const Axes force = axes_of(p.travel_m, p.push_N.minCoeff(), p.push_N.maxCoeff(), 8, kHeight - 16);
  Eigen::VectorXd left = Eigen::VectorXd::Zero(p.travel_m.size());
  if (p.fitted_N.size() == left.size())
    left = (p.push_N - p.fitted_N).array().isFinite().select(p.push_N - p.fitted_N, 0.0);
  const double most = left.cwiseAbs().maxCoeff();
  const Axes rest = axes_of(p.travel_m, -most, most, kHeight, kRest);
  std::string dots, line, rests;
  for (Eigen::Index i = 0; i < p.travel_m.size(); i += stride) {
    const double x = force.x(p.travel_m[i]);
    dots += fmt::format("M{:.1f} {:.1f}h.01", x, force.y(p.push_N[i]));
    rests += fmt::format("M{:.1f} {:.1f}h.01", x, rest.y(left[i]));
    if (p.fitted_N.size() == left.size() && std::isfinite(p.fitted_N[i]))
      line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L", x, force.y(p.fitted_N[i]));
  }
  std::string svg = fmt::format(
      "<svg viewBox='0 0 {} {}' width='{}' stroke-linecap='round' fill='none' font-size='10'>",
      kWidth, kHeight + kRest + 18, kWidth);
  if (!p.model.empty()) {
    const double x = force.x(p.contact_m);
    const double half = std::max(1., force.x(p.contact_m + p.contact_deviation_m) - x);
    svg += fmt::format(
        "<rect x='{:.1f}' y='8' width='{:.1f}' height='{}' fill='#1c7ed6' opacity='.25'/>",
        std::max<double>(kLeft, x - half), std::min<double>(2 * half, kWidth - kLeft),
        kHeight - 16);
  }
  svg += fmt::format("<path d='{}' stroke='#555' stroke-width='2'/>", dots);
  svg += fmt::format("<path d='{}' stroke='#e8590c' stroke-width='1.5'/>", line);
  svg += fmt::format("<path d='{}' stroke='#868e96' stroke-width='1.5'/>", rests);
  const auto label = [&](double x, double y, const char* anchor, const std::string& text) {
    svg += fmt::format("<text x='{:.0f}' y='{:.0f}' text-anchor='{}' fill='currentColor'>{}</text>",
                       x, y, anchor, text);
  };
  label(kLeft - 4, 16, "end", prefixed(force.y1, "N"));
  label(kLeft - 4, kHeight - 8, "end", prefixed(force.y0, "N"));
  label(kLeft - 4, kHeight + 12, "end", "±" + prefixed(most, "N"));
  label(kLeft, kHeight + kRest + 14, "start", prefixed(force.x0, "m"));
  label(kWidth - 8, kHeight + kRest + 14, "end", prefixed(force.x1, "m"));
  return svg + "</svg>";
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
  Eigen::Index across = 2;
  (high - low).minCoeff(&across);
  const Eigen::Index u = across == 0 ? 1 : 0, v = across == 2 ? 1 : 2;
  const double size = std::max({high[u] - low[u], high[v] - low[v], 1e-30});
  if (!(size > 1e-12)) return "";
  const double radius = std::clamp(180 / std::sqrt(static_cast<double>(placed.size())), 3., 24.);
  std::string svg = "<h2>Map</h2><svg viewBox='0 0 520 480' width='520' font-size='11'>";
  for (const auto* p : placed) {
    const double t = stiff > soft ? std::log(p->young_Pa / soft) / std::log(stiff / soft) : 0.5;
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
                     "width:400px;margin:6px}b{font-weight:600}p{margin:2px 0}</style><h1>" +
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
                        escaped(p.name), escaped(p.point), kColours[rank(p)], p.grade);
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
