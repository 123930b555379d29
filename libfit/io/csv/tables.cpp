#include "libfit/io/csv/tables.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "libfit/core/error.hpp"
#include "libfit/core/text.hpp"
#include "libfit/io/csv/csv.hpp"

namespace palpate {
namespace {

constexpr std::array<CsvColumnRule, 6> kPointRules{
    {{"x_m"}, {"y_m"}, {"z_m"}, {"nx", false}, {"ny", false}, {"nz", false}}};
constexpr std::array<std::string_view, 3> kPlace{"x_m", "y_m", "z_m"}, kNormal{"nx", "ny", "nz"},
    kDeflection{"dx_m", "dy_m", "dz_m"};
constexpr std::array<std::string_view, 4> kQuaternion{"qx", "qy", "qz", "qw"};
constexpr std::array<CsvColumnRule, 7> kToolPathRules{
    {{"path", true, true}, {"x_m"}, {"y_m"}, {"z_m"}, {"dx_m"}, {"dy_m"}, {"dz_m"}}};
constexpr std::array<CsvColumnRule, 8> kTipPathRules{
    {{"t_s"}, {"x_m"}, {"y_m"}, {"z_m"}, {"qx"}, {"qy"}, {"qz"}, {"qw"}}};
constexpr std::array<CsvColumnRule, 10> kPosePathRules{{{"t_s"},
                                                        {"x_m"},
                                                        {"y_m"},
                                                        {"z_m"},
                                                        {"qx", false},
                                                        {"qy", false},
                                                        {"qz", false},
                                                        {"qw", false},
                                                        {"tool", false},
                                                        {"force_N", false}}};
constexpr std::array<CsvColumnRule, 20> kForceRules{
    {{"t_s"},       {"fx_N"},    {"fy_N"},    {"fz_N"},         {"contact"},
     {"cx_m"},      {"cy_m"},    {"cz_m"},    {"triangle"},     {"depth_m"},
     {"lateral_m"}, {"sliding"}, {"outside"}, {"extrapolated"}, {"blocked"},
     {"in_debt"},   {"tool"},    {"tx_Nm"},   {"ty_Nm"},        {"tz_Nm"}}};
constexpr std::array<CsvColumnRule, 7> kCurveRules{{{"point"},
                                                    {"name", true, true},
                                                    {"curve", true, true},
                                                    {"at_m"},
                                                    {"value_N"},
                                                    {"slope_N_m"},
                                                    {"deviation_N", false}}};

// The header a writer gives: the rules' names, the optional ones only on demand.
template <std::size_t N>
std::vector<std::string_view> header(const std::array<CsvColumnRule, N>& rules,
                                     bool with_optional = true) {
  std::vector<std::string_view> names;
  for (const auto& rule : rules)
    if (rule.is_required || with_optional) names.push_back(rule.name);
  return names;
}

Error error_at(const CsvTable& table, std::size_t row, const std::string& what,
               const std::string& remedy) {
  return Error(fmt::format("{}:{}", table.path.string(), table.line[row]), what, remedy);
}

template <std::size_t N>
Eigen::Matrix<double, Eigen::Dynamic, N, Eigen::RowMajor> columns(
    const CsvTable& table, const std::array<std::string_view, N>& names) {
  const auto rows = static_cast<Eigen::Index>(table.rows());
  Eigen::Matrix<double, Eigen::Dynamic, N, Eigen::RowMajor> out(rows, N);
  for (std::size_t k = 0; k < N; ++k)
    out.col(k) = Eigen::Map<const Eigen::VectorXd>(table.number(names[k]).data(), rows);
  return out;
}

// True where a table has all of some optional columns, false where it has none.
template <std::size_t N>
bool has_all(const CsvTable& table, const std::array<std::string_view, N>& names) {
  const auto found =
      std::ranges::count_if(names, [&](std::string_view name) { return table.has(name); });
  if (found != 0 && found != N)
    throw Error(table.path.string() + ":1",
                fmt::format("has some of {} but not all", fmt::join(names, ",")),
                "Give all or none.");
  return found != 0;
}

void put(CsvWriter& csv, const Vec3& v) { csv.number(v[0]).number(v[1]).number(v[2]); }

Points unit_normals(const CsvTable& table) {
  if (!has_all(table, kNormal)) return Points(0, 3);
  Points normal = columns(table, kNormal);
  for (Eigen::Index i = 0; i < normal.rows(); ++i) {
    const double length = normal.row(i).norm();
    if (!(length > 0) || !std::isfinite(length))
      throw error_at(table, static_cast<std::size_t>(i), "the normal has no direction",
                     "Give a vector into the body, or leave out nx,ny,nz.");
    if (std::abs(length - 1) > 1e-15) normal.row(i) /= length;  // keeps written unit vectors exact
  }
  return normal;
}

// A table that is read for its rows has some.
template <class Rules>
CsvTable read_rows(const std::filesystem::path& path, const Rules& rules) {
  CsvTable table = read_csv(path, rules);
  if (table.rows() == 0)
    throw Error(path.string(), "has no row below its header", "Add one row at least.");
  return table;
}

// Number of tools of a path: as many as rows have its first time.
std::size_t tools_of(const CsvTable& table) {
  if (!table.has("tool")) return 1;
  const auto& time_s = table.number("t_s");
  const auto other =
      std::find_if(time_s.begin(), time_s.end(), [&](double t) { return t != time_s.front(); });
  const auto tools = static_cast<std::size_t>(other - time_s.begin());
  if (tools > kMaxPathTools)
    throw error_at(table, kMaxPathTools,
                   fmt::format("more than {} rows have the same time", kMaxPathTools),
                   fmt::format("Give {} tools at most.", kMaxPathTools));
  return tools;
}

// Times increase, and each has tools 0, 1, ... in this order.
void check_times(const CsvTable& table, std::size_t tools) {
  const auto& time_s = table.number("t_s");
  const char* const remedy =
      "Give the rows of a time one after another: tools 0, 1, ... in this order, all at every "
      "time.";
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const std::size_t tool = i % tools;
    if (table.has("tool") && table.number("tool")[i] != static_cast<double>(tool))
      throw error_at(
          table, i,
          fmt::format("column `tool` is {} where tool {} is due", table.number("tool")[i], tool),
          remedy);
    if (tool > 0 && time_s[i] != time_s[i - tool])
      throw error_at(table, i, fmt::format("tool {} has another time than tool 0", tool), remedy);
    if (tool == 0 && i > 0 && !(time_s[i] > time_s[i - 1]))
      throw error_at(table, i, "column `t_s` does not increase", "Sort the rows by time.");
  }
  if (table.rows() % tools != 0)
    throw error_at(table, table.rows() - 1, "the last time has not all tools", remedy);
}

Quaternions unit_quaternions(const CsvTable& table) {
  if (!has_all(table, kQuaternion)) return Quaternions(0, 4);
  const Quaternions out = columns(table, kQuaternion);
  // The tolerance of the length is the engine's.
  for (Eigen::Index i = 0; i < out.rows(); ++i)
    if (!(std::abs(out.row(i).norm() - 1) <= 1e-3))
      throw error_at(table, static_cast<std::size_t>(i),
                     fmt::format("the quaternion has the length {:.4g}", out.row(i).norm()),
                     "Give unit quaternions.");
  return out;
}

}  // namespace

