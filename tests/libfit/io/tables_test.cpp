#include "libfit/io/csv/tables.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "libfit/io/atomic_file.hpp"
#include "libfit/io/csv/csv.hpp"
#include "tests/libfit/io/examples.hpp"
#include "tests/libfit/io/scratch.hpp"

namespace palpate::testing_io {
namespace {

void put(CsvWriter& csv, const Vec3& v) { csv.number(v[0]).number(v[1]).number(v[2]); }

class Tables : public ScratchTest {
 protected:
  void write_points(const std::string& name, const PointTable& points) {
    std::vector<std::string_view> header{"x_m", "y_m", "z_m", "nx", "ny", "nz"};
    if (points.normal.rows() == 0) header.resize(3);
    CsvWriter csv(at(name), header);
    for (Eigen::Index i = 0; i < points.position.rows(); ++i) {
      put(csv, points.position.row(i));
      if (points.normal.rows() != 0) put(csv, points.normal.row(i));
      csv.end_row();
    }
    csv.commit();
  }
  PointTable points_of(const std::string& text) {
    write_quickly(at("P.csv"), text);
    return read_point_table(at("P.csv"));
  }
  std::string points_error(const std::string& text) {
    return error_of([&] { points_of(text); });
  }
};

TEST_F(Tables, any_double_reads_back_to_the_same_bits) {
  std::mt19937_64 random(5);
  std::vector<double> values{0.0, -0.0, 5e-324, -2.2250738585072014e-308, 1.7976931348623157e308,
                             0.1};
  while (values.size() < 30000) {
    const std::uint64_t bits = random();
    double value;
    std::memcpy(&value, &bits, sizeof(value));
    if (std::isfinite(value)) values.push_back(value);
  }
  PointTable a{Eigen::Map<const Points>(values.data(), 10000, 3), Points(0, 3)};
  write_points("P.csv", a);
  EXPECT_TRUE(same_bits(a.position, read_point_table(at("P.csv")).position)) << "seed 5";
}

TEST_F(Tables, points_come_back_with_and_without_normals) {
  const PointTable a{awkward_points(20, 1), unit_vectors(20, 2)};
  write_points("P.csv", a);
  const PointTable b = read_point_table(at("P.csv"));
  EXPECT_TRUE(same_bits(a.position, b.position));
  EXPECT_LT((a.normal - b.normal).cwiseAbs().maxCoeff(), 3e-16);
  write_points("Q.csv", {a.position, Points(0, 3)});
  EXPECT_EQ(read_point_table(at("Q.csv")).normal.rows(), 0);
  EXPECT_TRUE(read_whole_file(at("Q.csv")).starts_with("x_m,y_m,z_m\n"));
}

TEST_F(Tables, byte_order_mark_crlf_blank_lines_spaces_order_and_extra_columns_are_accepted) {
  const PointTable p = points_of(
      "\xEF\xBB\xBF\r\n z_m , \"x_m\",note,y_m\r\n\r\n 3, 1 ,\"a, \"\"b\"\"\",+2\r\n\r\n6e0,4,,.5");
  ASSERT_EQ(p.position.rows(), 2);
  EXPECT_EQ(p.position.row(0), Eigen::RowVector3d(1, 2, 3));
  EXPECT_EQ(p.position.row(1), Eigen::RowVector3d(4, 0.5, 6));
}

TEST_F(Tables, normals_are_made_unit) {
  const PointTable p = points_of("x_m,y_m,z_m,nx,ny,nz\n0,0,0,0,0,-2\n");
  EXPECT_EQ(p.normal.row(0), Eigen::RowVector3d(0, 0, -1));
  EXPECT_EQ(points_error("x_m,y_m,z_m,nx,ny,nz\n0,0,0,0,0,0\n"),
            "P.csv:2: the normal has no direction");
  EXPECT_EQ(points_error("x_m,y_m,z_m,nx\n0,0,0,1\n"), "P.csv:1: has some of nx,ny,nz but not all");
}

TEST_F(Tables, columns_without_their_unit_are_refused) {
  EXPECT_EQ(points_error("x,y,z\n1,2,3\n"),
            "P.csv:1: column `x` is not `x_m`: it does not say its unit");
  EXPECT_EQ(points_error("x_m,y_mm,z_m\n1,2,3\n"), "P.csv:1: column `y_mm` is not `y_m`");
  EXPECT_EQ(points_error("x_m,y_m,z_m,NX,ny,nz\n"), "P.csv:1: column `NX` is not `nx`");
  EXPECT_EQ(points_error("x_m,y_m\n1,2\n"), "P.csv:1: column `z_m` is missing");
  EXPECT_EQ(points_error("x_m,y_m,z_m,x_m\n1,2,3,4\n"), "P.csv:1: column `x_m` comes twice");
  EXPECT_EQ(points_error("\n\n"), "P.csv:1: is empty");
}

TEST_F(Tables, other_separators_than_commas_are_named) {
  EXPECT_EQ(points_error("x_m;y_m;z_m\n0,04;0,03;0\n"),
            "P.csv:1: the columns are separated by semicolons");
  EXPECT_EQ(points_error("x_m\ty_m\tz_m\n1\t2\t3\n"), "P.csv:1: the columns are separated by tabs");
}

TEST_F(Tables, bad_fields_are_named_by_file_line_and_column) {
  const std::string head = "x_m,y_m,z_m\r\n\r\n";
  EXPECT_EQ(points_error(head + "1,2,3\n1,two,3\n"),
            "P.csv:4: column `y_m`: `two` is not a number");
  EXPECT_EQ(points_error(head + "1,,3\n"), "P.csv:3: column `y_m`: `` is not a number");
  EXPECT_EQ(points_error(head + "1,nan,3\n"), "P.csv:3: column `y_m`: `nan` is not finite");
  EXPECT_EQ(points_error(head + "1,2,-inf\n"), "P.csv:3: column `z_m`: `-inf` is not finite");
  EXPECT_EQ(points_error(head + "1e999,2,3\n"), "P.csv:3: column `x_m`: `1e999` is out of range");
  EXPECT_EQ(points_error(head + "0x1p3,2,3\n"), "P.csv:3: column `x_m`: `0x1p3` is not a number");
  EXPECT_EQ(points_error(head + "1 2,2,3\n"), "P.csv:3: column `x_m`: `1 2` is not a number");
  EXPECT_EQ(points_error(head + "1,5,2,5,3\n"), "P.csv:3: has 5 fields where the header has 3");
  EXPECT_EQ(points_error(head + "1,2\n"), "P.csv:3: has 2 fields where the header has 3");
  EXPECT_EQ(points_error(head + "\"1,2,3\n"), "P.csv:3: a quote is not closed");
  EXPECT_EQ(points_error(head + "\"1\"2,2,3\n"), "P.csv:3: text follows a closing quote");
  EXPECT_EQ(error_of([&] { read_point_table(at("none.csv")); }), "none.csv: no such file");
}

TEST_F(Tables, random_bytes_are_refused_or_read_but_never_crash) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    std::mt19937 random(seed);
    std::string text = seed % 2 != 0 ? "x_m,y_m,z_m\n" : "";
    constexpr std::string_view kAlphabet = "01.,e-+\"\n\r nxyz_m\xff";
    for (int i = 0; i < 60; ++i) text += kAlphabet[random() % kAlphabet.size()];
    text += std::string(1, '\0');
    EXPECT_NO_FATAL_FAILURE(points_error(text)) << "seed " << seed;
  }
}

