// Every format, and everything that can be wrong with a file.

#include "libfit/recordings/formats/importers.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <csignal>
#include <random>

#include "libfit/io/hdf5/hdf5.hpp"
#include "tests/libfit/io/scratch.hpp"

// HDF5 1.10 leaks a little of its own whenever it gives up on a damaged file.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() { return "leak:libhdf5"; }

namespace palpate::importers {
namespace {

namespace fs = std::filesystem;
using testing_io::error_of;

constexpr unsigned kSeed = 99;

class ImportersTest : public testing_io::ScratchTest {
 protected:
  ReadSettings axial() const {
    ReadSettings s;
    s.columns.time = "t";
    s.columns.depth = "d";
    s.columns.force = {"F"};
    s.units = {"s", "mm", "N"};
    return s;
  }
  std::vector<RawRecording> read(const std::string& text, const ReadSettings& settings,
                                 const std::string& name = "a.csv") {
    testing_io::write_quickly(at(name), text);
    return read_recordings(
        at(name), unpacked(at(name), read_bytes(at(name), settings.max_bytes), settings.max_bytes),
        settings);
  }
  std::string refusal(const std::string& text, const ReadSettings& settings) {
    return error_of([&] { read(text, settings); });
  }
};

const std::string kPlain = "t,d,F\n0,0,0.5\n0.1,1,1.5\n0.2,2,2.5\n";

TEST_F(ImportersTest, the_same_table_reads_alike_however_it_is_spelled) {
  ReadSettings brackets = axial();
  brackets.units = {};
  const std::vector<std::pair<std::string, ReadSettings>> spellings{
      {kPlain, axial()},
      {"\xEF\xBB\xBFt,d,F\r\n0,0,0.5\r\r\n0.1,1,1.5\n0.2,2,2.5", axial()},
      {"t\td\tF\n0\t0\t0,5\n0,1\t1\t1,5\n0,2\t2\t2,5\n", axial()},
      {"t;d;F\n0;0;0,5\n0,1;1;1,5\n0,2;2;2,5\n", axial()},
      {"# a rig\n# t d F\n 0 0  0.5\n0.1 1 1.5\n# hold\n0.2 2 2.5\n", axial()},
      {"name,value\nspeed,3\n\nt,d,F,extra\n0,0,0.5,x\n0.1,1,1.5,y\n0.2,2,2.5,\n", axial()},
      {"t (s),d [\xC2\xB5m],F (mN)\n0,0,500\n0.1,1000,1500\n0.2,2000,2500\n", brackets},
      {"\"t\",\"d\",\"F\"\n\"0\",\"0\",\"+0.5\"\n0.1,1,1.5\n0.2,2,25e-1\n", axial()},
  };
  for (const auto& [text, settings] : spellings) {
    const auto r = read(text, settings);
    ASSERT_EQ(r.size(), 1u);
    ASSERT_EQ(r[0].rows(), 3) << text;
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      EXPECT_DOUBLE_EQ(r[0].time_s[k], 0.1 * i) << text;
      EXPECT_DOUBLE_EQ(r[0].travel_m[k], 1e-3 * i) << text;
      EXPECT_DOUBLE_EQ(r[0].push_N[k], 0.5 + i) << text;
    }
  }
}

TEST_F(ImportersTest, latin_1_and_gzip_and_columns_by_number) {
  ReadSettings latin = axial();
  latin.encoding = "latin-1";
  latin.units.position = "";
  EXPECT_DOUBLE_EQ(read("t,d (\xb5m),F\n0,0,1\n1,5,2\n", latin)[0].travel_m[1], 5e-6);
  ReadSettings numbered = axial();
  numbered.columns = {};
  numbered.columns.depth = "#1";
  numbered.columns.force = {"-#2"};
  numbered.separator = ' ';
  EXPECT_DOUBLE_EQ(read("1,0 2,0\n3,5 4,0\n", numbered)[0].push_N[1], -4);
  const std::string name = at("a.csv.gz").string();
  gzFile packed = gzopen(name.c_str(), "wb");
  gzwrite(packed, kPlain.data(), static_cast<unsigned>(kPlain.size()));
  gzclose(packed);
  EXPECT_EQ(unpacked(at("a.csv.gz"), read_bytes(at("a.csv.gz"), 1 << 20), 1 << 20), kPlain);
}

TEST_F(ImportersTest, force_on_the_tool_changes_sign_and_a_minus_turns_a_column) {
  ReadSettings tool = axial();
  tool.is_force_on_tool = true;
  tool.columns.depth = "-d";
  const auto r = read(kPlain, tool);
  EXPECT_DOUBLE_EQ(r[0].push_N[2], -2.5);
  EXPECT_DOUBLE_EQ(r[0].travel_m[2], -2e-3);
}

TEST_F(ImportersTest, a_force_with_its_own_clock_has_rows_of_its_own) {
  ReadSettings s = axial();
  s.columns.force_time = "tf";
  const auto r = read("t,d,tf,F\n0,0,0,1\n1,1,0.5,2\n,,1,3\n", s)[0];
  EXPECT_EQ(r.time_s, (std::vector<double>{0, 1}));
  EXPECT_EQ(r.force_time_s, (std::vector<double>{0, 0.5, 1}));
  EXPECT_EQ(r.push_N, (std::vector<double>{1, 2, 3}));
}

TEST_F(ImportersTest, bad_files_are_named_with_their_line) {
  ReadSettings unknown = axial(), bracket = axial();
  unknown.units.force = "";
  bracket.units.force = "mN";
  EXPECT_EQ(refusal("t,d,Fz\n0,0,1\n", axial()), "a.csv:1: column `F` is missing");
  EXPECT_EQ(refusal("t,d,F,F\n0,0,1,1\n", axial()), "a.csv:1: column `F` comes twice");
  EXPECT_EQ(refusal("t,d,F\n0,0,1\n1,1,nan\n", axial()),
            "a.csv:3: column `F`: `nan` is not a number");
  EXPECT_EQ(refusal("t,d,F\n0,0,1\n1,1\n", axial()), "a.csv:3: column `F` has no value here");
  EXPECT_EQ(refusal("t,d,F\n0,0,1\n1,1,1e300\n", axial()),
            "a.csv:3: column `F`: `1e300` is out of range");
  EXPECT_EQ(refusal("t,d,F\n0,0,1\n1,1,1\xff\n", axial()), "a.csv:3: is not UTF-8 text");
  EXPECT_EQ(refusal("", axial()), "a.csv:1: is empty");
  EXPECT_EQ(refusal(" \n\n", axial()), "a.csv:1: is empty");
  EXPECT_EQ(refusal("t,d,F\n", axial()), "a.csv: has no row of numbers");
  EXPECT_EQ(refusal(kPlain, unknown), "a.csv:1: column `F` has no unit");
  EXPECT_EQ(refusal("t,d,F (N)\n0,0,1\n", bracket),
            "a.csv:1: column `F (N)` is in N, the manifest says mN");
  EXPECT_EQ(refusal(std::string("t,d\0F\n", 6), axial()), "a.csv:1: is binary data, not text");
  EXPECT_EQ(refusal(std::string("\xff\xfet\0,\0d", 7), axial()),
            "a.csv:1: is UTF-16 text that is damaged or cut short");
  EXPECT_EQ(refusal("t,d,F\n", {}), "a.csv:1: is in no format that is known by its beginning");
  EXPECT_EQ(refusal("\x1f\x8b\x08 broken", axial()), "a.csv: is a damaged gzip file");
  EXPECT_EQ(error_of([&] { read_bytes(at("none.csv"), 100); }), "none.csv: no such file");
}

TEST_F(ImportersTest, a_two_gigabyte_file_is_refused_without_being_read) {
  testing_io::write_quickly(at("huge.csv"), "t,d,F\n");
  fs::resize_file(at("huge.csv"), std::uintmax_t{2} << 30);
  EXPECT_EQ(error_of([&] { read_bytes(at("huge.csv"), ReadSettings{}.max_bytes); }),
            "huge.csv: holds more than 256 MiB");
}

TEST_F(ImportersTest, hdf5_columns_read_as_text_columns_do) {
  h5::Writer writer(at("a.h5"), "rig", {});
  const std::vector<double> t{0, 1, 2}, x{0, 0, 0, 1, 2, 3, 4, 5, 6}, f{1, 2, 3};
  writer.numbers("run/t", "s", t.data(), {3, 0});
  writer.numbers("run/x", "mm", x.data(), {3, 3});
  writer.numbers("run/f", "mN", f.data(), {3, 0});
  writer.commit();
  ReadSettings s;
  s.columns.time = "/run/t";
  s.columns.position = {"/run/x"};
  s.columns.force = {"run/f"};
  const auto r = read_recordings(at("a.h5"), read_bytes(at("a.h5"), 1 << 20), s);
  EXPECT_DOUBLE_EQ(r[0].position_m(2, 1), 5e-3);
  EXPECT_DOUBLE_EQ(r[0].push_N[2], 3e-3);
  s.columns.time = "run/none";
  EXPECT_EQ(error_of([&] { read_recordings(at("a.h5"), read_bytes(at("a.h5"), 1 << 20), s); }),
            "a.h5:run/none: data set is missing");
}

TEST_F(ImportersTest, a_reader_that_crashes_or_hangs_is_an_error_and_one_that_throws_is_left) {
  EXPECT_EQ(error_of([&] { rehearse(at("a.h5"), [] { std::raise(SIGSEGV); }); }),
            "a.h5: is damaged: the HDF5 library crashes on it");
  EXPECT_EQ(error_of([&] { rehearse(at("a.h5"), [] { std::raise(SIGXCPU); }); }),
            "a.h5: is damaged: the HDF5 library does not come to an end on it");
  EXPECT_NO_THROW(rehearse(at("a.h5"), [] { throw std::runtime_error("said by the parent"); }));
}

TEST_F(ImportersTest, a_damaged_hdf5_file_is_read_or_refused_and_the_program_lives) {
  h5::Writer writer(at("whole.h5"), "rig", {});
  const std::vector<double> t{0, 1, 2}, x{0, 1, 2}, f{1, 2, 3};
  writer.numbers("run/t_s", "s", t.data(), {3, 0});
  writer.numbers("run/depth_mm", "mm", x.data(), {3, 0});
  writer.numbers("run/F_N", "N", f.data(), {3, 0});
  writer.commit();
  const std::string whole = read_bytes(at("whole.h5"), 1 << 20);
  ReadSettings s;
  s.columns.time = "run/t_s", s.columns.depth = "run/depth_mm", s.columns.force = {"run/F_N"};
  SCOPED_TRACE(kSeed);
  std::mt19937 random(kSeed);
  int refused = 0;
  for (int k = 0; k < 60; ++k) {
    std::string bytes = whole;
    for (int n = 0; n < 4; ++n) bytes[8 + random() % (bytes.size() - 8)] = char(random());
    testing_io::write_quickly(at("a.h5"), bytes);
    try {
      EXPECT_EQ(read_recordings(at("a.h5"), bytes, s).size(), 1u) << k;
    } catch (const Error& error) {
      ++refused;
      EXPECT_FALSE(error.remedy().empty()) << k;
    }
  }
  EXPECT_GT(refused, 5);
}

const std::string kRobotHeader =
    "contact_x,contact_y,contact_z,normal_x,normal_y,normal_z,force_x,force_y,force_z,desired_x,"
    "desired_y,desired_z,current_x,current_y,current_z\n";

// Three rows of a robot's probe number `probe`, along z.
std::string robot_rows(int probe, int normal_z, int force_z) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    const std::string x = std::to_string(10 * probe) + ",0,";
    text += x + "0,0,0," + std::to_string(normal_z) + ",0,0," + std::to_string(force_z * i) + "," +
            x + std::to_string(-i) + "," + x + std::to_string(-0.9 * i) + "\n";
  }
  return text;
}