PointTable read_point_table(const std::filesystem::path& path) {
  const CsvTable table = read_rows(path, kPointRules);
  return {columns(table, kPlace), unit_normals(table), table.ignored};
}

std::vector<PathInTable> read_tool_paths(const std::filesystem::path& path,
                                         std::vector<std::string>* ignored) {
  const CsvTable table = read_rows(path, kToolPathRules);
  if (ignored) *ignored = table.ignored;
  const Points point = columns(table, kPlace);
  const Points deflection = columns(table, kDeflection);
  const auto& name = table.text("path");
  std::vector<PathInTable> paths;
  std::set<std::string> seen;
  for (std::size_t first = 0, last = 0; first < table.rows(); first = last) {
    if (!seen.insert(name[first]).second)
      throw error_at(table, first, "path `" + name[first] + "` comes back after another one",
                     "Keep the rows of a path together.");
    for (last = first; last < table.rows() && name[last] == name[first]; ++last)
      if (point.row(last) != point.row(first))
        throw error_at(table, last, "path `" + name[last] + "` changes its test point",
                       "Repeat the point's x_m,y_m,z_m in all rows of a path.");
    paths.push_back({name[first], point.row(first),
                     deflection.middleRows(first, static_cast<Eigen::Index>(last - first))});
  }
  return paths;
}

PosePath read_pose_path(const std::filesystem::path& path) {
  const CsvTable table = read_rows(path, kPosePathRules);
  const std::size_t tools = tools_of(table);
  check_times(table, tools);
  PosePath out;
  out.tools = static_cast<int>(tools);
  for (std::size_t i = 0; i < table.rows(); i += tools)
    out.time_s.push_back(table.number("t_s")[i]);
  out.position = columns(table, kPlace);
  out.orientation = unit_quaternions(table);
  if (table.has("force_N")) out.force_N = table.number("force_N");
  out.ignored = table.ignored;
  return out;
}

void write_tip_path(const std::filesystem::path& path, const PosePath& tip) {
  CsvWriter csv(path, header(kTipPathRules));
  for (std::size_t i = 0; i < tip.time_s.size(); ++i) {
    csv.number(tip.time_s[i]);
    put(csv, tip.position.row(i));
    for (int k = 0; k < 4; ++k) csv.number(tip.orientation(static_cast<Eigen::Index>(i), k));
    csv.end_row();
  }
  csv.commit();
}

void write_forces(const std::filesystem::path& path, const std::vector<ForceRow>& rows) {
  CsvWriter csv(path, header(kForceRules));
  for (const auto& row : rows) {
    csv.number(row.time_s);
    put(csv, row.force_N);
    csv.integer(row.is_in_contact);
    put(csv, row.contact_point_m);
    csv.integer(row.triangle).number(row.depth_m).number(row.lateral_m).integer(row.is_sliding);
    csv.integer(row.is_outside).integer(row.is_extrapolated).integer(row.is_blocked);
    csv.integer(row.is_in_debt).integer(row.tool);
    put(csv, row.torque_Nm);
    csv.end_row();
  }
  csv.commit();
}

void write_curve_rows(const std::filesystem::path& path, const std::vector<CurveTableRow>& rows) {
  const bool has_deviation =
      !rows.empty() && std::none_of(rows.begin(), rows.end(), [](const CurveTableRow& row) {
        return std::isnan(row.deviation_N);
      });
  CsvWriter csv(path, header(kCurveRules, has_deviation));
  for (const auto& row : rows) {
    csv.integer(row.point).text(row.name).text(kCurveNames[static_cast<int>(row.curve)]);
    csv.number(row.at_m).number(row.value_N).number(row.slope_N_m);
    if (has_deviation) csv.number(row.deviation_N);
    csv.end_row();
  }
  csv.commit();
}

}  // namespace palpate