TEST_F(Tables, tool_paths_come_back) {
  std::vector<PathInTable> a{{"around, \"twice\"", Vec3(0.1, 0.2, 1.0 / 3), awkward_points(4, 1)},
                             {"1", Vec3(0, 0, 0), awkward_points(1, 2)}};
  static constexpr std::string_view kHeader[] = {"path", "x_m",  "y_m", "z_m",
                                                 "dx_m", "dy_m", "dz_m"};
  CsvWriter csv(at("T.csv"), kHeader);
  for (const PathInTable& path : a)
    for (Eigen::Index i = 0; i < path.deflection.rows(); ++i) {
      csv.text(path.name);
      put(csv, path.point);
      put(csv, path.deflection.row(i));
      csv.end_row();
    }
  csv.commit();
  const auto b = read_tool_paths(at("T.csv"));
  ASSERT_EQ(b.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(a[i].name, b[i].name);
    EXPECT_EQ(a[i].point, b[i].point);
    EXPECT_TRUE(same_bits(a[i].deflection, b[i].deflection));
  }
}

TEST_F(Tables, tool_paths_that_return_or_move_are_refused) {
  const auto paths_error = [&](const std::string& rows) {
    write_file_atomically(at("T.csv"), "path,x_m,y_m,z_m,dx_m,dy_m,dz_m\n" + rows);
    return error_of([&] { read_tool_paths(at("T.csv")); });
  };
  EXPECT_EQ(paths_error("a,0,0,0,0,0,0\nb,0,0,0,0,0,0\na,0,0,0,0,0,0\n"),
            "T.csv:4: path `a` comes back after another one");
  EXPECT_EQ(paths_error("a,0,0,0,0,0,0\na,0,1,0,0,0,0\n"),
            "T.csv:3: path `a` changes its test point");
}