ReadSettings robot() {
  ReadSettings s;
  s.format = "robot-palpation";
  s.units = {"", "mm", "N"};
  return s;
}

TEST_F(ImportersTest, a_robot_file_gives_a_recording_per_contact_point) {
  ReadSettings s = robot();
  s.is_force_on_tool = true;
  s.is_normal_outward = true;
  const auto r = read(kRobotHeader + robot_rows(0, 2, 1) + robot_rows(1, 2, 1), s);
  ASSERT_EQ(r.size(), 2u);
  EXPECT_EQ(r[1].name, "contact2");
  EXPECT_EQ(*r[1].normal, Vec3(0, 0, -1));
  EXPECT_EQ(*r[1].contact_m, Vec3(0.01, 0, 0));
  EXPECT_DOUBLE_EQ(r[1].force_N(2, 2), -2);
  EXPECT_DOUBLE_EQ(r[1].position_m(2, 2), -1.8e-3);
}

// Robots write zeros for a probe that failed; once one of them cost the whole file.
TEST_F(ImportersTest, a_failed_probe_of_a_robot_refuses_itself_and_not_the_file) {
  ReadSettings s = robot();
  s.is_force_on_tool = false;
  const auto r =
      read(kRobotHeader + robot_rows(0, -1, -1) + robot_rows(1, 0, -1) + robot_rows(2, -1, -1), s);
  ASSERT_EQ(r.size(), 3u);
  EXPECT_FALSE(r[0].unread);
  ASSERT_TRUE(r[1].unread);
  EXPECT_EQ(r[1].name, "contact2");
  EXPECT_EQ(r[1].unread->fact(), "the surface normal has no direction");
  EXPECT_TRUE(r[1].unread->where().ends_with(":5")) << r[1].unread->where();
  EXPECT_EQ(r[1].rows(), 0);
  EXPECT_FALSE(r[2].unread);
  EXPECT_EQ(r[2].name, "contact3");
  EXPECT_EQ(*r[2].contact_m, Vec3(0.02, 0, 0));
  EXPECT_EQ(refusal(kRobotHeader + robot_rows(0, 0, -1) + robot_rows(1, 0, -1), s),
            "a.csv:2: the surface normal has no direction");
}

