// Every command of docs/tutorial.md, in its order, on a small block; and every command and option
// that the documents name is there.

#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "libfit/core/geometry.hpp"
#include "libfit/io/csv/csv.hpp"
#include "tests/tools/block_scene.hpp"

namespace palpate::tools {
namespace {

using namespace testing_support;

const fs::path kDocs = fs::path(PALPATE_SOURCE_DIR) / "docs";

// A fenced block: "sh" holds commands, "toml NAME" is a file.
struct Block {
  std::string language, name, text;
};

std::vector<Block> blocks_of(const fs::path& page) {
  static const std::regex fence("```([a-z]+) ?(.*)");
  std::istringstream lines(content_of(page));
  std::vector<Block> blocks;
  bool is_inside = false;
  for (std::string line; std::getline(lines, line);) {
    std::smatch found;
    if (line == "```") {
      is_inside = false;
    } else if (std::regex_match(line, found, fence)) {
      blocks.push_back({found[1], found[2], ""});
      is_inside = true;
    } else if (is_inside) {
      blocks.back().text += line + "\n";
    }
  }
  return blocks;
}

// Hertz's law from 1 mm of travel on, as the page shows an excerpt of.
std::string recording() {
  std::string text = "t,z,F\n";
  for (int i = 0; i < 100; ++i) {
    char row[64];
    const double depth_mm = std::max(0.0, 0.03 * i - 1);
    std::snprintf(row, sizeof row, "%.2f,%.2f,%.4f\n", 0.01 * i, 0.03 * i,
                  0.4 * depth_mm * std::sqrt(depth_mm) + 1e-4 * (i % 3));
    text += row;
  }
  return text;
}

// What the page says of the scene that `new` proposes: read it and change what you know better.
// Here that is what costs time.
void change_scene(const fs::path& scene) {
  std::string text = content_of(scene);
  const auto change = [&](const std::string& key, const std::string& value) {
    const std::size_t at = text.find("\n" + key + " = ");
    ASSERT_NE(at, std::string::npos) << key << " is not in\n" << text;
    const std::size_t from = at + key.size() + 4;
    text.replace(from, text.find('\n', from) - from, value);
  };
  change("poisson", "0.3"), change("press_steps", "4"), change("drag_steps", "4");
  change("points", "1");
  std::ofstream(scene) << text;
}

// What the page says of its path: the tip begins and ends in the air, touches, slips, stays in the
// window, and feels a force that is neither nothing nor boundless.
void expect_press_slide_and_lift(const fs::path& forces) {
  SCOPED_TRACE(forces);
  static constexpr CsvColumnRule kRules[] = {{"fx_N"},    {"fy_N"},    {"fz_N"},
                                             {"contact"}, {"sliding"}, {"outside"}};
  const CsvTable table = read_csv(forces, kRules);
  const std::vector<double>& contact = table.number("contact");
  ASSERT_GT(contact.size(), 1000u);
  EXPECT_EQ(contact.front(), 0);
  EXPECT_EQ(contact.back(), 0);
  std::size_t touching = 0, slipping = 0;
  double most_N = 0;
  for (std::size_t i = 0; i < contact.size(); ++i) {
    const Vec3 force(table.number("fx_N")[i], table.number("fy_N")[i], table.number("fz_N")[i]);
    most_N = std::max(most_N, force.norm());
    touching += contact[i] != 0;
    slipping += table.number("sliding")[i] != 0;
    EXPECT_EQ(table.number("outside")[i], 0) << "tick " << i;
  }
  EXPECT_GT(touching, contact.size() / 2);
  EXPECT_GT(slipping, contact.size() / 10);
  EXPECT_GT(most_N, 0.05);
  EXPECT_LT(most_N, 10);
}

TEST(Tutorial, runs_as_it_stands) {
  const Folder folder;
  folder.write("organ.off", block_off(6));
  folder.write("phantom.off", block_off(8));
  fs::create_directory(folder / "rig");
  for (const char* name : {"rig/p1.csv", "rig/p2.csv", "rig/p3.csv", "rig/p4.csv"})
    folder.write(name, recording());
  const std::string program = fs::path(PALPATE_PROGRAM).parent_path();
  int commands = 0;
  for (const Block& block : blocks_of(kDocs / "tutorial.md")) {
    if (block.language != "sh") {
      ASSERT_FALSE(block.name.empty()) << block.text;
      folder.write(block.name, block.text);
      continue;
    }
    std::istringstream lines(block.text);
    for (std::string line; std::getline(lines, line); ++commands) {
      const std::string whole = "cd " + folder.path().string() + " && PATH=" + program +
                                ":$PATH && { " + line + "; } >.out 2>.err </dev/null";
      ASSERT_EQ(std::system(whole.c_str()), 0) << line << "\n" << content_of(folder / ".err");
      if (line.starts_with("palpate new organ.off")) change_scene(folder / "organ.toml");
    }
  }
  EXPECT_GE(commands, 13);
  for (const char* forces : {"forces.csv", "measured-forces.csv"})
    expect_press_slide_and_lift(folder / forces);
}

TEST(Tutorial, shows_rows_of_the_recording_that_it_speaks_of) {
  const std::string page = content_of(kDocs / "tutorial.md"), rows = recording();
  const std::size_t from = page.find("    t,z,F\n");
  ASSERT_NE(from, std::string::npos);
  std::istringstream lines(page.substr(from, page.find("\n\n", from) - from));
  for (std::string line; std::getline(lines, line);)
    EXPECT_TRUE(holds(rows, line.substr(4) + "\n")) << line;
}

TEST(Documents, name_commands_and_options_that_are_there) {
  const Folder folder;
  std::map<std::string, std::string> help;
  const auto help_of = [&](const std::string& command) -> const std::string& {
    const auto [found, is_new] = help.emplace(command, "");
    if (is_new) found->second = palpate(folder, command + " --help").out;
    return found->second;
  };
  static const std::regex use(R"re(palpate ([a-z]+)((?: [^`\n|;]*)?))re"), option("--[a-z-]+");
  std::vector<fs::path> pages{fs::path(PALPATE_SOURCE_DIR) / "README.md"};
  for (const auto& entry : fs::recursive_directory_iterator(kDocs))
    if (entry.path().extension() == ".md" && entry.path().filename() != "bad-inputs.md")
      pages.push_back(entry.path());
  const std::string commands = help_of("");
  int checked = 0;
  for (const fs::path& page : pages) {
    const std::string text = content_of(page);
    // Commands stand in code: after a backtick or an indent.
    for (std::sregex_iterator it(text.begin(), text.end(), use), end; it != end; ++it) {
      const auto at = static_cast<std::size_t>(it->position());
      const char before = at > 0 ? text[at - 1] : '\n';
      if (before != '`' && before != '\n' && !(at > 3 && text.substr(at - 4, 4) == "    "))
        continue;
      const std::string command = (*it)[1], rest = (*it)[2];
      EXPECT_TRUE(holds(commands, "\n  " + command + " ")) << page << ": palpate " << command;
      for (std::sregex_iterator o(rest.begin(), rest.end(), option); o != end; ++o, ++checked)
        EXPECT_TRUE(holds(help_of(command), o->str())) << page << ": palpate " << command << rest;
    }
  }
  EXPECT_GE(checked, 10);
}

}  // namespace
}  // namespace palpate::tools
