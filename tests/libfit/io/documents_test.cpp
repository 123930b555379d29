// The data sets in docs/formats are those of files that the library wrote, with their types and
// units. PALPATE_WRITE_DOCS=1 writes the tables anew.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>
#include <regex>

#include "libfit/io/csv/tables.hpp"
#include "libfit/io/files/files.hpp"
#include "tests/libfit/io/examples.hpp"
#include "tests/libfit/io/scratch.hpp"
#include "tests/support/generated_page.hpp"

namespace palpate::testing_io {
namespace {

using testing_support::content_of_page;
using testing_support::expect_content;
using testing_support::expect_tables;
using testing_support::PageTable;

class Documents : public ScratchTest {};

// Whether a data set has rows of the table, and what the table calls it; "": it does not.
using Naming = std::function<std::string(const std::string&)>;

bool is_in(const std::string& name, std::initializer_list<const char*> groups) {
  return std::ranges::any_of(groups, [&](const char* group) { return name.starts_with(group); });
}

// Of its own: neither the probe's nor the scene's.
std::string own(const std::string& name) {
  return is_in(name, {"probe/", "probe_1/", "scene/"}) ? "" : name;
}

// Curves of each kind have the same data sets; other parts of a family have a table of their own.
std::string of_curves(const std::string& name) {
  static const std::regex kind("curves/(normal|lateral|limit)/");
  const std::string out = std::regex_replace(own(name), kind, "curves/KIND/");
  return is_in(out, {"curves/KIND/", "curves/first_row"}) || !is_in(out, {"curves/", "coupling/"})
             ? out
             : "";
}

PageTable data_sets(const std::filesystem::path& file, const Naming& naming) {
  PageTable table{{"data set", "shape", "type", "unit", "meaning"}, {}};
  std::set<std::string> seen;
  for (const DataSetDescription& set : describe(file).data_sets) {
    const std::string name = naming(set.name);
    if (name.empty() || !seen.insert(name).second) continue;
    table.rows.push_back({"`" + name + "`", std::nullopt, set.type,
                          set.unit.empty() ? std::string("1") : set.unit, std::nullopt});
  }
  return table;
}

Samples whole_samples() {
  Samples s = example_samples();
  s.point_sway = Eigen::Matrix<double, 3, 6>::Constant(1e-3);
  s.point_scale = Eigen::Vector3d::Ones();
  s.tool.assign(6, 0);
  s.probe_number.assign(6, 0);
  s.path.assign(6, PathKind::sliding);
  s.step_check.assign(6, StepCheck{});
  s.time_s = Eigen::VectorXd::Constant(6, std::numeric_limits<double>::quiet_NaN());
  s.lean = Eigen::Matrix<double, 6, 2>::Constant(0.1);
  s.relaxation.share = Eigen::VectorXd::Constant(1, 0.5);
  s.relaxation.time_s = Eigen::VectorXd::Constant(1, 0.1);
  MeasuredRecordings& r = s.recordings;
  r.experiment = {0};
  r.file = r.hash = r.estimator = r.reasons = {"a"};
  for (auto* column :
       {&r.contact_m, &r.contact_deviation_m, &r.speed_m_s, &r.noise_N, &r.hysteresis, &r.young_Pa})
    *column = {0.001};
  r.grade.resize(1);
  s.surface.resize(6, 15);
  s.surface.setZero();
  return s;
}

FittedCurves whole_curves(CurveFamily family) {
  FittedCurves curves = example_curves();
  curves.curves = example_of_family(curves.curves, family);
  curves.curves.relaxation = whole_samples().relaxation;
  curves.curves.relaxation.radius_m = 8e-3;
  curves.curves.damage = {1.5, 0.01, 0.1, 0.01};
  return curves;
}

std::string bounds_of(const runtime::Part& part) {
  return part.min == -part.max ? fmt::format("±{:g}", part.max)
                               : fmt::format("{:g} to {:g}", part.min, part.max);
}

PageTable parts_of_rings() {
  PageTable table{{"PART", "width", "unit", "bounds", "meaning"}, {}};
  for (const runtime::Part& part : parts_of(CurveFamily::rings))
    table.rows.push_back({fmt::format("`{}`", part.name), fmt::format("{}", part.width),
                          std::string(part.unit), bounds_of(part), std::nullopt});
  return table;
}

TEST_F(Documents, name_every_data_set_of_a_body) {
  write_body(at("b.h5"), example_body());
  expect_tables("formats/body.md", {{"body", data_sets(at("b.h5"), own)}});
}

TEST_F(Documents, name_every_data_set_of_samples) {
  const Samples s = whole_samples();
  write_samples(at("s.h5"), s);
  write_surface_motion(at("s.surface.h5"), s);
  write_signals(at("s.signals.h5"), RecordedSignals{});
  expect_tables("formats/samples.md", {{"samples", data_sets(at("s.h5"), own)},
                                       {"surface", data_sets(at("s.surface.h5"), own)},
                                       {"signals", data_sets(at("s.signals.h5"), own)}});
  std::string columns;
  for (const DataSetDescription& set : describe(at("s.h5")).data_sets)
    if (!is_in(set.name,
               {"probe/half_angle", "probe/semi_axes", "probe/mesh/vertices", "probe_1/"}))
      columns += fmt::format("{}\n  \"{}\": [\"{}\", \"{}\"]", columns.empty() ? "{" : ",",
                             set.name, set.type, set.unit.empty() ? "1" : set.unit);
  expect_content("../tools/python/palpate/samples.json", columns + "\n}\n");
}

TEST_F(Documents, name_every_data_set_of_curves) {
  FittedCurves curves = whole_curves(CurveFamily::separable);
  curves.curves.relaxation = {}, curves.curves.damage = {};
  write_curves(at("separable.h5"), curves);
  PageTable all = data_sets(at("separable.h5"), of_curves);
  curves = whole_curves(CurveFamily::rings);
  write_curves(at("rings.h5"), curves);
  std::set<std::string> keys;
  for (const auto& row : all.rows) keys.insert(*row[0]);
  for (const auto& row : data_sets(at("rings.h5"), of_curves).rows)
    if (keys.insert(*row[0]).second) all.rows.push_back(row);
  expect_tables("formats/curves.md", {{"curves", all}, {"rings", parts_of_rings()}});
}

TEST_F(Documents, name_every_data_set_of_a_model) {
  Model model = example_model();
  model.shape = example_shape();
  write_model(at("m.h5"), model);
  expect_tables("formats/model.md", {{"model", data_sets(at("m.h5"), of_curves)}});
}

TEST_F(Documents, show_the_headers_of_tables) {
  write_forces(at("forces.csv"), {});
  write_tip_path(at("path.csv"), {});
  CurveTableRow row;
  write_curve_rows(at("curves.csv"), {row});
  row.deviation_N = 0;
  write_curve_rows(at("bands.csv"), {row});
  const std::string page = content_of_page("formats/csv.md");
  const auto header = [&](const char* file) {
    std::ifstream stream(at(file));
    std::string line;
    std::getline(stream, line);
    return line;
  };
  const std::string curves = header("curves.csv"), bands = header("bands.csv"),
                    path = header("path.csv");
  const std::size_t turn = path.find(",qx");
  ASSERT_TRUE(bands.starts_with(curves + ",")) << bands;
  for (const std::string& shown : {"\n`" + header("forces.csv") + "`\n",
                                   "`" + path.substr(0, turn) + "[" + path.substr(turn) + "]",
                                   "`" + curves + "[" + bands.substr(curves.size()) + "]`"})
    EXPECT_NE(page.find(shown), std::string::npos) << shown;
}

TEST_F(Documents, name_every_data_set_of_a_probe) {
  Body body = example_body();
  body.probe->orientation = Vec3(0, 0, 1);
  write_body(at("b.h5"), body);
  const auto of_probe = [](const std::string& name) -> std::string {
    if (!is_in(name, {"probe/"})) return "";
    return is_in(name, {"probe/half_angle", "probe/semi_axes"}) ? "probe/KEY" : name;
  };
  PageTable table = data_sets(at("b.h5"), of_probe);
  for (auto& row : table.rows)
    if (*row[0] == "`probe/KEY`") row[3] = "m or rad";
  expect_tables("formats.md", {{"probe", table}});
}

}  // namespace
}  // namespace palpate::testing_io
