// `palpate report --figures`: the SVG is read back, and what is drawn is what the run left.

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "libfit/io/files/files.hpp"
#include "tests/tools/kept_run.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

struct Element {
  std::string name, text;
  std::map<std::string, std::string> attribute;
  int parent = -1;
  double number(const std::string& key) const { return std::stod(attribute.at(key)); }
};

/// Elements of an XML text in their order; throws where it is not well-formed.
std::vector<Element> parse_xml(const std::string& text) {
  std::vector<Element> all;
  int open = -1;
  const auto fail = [](const std::string& why) { throw std::runtime_error(why); };
  std::size_t at = text.find("?>") + 2;
  while (at < text.size()) {
    const std::size_t tag = text.find('<', at);
    const std::string between = text.substr(at, tag - at);
    if (open < 0 && between.find_first_not_of(" \n") != std::string::npos) fail("text outside");
    for (std::size_t i = between.find('&'); i != std::string::npos; i = between.find('&', i + 1))
      if (between.substr(i, 5) != "&amp;" && between.substr(i, 4) != "&lt;" &&
          between.substr(i, 4) != "&gt;")
        fail("a bare & in " + between);
    if (open >= 0) all[static_cast<std::size_t>(open)].text += between;
    if (tag == std::string::npos) break;
    const bool is_comment = text.compare(tag, 4, "<!--") == 0;
    const std::size_t end = is_comment ? text.find("-->", tag) : text.find('>', tag);
    if (end == std::string::npos) fail("a tag without an end");
    at = end + (is_comment ? 3 : 1);
    if (is_comment) continue;
    std::string inside = text.substr(tag + 1, end - tag - 1);
    if (inside.front() == '/') {
      if (open < 0 || all[static_cast<std::size_t>(open)].name != inside.substr(1))
        fail("</" + inside.substr(1) + " closes another element");
      open = all[static_cast<std::size_t>(open)].parent;
      continue;
    }
    const bool is_closed = inside.back() == '/';
    if (is_closed) inside.pop_back();
    Element element;
    std::istringstream words(inside);
    words >> element.name;
    element.parent = open;
    std::size_t next = element.name.size();
    while ((next = inside.find_first_not_of(" \n", next)) != std::string::npos) {
      const std::size_t equals = inside.find("=\"", next), quote = inside.find('"', equals + 2);
      if (equals == std::string::npos || quote == std::string::npos) fail("bad: " + inside);
      const std::string key = inside.substr(next, equals - next);
      if (!element.attribute.emplace(key, inside.substr(equals + 2, quote - equals - 2)).second)
        fail(key + " twice in " + inside);
      next = quote + 1;
    }
    all.push_back(element);
    if (!is_closed) open = static_cast<int>(all.size()) - 1;
  }
  if (open >= 0) fail("an element without an end");
  return all;
}

/// From drawing to data, by the labels of the ticks that stand before an element.
struct Scale {
  Scale(const std::vector<Element>& all, std::size_t before, const std::string& axis) {
    std::vector<std::pair<double, double>> ticks;  // of the last panel begun
    for (std::size_t i = 0; i < before; ++i) {
      if (all[i].name == "g" && all[i].attribute.count("class") &&
          all[i].attribute.at("class") == "axes")
        ticks.clear();
      if (all[i].name == "text" && all[i].attribute.count("class") &&
          all[i].attribute.at("class") == axis)
        ticks.emplace_back(all[i].number(axis) - (axis == "y" ? 2.8 : 0), std::stod(all[i].text));
    }
    if (ticks.size() < 2) throw std::runtime_error("no ticks on " + axis);
    slope = (ticks.back().second - ticks[0].second) / (ticks.back().first - ticks[0].first);
    origin = ticks[0].second - slope * ticks[0].first;
  }
  double operator()(double drawn) const { return origin + slope * drawn; }
  double slope, origin;
};

using Pairs = std::vector<std::pair<double, double>>;

/// What the marks of a group stand for; group: number of a <g>.
Pairs marks_of(const std::vector<Element>& all, std::size_t group) {
  const Scale x(all, group, "x"), y(all, group, "y");
  Pairs out;
  for (const Element& mark : all) {
    if (mark.parent != static_cast<int>(group)) continue;
    double px = 0, py = 0;
    if (std::sscanf(mark.attribute.at("transform").c_str(), "translate(%lf %lf)", &px, &py) != 2)
      throw std::runtime_error(mark.attribute.at("transform"));
    out.emplace_back(x(px), y(py));
  }
  return out;
}