const std::string kCompression =
    "EF10\nCylinder Diameter: 50mm;\nTime (s),Compression (mm),Load (N),Engineering Strain "
    "[-]\n0,0,0.1,0\n1,2,3,0\n";

// As the machines of the silicone phantoms' compression tests export it.
TEST_F(ImportersTest, a_compression_test_below_a_preamble_names_its_columns) {
  ReadSettings s;
  s.is_force_on_tool = false;
  const auto r = read(kCompression, s)[0];
  EXPECT_DOUBLE_EQ(r.travel_m[1], 2e-3);
  EXPECT_DOUBLE_EQ(r.push_N[1], 3);
}

TEST_F(ImportersTest, three_names_that_differ_in_an_axis_are_what_their_unit_says) {
  ReadSettings s;
  s.is_force_on_tool = false;
  const std::string rows = "\n0,1,2,3,4,5,6\n1,1,2,3,4,5,6\n";
  for (const char* header :
       {"clock [ms],stage_x [mm],stage_y [mm],stage_z [mm],load_x [mN],load_y [mN],load_z [mN]",
        "clock [ms],TipX (mm),TipY (mm),TipZ (mm),x_cell_mN,y_cell_mN,z_cell_mN"}) {
    const auto r = read(header + rows, s)[0];
    EXPECT_DOUBLE_EQ(r.time_s[1], 1e-3);
    EXPECT_TRUE(r.position_m.row(1).isApprox(Vec3(1e-3, 2e-3, 3e-3).transpose()));
    EXPECT_TRUE(r.force_N.row(1).isApprox(Vec3(4e-3, 5e-3, 6e-3).transpose()));
  }
  const std::string two = "aX (mm),aY (mm),aZ (mm),bX (mm),bY (mm),bZ (mm),F (N)";
  EXPECT_NE(refusal(two + rows, s), "") << "no guess between two";
}

