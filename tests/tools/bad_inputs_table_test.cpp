// The table of bad inputs: each is answered with what it says in docs/bad-inputs.md, word for word.
// PALPATE_WRITE_DOCS=1 writes that page anew from the rows of bad_scenes.cpp, bad_recordings.cpp
// and bad_files.cpp.

#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "tests/tools/bad_inputs.hpp"
#include "tests/tools/block_scene.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

class BadInputs : public testing::Test {
 protected:
  void SetUp() override {
    // Of presses and one held-out point: no answer depends on drags, and they take most of a run.
    folder.write("scene.toml", replaced(scene_with("drag_depths = [\"3 mm\"]", "drag_depths = []"),
                                        "points = 2", "points = 1"));
    folder.write("path.csv", "t_s,x_m,y_m,z_m\n0,0.04,0.04,0.031\n0.1,0.04,0.04,0.028\n");
    fs::create_directory(folder / "empty_folder");
    fs::create_directory(folder / "notes");
    folder.write("notes/a.txt", "calibrated by hand on Monday\n");
    const Outcome run = palpate(folder, "run scene.toml -o out");
    ASSERT_EQ(run.status, 0) << run.err;
    const std::string samples = content_of(folder / "out/samples.h5");
    std::string asset = content_of(folder / "out/asset.palp");
    folder.write("out/asset.palp.copy", asset);
    folder.write("cut.h5", samples.substr(0, samples.size() / 2));
    folder.write("cut.palp", asset.substr(0, asset.size() / 2));
    asset[asset.size() / 2] ^= 1;
    folder.write("changed.palp", asset);
  }
  std::set<std::string> files() const {
    std::set<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
      if (const std::string name = entry.path().filename();
          !name.starts_with('.') && name.find(".import.") == std::string::npos)
        names.insert(name);  // an import keeps its list of refusals
    return names;
  }
  BlockFolder folder;
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
  std::vector<BadInputRow> inputs = bad_scenes();
  for (const auto& more : {bad_recordings(), bad_files()})
    inputs.insert(inputs.end(), more.begin(), more.end());
  EXPECT_GE(inputs.size(), 60u);
  std::string page =
      "# Bad inputs\n\nEvery command says where it is, what is wrong and what to do, writes "
      "nothing, and ends with status 1 (bad input or surroundings) or 2 (wrong usage, ² below). "
      "The folder of these commands holds what `run scene.toml -o out` left on a block of 80 x 80 "
      "x 30 mm; `bad.*` has what the first column says, and meshes are named with the scene's "
      "folder before them. An empty cell is the command above it. "
      "`tests/tools/bad_inputs_table_test.cpp` compares this table with what the program answers, "
      "and writes it.\n\n"
      "| wrong | `palpate` | answer |\n|---|---|---|\n";
  std::string above;
  std::set<std::string> commands;
  for (const BadInputRow& input : inputs) {
    SCOPED_TRACE(input.what + std::string(": palpate ") + input.command);
    for (const auto& [name, content] : input.files) folder.write(name, content);
    const std::set<std::string> before = files();
    Outcome outcome = palpate(folder, input.command);
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
      EXPECT_FALSE(holds(outcome.err, sign));
    page += "| " + std::string(input.what) + (input.status == 2 ? " ²" : "") + " |" +
            (input.command == above || input.command.empty() ? "" : " `" + input.command + "`") +
            " | " + cell(said.what) + "<br>" + cell(said.remedy) + " |\n";
    above = input.command;
    commands.insert(input.command.substr(0, input.command.find(' ')));
  }
  for (const char* command :
       {"run", "new", "check", "prepare", "simulate", "merge", "import", "calibrate", "fit",
        "refine", "export", "replay", "validate", "inspect", "tabulate", "report", "study"})
    EXPECT_TRUE(commands.contains(command)) << command;
  const fs::path docs = fs::path(PALPATE_SOURCE_DIR) / "docs/bad-inputs.md";
  if (std::getenv("PALPATE_WRITE_DOCS") != nullptr) std::ofstream(docs) << page;
  EXPECT_EQ(content_of(docs), page) << "run this test with PALPATE_WRITE_DOCS=1 and look at it";
}

}  // namespace
}  // namespace palpate::tools
