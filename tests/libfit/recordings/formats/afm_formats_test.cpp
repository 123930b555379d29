// Formats of atomic force microscopes and of MATLAB, and columns that name themselves.

#include <gtest/gtest.h>
#include <zlib.h>

#include <random>

#include "libfit/io/hdf5/hdf5.hpp"
#include "libfit/recordings/formats/importers.hpp"
#include "tests/libfit/io/scratch.hpp"
#include "tests/support/afm_files.hpp"
#include "tests/support/shared_data.hpp"

namespace palpate::importers {
namespace {

using namespace testing_support;
using testing_io::error_of;
using testing_io::write_quickly;

class AfmFormatsTest : public testing_io::ScratchTest {
 protected:
  std::vector<RawRecording> read(const std::string& bytes, const ReadSettings& settings = {}) {
    write_quickly(at("a"), bytes);
    return read_recordings(at("a"), bytes, settings);
  }
  std::string refusal(const std::string& bytes, const ReadSettings& settings = {}) {
    return error_of([&] { read(bytes, settings); });
  }
};

ReadSettings with_cantilever(double stiffness_N_m, double sensitivity_m) {
  ReadSettings settings;
  settings.cantilever = Cantilever{stiffness_N_m, sensitivity_m, 0, 0};
  return settings;
}

// A manifest's columns of a one-axis table in mm and N on the body.
ReadSettings axial(const std::string& time, const std::string& depth, const std::string& force) {
  ReadSettings settings;
  settings.columns.time = time;
  settings.columns.depth = depth;
  settings.columns.force = {force};
  settings.units = {"s", "mm", "N"};
  return settings;
}

std::string all_of(const std::vector<std::string>& phrases) {
  std::string text;
  for (const std::string& phrase : phrases) text += phrase + "; ";
  return text;
}

void expect_the_press(const RawRecording& r, double tolerance_m) {
  ASSERT_EQ(r.rows(), 2 * kWayRows);
  for (int i = 0; i < 2 * kWayRows; i += 7) {
    const auto k = static_cast<std::size_t>(i);
    EXPECT_NEAR(r.travel_m[k] - r.travel_m[0], press_travel_m(i), tolerance_m) << i;
    EXPECT_NEAR(r.push_N[k], press_force_N(i), kSpring_N_m * tolerance_m) << i;
  }
}

TEST_F(AfmFormatsTest, the_same_press_comes_out_of_every_format) {
  for (const auto& [format, bytes] :
       {std::pair<std::string, std::string>{"jpk", zip_of(jpk_curve())},
        {"jpk", zip_of(jpk_map(1))},
        {"igor", igor_wave()},
        {"afmformats", afmformats_table()}}) {
    const auto r = read(bytes);
    ASSERT_EQ(r.size(), 1u) << format;
    EXPECT_EQ(r[0].format, format);
    expect_the_press(r[0], 2e-13);
    EXPECT_EQ(r[0].retract_begins, std::optional<Eigen::Index>(kWayRows)) << format;
    ASSERT_EQ(r[0].time_s.size(), 800u) << format;
    EXPECT_NEAR(r[0].time_s[kWayRows], 1, 1e-9) << format;
    EXPECT_NE(all_of(r[0].taken).find("spring constant 0.05 N/m; sensitivity 80 nm per unit"),
              std::string::npos)
        << format << all_of(r[0].taken);
    ASSERT_TRUE(r[0].contact_m && r[0].normal) << format;
    EXPECT_EQ(*r[0].normal, Vec3(0, 0, -1));
  }
  const ReadSettings matrix = axial("t_s", "M(:,1)", "M(:,2)");
  const auto r = read(matlab_file(), matrix);
  EXPECT_EQ(r[0].format, "matlab");
  expect_the_press(r[0], 1e-15);
}

TEST_F(AfmFormatsTest, a_jpk_map_is_a_recording_per_curve_at_its_place) {
  const auto r = read(zip_of(jpk_map(3)));
  ASSERT_EQ(r.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(r[i].name, std::to_string(i));
    EXPECT_NEAR((*r[i].contact_m - Vec3(1e-5 * double(i), 5e-6, 0)).norm(), 0, 1e-15);
    expect_the_press(r[i], 2e-13);
  }
}

TEST_F(AfmFormatsTest, a_bad_curve_of_a_jpk_map_leaves_the_others) {
  Parts map = jpk_map(3);
  map.erase("index/1/segments/1/channels/vDeflection.dat");
  const auto r = read(zip_of(map));
  ASSERT_EQ(r.size(), 3u);
  ASSERT_TRUE(r[1].unread);
  EXPECT_EQ(r[1].unread->fact(), "channel `vDeflection` is missing");
  expect_the_press(r[0], 2e-13), expect_the_press(r[2], 2e-13);
}

TEST_F(AfmFormatsTest, a_jpk_pause_stands_between_the_ways_with_its_time) {
  const auto r = read(zip_of(jpk_curve(true, 200)));
  ASSERT_EQ(r[0].rows(), 1000);
  EXPECT_FALSE(r[0].retract_begins);
  EXPECT_NEAR(r[0].push_N[500], press_force_N(kWayRows), 1e-14);
  for (std::size_t i = 1; i < 1000; ++i) ASSERT_GT(r[0].time_s[i], r[0].time_s[i - 1]);
}

TEST_F(AfmFormatsTest, the_manifest_s_cantilever_stands_over_the_file_s) {
  for (const std::string& bytes : {zip_of(jpk_curve()), igor_wave(), afmformats_table()}) {
    const auto own = read(bytes)[0], stiffer = read(bytes, with_cantilever(0.1, 0))[0],
               longer = read(bytes, with_cantilever(0.05, 160e-9))[0];
    const std::size_t most = kWayRows - 1;
    EXPECT_NEAR(stiffer.push_N[most], 2 * own.push_N[most], 1e-15);
    EXPECT_NEAR(stiffer.travel_m[most], own.travel_m[most], 1e-15);
    EXPECT_NEAR(longer.push_N[most], 2 * own.push_N[most], 1e-15);
    EXPECT_NEAR(longer.travel_m[most], own.travel_m[most] - own.push_N[most] / 0.05, 1e-15);
    EXPECT_EQ(all_of(longer.taken).find("spring constant"), std::string::npos);
  }
}

TEST_F(AfmFormatsTest, every_encoding_of_jpk_gives_its_numbers) {
  const auto with = [](const std::string& type, const std::string& content) {
    Parts parts = jpk_curve();
    std::string& header = parts["segments/0/segment-header.properties"];
    const std::string from = "channel.vDeflection.data.encoder.type=signedinteger";
    header.replace(header.find(from), from.size(), "channel.vDeflection.data.encoder.type=" + type);
    parts["segments/0/channels/vDeflection.dat"] = content;
    std::string height;
    for (int i = 0; i < 2; ++i) height += big_endian(std::int32_t{-1000 * i});
    parts["segments/0/channels/measuredHeight.dat"] = height;
    return zip_of(parts);
  };
  const double newton = 1e-8 * kSensitivity_m * kSpring_N_m;
  for (const auto& [type, content, first, second] :
       {std::tuple<std::string, std::string, double, double>{
            "signedshort", big_endian(std::int16_t{-5}) + big_endian(std::int16_t{300}), -5, 300},
        {"unsignedshort", big_endian(std::uint16_t{65000}) + big_endian(std::uint16_t{1}), 65000,
         1},
        {"unsignedinteger", big_endian(4000000000u) + big_endian(7u), 4e9, 7},
        {"signedlong", big_endian(std::int64_t{-9}) + big_endian(std::int64_t{1} << 40), -9,
         1099511627776.0},
        {"float", big_endian(2.5f) + big_endian(-1.25f), 2.5, -1.25}}) {
    const auto r = read(with(type, content))[0];
    EXPECT_NEAR(r.push_N[0], first * newton, 1e-12 * newton * std::abs(first)) << type;
    EXPECT_NEAR(r.push_N[1], second * newton, 1e-12 * newton * std::abs(second)) << type;
  }
  EXPECT_EQ(refusal(with("signedshort", "abc")),
            "a#segments/0/channels/vDeflection.dat: has 3 bytes, which are no numbers of 2");
  EXPECT_EQ(refusal(with("braille", "ab")),
            "a#segments/0/segment-header.properties: channel `vDeflection` is stored as `braille`, "
            "which is not known");
}

TEST_F(AfmFormatsTest, what_is_wrong_with_a_file_of_an_instrument_is_named_with_its_part) {
  const std::string good = zip_of(jpk_curve());
  EXPECT_EQ(refusal(good.substr(0, good.size() / 2)),
            "a: is a zip file that is cut short or damaged");
  EXPECT_EQ(refusal(zip_of(jpk_curve(), "secret")),
            "a#segments/0/segment-header.properties: is encrypted");
  EXPECT_EQ(refusal(zip_of({{"readme.txt", "a"}})),
            "a: is a zip file without a JPK force curve (segments/0)");
  EXPECT_EQ(refusal(zip_of(jpk_curve(false))),
            "a#segments/0/segment-header.properties: states no spring constant");
  EXPECT_EQ(read(zip_of(jpk_curve(false)), with_cantilever(0.05, 0)).size(), 1u);
  Parts without = jpk_curve();
  without.erase("segments/0/channels/measuredHeight.dat");
  EXPECT_EQ(refusal(zip_of(without)),
            "a#segments/0/channels: has no channel of the height in metres");
  ReadSettings small;
  small.max_bytes = 1 << 10;
  EXPECT_EQ(refusal(good, small), "a: holds more than 0 MiB");
  std::string flipped = good;
  flipped[good.find("vDeflection.dat") + 40] ^= 64;
  EXPECT_NE(refusal(flipped).find("is damaged or packed in a way that is not known"),
            std::string::npos);
  std::string wave = igor_wave();
  EXPECT_EQ(refusal(wave.substr(0, 5000)), "a: is an Igor wave that is cut short");
  wave.replace(wave.rfind("Defl"), 4, "Ampl");
  EXPECT_EQ(refusal(wave), "a: has no channel `Defl`");
  const std::string table = afmformats_table();
  EXPECT_EQ(refusal(std::string(table).replace(table.find("force\t"), 5, "power")),
            "a:12: has no column `force`");
  EXPECT_EQ(refusal(std::string(table).replace(table.find("\"spring"), 7, "\"no")),
            "a:12: states no spring constant");
}

TEST_F(AfmFormatsTest, a_nanoscope_curve_goes_in_and_back_by_its_sensor_or_its_ramp) {
  for (const bool has_sensor : {true, false}) {
    const auto r = read(nanoscope_curve(has_sensor));
    ASSERT_EQ(r.size(), 1u);
    EXPECT_EQ(r[0].format, "nanoscope");
    ASSERT_EQ(r[0].rows(), 2 * kWayRows);
    // A bit is 0.2 nm of the sensor and 16 pm of bending; the ramp is even, and the press is not.
    for (int i = 0; i < 2 * kWayRows; i += 7) {
      const auto k = static_cast<std::size_t>(i);
      EXPECT_NEAR(r[0].push_N[k], press_force_N(i), 1.7e-11 * kSpring_N_m) << i;
      if (has_sensor) {
        EXPECT_NEAR(r[0].travel_m[k] - r[0].travel_m[0], press_travel_m(i), 3e-10) << i;
      }
    }
    EXPECT_NEAR(r[0].travel_m[kWayRows - 1] - r[0].travel_m[0], press_travel_m(kWayRows - 1),
                3e-10);
    EXPECT_EQ(r[0].retract_begins, std::optional<Eigen::Index>(kWayRows));
    EXPECT_NEAR(r[0].time_s[kWayRows], 1, 1e-12);
    EXPECT_NEAR((*r[0].contact_m - Vec3(3e-6, 4e-6, 0)).norm(), 0, 1e-15);
    EXPECT_EQ(all_of(r[0].taken),
              std::string("spring constant 0.05 N/m; sensitivity 80 nm per unit; height of the ") +
                  (has_sensor ? "sensor" : "ramp") + "; position (3e-06, 4e-06, 0) m; ");
  }
  EXPECT_NEAR(read(nanoscope_curve(), with_cantilever(0.1, 0))[0].push_N[kWayRows - 1],
              2 * press_force_N(kWayRows - 1), 2e-12);
}

TEST_F(AfmFormatsTest, what_is_wrong_with_a_nanoscope_file_is_named) {
  const std::string good = nanoscope_curve();
  const auto with = [&](const std::string& from, const std::string& to) {
    std::string bytes = good;
    for (std::size_t at = 0; (at = bytes.find(from, at)) != std::string::npos; at += to.size())
      bytes.replace(at, from.size(), to);
    return bytes;
  };
  EXPECT_EQ(refusal(good.substr(0, 8400)), "a: is cut short: a channel lies beyond its end");
  EXPECT_EQ(refusal(good.substr(0, 600)),
            "a: has no end of its header: it is cut short or damaged");
  EXPECT_EQ(refusal(with("Bytes/pixel: 2", "Bytes/pixel: 4")),
            "a: stores numbers of 4 bytes, and those of 2 are read");
  EXPECT_EQ(refusal(with("[DeflectionError]", "[LateralFriction]")),
            "a: has no channel of the deflection");
  EXPECT_EQ(refusal(with("Data length: 1600", "Data length: 9600")),
            "a: holds a map of force curves");
  EXPECT_EQ(refusal(with("\\Spring Constant: 0.05", "\\Spring Constant: none")),
            "a: states no spring constant");
  EXPECT_EQ(refusal(with("Samps/line: 400 400", "Samps/line: NaN 400")),
            "a: does not say how many rows its curve has (Samps/line)");
  std::mt19937 random(4);
  for (int trial = 0; trial < 3000; ++trial) {
    std::string damaged = good;
    for (unsigned k = 0; k < 1 + random() % 4; ++k)
      damaged[random() % 1600] = static_cast<char>(random());
    try {
      for (const RawRecording& r : read_recordings("a", damaged, {}))
        for (const double value : r.push_N) ASSERT_TRUE(std::isfinite(value)) << trial;
    } catch (const Error&) {
    }
  }
}

// The name of a variable of a MATLAB file of version 7.3: HDF5 with rows and columns exchanged.
TEST_F(AfmFormatsTest, matlab_reads_alike_packed_or_not_and_from_version_7_3) {
  const std::string plain = matlab_file();
  const ReadSettings matrix = axial("t_s", "M(:,1)", "M(:,2)");
  std::string packed = plain.substr(0, 128);
  for (std::size_t first = 128, size = 0; first < plain.size(); first += size) {
    std::uint32_t data_bytes = 0;
    std::memcpy(&data_bytes, plain.data() + first + 4, 4);
    size = 8 + data_bytes;
    std::string out(compressBound(size), '\0');
    uLongf bytes = out.size();
    compress(reinterpret_cast<Bytef*>(out.data()), &bytes,
             reinterpret_cast<const Bytef*>(plain.data() + first), size);
    const std::uint32_t tag[] = {15, static_cast<std::uint32_t>(bytes)};
    packed.append(reinterpret_cast<const char*>(tag), sizeof tag).append(out.data(), bytes);
  }
  expect_the_press(read(packed, matrix)[0], 1e-15);

  std::vector<double> time, rows;
  for (int i = 0; i < 2 * kWayRows; ++i) time.push_back(0.0025 * i);
  for (int i = 0; i < 2 * kWayRows; ++i) rows.push_back(1e3 * press_travel_m(i));
  for (int i = 0; i < 2 * kWayRows; ++i) rows.push_back(press_force_N(i));
  h5::Writer writer(at("b.h5"), "rig", {});
  writer.numbers("t_s", "1", time.data(), {1, 2 * kWayRows});
  writer.numbers("M", "1", rows.data(), {2, 2 * kWayRows});
  writer.commit();
  std::string block = "MATLAB 7.3 MAT-file, Platform: GLNXA64";  // before HDF5's own bytes
  block.resize(512, ' ');
  const std::string bytes = block + read_bytes(at("b.h5"), 1 << 20);
  expect_the_press(read(bytes, matrix)[0], 1e-15);

  EXPECT_EQ(refusal(plain, axial("t_s", "depth", "M(:,2)")), "a:depth: variable is missing");
  EXPECT_EQ(refusal(plain, axial("t_s", "M", "M(:,2)")), "a:M: is a matrix of 2 columns");
  EXPECT_EQ(refusal(plain, axial("t_s", "M(:,3)", "M(:,2)")), "a:M(:,3): has 2 columns");
  EXPECT_EQ(refusal(plain), "a: no variable is named");
  EXPECT_EQ(refusal(plain.substr(0, plain.size() - 100), matrix), "a: is a damaged MATLAB file");
}

TEST_F(AfmFormatsTest, columns_that_name_quantity_and_unit_need_no_settings) {
  ReadSettings body;
  body.is_force_on_tool = false;
  for (const std::string header : {"t_s,x_mm,F_N", "t_s,z_mm,F_N", "time_s,depth_mm,force_N",
                                   "Time (s),Depth [mm],Load (N)", "speed_mm_s,t_s,d_mm,F_N"}) {
    const bool has_more = header.starts_with("speed");
    std::string text = header + "\n";
    for (int i = 0; i < 3; ++i)
      text += (has_more ? "9," : "") + std::to_string(0.1 * i) + "," + std::to_string(i) + "," +
              std::to_string(0.5 + i) + "\n";
    const auto r = read(text, body)[0];
    EXPECT_EQ(r.format, "csv") << header;
    EXPECT_NEAR(r.time_s[2], 0.2, 1e-12) << header;
    EXPECT_NEAR(r.travel_m[2], 2e-3, 1e-15) << header;
    EXPECT_NEAR(r.push_N[2], 2.5, 1e-12) << header;
    EXPECT_TRUE(r.taken.at(0).starts_with("columns ")) << r.taken[0];
  }
  const auto robot =
      read("t_ms\tx_mm\ty_mm\tz_um\tfx_mN\tfy_mN\tfz_N\n0\t1\t2\t3\t4\t5\t6\n", body)[0];
  EXPECT_NEAR((Vec3(robot.position_m.row(0)) - Vec3(1e-3, 2e-3, 3e-6)).norm(), 0, 1e-15);
  EXPECT_NEAR((Vec3(robot.force_N.row(0)) - Vec3(4e-3, 5e-3, 6)).norm(), 0, 1e-15);
  // The unit behind a name counts where columns are named, too.
  ReadSettings named = axial("t_s", "x_um", "F_mN");
  named.units = {};
  EXPECT_NEAR(read("t_s,x_um,F_mN\n0,5,7\n", named)[0].travel_m[0], 5e-6, 1e-18);
}

TEST_F(AfmFormatsTest, columns_that_name_themselves_badly_are_refused_with_the_remedy) {
  ReadSettings body;
  body.is_force_on_tool = false;
  EXPECT_EQ(refusal("t_s,x_furlong,F_N\n0,1,2\n", body),
            "a:1: column `x_furlong` is in `furlong`, which is no unit of length");
  EXPECT_EQ(refusal("t_s,x_mm,z_mm,F_N\n0,1,2,3\n", body),
            "a:1: columns `x_mm` and `z_mm` may both be the depth");
  EXPECT_EQ(refusal("t_s,x_mm,F_N\n0,1,2\n"),
            "a:1: force_on is missing: whose force the sensor reports");
  ReadSettings metres = body;
  metres.units.position = "m";
  EXPECT_EQ(refusal("t_s,x_mm,F_N\n0,1,2\n", metres),
            "a:1: column `x_mm` is in mm, the manifest says m");
  EXPECT_EQ(refusal("t,x,F\n0,1,2\n", body), "a:1: is in no format that is known by its beginning");
}

// Values that afmformats and nanite publish in their own tests of these files.
TEST(RealAfmFiles, published_forces_heights_and_cantilevers_are_met_to_the_last_digits) {
  PALPATE_NEEDS_DATA("data/indentation/afm");
  const auto folder = shared_data("data/indentation/afm");
  struct Published {
    const char* file;
    std::size_t curve, row;
    double force_N, height_m, stiffness_N_m;  // 0: not published
  };
  for (const Published& p : {
           Published{"fmt-jpk-fd_spot3-0192.jpk-force", 0, 0, -5.145579192349918e-10,
                     2.2815672438768612e-05, 0.043493666407368466},
           {"fmt-jpk-fd_spot3-0192.jpk-force", 0, 100, -4.853736717639109e-10,
            2.256791903750211e-05, 0.043493666407368466},
           {"fmt-jpk-fd_map2x2_extracted.jpk-force-map", 2, 0, -5.8540192943834714e-10,
            0.0001001727719556085, 0},
           {"fmt-jpk-fd_map0d_extracted.jpk-force-map", 0, 0, -4.7426862623854873e-10,
            7.0554296897149161e-05, 0},
           {"fmt-jpk-fd_2020.02.07-16.29.05.036.jpk-qi-data", 0, 0, -1.269014596090597e-10,
            4.716154783699957e-06, 0},
           {"fmt-tab-fd_version_0.13.3.tab", 0, 2000, -6.7762282e-10, 0, 0.02230065831827453},
           {"fmt-hdf5-fd_version_0.13.3.h5", 0, 2000, -7.038311459845539e-10, 0,
            0.02230065831827453},
       }) {
    if (!std::filesystem::exists(folder / p.file)) continue;
    const auto all = read_recordings(folder / p.file, read_bytes(folder / p.file, 1 << 28), {});
    const RawRecording& r = all.at(p.curve);
    EXPECT_NEAR(r.push_N[p.row], p.force_N, 1e-10 * std::abs(p.force_N)) << p.file;
    const double k = r.cantilever->stiffness_N_m,
                 height_m = -r.travel_m[p.row] - r.push_N[p.row] / k;
    if (p.stiffness_N_m > 0) {
      EXPECT_DOUBLE_EQ(k, p.stiffness_N_m) << p.file;
    }
    if (p.height_m > 0) {
      EXPECT_NEAR(height_m, p.height_m, 1e-10 * p.height_m) << p.file;
    }
  }
  if (const auto wave = folder / "fmt-igor-fd_U3_3_p10004.ibw"; std::filesystem::exists(wave)) {
    const auto r = read_recordings(wave, read_bytes(wave, 1 << 28), {}).at(0);
    EXPECT_EQ(r.rows(), 10097);
    EXPECT_DOUBLE_EQ(r.cantilever->stiffness_N_m, 0.31451);
    EXPECT_DOUBLE_EQ(r.cantilever->sensitivity_m, 2.0364e-07);
    EXPECT_NEAR(*std::max_element(r.push_N.begin(), r.push_N.end()), 1.778407e-07, 1e-14);
  }
}

}  // namespace
}  // namespace palpate::importers
