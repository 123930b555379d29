#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

// Tables of documents whose facts stand in the code. In a page such a table follows the line
// `<!-- table: NAME -->`, and the first cell of a row is its key. The code writes the cells that it
// knows; the others, such as what a key means, stand in the page alone and stay.
namespace palpate::testing_support {

using Cells = std::vector<std::string>;

struct PageTable {
  Cells header;
  /// A row: its key, then what the code knows of the other cells; nothing: the page's own.
  std::vector<std::vector<std::optional<std::string>>> rows;
};

inline Cells cells_of(const std::string& line) {
  Cells cells;
  std::string cell;
  for (std::size_t i = 1; i < line.size(); ++i) {
    if (line[i] != '|' || line[i - 1] == '\\') {
      cell += line[i];
      continue;
    }
    const std::size_t from = cell.find_first_not_of(' '), to = cell.find_last_not_of(' ');
    cells.push_back(from == std::string::npos ? "" : cell.substr(from, to - from + 1));
    cell.clear();
  }
  return cells;
}

inline std::string line_of(const Cells& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += cell.empty() ? " |" : " " + cell + " |";
  return line + "\n";
}

/// The table as it should stand, its rows in the page's order and new ones behind. old: its lines.
inline std::string table_text(const PageTable& table, const std::vector<std::string>& old) {
  std::map<std::string, Cells> kept;
  std::vector<std::string> order;
  for (std::size_t i = 2; i < old.size(); ++i) {
    const Cells cells = cells_of(old[i]);
    if (cells.size() == table.header.size()) kept[cells[0]] = cells, order.push_back(cells[0]);
  }
  std::map<std::string, Cells> now;
  for (const auto& row : table.rows) {
    const std::string key = *row[0];
    if (!kept.contains(key)) order.push_back(key);
    Cells cells;
    for (std::size_t i = 0; i < row.size(); ++i)
      cells.push_back(row[i] ? *row[i] : kept.contains(key) ? kept[key][i] : "");
    EXPECT_FALSE(cells.back().empty()) << "describe " << key;
    now[key] = cells;
  }
  std::string text = line_of(table.header) + "|";
  for (std::size_t i = 0; i < table.header.size(); ++i) text += "---|";
  text += "\n";
  for (const std::string& key : order)
    if (now.contains(key)) text += line_of(now[key]);
  return text;
}

/// Of docs/, by its name there.
inline std::string content_of_page(const std::string& document) {
  std::ifstream stream(std::filesystem::path(PALPATE_SOURCE_DIR) / "docs" / document);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// Expects that a document is this. PALPATE_WRITE_DOCS=1 writes it.
inline void expect_content(const std::string& document, const std::string& wanted) {
  const std::string found = content_of_page(document);
  if (std::getenv("PALPATE_WRITE_DOCS") != nullptr)
    std::ofstream(std::filesystem::path(PALPATE_SOURCE_DIR) / "docs" / document) << wanted;
  EXPECT_EQ(found, wanted) << "run this test with PALPATE_WRITE_DOCS=1 and look at " << document;
}

/// Expects these tables, and no others, in a document. PALPATE_WRITE_DOCS=1 writes them.
inline void expect_tables(const std::string& document,
                          const std::map<std::string, PageTable>& tables) {
  const std::string page = content_of_page(document);
  const std::string mark = "<!-- table: ";
  std::istringstream lines(page);
  std::string wanted, line;
  std::size_t found = 0;
  while (std::getline(lines, line)) {
    wanted += line + "\n";
    if (!line.starts_with(mark)) continue;
    const std::string name = line.substr(mark.size(), line.find(" -->") - mark.size());
    const auto table = tables.find(name);
    ASSERT_NE(table, tables.end()) << document << " asks for " << name;
    ++found;
    std::vector<std::string> old;
    while (std::getline(lines, line) && line.starts_with("|")) old.push_back(line);
    wanted += table_text(table->second, old) + line + "\n";
  }
  EXPECT_EQ(found, tables.size()) << document << " has not all tables";
  expect_content(document, wanted);
}

}  // namespace palpate::testing_support