std::vector<std::size_t> groups_of(const std::vector<Element>& all, const std::string& name) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].name == "g" && all[i].attribute.count("class") &&
        all[i].attribute.at("class") == name)
      out.push_back(i);
  return out;
}

class Figures : public KeptRun {
 protected:
  static std::vector<Element> figure(const std::string& name, const std::string& folder = "out") {
    const Outcome made = palpate(*folder_, "report " + path(folder) + " --figures " + path("fig"));
    EXPECT_EQ(made.status, 0) << made.err;
    return parse_xml(content_of(path("fig/" + name)));
  }
};

TEST_F(Figures, are_what_the_folder_is_enough_for) {
  const Outcome made =
      palpate(*folder_, "report " + path("out") + " --figures " + path("all") + " --json");
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(nlohmann::json::parse(made.out).at("figures"),
            (std::vector<std::string>{"curves.svg", "error.svg", "stiffness.svg"}));
  const Outcome nothing = palpate(*folder_, "report " + path("out"));
  EXPECT_EQ(nothing.status, 1);
  EXPECT_NE(nothing.err.find("neither a page nor figures are wanted"), std::string::npos);
}

// Every sample of three points stands where its depth and force are.
TEST_F(Figures, curves_show_the_samples_of_the_points_that_they_name) {
  const auto all = figure("curves.svg");
  const Samples samples = read_samples(path("out/samples.h5"));
  const FittedCurves fitted = read_curves(path("out/curves.h5"));
  std::size_t checked = 0;
  for (const std::size_t group : groups_of(all, "samples")) {
    std::string title, label;
    for (std::size_t i = 0; i < group; ++i) {
      if (all[i].attribute.count("font-weight")) title = all[i].text;
      if (all[i].text.find(" force [") != std::string::npos) label = all[i].text;
    }
    if (title.find(": ") == std::string::npos) continue;  // a drag
    const double unit = label.find("[mN]") != std::string::npos ? 1e3 : 1;
    const std::string name = title.substr(0, title.find(": "));
    const Pairs drawn = marks_of(all, group);
    Pairs wanted;
    for (Eigen::Index row = 0; row < samples.rows(); ++row) {
      const auto point = static_cast<std::size_t>(samples.point[row]);
      if (samples.point_name[point] != name || static_cast<int>(samples.kind[row]) != 0) continue;
      const auto place = std::find(fitted.name.begin(), fitted.name.end(), name);
      const Vec3 u = fitted.normal.row(place - fitted.name.begin());
      wanted.emplace_back(samples.deflection.row(row).dot(u) * 1e3,
                          samples.force.row(row).dot(u) * unit);
    }
    ASSERT_EQ(drawn.size(), wanted.size()) << name;
    for (std::size_t i = 0; i < drawn.size(); ++i) {
      EXPECT_NEAR(drawn[i].first, wanted[i].first, 1e-3 * wanted.back().first) << name;
      EXPECT_NEAR(drawn[i].second, wanted[i].second, 1e-3 * wanted.back().second) << name;
    }
    ++checked;
  }
  EXPECT_EQ(checked, 3u);
}

