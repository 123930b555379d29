// Rows of the table of bad inputs (bad_inputs_table_test.cpp).

#include "tests/tools/bad_inputs.hpp"
#include "tests/tools/block_scene.hpp"

namespace palpate::tools::testing_support {
namespace {

BadInputRow in_scene(const char* what, const std::string& from, const std::string& to,
                     const char* command = "check bad.toml") {
  return {what, command, 1, {{"bad.toml", scene_with(from, to)}}};
}

}  // namespace

std::string scene_with(const std::string& from, const std::string& to) {
  return replaced(kScene, from, to);
}

std::vector<BadInputRow> bad_scenes() {
  const std::string fixed = "fixed = [ { below = { axis = \"z\", at = \"1 mm\" } } ]\n";
  const std::string window =
      "region = { box = [[\"20 mm\", \"20 mm\", \"29 mm\"], [\"60 mm\", \"60 mm\", \"31 mm\"]] }";
  const auto mesh = [](const char* what, const std::string& content) {
    return BadInputRow{what,
                       "check bad.toml",
                       1,
                       {{"bad.toml", scene_with("block.off", "bad.off")}, {"bad.off", content}}};
  };
  return {
      {"no command", "", 2},
      {"a command misspelt", "simulat scene.toml -o s.h5", 2},
      {"an option misspelt", "fit out/samples.h5 --out c.h5", 2},
      {"an output left out", "fit out/samples.h5", 2},
      {"a word where a number belongs", "run scene.toml -o o --jobs many", 2},
      {"a scene that is missing", "run none.toml -o o"},
      {"a mesh as a scene", "check block.off"},
      {"a scene cut in the middle", "run bad.toml -o o", 1, {{"bad.toml", kScene.substr(0, 90)}}},
      in_scene("a key misspelt", "depth =", "detph ="),
      in_scene("a length where a pressure belongs", "\"10 kPa\"", "\"10 mm\""),
      in_scene("a unit that is none", "\"8 mm\"", "\"8 furlong\""),
      in_scene("a text where a number belongs", "press_steps = 5", "press_steps = \"five\""),
      in_scene("a negative modulus", "\"10 kPa\"", "\"-10 kPa\""),
      in_scene("an incompressible body", "poisson = 0.45", "poisson = 0.5"),
      in_scene("a law that is none", "young = ", "law = \"jelly\"\nyoung = "),
      in_scene("a constant of the law left out", "young = \"10 kPa\"\n", "law = \"yeoh\"\n"),
      in_scene("a relaxation that is a list of numbers", "poisson = 0.45",
               "relaxation = [0.5, 0.1]"),
      in_scene("a softening beside a relaxation", "poisson = 0.45",
               "softening = { r = 2, beta = 0.1 }\nrelaxation = [[0.5, \"1 s\"]]"),
      in_scene("pairs of a tool that is no ball",
               "radius = \"8 mm\"\nfriction = 0.3\n[experiments]\n",
               "shape = \"flat\"\nradius = \"8 mm\"\n[experiments]\npairs = 4\n"),
      in_scene("a tool without balls", "[experiments]",
               "[tool]\nshape = \"capsule\"\nradius = \"8 mm\"\nlength = \"30 mm\"\n[experiments]"),
      in_scene("a tool of more balls than the engine plays", "[experiments]",
               "[tool]\nshape = \"capsule\"\nradius = \"8 mm\"\nlength = \"30 mm\"\nballs = 9\n"
               "[experiments]"),
      in_scene("a probe that is none", "radius = \"8 mm\"", "shape = \"spheer\""),
      in_scene("a probe larger than the body", "radius = \"8 mm\"", "radius = \"400 mm\""),
      in_scene("a depth beyond the body", "depth = \"4 mm\"", "depth = \"60 mm\""),
      in_scene("no test points", "test_points = 4", "test_points = 0"),
      in_scene("a mesh and a tetrahedral mesh", "length_unit",
               "tetmesh = \"block.msh\"\nlength_unit"),
      in_scene("no unit of the mesh", "length_unit = \"mm\"\n", ""),
      in_scene("nothing held", fixed, ""),
      in_scene("held beside the body", "at = \"1 mm\"", "at = \"-100 mm\""),
      in_scene("a window beside the surface", "\"29 mm\"], [\"60 mm\", \"60 mm\", \"31 mm\"]",
               "\"39 mm\"], [\"60 mm\", \"60 mm\", \"41 mm\"]"),
      in_scene(
          "a bed on which the body slides away", fixed,
          "# nothing is held\n[[bed]]\nbelow = { axis = \"z\", at = \"1 mm\" }\nthickness = \"10 "
          "mm\"\nslides = true\nmaterial = { young = \"2 kPa\" }\n"),
      {"a group misspelt",
       "check bad.toml",
       1,
       {{"bad.toml",
         "[body]\nsurface = \"bad.obj\"\nlength_unit = \"mm\"\nfixed = [ { group = \"bottom\" } "
         "]\n[material]\nyoung = \"10 kPa\"\n"},
        {"bad.obj",
         "v 0 0 0\nv 80 0 0\nv 0 80 0\nv 0 0 80\ng base\nf 1 3 2\ng sides\nf 1 2 4\nf 2 3 4\n"
         "f 3 1 4\n"}}},
      {"an inclusion of an open surface",
       "check bad.toml",
       1,
       {{"bad.toml", std::string(scene_with("[probe]",
                                            "[[inclusion]]\ninside = \"bad.off\"\nmaterial = { "
                                            "young = \"40 kPa\" }\n[probe]"))},
        {"bad.off", "OFF\n4 2 0\n0 0 0\n100 0 0\n100 100 0\n0 100 0\n3 0 1 2\n3 0 2 3\n"}}},
      in_scene("a mesh that is missing", "block.off", "none.off"),
      in_scene("a mesh format that is none", "block.off", "scene.toml"),
      mesh("a mesh cut in the middle", block_off(8).substr(0, 2000)),
      mesh("a compressed mesh", "\x1f\x8b\x08"),
      in_scene("a mesh in mm that is read as um", "length_unit = \"mm\"", "length_unit = \"um\""),
      mesh("a surface without an inside",
           "OFF\n4 2 0\n0 0 0\n100 0 0\n100 100 0\n0 100 0\n3 0 1 2\n3 0 2 3\n"),
      {"a wrap of an open sheet",
       "check bad.toml",
       1,
       {{"bad.toml", scene_with("block.off\"", "bad.off\"\nwrap = \"2 mm\"")},
        {"bad.off", "OFF\n4 2 0\n0 0 0\n100 0 0\n100 100 0\n0 100 0\n3 0 1 2\n3 0 2 3\n"}}},
      in_scene("a probe of 8 m", "radius = \"8 mm\"", "radius = 8"),
      in_scene("a window of bare numbers",
               "box = [[\"20 mm\", \"20 mm\", \"29 mm\"], [\"60 mm\", \"60 mm\", \"31 mm\"]]",
               "box = [[20, 20, 29], [60, 60, 31]]"),
      {"points that the tool cannot touch",
       "check bad.toml",
       1,
       {{"bad.toml", scene_with("test_points = 4", "test_points = \"p.csv\"")},
        {"p.csv", "x_m,y_m,z_m,nx,ny,nz\n0.04,0.04,0.03,1,0,0\n"}}},
      {"a file as the folder of a run", "run scene.toml -o block.off"},
      {"a file in a folder that cannot be written", "prepare scene.toml -o /proc/palpate/body.h5"},
      {"a folder as an output", "fit out/samples.h5 -o out"},
      {"a table to stdout", "tabulate out/curves.h5 -o -"},
      {"an input as its own output", "fit out/samples.h5 -o out/samples.h5"},
      {"an output that is another kind of file", "fit out/samples.h5 -o out/body.h5"},
      {"a scene that is there already", "new block.off -o scene.toml"},
      {"a tissue that is none", "new block.off -o new.toml --tissue lver"},
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
      {"a normal that points out of the body",
       "simulate out/body.h5 -o s.h5 --points p.csv",
       1,
       {{"p.csv", "x_m,y_m,z_m,nx,ny,nz\n0.04,0.04,0.03,0,0,1\n"}}},
      in_scene("a drag depth named twice", "drag_depths = [\"3 mm\"]",
               "drag_depths = [\"3 mm\", \"2 mm\", \"3 mm\"]"),
      {"two points at one place",
       "simulate out/body.h5 -o s.h5 --points p.csv",
       1,
       {{"p.csv", "x_m,y_m,z_m\n0.04,0.04,0.03\n0.05,0.04,0.03\n0.04,0.04,0.03\n"}}},
      {"a path of mm in columns of metres",
       "simulate out/body.h5 -o s.h5 --paths p.csv",
       1,
       {{"p.csv", "path,x_m,y_m,z_m,dx_m,dy_m,dz_m\na,0.04,0.04,0.03,0,0,-3\n"}}},
      {"a path that goes out of the body",
       "simulate out/body.h5 -o s.h5 --paths p.csv",
       1,
       {{"p.csv", "path,x_m,y_m,z_m,dx_m,dy_m,dz_m\na,0.04,0.04,0.03,0,0,0.001\n"}}},
  };
}

}  // namespace palpate::tools::testing_support
