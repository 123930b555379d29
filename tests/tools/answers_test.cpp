// What every command says on stdout and stderr: --json, --quiet, --verbose, colours.

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "tests/tools/block_scene.hpp"
#include "tools/console.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;
using Json = nlohmann::json;

// Names in the program's own help.
std::set<std::string> commands(const std::string& help) {
  static const std::regex line("\n  ([a-z]+) +[A-Z]");
  std::set<std::string> names;
  const std::string list = help.substr(help.find("\nStart:"));
  for (std::sregex_iterator it(list.begin(), list.end(), line), end; it != end; ++it)
    names.insert((*it)[1]);
  return names;
}

std::string page(const std::string& name) {
  return content_of(fs::path(PALPATE_SOURCE_DIR) / "docs" / "formats" / name);
}

void add_quoted(const std::string& text, std::set<std::string>& keys) {
  static const std::regex quoted("`([A-Za-z_0-9]+)`");
  for (std::sregex_iterator it(text.begin(), text.end(), quoted), end; it != end; ++it)
    keys.insert((*it)[1]);
}

// What docs/formats/commands.md says that a command's object has: in the command's rows, and on the
// pages that these refer to.
std::set<std::string> documented_keys(const std::string& command) {
  static const std::pair<const char*, const char*> kPages[] = {{"](#", "commands.md"},
                                                               {"statement.json", "statement.md"},
                                                               {"samples.import", "manifest.md"}};
  std::set<std::string> keys;
  std::istringstream lines(page("commands.md"));
  for (std::string line; std::getline(lines, line);) {
    const std::string first = line.substr(0, line.find('|', 1));
    const bool is_row = first.starts_with("| `") && first.find('`' + command + '`') < first.size();
    if (is_row || line.starts_with("The object has")) add_quoted(line, keys);
    for (const auto& [mark, name] : kPages)
      if (is_row && line.find(mark) < line.size()) add_quoted(page(name), keys);
    if (is_row && line.find("as `simulate`") < line.size()) keys.merge(documented_keys("simulate"));
  }
  return keys;
}

const std::string kManifest =
    press_manifest("*.press.csv") + "probe = { shape = \"flat\", radius = \"10 mm\" }\n";

// One run for all tests. Here the program is loaded with a BLAS and LAPACK whose functions abort:
// Debian's Ceres and CHOLMOD need one to load, and no command may compute with it.
class Answers : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    ::setenv("LD_PRELOAD", PALPATE_ABORTING_LAPACK, 1);
    shared = std::make_unique<BlockFolder>();
    shared->write("manifest.toml", kManifest), shared->write("a.press.csv", press_csv(1000));
    shared->write("path.csv", "t_s,x_m,y_m,z_m\n0,0.04,0.04,0.031\n0.1,0.04,0.04,0.028\n");
    shared->write("study.toml", "scene = \"scene.toml\"\n");
    shared->write("points.csv", "x_m,y_m,z_m\n0.04,0.04,0.03\n");
    const Outcome whole = run("out");
    ASSERT_EQ(whole.status, 0) << whole.err;
    ASSERT_EQ(
        palpate(*shared, "simulate out/body.h5 --shard 1/1 --points points.csv -o shards").status,
        0);
    std::string six = "x_m,y_m,z_m\n";
    for (const char* x : {"0.034", "0.04", "0.046"})
      for (const char* y : {"0.036", "0.044"}) six += std::string(x) + "," + y + ",0.03\n";
    shared->write("six.csv", six);
    ASSERT_EQ(palpate(*shared, "simulate out/body.h5 --points six.csv -o six.h5").status, 0);
  }
  static void TearDownTestSuite() {
    shared.reset();
    ::unsetenv("LD_PRELOAD");
  }
  static Outcome run(const std::string& out, const std::string& options = "") {
    return palpate(*shared, "run scene.toml -o " + out + " " + options);
  }
  // A line that each command does well.
  std::map<std::string, std::string> lines() const {
    return {
        {"run", " scene.toml -o out"},
        {"new", " block.off -o new.toml </dev/null"},
        {"check", " scene.toml"},
        {"prepare", " scene.toml -o b.h5"},
        {"simulate", " out/body.h5 -o s.h5 --points points.csv"},
        {"merge", " shards -o merged.h5"},
        {"import", " manifest.toml -o i.h5"},
        {"calibrate", " scene.toml --samples out/samples.h5 -o calibrated.toml --points 1"},
        {"surface", " six.h5 -o surface.obj"},
        {"fit", " out/samples.h5 -o c.h5"},
        {"refine", " out/curves.h5 --body out/body.h5 -o m.h5"},
        {"export", " out/model.h5 -o a.palp"},
        {"replay", " out/asset.palp path.csv -o f.csv"},
        {"validate", " out/asset.palp scene.toml --points 2 --no-causes --reference out"},
        {"inspect", " out/asset.palp"},
        {"tabulate", " out/curves.h5 -o t.csv"},
        {"report", " out -o r.html"},
        {"study", " study.toml -o study --on script"},
    };
  }

  static std::unique_ptr<BlockFolder> shared;
  const Folder& folder = *shared;
};
std::unique_ptr<BlockFolder> Answers::shared;