TEST_F(Figures, error_shows_every_held_out_row_and_the_shares_of_the_statement) {
  const auto all = figure("error.svg");
  std::istringstream rows(content_of(path("out/validation.csv")));
  std::string line;
  std::getline(rows, line);
  const auto fields_of = [](const std::string& text) {
    std::vector<std::string> fields;
    std::istringstream stream(text);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    return fields;
  };
  const std::vector<std::string> header = fields_of(line);
  const auto error =
      static_cast<std::size_t>(std::find(header.begin(), header.end(), "error_N") - header.begin());
  ASSERT_LT(error, header.size());
  std::map<std::string, std::vector<double>> errors_N;
  while (std::getline(rows, line)) {
    const std::vector<std::string> fields = fields_of(line);
    errors_N[fields[1]].push_back(std::stod(fields[error]));
  }
  ASSERT_FALSE(errors_N.empty());
  for (const auto& [name, errors] : errors_N) {
    const auto groups = groups_of(all, name);
    ASSERT_EQ(groups.size(), 1u) << name;
    const Pairs drawn = marks_of(all, groups[0]);
    ASSERT_EQ(drawn.size(), errors.size());
    std::string label;
    for (std::size_t i = 0; i < groups[0]; ++i)
      if (all[i].text.find("error [") == 0) label = all[i].text;
    const double unit = label == "error [mN]" ? 1e3 : 1, most = unit * 0.02;
    for (std::size_t i = 0; i < drawn.size(); ++i)
      EXPECT_NEAR(drawn[i].second, unit * errors[i], 1e-3 * most) << name;
  }
  const auto statement = nlohmann::json::parse(content_of(path("out/statement.json")));
  const Scale x(all, all.size(), "x");
  std::vector<double> drawn, wanted;
  for (const Element& bar : all)
    if (bar.name == "rect" && bar.attribute.count("class") &&
        bar.attribute.at("class") == "p95_rel")
      drawn.push_back(x(bar.number("x") + bar.number("width")) / 100);
  for (const auto& section : statement.at("sections"))
    for (const auto& [name, figures] : statement.at(section.at("name")).items())
      if (section.at("name") != "baselines") wanted.push_back(figures.at("p95_rel"));
  ASSERT_EQ(drawn.size(), wanted.size());
  std::sort(drawn.begin(), drawn.end());
  std::sort(wanted.begin(), wanted.end());
  for (std::size_t i = 0; i < drawn.size(); ++i) EXPECT_NEAR(drawn[i], wanted[i], 1e-3);
}

// The block is pressed on its flat top: seen along its normal, lengths are true.
TEST_F(Figures, stiffness_has_a_scale_bar_that_measures_the_test_points) {
  const auto all = figure("stiffness.svg");
  const FittedCurves fitted = read_curves(path("out/curves.h5"));
  const auto group = groups_of(all, "test-points");
  ASSERT_EQ(group.size(), 1u);
  Pairs drawn;
  for (const Element& e : all)
    if (e.parent == static_cast<int>(group[0])) drawn.emplace_back(e.number("cx"), e.number("cy"));
  ASSERT_EQ(drawn.size(), fitted.name.size());
  double scale = 0;  // pt a millimetre
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!all[i].attribute.count("class") || all[i].attribute.at("class") != "scale") continue;
    double from = 0, y = 0, to = 0;
    ASSERT_EQ(std::sscanf(all[i].attribute.at("d").c_str(), "M%lf %lfH%lf", &from, &y, &to), 3);
    scale = (to - from) / std::stod(all[i + 1].text);
    EXPECT_NE(all[i + 1].text.find(" mm"), std::string::npos);
  }
  for (std::size_t i = 1; i < drawn.size(); ++i) {
    const double apart =
        std::hypot(drawn[i].first - drawn[0].first, drawn[i].second - drawn[0].second);
    const double wanted_mm =
        1e3 * (fitted.position.row(static_cast<Eigen::Index>(i)) - fitted.position.row(0)).norm();
    EXPECT_NEAR(apart / scale, wanted_mm, 0.01 * wanted_mm);
  }
  int triangles = 0;
  for (const Element& e : all)
    triangles += e.parent == static_cast<int>(groups_of(all, "body")[0]) ? 1 : 0;
  EXPECT_GE(triangles, 128);  // the top's; the others are seen from behind or edge-on
}

TEST_F(Figures, placement_shows_each_round) {
  fs::create_directories(path("placed"));
  fs::copy(path("out/curves.h5"), path("placed/curves.h5"), fs::copy_options::overwrite_existing);
  folder_->write("placed/placement.csv",
                 "points,new_points,median_rel,p95_rel,max_rel,dragged\n"
                 "12,6,0.2,0.7,0.9,6\n18,9,0.09,0.25,0.3,6\n27,2,0.04,0.1,0.12,6\n");
  const auto all = figure("placement.svg", "placed");
  const auto groups = groups_of(all, "p95_rel");
  ASSERT_EQ(groups.size(), 1u);
  const Pairs drawn = marks_of(all, groups[0]), wanted{{12, 70}, {18, 25}, {27, 10}};
  ASSERT_EQ(drawn.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(drawn[i].first, wanted[i].first, 0.01);
    EXPECT_NEAR(drawn[i].second, wanted[i].second, 0.05);
  }
}

}  // namespace
}  // namespace palpate::tools
