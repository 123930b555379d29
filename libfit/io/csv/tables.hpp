#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "libfit/core/curves.hpp"
#include "libfit/core/geometry.hpp"

namespace palpate {

// The comma-separated tables of the command line. All readers throw Error naming file, line and
// column (read_csv); all writers store whole or not at all.

/// P.csv, `x_m,y_m,z_m[,nx,ny,nz]`: where to experiment. position P x 3 [m]; normal P x 3 inward,
/// made unit on reading, or 0 x 3 when the file has none.
struct PointTable {
  Points position;
  Points normal;
  std::vector<std::string> ignored = {};  ///< names of columns that say nothing here
};
PointTable read_point_table(const std::filesystem::path& path);

/// One tool path of PATHS.csv, `path,x_m,y_m,z_m,dx_m,dy_m,dz_m`: a test point and successive
/// deflections there, K x 3 [m]. Rows of a path follow one another and repeat its point.
struct PathInTable {
  std::string name;
  Vec3 point;
  Points deflection;
};
/// ignored: gets the names of columns that say nothing here, unless null.
std::vector<PathInTable> read_tool_paths(const std::filesystem::path& path,
                                         std::vector<std::string>* ignored = nullptr);

constexpr int kMaxPathTools = 8;
using Quaternions = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;

/// PATH.csv, `t_s,x_m,y_m,z_m[,qx,qy,qz,qw][,tool][,force_N]`: where 1 to kMaxPathTools tools are
/// at T strictly increasing times [s]. Row i tools + k is tool k's at time_s[i]. position: T tools
/// x 3 [m]; orientation: T tools x 4, unit quaternions x, y, z, w, or 0 x 4 where no tool turns.
struct PosePath {
  std::vector<double> time_s;
  int tools = 1;
  Points position;
  Quaternions orientation;
  std::vector<double> force_N = {};  ///< T tools sizes of recorded forces; none without the column
  std::vector<std::string> ignored = {};  ///< names of columns that say nothing here
};
/// Throws Error where at a time the tools 0, 1, ... do not follow each other, all of them.
PosePath read_pose_path(const std::filesystem::path& path);
/// Writes `t_s,x_m,y_m,z_m,qx,qy,qz,qw` of one tool that has an orientation at each time.
void write_tip_path(const std::filesystem::path& path, const PosePath& tip);

/// One row of FORCES.csv: what the engine answers at a tick. force_N acts ON THE TOOL.
/// triangle -1 without contact. torque_Nm: of that force, about the tool's position.
struct ForceRow {
  double time_s = 0;
  Vec3 force_N = Vec3::Zero();
  bool is_in_contact = false;
  Vec3 contact_point_m = Vec3::Zero();
  std::int32_t triangle = -1;
  double depth_m = 0;
  double lateral_m = 0;
  bool is_sliding = false;
  bool is_outside = false, is_extrapolated = false, is_blocked = false, is_in_debt = false;
  int tool = 0;
  Vec3 torque_Nm = Vec3::Zero();
};
void write_forces(const std::filesystem::path& path, const std::vector<ForceRow>& rows);

/// One row of T.csv, `point,name,curve,at_m,value_N,slope_N_m[,deviation_N]`. point: index of the
/// test point or vertex; a vertex has no name. deviation_N: standard error of the value; the column
/// is written when every row has one.
struct CurveTableRow {
  std::int64_t point = 0;
  std::string name;
  CurveKind curve = CurveKind::normal;
  double at_m = 0;
  double value_N = 0;
  double slope_N_m = 0;
  double deviation_N = kNan;
};
void write_curve_rows(const std::filesystem::path& path, const std::vector<CurveTableRow>& rows);

}  // namespace palpate
