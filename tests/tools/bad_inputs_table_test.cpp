// The table of bad inputs: each is answered with what it says in docs/bad-inputs.md, word for word.
// PALPATE_WRITE_DOCS=1 writes that page anew from the rows below.

#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <set>

#include "tests/support/afm_files.hpp"
#include "tests/tools/block_scene.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;
namespace afm = palpate::testing_support;

struct BadInput {
  const char* what;     ///< is wrong
  std::string command;  ///< run in a folder that holds what a good run left, and `files`
  int status = 1;
  std::vector<std::pair<std::string, std::string>> files = {};
};

// The good scene with one thing changed.
std::string scene_with(const std::string& from, const std::string& to) {
  std::string text = kScene;
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::logic_error("no \"" + from + "\" in the scene");
  return text.replace(at, from.size(), to);
}

BadInput in_scene(const char* what, const std::string& from, const std::string& to,
                  const char* command = "check bad.toml") {
  return {what, command, 1, {{"bad.toml", scene_with(from, to)}}};
}

BadInput in_manifest(const char* what, const std::string& manifest,
                     const std::string& recording = "t,d,F\n0,0,0\n1,1,1\n") {
  return {what, "import bad.toml -o s.h5", 1, {{"bad.toml", manifest}, {"a.csv", recording}}};
}