TEST_F(Tables, paths_come_back_and_time_must_increase) {
  write_file_atomically(at("PATH.csv"),
                        "t_s,x_m,y_m,z_m\n0,1,2,3\n0.3333333333333333,-0,1e-300,0.1\n");
  const PosePath path = read_pose_path(at("PATH.csv"));
  EXPECT_EQ(path.time_s, (std::vector<double>{0, 1.0 / 3}));
  EXPECT_EQ(path.tools, 1);
  EXPECT_EQ(path.orientation.rows(), 0);
  EXPECT_EQ(path.position.row(1), Eigen::RowVector3d(-0.0, 1e-300, 0.1));
  const Quaternions leaning = Eigen::RowVector4d(0.6, 0, 0, 0.8).replicate(2, 1);
  write_tip_path(at("TIP.csv"), {path.time_s, 1, path.position, leaning});
  EXPECT_TRUE(same_bits(read_pose_path(at("TIP.csv")).position, path.position));
  EXPECT_EQ(read_pose_path(at("TIP.csv")).orientation, leaning);
  write_file_atomically(at("PATH.csv"), "t_s,x_m,y_m,z_m\n0,0,0,0\n0,0,0,0\n");
  EXPECT_EQ(error_of([&] { read_pose_path(at("PATH.csv")); }),
            "PATH.csv:3: column `t_s` does not increase");
  write_file_atomically(at("PATH.csv"), "t_ms,x_m,y_m,z_m\n0,0,0,0\n");
  EXPECT_EQ(error_of([&] { read_pose_path(at("PATH.csv")); }),
            "PATH.csv:1: column `t_ms` is not `t_s`");
}

TEST_F(Tables, paths_of_several_tools_that_turn_come_back) {
  write_file_atomically(at("PATH.csv"),
                        "tool,t_s,x_m,y_m,z_m,qw,qx,qy,qz\n0,0,1,2,3,1,0,0,0\n1,0,4,5,6,0,0,1,0\n"
                        "0,0.5,1,2,4,0.6,0.8,0,0\n1,0.5,4,5,7,0,0,0,-1\n");
  const PosePath path = read_pose_path(at("PATH.csv"));
  EXPECT_EQ(path.time_s, (std::vector<double>{0, 0.5}));
  EXPECT_EQ(path.tools, 2);
  EXPECT_EQ(path.position.row(3), Eigen::RowVector3d(4, 5, 7));
  EXPECT_EQ(path.orientation.row(2), Eigen::RowVector4d(0.8, 0, 0, 0.6));
}

