// Where recordings lie, as [registration] of a manifest says it.

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "tests/tools/command_line.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

constexpr double kAngle = 0.4, kShift_mm[] = {7, -5, 3};  // from body to rig, about z

std::string in_rig(double x, double y, double z, const char* unit) {
  std::ostringstream text;
  text.precision(12);
  const auto put = [&](double value, const char* end) {
    if (*unit)
      text << '"' << value << ' ' << unit << '"' << end;
    else
      text << value << end;
  };
  put(std::cos(kAngle) * x - std::sin(kAngle) * y + kShift_mm[0], ", ");
  put(std::sin(kAngle) * x + std::cos(kAngle) * y + kShift_mm[1], ", ");
  put(z + kShift_mm[2], "");
  return "[" + text.str() + "]";
}

// A ball's cap, bumpy enough that no turn of it lies on itself.
double height_mm(double x, double y) {
  return 10 - 0.01 * (x * x + 2 * y * y) + 0.8 * std::sin(0.2 * x) * std::cos(0.3 * y + 0.5);
}

class RegistrationTest : public testing::Test {
 protected:
  // Robot recordings at the nodes of a coarse grid: down along z in the rig's frame, all clean.
  void SetUp() override {
    folder_.write("body.off", sheet_off(20, [](std::ostream& out, int i, int j) {
                    const double x = 2 * i - 20, y = 2 * j - 20;
                    out << x << ' ' << y << ' ' << height_mm(x, y);
                  }));
    for (int k = 0; k < 25; ++k) write_press(k);
  }
  void write_press(int k) const {
    const double x = 8 * (k % 5) - 16, y = 8 * (k / 5) - 16;
    std::ostringstream text;
    text << "t,x,y,z,fx,fy,fz\n";
    for (int i = 0; i < 120; ++i) {
      const double above = 1 - 0.03 * i;
      const std::string at = in_rig(x, y, height_mm(x, y) + above, "");
      text << 0.01 * i << ',' << at.substr(1, at.size() - 2) << ",0,0,"
           << -0.5 * std::max(0.0, -above) + 1e-5 * (i % 3) << '\n';
    }
    folder_.write("p" + std::to_string(10 + k) + ".csv", text.str());
  }
  Outcome run(const std::string& registration,
              const std::string& surface = "surface = \"body.off\"\nlength_unit = \"mm\"\n") const {
    folder_.write("manifest.toml", surface + registration + R"(
[defaults]
columns = { time = "t", position = ["x", "y", "z"], force = ["fx", "fy", "fz"] }
units = { time = "s", position = "mm", force = "N" }
force_on = "body"
normal = [0, 0, -1]
probe = { shape = "flat", radius = "2 mm" }
[[recording]]
file = "p*.csv"
)");
    return palpate(folder_, "import --force manifest.toml -o samples.h5");
  }
  static std::string landmarks(double off_mm) {
    std::string text = "[registration]\nlandmarks = [\n";
    const double at[4][3] = {{-20, -20, 0}, {20, -20, 2}, {20, 20, 0}, {-20, 20, 5}};
    for (const auto& p : at) {
      std::ostringstream body;
      body << "[\"" << p[0] + off_mm << " mm\", \"" << p[1] << " mm\", \"" << p[2] << " mm\"]";
      text += "{ rig = " + in_rig(p[0], p[1], p[2], "mm") + ", body = " + body.str() + " },\n";
    }
    return text + "]\n";
  }
  static std::string transform(const char* tail) {
    std::ostringstream text;
    text.precision(12);
    const double c = std::cos(kAngle), s = std::sin(kAngle), x = -1e-3 * kShift_mm[0],
                 y = -1e-3 * kShift_mm[1];
    text << "[registration]\ntransform = [" << c << ',' << s << ",0," << c * x + s * y << ',' << -s
         << ',' << c << ",0," << -s * x + c * y << ",0,0,1," << -1e-3 * kShift_mm[2] << tail
         << "]\n";
    return text.str();
  }
  static double after(const std::string& text, const std::string& words) {
    const auto at = text.find(words);
    EXPECT_NE(at, std::string::npos) << words << " in:\n" << text;
    return at == std::string::npos ? 1e9 : std::stod(text.substr(at + words.size()));
  }

  Folder folder_;
};

TEST_F(RegistrationTest, a_transform_or_landmarks_put_recordings_on_the_surface) {
  const Outcome given = run(transform(",0,0,0,1"));
  EXPECT_EQ(given.status, 0) << given.err;
  EXPECT_LT(after(given.err, "25 recordings lie "), 0.1) << given.err;
  const Outcome found = run(landmarks(0));
  EXPECT_EQ(found.status, 0) << found.err;
  EXPECT_LT(after(found.err, "landmarks: 4 pairs, residual "), 1e-6);
  EXPECT_LT(after(found.err, "25 recordings lie "), 0.1) << found.err;
}

TEST_F(RegistrationTest, icp_mends_landmarks_that_are_off) {
  const Outcome off = run(landmarks(1.5));
  const Outcome mended = run(landmarks(1.5) + "icp = true\n");
  EXPECT_EQ(mended.status, 0) << mended.err;
  EXPECT_LT(after(mended.err, "surface: residual "), 0.1) << mended.err;
  EXPECT_LT(3 * after(mended.err, "25 recordings lie "), after(off.err, "25 recordings lie "));
}

TEST_F(RegistrationTest, recordings_in_the_wrong_frame_are_refused) {
  const Outcome outcome = run("place_tolerance = \"1 mm\"\n");
  EXPECT_NE(outcome.status, 0);
  EXPECT_TRUE(holds(outcome.err, "from the surface"));
}

TEST_F(RegistrationTest, mistakes_are_named) {
  const auto error = [&](const std::string& registration) {
    const Outcome outcome = run(registration);
    EXPECT_EQ(outcome.status, 1) << outcome.err;
    return outcome.err;
  };
  EXPECT_TRUE(holds(error(transform(",0,0,0,2")), "transform is no rigid motion"));
  EXPECT_TRUE(holds(error(transform(",0,0,1")), "is not a list of 16 numbers"));
  std::string both = landmarks(0);
  both += transform(",0,0,0,1").substr(std::string("[registration]\n").size());
  EXPECT_TRUE(holds(error(both), "registration has both a transform and landmarks"));
  EXPECT_TRUE(holds(error("[registration]\nlandmark = []\n"), "Did you mean \"landmarks\"?"));
  std::string two = landmarks(0);
  two = two.substr(0, two.find("},", two.find("},") + 2) + 2) + "]\n";
  EXPECT_TRUE(holds(error(two), "landmark"));
  const Outcome bare = run("[registration]\nicp = true\n", "");
  EXPECT_EQ(bare.status, 1);
  EXPECT_TRUE(holds(bare.err, "icp needs a surface"));
}

}  // namespace
}  // namespace palpate::tools
