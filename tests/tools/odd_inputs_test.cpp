// Recordings, scenes and paths as strangers have them: each is read, or refused with its reason.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "tests/tools/odd_inputs.hpp"
#include "tests/tools/odd_presses.hpp"

namespace palpate::tools {
namespace {

using Rows = std::vector<std::array<double, 3>>;

// Writes a line for each row: time {0}, depth {1}, force {2}, number {3}.
std::string lines(const std::string& header, const std::string& format,
                  const Rows& rows = press()) {
  std::string text = header + "\n";
  int number = 0;
  for (const auto& [t, d, f] : rows)
    text += fmt::format(fmt::runtime(format), t, d, f, ++number) + "\n";
  return text;
}

template <class Change>
Rows changed(Change&& change) {
  Rows rows = press();
  for (std::size_t i = 0; i < rows.size(); ++i) change(i, rows[i]);
  return rows;
}

// Delays the force by some readings, and takes its mean over some before.
Rows late_by(std::size_t readings, std::size_t mean_of = 1) {
  return changed([&, rows = press()](std::size_t i, std::array<double, 3>& row) {
    row[2] = 0;
    for (std::size_t k = 0; k < mean_of; ++k)
      row[2] += rows[i - std::min(i, readings + k)][2] / static_cast<double>(mean_of);
  });
}

constexpr const char* kHeader = "t_s,z_mm,F_N";
constexpr const char* kRow = "{0:.3f},{1:.5f},{2:.6f}";
constexpr const char* kPress =
    "press, 0\\.(19|20|21)\\d* N at (2\\.9|3)\\S* mm, contact (1\\.9[4-9]|2|2\\.0[0-5])\\S* \\+-.*"
    "(good|fair)";

std::vector<OddInput> odd_recordings() {
  const Rows pressed = press();
  const std::string plain = lines(kHeader, kRow);
  const auto of = [](const Rows& rows) { return lines(kHeader, kRow, rows); };
  const auto with = [&](auto&& change) { return of(changed(change)); };
  using Row = std::array<double, 3>;
  std::string nul = all_replaced(plain, "\n", std::string("\0\n", 2));
  return {
      {"sep= of a spreadsheet", "a.csv", "\xef\xbb\xbfsep=;\n" + all_replaced(plain, ",", ";"),
       kRead, kPress},
      {"a ball of 5 um for 5 mm", "a.csv", plain, kRead,
       "radii of its tip deep: is the unit of radius",
       "probe = { shape = \"sphere\", radius = \"5 um\" }\n"},
      {"row names of R without a header field, tidyverse/readr", "a.csv",
       lines("t_s z_mm F_N", "\"{3}\" {0:.3f} {1:.5f} {2:.6f}"), kRefused,
       "a.csv:1: the header names 3 columns, the rows have 4"},
      {"row numbers without a header field", "a.csv", lines("z_mm,F_N", "{3},{1:.5f},{2:.6f}"),
       kRefused, "the header names 2 columns, the rows have 3"},
      {"a comma for two things", "a.csv",
       "z_mm,F_N\n" + all_replaced(lines("", "{1:.4f},{2:.4f}").substr(1), ".", ","), kRefused,
       "the header names 2 columns, the rows have 4: a comma separates fields and is the decimal"},
      {"an index without a name, of pandas", "a.csv",
       lines(",t_s,z_mm,F_N", "{3},{0:.3f},{1:.5f},{2:.6f}"), kRead, kPress},
      {"commas that end rows", "a.csv", lines(kHeader, std::string(kRow) + ","), kRead, kPress},
      {"commas that begin rows", "a.csv", lines(kHeader, std::string(",") + kRow), kRefused,
       "the header names 3 columns, the rows have 4"},
      {"notes behind some rows", "a.csv", all_replaced(plain, "\n3.0", ",note\n3.0"), kRead,
       kPress},
      {"two logs", "a.csv", plain + plain, kRefused,
       "a.csv:503: column `t_s`: `t_s` is not a number"},
      {"two logs, one header", "a.csv", plain + plain.substr(plain.find('\n') + 1), kRefused,
       "a.csv:503: time goes back"},
      {"a clock of 16 bits", "a.csv",
       lines("t_ms,z_mm,F_N", "{:.0f},{:.5f},{:.6f}",
             changed([](std::size_t, Row& r) { r[0] = std::fmod(63000 + 1000 * r[0], 65536); })),
       kRefused, "time goes back"},
      {"a clock of 0.1 s", "a.csv", lines(kHeader, "{:.1f},{:.5f},{:.6f}"), kRefused,
       "the time stamp repeats"},
      {"no force", "a.csv", with([](std::size_t, Row& r) { r[2] = 0; }), kRefused, "no contact"},
      {"a stuck force", "a.csv", with([](std::size_t, Row& r) { r[2] = std::min(r[2], 0.1); }),
       kRead, "fair: \\d+ of 40 rows are saturated"},
      {"the other sign", "a.csv", with([](std::size_t, Row& r) { r[2] *= -1; }), kRefused,
       "the sign of force or depth is reversed"},
      {"a tare left on", "a.csv", with([](std::size_t, Row& r) { r[2] += 1; }), kRead, kPress},
      {"a spike", "a.csv", with([](std::size_t i, Row& r) { r[2] += i == 100 ? 1000 : 0; }), kRead,
       "1 single readings stand out"},
      {"micrometres called mm", "a.csv", with([](std::size_t, Row& r) { r[1] *= 1000; }), kRefused,
       "which no soft body is made of: is a unit wrong\\?"},
      {"the way back alone", "a.csv", of({pressed.begin() + 250, pressed.end()}), kRefused,
       "the tip never goes in"},
      {"a force that copies the depth", "a.csv", with([](std::size_t, Row& r) { r[2] = r[1]; }),
       kRead, "poor: begins in contact"},
      {"a force 0.1 s late", "a.csv", of(late_by(10)), kRead,
       "fair: unloading returns 13\\d % of the work of loading.*force_delay = \"0\\.(1|09\\d*) "
       "s\""},
      {"a force 0.5 s late", "a.csv", of(late_by(50)), kRead,
       "poor: .*force_delay = \"0\\.(5|49) s\""},
      {"a force filtered over 0.5 s", "a.csv", of(late_by(0, 50)), kRead,
       "poor: unloading returns.*force_delay"},
      {"units in cells", "a.csv", lines(kHeader, "{:.3f} s,{:.5f} mm,{:.6f} N"), kRefused,
       "column `t_s`: `0.000 s` is not a number"},
      {"exponents of Fortran", "a.csv",
       all_replaced(lines(kHeader, "{:.3f},{:.5e},{:.6f}"), "e", "D"), kRefused,
       "`0.00000D\\+00` is not a number"},
      {"hexadecimal", "a.csv", lines(kHeader, "{0:.3f},0x{3:x},{2:.6f}"), kRefused,
       "`0x1` is not a number"},
      {"inf", "a.csv",
       all_replaced(plain, lines("", kRow, {pressed[200]}).substr(1), "2.0,4.0,inf\n"), kRefused,
       "column `F_N`: `inf` is not a number"},
      {"a unit of the manifest that is not the header's", "a.csv", plain, kRefused,
       "column `F_N` is in N, the manifest says mN",
       "columns = { time = \"t_s\", depth = \"z_mm\", force = \"F_N\" }\nunits = { force = \"mN\" "
       "}"},
      {"one name twice", "a.csv", lines("t_s,z_mm,F_N,F_N", std::string(kRow) + ",9"), kRefused,
       "columns `F_N` and `F_N` may both be the force"},
      {"a row cut at the end", "a.csv", plain.substr(0, plain.size() - 12), kRefused,
       "a.csv:502: column `F_N` has no value here"},
      {"percent signs", "a.csv", "% made by x\n% " + plain, kRead, kPress, "comment = \"%\""},
      {"a spreadsheet by another name", "a.csv", std::string("PK\3\4", 4) + std::string(200, '\0'),
       kRefused, "is a zip file, which is not read"},
      {"no units", "a.csv", lines("t,z,F", kRow), kRefused, "column `t` has no unit",
       "columns = { time = \"t\", depth = \"z\", force = \"F\" }"},
      {"kN and m of a testing machine", "a.csv",
       lines("Time (s),Extension (m),Load (kN)", "{:.3f},{:.8f},{:.9f}",
             changed([](std::size_t, Row& r) { r[1] /= 1000, r[2] /= 1000; })),
       kRead, kPress, "columns = { time = \"Time\", depth = \"Extension\", force = \"Load\" }"},
      {"a typographic minus", "a.csv", all_replaced(plain, "-", "\xe2\x88\x92"), kRefused,
       "is not a number"},
      {"semicolons in the header alone", "a.csv", lines("t_s;z_mm;F_N", kRow), kRefused,
       "column `t_s`: `0.000,0.00000,"},
      {"blanks below tabs", "a.csv", lines("t_s\tz_mm\tF_N", "{:.3f}  {:.5f}  {:.6f}"), kRefused,
       "column `t_s`: `0.000  0.00000  "},
      {"blanks in quotes", "a.csv", lines(kHeader, "\" {:.3f} \",\" {:.5f} \",\" {:.6f} \""), kRead,
       kPress},
      {"rows twice", "a.csv", lines(kHeader, std::string(kRow) + "\n" + kRow), kRefused,
       "the time stamp repeats"},
      {"NUL bytes", "a.csv", nul, kRefused, "is binary data, not text"},
      {"an array of NumPy", "t_s.npy", "\x93NUMPY", kRefused,
       "of NumPy, which is not read\n.*numpy\\.savetxt\\("},
      {"arrays of NumPy", "a.npz",
       std::string("PK\3\4\0\0", 6) + "t_s.npy" + std::string(200, '\0'), kRefused,
       "of NumPy arrays, which is not read\n.*numpy\\.savetxt\\("},
  };
}

TEST(OddInputs, recordings_are_read_or_refused_with_the_reason) {
  const Folder folder;
  expect_answers(folder, odd_recordings(), [&](const OddInput& input) {
    folder.write("m.toml", manifest(input.file, "", kPlaced + input.keys));
    return "check m.toml";
  });
}

// Each scene has `keys` in place of `content`.
std::vector<OddInput> odd_scenes() {
  return {
      {"blanks in a quantity", "s", "\"10 kPa\"", kRead, "wrote", "\"  10   kPa  \""},
      {"a unit in lower case", "s", "\"10 kPa\"", kRefused, "\"10 kpa\", which is not a pressure",
       "\"10 kpa\""},
      {"psi", "s", "\"10 kPa\"", kRefused, "\"1.5 psi\", which is not a pressure", "\"1.5 psi\""},
      {"a decimal comma", "s", "\"10 kPa\"", kRefused, "\"5,4 kPa\", which is not a pressure",
       "\"5,4 kPa\""},
      {"a typographic minus", "s", "at = \"1 mm\"", kRefused, "which is not a length",
       "at = \"\xe2\x88\x92"
       "1 mm\""},
      {"a fraction", "s", "\"8 mm\"", kRefused, "\"1/2 mm\", which is not a length", "\"1/2 mm\""},
      {"no blank before a unit", "s", "\"8 mm\"", kRead, "wrote", "\"8mm\""},
      {"more than a number holds", "s", "\"8 mm\"", kRefused, "which is not a length",
       "\"1e400 mm\""},
      {"nan", "s", "\"8 mm\"", kRefused, "which is not a length", "\"nan mm\""},
      {"a friction of 30 %", "s", "friction = 0.3", kRead,
       "a friction of 30 is more than any tool has", "friction = 30"},
      {"a negative friction", "s", "friction = 0.3", kRefused, "friction of \\[probe\\] is -0.3",
       "friction = -0.3"},
      {"a friction as text", "s", "friction = 0.3", kRefused, "is a text, not a number",
       "friction = \"0.3\""},
      {"an angle without a unit", "s", "radius = \"8 mm\"", kRefused,
       "half_angle of \\[probe\\] is 60", "shape = \"cone\"\nhalf_angle = 60"},
      {"a key twice", "s", "poisson = 0.45", kRefused, "cannot redefine",
       "poisson = 0.45\npoisson = 0.3"},
      {"CR and LF", "s", "\n", kRead, "wrote", "\r\n"},
      {"corners swapped", "s",
       "[\"20 mm\", \"20 mm\", \"29 mm\"], [\"60 mm\", \"60 mm\", \"31 mm\"]", kRefused,
       "box of region of \\[experiments\\] is empty",
       "[\"60 mm\", \"60 mm\", \"31 mm\"], [\"20 mm\", \"20 mm\", \"29 mm\"]"},
      {"no held-out points", "s", "points = 2\n", kRefused, "points of \\[validate\\] is 0",
       "points = 0\n"},
      {"a tolerance of 2 %", "s", "tolerance = 0.02", kRefused, "tolerance of \\[fit\\] is 2",
       "tolerance = 2"},
      {"inches", "s", "length_unit = \"mm\"", kRefused, "surface: 2.03 x 2.03 x 0.762 m",
       "length_unit = \"in\""},
  };
}

TEST(OddInputs, scenes_are_read_or_refused_with_the_reason) {
  const Folder folder;
  folder.write("block.off", block_off(8));
  expect_answers(folder, odd_scenes(), [&](const OddInput& input) {
    EXPECT_TRUE(holds(kScene, input.content));
    folder.write("scene.toml", replaced(kScene, input.content, input.keys));
    return "prepare scene.toml -o body.h5";
  });
}

std::vector<OddInput> odd_paths() {
  const std::string header = "t_s,x_m,y_m,z_m", turned = header + ",qx,qy,qz,qw\n0,0,0,0,";
  return {
      {"time that goes back", "p.csv", header + "\n1,0,0,0\n0,0,0,0\n", kRefused,
       "p.csv:3: column `t_s` does not increase"},
      {"columns in mm", "p.csv", "t_s,x_mm,y_mm,z_mm\n0,0,0,0\n", kRefused,
       "column `x_mm` is not `x_m`"},
      {"NaN", "p.csv", header + "\n0,nan,0,0\n", kRefused, "column `x_m`: `nan` is not finite"},
      {"a quaternion of zeros", "p.csv", turned + "0,0,0,0\n", kRefused, "has the length 0"},
      {"a quaternion of length 2", "p.csv", turned + "0,0,0,2\n", kRefused, "has the length 2"},
      {"a quaternion cut short", "p.csv", header + ",qx,qy,qz\n0,0,0,0,0,0,0\n", kRefused,
       "has some of qx,qy,qz,qw but not all"},
      {"a path beside the body", "p.csv", header + "\n0,0,0,0.5\n1,0,0,0.4\n", kNoVerdict,
       "the path never touches the body"},
  };
}

TEST(OddInputs, paths_are_read_or_refused_with_the_reason) {
  const Folder folder;
  const std::string golden =
      std::string(PALPATE_SOURCE_DIR) + "/tests/libfit/runtime/golden/rings.palp";
  expect_answers(folder, odd_paths(),
                 [&](const OddInput&) { return "replay " + golden + " p.csv -o f.csv"; });
}

}  // namespace
}  // namespace palpate::tools
