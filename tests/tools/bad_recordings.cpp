// Rows of the table of bad inputs (bad_inputs_table_test.cpp).

#include <cmath>

#include "tests/support/matlab_file.hpp"
#include "tests/tools/bad_inputs.hpp"
#include "tests/tools/block_scene.hpp"

namespace palpate::tools::testing_support {
namespace {

BadInputRow in_manifest(const char* what, const std::string& manifest,
                        const std::string& recording = "t,d,F\n0,0,0\n1,1,1\n") {
  return {what, "import bad.toml -o s.h5", 1, {{"bad.toml", manifest}, {"a.csv", recording}}};
}

BadInputRow in_checked(const char* what, const char* command, const std::string& keys,
                       const std::string& recording = "a.csv") {
  std::string table = "t_s,d_mm,F_N\n";
  for (int i = 0; i < 60; ++i)
    table += std::to_string(0.1 * i) + "," + std::to_string(0.1 * i) + "," +
             std::to_string(i < 20 ? 0 : 1e-3 * (i - 20) * (i - 20)) + "\n";
  return {what,
          command,
          1,
          {{"bad.toml", keys +
                            "[defaults]\nforce_on = \"body\"\n"
                            "[[recording]]\nfile = \"" +
                            recording +
                            "\"\nposition = [\"0 mm\", \"0 mm\", \"0 mm\"]\nnormal = [0, 0, -1]\n"},
           {"a.csv", table}}};
}

const std::string kManifest = press_manifest("a.csv");

// A way in and out of a ball of 8 mm on 10 kPa, times factors.
std::string press_of(double depth_factor, double force_factor) {
  std::string text = "t,d,F\n";
  for (int i = 0; i <= 80; ++i) {
    const double travel_mm = 0.15 * (40 - std::abs(i - 40)),
                 depth_mm = std::max(0.0, travel_mm - 2);
    const double force_N =
        1e4 * 16 / 9 * std::sqrt(8e-3) * std::pow(1e-3 * depth_mm, 1.5) + 1e-4 * (i * 7 % 5 - 2);
    text += std::to_string(0.1 * i) + "," + std::to_string(depth_factor * travel_mm) + "," +
            std::to_string(force_factor * force_N) + "\n";
  }
  return text;
}

// A recording of an instrument that says itself what it holds.
BadInputRow in_recording(const char* what, const std::string& file, const std::string& content,
                         const std::string& keys = "") {
  return {what,
          "import bad.toml -o s.h5",
          1,
          {{"bad.toml", "[[recording]]\nfile = \"" + file + "\"\n" + keys}, {file, content}}};
}

}  // namespace

std::vector<BadInputRow> bad_recordings() {
  return {
      in_manifest("a manifest without recordings", ""),
      in_manifest("a recording that is missing", "[[recording]]\nfile = \"none.csv\"\n" +
                                                     kManifest.substr(kManifest.find("columns"))),
      in_manifest("an empty recording", kManifest, ""),
      in_manifest("a contact point that is none", "[defaults]\ncontact = \"5 mN\"\n" + kManifest),
      in_manifest("a force without a side", replaced(kManifest, "force_on = \"body\"", "")),
      {"a scene to calibrate without samples", "calibrate scene.toml -o c.toml", 2},
      {"a parameter that the law has not",
       "calibrate scene.toml --samples out/samples.h5 --free c10 -o c.toml"},
      in_recording("a JPK file", "a.jpk-force",
                   std::string("PK\3\4\x14\0", 6) + "segments/0/segment-header.properties"),
      in_recording("a zip file of something else", "a.zip", "PK\3\4 readme.txt"),
      in_recording("a spreadsheet", "a.ods",
                   "PK\3\4 application/vnd.oasis.opendocument.spreadsheet"),
      in_recording("a force curve of NanoScope", "a.spm", "\\*Force file list\r\n\\Version: 0x09"),
      in_recording("an Igor wave", "a.ibw",
                   std::string("\5\0\x2a\x1b", 4) + std::string(400, '\0')),
      in_recording("a TDMS file", "a.tdms", std::string("TDSm\x0e\0\0\0", 8)),
      in_recording("a MATLAB file without the variable", "a.mat",
                   palpate::testing_support::matlab_file(),
                   "columns = { depth = \"z\", force = \"M(:,2)\" }\nforce_on = \"body\"\n"
                   "units = { position = \"mm\", force = \"N\" }\n"),
      in_recording("a unit that is none behind a column's name", "a.csv",
                   "t_s,x_furlong,F_N\n0,0,0\n", "force_on = \"body\"\n"),
      in_recording("a unit that is not the header's", "a.csv", "t_s,x_mm,F_N\n0,0,0\n",
                   "force_on = \"body\"\nunits = { position = \"m\" }\n"),
      {"a folder of what are no recordings", "new notes --recordings -o m.toml"},
      in_checked("a manifest's key misspelt", "check bad.toml", "probes = 1\n"),
      in_checked("a manifest's fit as what it is not", "run bad.toml -o o",
                 "[fit]\nfamily = \"circles\"\n"),
      in_checked("held-out points of a name that none has", "check bad.toml",
                 "[validate]\nhold_out = [\"p7\"]\n"),
      in_checked("a manifest that holds every point out", "check bad.toml",
                 "[validate]\nhold_out = 1\n"),
      in_checked("a manifest to run quickly", "run bad.toml -o o --quick", ""),
      in_checked("a manifest where a scene belongs", "prepare bad.toml -o b.h5", ""),
      in_checked("a manifest to validate an asset with", "validate out/asset.palp bad.toml", ""),
      {"points of recordings to validate with",
       "validate out/asset.palp out/samples.h5 --points 5"},
      {"curves of recordings without their body",
       "validate out/asset.palp out/samples.h5 --curves out/curves.h5"},
      {"a folder of recordings without its option", "new notes -o m.toml"},
      {"a surface of a body", "surface out/body.h5 -o b.obj"},
      in_manifest("depth and force of the other sign, in and out", kManifest, press_of(-1, -1)),
      in_manifest("forces in mN said to be in N", kManifest, press_of(1, 1e3)),
      in_manifest("a recording in UTF-16 that is cut short", kManifest,
                  std::string("\xff\xfet\0,\0d", 7)),
      in_manifest("a tip of five metres", kManifest + "probe = { radius = \"5 m\" }\n"),
  };
}

}  // namespace palpate::tools::testing_support