BadInput in_tests(const char* what, const std::string& keys, const char* options = "",
                  const std::string& table = "0,0\n-0.1,-1\n-0.2,-3\n") {
  return {what,
          std::string("calibrate bad.toml -o c.toml") + options,
          1,
          {{"bad.toml", "[material]\nyoung = \"1 kPa\"\n[[test]]\nfile = \"a.csv\"\n" + keys},
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
BadInput in_recording(const char* what, const std::string& file, const std::string& content,
                      const std::string& keys = "") {
  return {what,
          "import bad.toml -o s.h5",
          1,
          {{"bad.toml", "[[recording]]\nfile = \"" + file + "\"\n" + keys}, {file, content}}};
}

afm::Parts jpk_without(const std::string& part) {
  auto parts = afm::jpk_curve();
  parts.erase(part);
  return parts;
}

std::vector<BadInput> bad_inputs() {
  const std::string fixed = "fixed = [ { below = { axis = \"z\", at = \"1 mm\" } } ]\n";
  const std::string window =
      "region = { box = [[\"20 mm\", \"20 mm\", \"29 mm\"], [\"60 mm\", \"60 mm\", \"31 mm\"]] }";
  const auto mesh = [](const char* what, const std::string& content) {
    return BadInput{what,
                    "check bad.toml",
                    1,
                    {{"bad.toml", scene_with("block.off", "bad.off")}, {"bad.off", content}}};
  };
  return {
      {"no command", "", 2},
      {"a command misspelt", "simulat scene.toml -o s.h5", 2},
      {"an option misspelt", "fit out/samples.h5 --out c.h5", 2},
      {"an option that no command has", "run scene.toml -o o --fast", 2},
      {"an output left out", "fit out/samples.h5", 2},
      {"an input left out", "inspect", 2},
      {"a word where a number belongs", "run scene.toml -o o --jobs many", 2},
      {"one argument too many", "inspect out/body.h5 out/samples.h5", 2},
      {"quiet and verbose at once", "inspect out/body.h5 --quiet --verbose", 2},
      {"a scene that is missing", "run none.toml -o o"},
      {"an empty scene", "run bad.toml -o o", 1, {{"bad.toml", ""}}},
      {"a folder as a scene", "run out -o o"},
      {"a mesh as a scene", "check block.off"},
      {"an asset as a scene", "run out/asset.palp.copy -o o"},
      {"a scene cut in the middle", "run bad.toml -o o", 1, {{"bad.toml", kScene.substr(0, 90)}}},
      in_scene("a key misspelt", "depth =", "detph ="),
      in_scene("a section misspelt", "[probe]", "[prob]"),
      in_scene("a length where a pressure belongs", "\"10 kPa\"", "\"10 mm\""),
      in_scene("a pressure without a number", "\"10 kPa\"", "\"kPa\""),
      in_scene("a unit that is none", "\"8 mm\"", "\"8 furlong\""),
      in_scene("a text where a number belongs", "press_steps = 5", "press_steps = \"five\""),
      in_scene("a negative modulus", "\"10 kPa\"", "\"-10 kPa\""),
      in_scene("an incompressible body", "poisson = 0.45", "poisson = 0.5"),
      in_scene("a law that is none", "young = ", "law = \"jelly\"\nyoung = "),
      in_scene("a constant of another law",
               "young = ", "law = \"yeoh\"\nc10 = \"2 kPa\"\nyoung = "),
      in_scene("a constant of the law left out", "young = \"10 kPa\"\n", "law = \"yeoh\"\n"),
      in_scene("a relaxation that is a list of numbers", "poisson = 0.45",
               "relaxation = [0.5, 0.1]"),
      in_scene("a relaxation whose times fall", "poisson = 0.45",
               "relaxation = [[0.5, \"1 s\"], [0.5, \"0.1 s\"]]"),
      in_scene("a relaxation of a law of one piece", "poisson = 0.45",
               "law = \"st-venant-kirchhoff\"\nrelaxation = [[0.5, \"1 s\"]]"),
      in_scene("a relaxation with an element of one piece", "[material]",
               "element = \"tet10\"\n[material]\nrelaxation = [[0.5, \"1 s\"]]"),
      in_scene("a softening without its r", "poisson = 0.45", "softening = { m = \"200 Pa\" }"),
      in_scene("a softening beside a relaxation", "poisson = 0.45",
               "softening = { r = 2, beta = 0.1 }\nrelaxation = [[0.5, \"1 s\"]]"),
      in_scene("a speed that is a length", "causes = false", "causes = false\nspeeds = [\"1 mm\"]"),
      in_scene("pairs of a tool that is no ball",
               "radius = \"8 mm\"\nfriction = 0.3\n[experiments]\n",
               "shape = \"flat\"\nradius = \"8 mm\"\n[experiments]\npairs = 4\n"),
      in_scene("a tool without balls", "[experiments]",
               "[tool]\nshape = \"capsule\"\nradius = \"8 mm\"\nlength = \"30 mm\"\n[experiments]"),
      in_scene("a tool of more balls than the engine plays", "[experiments]",
               "[tool]\nshape = \"capsule\"\nradius = \"8 mm\"\nlength = \"30 mm\"\nballs = 9\n"
               "[experiments]"),
      in_scene(
          "a tool of balls where the probe is none",
          "radius = \"8 mm\"\nfriction = 0.3\n[experiments]\n",
          "shape = \"flat\"\nradius = \"8 mm\"\n[tool]\nshape = \"sphere\"\nradius = \"8 mm\"\n"
          "balls = [[0, 0, \"8 mm\"]]\n[experiments]\n"),
      in_scene("a probe that is none", "radius = \"8 mm\"", "shape = \"spheer\""),
      in_scene("a key of another probe", "radius = \"8 mm\"",
               "radius = \"8 mm\"\nlength = \"9 mm\""),
      in_scene("a probe larger than the body", "radius = \"8 mm\"", "radius = \"400 mm\""),
      in_scene("a depth beyond the body", "depth = \"4 mm\"", "depth = \"60 mm\""),
      in_scene("a negative depth", "depth = \"4 mm\"", "depth = \"-4 mm\""),
      in_scene("a drag deeper than the presses", "drag_depths = [\"3 mm\"]",
               "drag_depths = [\"6 mm\"]"),
      in_scene("no test points", "test_points = 4", "test_points = 0"),
      in_scene("a tolerance beside a number of points", "test_points = 4",
               "test_points = 4\ntolerance = 0.05"),
      in_scene("a mesh and a tetrahedral mesh", "length_unit",
               "tetmesh = \"block.msh\"\nlength_unit"),
      in_scene("no unit of the mesh", "length_unit = \"mm\"\n", ""),
      in_scene("a blank that does not break", "length_unit =", "length_unit\xC2\xA0="),
      in_scene("a unit of the mesh that is none", "length_unit = \"mm\"", "length_unit = \"mmm\""),
      in_scene("nothing held", fixed, ""),
      in_scene("held beside the body", "at = \"1 mm\"", "at = \"-100 mm\""),
      in_scene("held as a whole", "at = \"1 mm\"", "at = \"100 mm\""),
      in_scene("a window beside the surface", "\"29 mm\"], [\"60 mm\", \"60 mm\", \"31 mm\"]",
               "\"39 mm\"], [\"60 mm\", \"60 mm\", \"41 mm\"]"),
      in_scene("two windows at once", "region = {",
               "region = { disc = { center = [0.04, 0.04, 0.03], radius = \"20 mm\" },"),
      in_scene("a window that names nothing", window, "region = {}"),
      in_scene("a side that is none", window, "region = { facing = \"up\" }"),
      in_scene("a disc beside the surface", window,
               "region = { disc = { center = [0.04, 0.04, 0.1], radius = \"20 mm\" } }"),
      in_scene("an inclusion outside the body", "[probe]",
               "[[inclusion]]\nsphere = { center = [\"0 mm\", \"0 mm\", \"300 mm\"], radius = \"5 "
               "mm\" }\nmaterial = { young = \"40 kPa\" }\n[probe]"),
      in_scene(
          "a bed on which the body slides away", fixed,
          "# nothing is held\n[[bed]]\nbelow = { axis = \"z\", at = \"1 mm\" }\nthickness = \"10 "
          "mm\"\nslides = true\nmaterial = { young = \"2 kPa\" }\n"),
      in_scene("a bed without a thickness", "[probe]",
               "[[bed]]\nbelow = { axis = \"z\", at = \"1 mm\" }\nmaterial = { young = \"2 kPa\" "
               "}\n[probe]"),
      in_scene("a group that the mesh has not", fixed, "fixed = [ { group = \"base\" } ]\n"),
      in_scene("a colour that is none", fixed, "fixed = [ { colour = \"red\" } ]\n"),
      in_scene("a colour of a mesh without", fixed, "fixed = [ { colour = \"#ff0000\" } ]\n"),
      in_scene("a field without a value", fixed, "fixed = [ { field = \"label\" } ]\n"),
      {"a group misspelt",
       "check bad.toml",
       1,
       {{"bad.toml",
         "[body]\nsurface = \"bad.obj\"\nlength_unit = \"mm\"\nfixed = [ { group = \"bottom\" } "
         "]\n[material]\nyoung = \"10 kPa\"\n"},
        {"bad.obj",
         "v 0 0 0\nv 80 0 0\nv 0 80 0\nv 0 0 80\ng base\nf 1 3 2\ng sides\nf 1 2 4\nf 2 3 4\n"
         "f 3 1 4\n"}}},
      in_scene("a weight that is too much for the body", "[probe]",
               "[gravity]\nacceleration = [0, 0, -4000]\n[probe]"),
      in_scene("a density without gravity", "[probe]",
               "[[inclusion]]\nsphere = { center = [0.04, 0.04, 0.015], radius = \"5 mm\" }\n"
               "material = { young = \"40 kPa\" }\ndensity = 1900\n[probe]"),
      in_scene("no acceleration", "[probe]", "[gravity]\nacceleration = [0, 0, 0]\n[probe]"),
      {"an inclusion of an open surface",
       "check bad.toml",
       1,
       {{"bad.toml", std::string(scene_with("[probe]",
                                            "[[inclusion]]\ninside = \"bad.off\"\nmaterial = { "
                                            "young = \"40 kPa\" }\n[probe]"))},
        {"bad.off", "OFF\n4 2 0\n0 0 0\n100 0 0\n100 100 0\n0 100 0\n3 0 1 2\n3 0 2 3\n"}}},
      in_scene("a mesh that is missing", "block.off", "none.off"),
      in_scene("a folder as a mesh", "block.off", "out"),
      in_scene("a mesh format that is none", "block.off", "scene.toml"),
      mesh("an empty mesh", ""),
      mesh("a mesh cut in the middle", block_off(8).substr(0, 2000)),
      mesh("a mesh of words", "OFF\n8 12 0\nnot numbers\n"),
      mesh("a surface without an inside",
           "OFF\n4 2 0\n0 0 0\n100 0 0\n100 100 0\n0 100 0\n3 0 1 2\n3 0 2 3\n"),
      {"a wrap of an open sheet",
       "check bad.toml",
       1,
       {{"bad.toml", scene_with("block.off\"", "bad.off\"\nwrap = \"2 mm\"")},
        {"bad.off", "OFF\n4 2 0\n0 0 0\n100 0 0\n100 100 0\n0 100 0\n3 0 1 2\n3 0 2 3\n"}}},
      in_scene("a probe of 8 m", "radius = \"8 mm\"", "radius = 8"),
      in_scene("a depth of 4 m", "depth = \"4 mm\"", "depth = 4"),
      in_scene("a window of bare numbers",
               "box = [[\"20 mm\", \"20 mm\", \"29 mm\"], [\"60 mm\", \"60 mm\", \"31 mm\"]]",
               "box = [[20, 20, 29], [60, 60, 31]]"),
      {"points that the tool cannot touch",
       "check bad.toml",
       1,
       {{"bad.toml", scene_with("test_points = 4", "test_points = \"p.csv\"")},
        {"p.csv", "x_m,y_m,z_m,nx,ny,nz\n0.04,0.04,0.03,1,0,0\n"}}},
      {"a file as the folder of a run", "run scene.toml -o block.off"},
      {"a folder that cannot be made", "run scene.toml -o /proc/palpate/out"},
      {"a file in a folder that cannot be written", "prepare scene.toml -o /proc/palpate/body.h5"},
      {"a scene as its own output", "prepare scene.toml -o scene.toml"},
      {"a folder as an output", "fit out/samples.h5 -o out"},
      {"a table to stdout", "tabulate out/curves.h5 -o -"},
      {"a run to stdout", "run scene.toml -o -"},
      {"an input as its own output", "fit out/samples.h5 -o out/samples.h5"},
      {"an output that is another kind of file", "fit out/samples.h5 -o out/body.h5"},
      {"a scene that is there already", "new block.off -o scene.toml"},
      {"no mesh to make a scene of", "new none.off -o new.toml"},
      {"a tissue that is none", "new block.off -o new.toml --tissue lver"},
      {"a held side that is none", "new block.off -o new.toml --held up"},
      {"a unit that is none for a new scene", "new block.off -o new.toml --unit furlong"},
      {"curves where a body belongs", "simulate out/curves.h5 -o s.h5"},
      {"a shard that is none", "simulate out/body.h5 --shard 5/4 -o shards"},
      {"a folder without shards", "merge out -o s.h5"},
      {"a folder without a study", "study status out"},
      {"a place that no study runs on", "study s.toml -o st --on moon"},
      {"a study without a scene", "study bad.toml -o st", 1, {{"bad.toml", "scale = true\n"}}},
      {"points without columns",
       "simulate out/body.h5 -o s.h5 --points p.csv",
       1,
       {{"p.csv", "1,2,3\n"}}},
      {"a point far from the surface",
       "simulate out/body.h5 -o s.h5 --points p.csv",
       1,
       {{"p.csv", "x_m,y_m,z_m\n9,9,9\n"}}},
      {"a path without rows",
       "simulate out/body.h5 -o s.h5 --paths p.csv",
       1,
       {{"p.csv", "path,x_m,y_m,z_m,dx_m,dy_m,dz_m\n"}}},
      {"a manifest that is missing", "import none.toml -o s.h5"},
      in_manifest("a manifest without recordings", ""),
      in_manifest("a recording that is missing", "[[recording]]\nfile = \"none.csv\"\n" +
                                                     kManifest.substr(kManifest.find("columns"))),
      in_manifest("a column that is missing", kManifest, "t,x,F\n0,0,0\n"),
      in_manifest("an empty recording", kManifest, ""),
      in_manifest("a contact point that is none", "[defaults]\ncontact = \"5 mN\"\n" + kManifest),
      in_manifest("a force without a side",
                  std::string(kManifest).replace(kManifest.find("force_on"), 18, "")),
      {"a scene to calibrate without samples", "calibrate scene.toml -o c.toml"},
      {"curves where samples to calibrate with belong",
       "calibrate scene.toml --samples out/curves.h5 -o c.toml"},
      {"a parameter that the law has not",
       "calibrate scene.toml --samples out/samples.h5 --free c10 -o c.toml"},
      in_tests("tests of specimens beside samples", "strain = 1\nstress = 2\nunit = \"kPa\"\n",
               " --samples out/samples.h5"),
      in_tests("a stress without a unit", "strain = 1\nstress = 2\n"),
      in_tests("a test without a strain", "stress = 2\nunit = \"kPa\"\n"),
      in_tests("a column of a test that is none", "strain = \"e\"\nstress = 2\nunit = \"kPa\"\n"),
      in_tests("a stretch of zero", "stretch = 1\nstress = 2\nunit = \"kPa\"\n"),
      in_tests("a test of a kind that is none",
               "strain = 1\nstress = 2\nunit = \"kPa\"\nkind = \"biaxial\"\n"),
      in_tests("a test without rows", "strain = 1\nstress = 2\nunit = \"kPa\"\n", "", ""),
      {"a model that is none", "modulus bad.toml -o m.csv --models herz"},
      {"no press to have a modulus of",
       "modulus bad.toml -o m.csv",
       1,
       {{"bad.toml", kManifest + "kind = \"path\"\n"}, {"a.csv", "t,d,F\n0,0,0\n"}}},
      in_recording("a JPK file cut in the middle", "a.jpk-force",
                   afm::zip_of(afm::jpk_curve()).substr(0, 3000)),
      in_recording("a JPK file with a password", "a.jpk-force",
                   afm::zip_of(afm::jpk_curve(), "secret")),
      in_recording("a JPK file without a spring constant", "a.jpk-force",
                   afm::zip_of(afm::jpk_curve(false))),
      in_recording("a JPK file without its deflection", "a.jpk-force",
                   afm::zip_of(jpk_without("segments/0/channels/vDeflection.dat"))),
      in_recording("a zip file of something else", "a.zip", afm::zip_of({{"readme.txt", "a"}})),
      in_recording("an Igor wave cut in the middle", "a.ibw", afm::igor_wave().substr(0, 5000)),
      in_recording("a MATLAB file without the variable", "a.mat", afm::matlab_file(),
                   "columns = { depth = \"z\", force = \"M(:,2)\" }\nforce_on = \"body\"\n"
                   "units = { position = \"mm\", force = \"N\" }\n"),
      in_recording("a unit that is none behind a column's name", "a.csv",
                   "t_s,x_furlong,F_N\n0,0,0\n", "force_on = \"body\"\n"),
      in_recording("a unit that is not the header's", "a.csv", "t_s,x_mm,F_N\n0,0,0\n",
                   "force_on = \"body\"\nunits = { position = \"m\" }\n"),
      {"samples that are missing", "fit none.h5 -o c.h5"},
      {"a body where samples belong", "fit out/body.h5 -o c.h5"},
      {"samples cut in the middle", "fit cut.h5 -o c.h5"},
      {"a text where samples belong", "fit scene.toml -o c.h5"},
      {"a family of curves that is none", "fit out/samples.h5 -o c.h5 --family ring"},
      {"a degree out of range", "fit out/samples.h5 -o c.h5 --degree 9"},
      {"samples where a body belongs", "refine out/curves.h5 --body out/samples.h5 -o m.h5"},
      {"a share of slopes out of range",
       "refine out/curves.h5 --body out/body.h5 -o m.h5 --slope-share 2"},
      {"curves where a model belongs", "export out/curves.h5 -o a.palp"},
      {"a format that is none", "export out/model.h5 -o a.palp --format obj"},
      {"a name of no format", "export out/model.h5 -o a.obj"},
      {"a name without a format", "export out/model.h5 -o asset"},
      {"a format that is not the name's", "export out/model.h5 -o a.vtu --format palp"},
      {"a depth that is none", "export out/model.h5 -o a.ply --format ply --depth deep"},
      {"a choice that is none", "export out/model.h5 -o a.palp --elsewhere some"},
      {"an asset that is missing", "replay none.palp path.csv -o f.csv"},
      {"an asset cut in the middle", "replay cut.palp path.csv -o f.csv"},
      {"an asset with one byte changed", "replay changed.palp path.csv -o f.csv"},
      {"a table where an asset belongs", "replay path.csv path.csv -o f.csv"},
      {"a path without times",
       "replay out/asset.palp bad.csv -o f.csv",
       1,
       {{"bad.csv", "x_m,y_m,z_m\n0,0,0\n"}}},
      {"a path with a word in it",
       "replay out/asset.palp bad.csv -o f.csv",
       1,
       {{"bad.csv", "t_s,x_m,y_m,z_m\n0,0,zero,0\n"}}},
      {"a path for what is no asset", "new block.off --path -o p.csv"},
      {"a path with semicolons",
       "replay out/asset.palp bad.csv -o f.csv",
       1,
       {{"bad.csv", "t_s;x_m;y_m;z_m\n0;0,04;0,04;0,031\n"}}},
      {"a path in mm",
       "replay out/asset.palp bad.csv -o f.csv",
       1,
       {{"bad.csv", "t_s,x_m,y_m,z_m\n0,40,40,31\n0.1,40,40,28\n"}}},
      {"a negative rate", "replay out/asset.palp path.csv -o f.csv --realtime -5"},
      {"the scene of another body",
       "validate out/asset.palp other.toml",
       1,
       {{"other.toml", scene_with("block.off", "other.off")}, {"other.off", block_off(9)}}},
      {"no held-out points", "validate out/asset.palp scene.toml --points -1"},
      {"curves without their model", "validate out/asset.palp scene.toml --curves out/curves.h5"},
      {"a body where samples to predict belong", "predict out/model.h5 out/body.h5"},
      {"a text to inspect", "inspect scene.toml"},
      {"an empty file to inspect", "inspect empty", 1, {{"empty", ""}}},
      {"no steps of a table", "tabulate out/curves.h5 -o t.csv --steps 0"},
      {"a body to tabulate", "tabulate out/body.h5 -o t.csv"},
      {"bands of an asset", "tabulate out/asset.palp -o t.csv --band"},
      {"a report of a folder that is missing", "report none -o r.html"},
      {"a report of a folder without a run", "report empty_folder -o r.html"},
      {"a benchmark that is none", "bench speed", 2},
      {"fewer threads than none", "fit out/samples.h5 -o c.h5 --jobs -1"},
      {"more threads than a machine has", "fit out/samples.h5 -o c.h5 --jobs 100000"},
      {"a device as a scene", "check /dev/null"},
      in_manifest("depth and force of the other sign, in and out", kManifest, press_of(-1, -1)),
      in_manifest("forces in mN said to be in N", kManifest, press_of(1, 1e3)),
      in_manifest("a recording in UTF-16 that is cut short", kManifest,
                  std::string("\xff\xfet\0,\0d", 7)),
      in_manifest("a tip of five metres", kManifest + "probe = { radius = \"5 m\" }\n"),
      {"a list of models that ends with a comma", "modulus bad.toml -o m.csv --models hertz,"},
      {"a page of somebody else's in the folder of a run",
       "run scene.toml -o .",
       1,
       {{"report.html", "my notes\n"}}},
      {"a table of somebody else's beside an output",
       "modulus bad.toml -o m.csv",
       1,
       {{"m.models.csv", "my notes\n"}}},
      {"an empty word where a number belongs", "fit out/samples.h5 -o c.h5 --jobs ''", 2},
      in_scene("a drag depth named twice", "drag_depths = [\"3 mm\"]",
               "drag_depths = [\"3 mm\", \"2 mm\", \"3 mm\"]"),
      {"two points at one place",
       "simulate out/body.h5 -o s.h5 --points p.csv",
       1,
       {{"p.csv", "x_m,y_m,z_m\n0.04,0.04,0.03\n0.05,0.04,0.03\n0.04,0.04,0.03\n"}}},
      {"two test points of a scene at one place",
       "check bad.toml",
       1,
       {{"bad.toml", scene_with("test_points = 4", "test_points = \"p.csv\"")},
        {"p.csv", "x_m,y_m,z_m\n0.04,0.04,0.03\n0.04,0.04,0.03\n"}}},
      {"a path of mm in columns of metres",
       "simulate out/body.h5 -o s.h5 --paths p.csv",
       1,
       {{"p.csv", "path,x_m,y_m,z_m,dx_m,dy_m,dz_m\na,0.04,0.04,0.03,0,0,-3\n"}}},
      {"an output without a name", "run scene.toml -o ''", 2},
      {"an output behind =", "fit out/samples.h5 -o=c.h5", 2},
      {"a path that goes out of the body",
       "simulate out/body.h5 -o s.h5 --paths p.csv",
       1,
       {{"p.csv", "path,x_m,y_m,z_m,dx_m,dy_m,dz_m\na,0.04,0.04,0.03,0,0,0.001\n"}}},
      in_tests("strain and stress of one column", "strain = 1\nstress = 1\nunit = \"kPa\"\n"),
      in_scene("a mesh size of 20 m", "mesh_size = \"20 mm\"", "mesh_size = 20"),
      {"an engine for a picture", "export out/model.h5 -o a.ply --engine e"},
      {"points beside paths",
       "simulate out/body.h5 -o s.h5 --points p.csv --paths p.csv",
       1,
       {{"p.csv", "x_m,y_m,z_m\n0.04,0.04,0.03\n"}}},
      {"a depth of what has every depth", "export out/model.h5 -o a.palp --depth '5 mm'"},
      {"a file as the folder of the engine", "export out/model.h5 -o a.palp --engine block.off"},
      {"a file as the folder of figures", "report out --figures block.off"},
  };
}

class BadInputs : public testing::Test {
 protected:
  void SetUp() override {
    folder.write("scene.toml", kScene);
    folder.write("block.off", block_off(8));
    folder.write("path.csv", "t_s,x_m,y_m,z_m\n0,0.04,0.04,0.031\n0.1,0.04,0.04,0.028\n");
    fs::create_directory(folder / "empty_folder");
    const Outcome run = at("run scene.toml -o out");
    ASSERT_EQ(run.status, 0) << run.err;
    const std::string samples = content_of(folder / "out/samples.h5");
    std::string asset = content_of(folder / "out/asset.palp");
    folder.write("out/asset.palp.copy", asset);
    folder.write("cut.h5", samples.substr(0, samples.size() / 2));
    folder.write("cut.palp", asset.substr(0, asset.size() / 2));
    asset[asset.size() / 2] ^= 1;
    folder.write("changed.palp", asset);
  }
  // As a user in the folder, so that answers hold no other path.
  Outcome at(const std::string& arguments) const {
    const fs::path before = fs::current_path();
    fs::current_path(folder.path());
    const Outcome outcome = palpate(folder, arguments);
    fs::current_path(before);
    return outcome;
  }
  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
      if (const std::string name = entry.path().filename();
          !name.starts_with('.') && name.find(".import.") == std::string::npos)
        names.insert(name);  // an import keeps its list of refusals
    return names;
  }
  Folder folder;
};

// "palpate: error: WHERE: WHAT" and the remedy of the line below.
struct Said {
  std::string what, remedy;
};
Said read(const std::string& err) {
  // A recording is refused in a list before the error that none is left.
  static const std::regex pattern("(?:palpate: error|refused): ([^\n]*: [^\n]*)\n  ([^\n]+)");
  std::smatch found;
  if (!std::regex_search(err, found, pattern)) return {};
  return {found[1], found[2]};
}

std::string cell(std::string text) {
  static const std::regex size(
      "eof = [0-9]+");  // of samples that another simulator may make larger
  text = std::regex_replace(text, size, "eof = N");
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2)
    text.replace(at, 1, "\\|");
  return text;
}

TEST_F(BadInputs, are_answered_with_place_fact_and_remedy_as_the_page_says) {
  const std::vector<BadInput> inputs = bad_inputs();
  EXPECT_GE(inputs.size(), 60u);
  std::string page =
      "# Bad inputs\n\nEvery command says where it is, what is wrong and what to do, writes "
      "nothing, and ends with status 1 (bad input or surroundings) or 2 (wrong usage). The folder "
      "of these commands holds what `run scene.toml -o out` left on a block of 80 x 80 x 30 mm; "
      "`bad.*` has what the first column says, and meshes are named with the scene's folder before "
      "them. `tests/tools/bad_inputs_table_test.cpp` compares "
      "this table with what the program answers, and writes it.\n\n"
      "| wrong | command | status | answer |\n|---|---|---|---|\n";
  std::set<std::string> commands;
  for (const BadInput& input : inputs) {
    SCOPED_TRACE(input.what + std::string(": palpate ") + input.command);
    for (const auto& [name, content] : input.files) folder.write(name, content);
    const std::set<std::string> before = files();
    Outcome outcome = at(input.command);
    const std::string here = folder.path().string() + "/";  // where the scene is, which says so
    for (std::size_t found; (found = outcome.err.find(here)) != std::string::npos;)
      outcome.err.erase(found, here.size());
    EXPECT_EQ(files(), before);
    for (const auto& file : input.files) fs::remove(folder / file.first);
    EXPECT_EQ(outcome.status, input.status) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    const Said said = read(outcome.err);
    EXPECT_NE(said.remedy, "") << outcome.err;
    for (const std::string& sign : {std::string("internal"), std::string("report this"),
                                    std::string("std::"), fs::temp_directory_path().string()})
      EXPECT_EQ(outcome.err.find(sign), std::string::npos) << outcome.err;
    page += "| " + std::string(input.what) + " | `palpate" + (input.command.empty() ? "" : " ") +
            input.command + "` | " + std::to_string(outcome.status) + " | " + cell(said.what) +
            "<br>" + cell(said.remedy) + " |\n";
    commands.insert(input.command.substr(0, input.command.find(' ')));
  }
  for (const char* command : {"run", "new", "check", "prepare", "simulate", "merge", "import",
                              "calibrate", "fit", "refine", "export", "replay", "validate",
                              "predict", "inspect", "tabulate", "report", "study", "bench"})
    EXPECT_TRUE(commands.contains(command)) << command;
  const fs::path docs = fs::path(PALPATE_SOURCE_DIR) / "docs/bad-inputs.md";
  if (std::getenv("PALPATE_WRITE_DOCS") != nullptr) std::ofstream(docs) << page;
  EXPECT_EQ(content_of(docs), page) << "run this test with PALPATE_WRITE_DOCS=1 and look at it";
}

}  // namespace
}  // namespace palpate::tools
