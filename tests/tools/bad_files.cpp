// Rows of the table of bad inputs (bad_inputs_table_test.cpp).

#include "tests/tools/bad_inputs.hpp"
#include "tests/tools/block_scene.hpp"

namespace palpate::tools::testing_support {

std::vector<BadInputRow> bad_files() {
  return {
      {"a body where samples belong", "fit out/body.h5 -o c.h5"},
      {"samples cut in the middle", "fit cut.h5 -o c.h5"},
      {"a family of curves that is none", "fit out/samples.h5 -o c.h5 --family ring"},
      {"samples where a body belongs", "refine out/curves.h5 --body out/samples.h5 -o m.h5"},
      {"curves where a model belongs", "export out/curves.h5 -o a.palp"},
      {"a name of no asset", "export out/model.h5 -o a.obj"},
      {"an asset that is missing", "replay none.palp path.csv -o f.csv"},
      {"an asset cut in the middle", "replay cut.palp path.csv -o f.csv"},
      {"an asset with one byte changed", "replay changed.palp path.csv -o f.csv"},
      {"a path without times",
       "replay out/asset.palp bad.csv -o f.csv",
       1,
       {{"bad.csv", "x_m,y_m,z_m\n0,0,0\n"}}},
      {"a path with a word in it",
       "replay out/asset.palp bad.csv -o f.csv",
       1,
       {{"bad.csv", "t_s,x_m,y_m,z_m\n0,0,zero,0\n"}}},
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
      {"a text to inspect", "inspect scene.toml"},
      {"bands of an asset", "tabulate out/asset.palp -o t.csv --band"},
      {"a report of a folder without a run", "report empty_folder -o r.html"},
      {"more threads than a machine has", "fit out/samples.h5 -o c.h5 --jobs 100000"},
      {"a device as a scene", "check /dev/null"},
      {"a page of somebody else's in the folder of a run",
       "run scene.toml -o .",
       1,
       {{"report.html", "my notes\n"}}},
      {"an output behind =", "fit out/samples.h5 -o=c.h5", 2},
      {"a folder of a run that is not there", "report none -o r.html"},
  };
}

}  // namespace palpate::tools::testing_support