TEST_F(Answers, of_every_command_are_one_object_with_json_and_nothing_when_quiet) {
  const auto all = lines();
  const std::set<std::string> known = commands(palpate(folder, "--help").out);
  EXPECT_EQ(known.size(), all.size());
  for (const std::string& command : known) {
    SCOPED_TRACE(command);
    ASSERT_TRUE(all.contains(command)) << "give it a line";
    const auto fresh = [&] {
      fs::remove(folder / "new.toml");
      fs::remove(folder / "new.divided.off");
    };
    fresh();
    const Outcome json = palpate(folder, command + " --json" + all.at(command));
    if (command == "report" && json.status == 1) continue;  // the page is not built
    EXPECT_EQ(json.status, 0) << json.err;
    const Json object = Json::parse(json.out, nullptr, false);
    ASSERT_TRUE(object.is_object()) << json.out;
    EXPECT_EQ(object.at("command"), command);
    EXPECT_GE(object.size(), 3u) << json.out;
    const std::set<std::string> documented = documented_keys(command);
    for (const auto& [key, value] : object.items())
      EXPECT_TRUE(documented.contains(key)) << key << " is not in docs/formats/commands.md";
    for (const Json& file : object.value("wrote", Json::array()))
      EXPECT_EQ(file.at("bytes"), fs::file_size(folder / file.at("file").get<std::string>()));
    fresh();
    const Outcome quiet = palpate(folder, command + " --quiet" + all.at(command));
    EXPECT_EQ(quiet.status, 0);
    EXPECT_EQ(quiet.out + quiet.err, "");
  }
}

TEST_F(Answers, come_with_a_lapack_that_names_who_calls_it) {
  if (std::string_view(PALPATE_ABORTING_LAPACK).empty()) GTEST_SKIP() << "sanitizers come first";
  void* const lapack = dlopen(PALPATE_ABORTING_LAPACK, RTLD_NOW);
  ASSERT_NE(lapack, nullptr) << dlerror();
  for (const char* name : {"dgeqrf_", "dgemm_"}) {
    const auto function = reinterpret_cast<void (*)()>(dlsym(lapack, name));
    ASSERT_NE(function, nullptr) << name;
    EXPECT_DEATH(function(), name);
  }
}

TEST_F(Answers, name_with_json_what_was_wrong) {
  const Outcome outcome = palpate(folder, "fit none.h5 -o c.h5 --json --quiet");
  EXPECT_EQ(outcome.status, 1);
  const Json error = Json::parse(outcome.out).at("errors").at(0);
  EXPECT_EQ(error.at("where"), "none.h5");
  EXPECT_NE(error.at("what"), "");
  EXPECT_NE(error.at("remedy"), "");
  EXPECT_TRUE(holds(outcome.err, "palpate: error: none.h5: ")) << "an error is said, however quiet";
}

TEST_F(Answers, say_failed_items_however_quiet_with_status_3) {
  const fs::path bad = folder.write("b.press.csv", "t,d,F\n0,0,0\n0,x,1\n");
  const std::string line = "import manifest.toml -o i.h5";
  const Outcome quiet = palpate(folder, line + " --quiet");
  EXPECT_EQ(quiet.status, 3);
  EXPECT_TRUE(quiet.err.starts_with("refused: ")) << quiet.err;
  const Outcome json = palpate(folder, line + " --json");
  EXPECT_EQ(json.status, 3);
  EXPECT_EQ(Json::parse(json.out).at("failures").size(), 1u) << json.out;
  fs::remove(bad);
}

TEST_F(Answers, of_run_have_a_table_of_eighty_columns_in_the_log) {
  const Outcome outcome = run("out");
  ASSERT_TRUE(holds(outcome.log, "force error at"));
  std::istringstream lines_of(outcome.log.substr(outcome.log.find("force error at")));
  for (std::string line; std::getline(lines_of, line);) EXPECT_LE(line.size(), 80u) << line;
  EXPECT_EQ(outcome.out.find('\033'), std::string::npos) << "this is no terminal";
}

TEST_F(Answers, come_with_times_when_verbose) {
  const Outcome outcome = run("out", "-v");
  EXPECT_TRUE(std::regex_search(outcome.err, std::regex("(^|\n)\\[ +[0-9]+\\.[0-9] s\\] ")))
      << outcome.err;
}

}  // namespace
}  // namespace palpate::tools