// What the Python package afmformats writes: comments, one of which names the columns, and rows.
TEST_F(ImportersTest, a_table_of_afmformats_is_read_by_the_numbers_of_its_columns) {
  ReadSettings s = axial();
  s.columns.time = "#4", s.columns.depth = "-#2", s.columns.force = {"#1"};
  s.units = {"s", "m", "N"};
  const auto r = read(
      "# afmformats 0.13.3\n#\n# BEGIN METADATA\n# {\n#   \"spring constant\": 0.05\n# }\n"
      "# END METADATA\n#\n# force\theight (measured)\tsegment\ttime\n"
      "0\t-0\tFalse\t0\n1e-9\t-2e-6\tFalse\t0.0025\n",
      s, "a.tab")[0];
  EXPECT_DOUBLE_EQ(r.travel_m[1], 2e-6);
  EXPECT_DOUBLE_EQ(r.push_N[1], 1e-9);
}

std::string utf16(std::u16string_view text, bool is_little) {
  std::string bytes = is_little ? "\xff\xfe" : "\xfe\xff";
  for (const char16_t unit : text) {
    const char low = static_cast<char>(unit & 0xFF), high = static_cast<char>(unit >> 8);
    bytes += is_little ? low : high;
    bytes += is_little ? high : low;
  }
  return bytes;
}

TEST_F(ImportersTest, text_of_utf16_is_read_as_it_is_written) {
  const std::u16string_view text = u"t_s;x [\u00b5m];F_mN\r\n0;0;1\r\n1;2;3\r\n# \U0001F600\r\n";
  for (const bool is_little : {true, false}) {
    ReadSettings s;
    s.is_force_on_tool = false;
    const auto r = read(utf16(text, is_little), s)[0];
    EXPECT_DOUBLE_EQ(r.travel_m[1], 2e-6);
    EXPECT_DOUBLE_EQ(r.push_N[1], 3e-3);
  }
  EXPECT_EQ(refusal(utf16(u"t_s;x_mm;F_N\n0;0;1\n", true) + "1", axial()),
            "a.csv:3: is UTF-16 text that is damaged or cut short");
  EXPECT_EQ(refusal(utf16({u"t\n\xDC00", 3}, true), axial()),
            "a.csv:2: is UTF-16 text that is damaged or cut short");
}

TEST_F(ImportersTest, grams_of_a_balance_are_forces) {
  const std::string text = "t (s),d (mm),F (g)\n0,0,0\n1,1,100\n";
  ReadSettings s = axial();
  s.columns.time = "t", s.columns.depth = "d", s.columns.force = {"F"};
  s.units = {};
  EXPECT_DOUBLE_EQ(read(text, s)[0].push_N[1], 0.980665);
}

}  // namespace
}  // namespace palpate::importers