TEST_F(Tables, paths_that_leave_out_a_tool_or_a_part_of_a_pose_are_refused) {
  const auto path_error = [&](const std::string& text) {
    write_file_atomically(at("PATH.csv"), text);
    return error_of([&] { read_pose_path(at("PATH.csv")); });
  };
  const std::string head = "t_s,x_m,y_m,z_m,tool\n";
  EXPECT_EQ(path_error(head + "0,0,0,0,0\n0,0,0,0,1\n1,0,0,0,0\n"),
            "PATH.csv:4: the last time has not all tools");
  EXPECT_EQ(path_error(head + "0,0,0,0,1\n0,0,0,0,0\n"),
            "PATH.csv:2: column `tool` is 1 where tool 0 is due");
  EXPECT_EQ(path_error(head + "0,0,0,0,0\n0,0,0,0,1\n1,0,0,0,0\n2,0,0,0,1\n"),
            "PATH.csv:5: tool 1 has another time than tool 0");
  EXPECT_EQ(path_error(head + "0,0,0,0,0\n0,0,0,0,0.5\n"),
            "PATH.csv:3: column `tool` is 0.5 where tool 1 is due");
  std::string crowd = head;
  for (int i = 0; i < 9; ++i) crowd += "0,0,0,0," + std::to_string(i) + "\n";
  EXPECT_EQ(path_error(crowd), "PATH.csv:10: more than 8 rows have the same time");
  EXPECT_EQ(path_error("t_s,x_m,y_m,z_m,qx,qy,qz\n0,0,0,0,0,0,0\n"),
            "PATH.csv:1: has some of qx,qy,qz,qw but not all");
  EXPECT_EQ(path_error("t_s,x_m,y_m,z_m,qx,qy,qz,qw\n0,0,0,0,0,0,0,2\n"),
            "PATH.csv:2: the quaternion has the length 2");
}

TEST_F(Tables, forces_are_written_under_the_agreed_header_and_only_where_finite) {
  std::vector<ForceRow> a(2);
  a[1] = {0.001, Vec3(0.1, -0.2, 1.0 / 3), true, Vec3(1, 2, 3), 42, 0.004, 0.001, true, false,
          true};
  a[1].tool = 3;
  a[1].torque_Nm = Vec3(0, -0.5, 1e-6);
  write_forces(at("F.csv"), a);
  const std::string written = read_whole_file(at("F.csv"));
  EXPECT_EQ(written,
            "t_s,fx_N,fy_N,fz_N,contact,cx_m,cy_m,cz_m,triangle,depth_m,lateral_m,sliding,"
            "outside,extrapolated,blocked,in_debt,tool,tx_Nm,ty_Nm,tz_Nm\n"
            "0,0,0,0,0,0,0,0,-1,0,0,0,0,0,0,0,0,0,0,0\n"
            "0.001,0.1,-0.2,0.3333333333333333,1,1,2,3,42,0.004,0.001,1,0,1,0,0,3,0,-0.5,1e-06\n");
  a[0].depth_m = std::nan("");
  EXPECT_EQ(error_of([&] { write_forces(at("F.csv"), a); }),
            "F.csv: row 0 field 10 would not be a finite number");
  EXPECT_EQ(read_whole_file(at("F.csv")), written) << "the old file must stay";
}

TEST_F(Tables, curve_rows_are_written_with_the_names_of_their_point_and_curve) {
  const std::vector<CurveTableRow> a{{0, "left, deep", CurveKind::normal, 0.001, 0.1, 100},
                                     {7, "", CurveKind::limit, 1.0 / 3, 0.25, 0}};
  write_curve_rows(at("T.csv"), a);
  EXPECT_EQ(read_whole_file(at("T.csv")),
            "point,name,curve,at_m,value_N,slope_N_m\n0,\"left, deep\",normal,0.001,0.1,100\n"
            "7,\"\",limit,0.3333333333333333,0.25,0\n");
}

}  // namespace
}  // namespace palpate::testing_io
