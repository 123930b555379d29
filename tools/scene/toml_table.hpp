#pragma once

#include <toml++/toml.h>

#include <initializer_list>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/core/error.hpp"
#include "libfit/core/geometry.hpp"
#include "libfit/core/units.hpp"
#include "tools/scene/key_log.hpp"

namespace palpate::tools {

/// The tables of a text. Throws Error at file:line:column with what is wrong there and `remedy`.
toml::table parse_toml(std::string_view text, const std::string& file, const std::string& remedy);

/// One table of a scene file, read key by key. Every getter remembers its key; `finish` then
/// refuses keys that nobody asked for, naming the nearest one that was. Errors carry
/// file:line:column of the value.
class SceneTable {
 public:
  /// name: as users write it, "[probe]" or "material of [[inclusion]]". log: filled with the keys
  /// that are asked for, of tables below this one, too.
  SceneTable(const toml::table& table, std::string name, std::string file, KeyLog* log = nullptr);

  bool has(std::string_view key);
  /// True if every key of the table is one of these.
  bool has_only(std::initializer_list<std::string_view> keys) const;
  std::string text(std::string_view key, std::string fallback);
  /// A text that must be there; else an Error at the table, with what is wrong and its remedy.
  std::string required_text(std::string_view key, const std::string& fact,
                            const std::string& remedy);
  /// A text that must be one of `choices`.
  std::string choice(std::string_view key, std::string fallback,
                     const std::vector<std::string_view>& choices);
  bool boolean(std::string_view key, bool fallback);
  long integer(std::string_view key, long fallback, long low, long high);
  double number(std::string_view key, double fallback, double low, double high);
  /// "12 mm" or a plain SI number; in [low, high] SI.
  double quantity(std::string_view key, Dimension dimension, double fallback, double low,
                  double high);
  double required_quantity(std::string_view key, Dimension dimension, double low, double high);
  std::vector<double> quantities(std::string_view key, Dimension dimension, double low,
                                 double high);
  /// A list of pairs [number, "quantity"], each in its bounds.
  std::vector<std::pair<double, double>> pairs(std::string_view key, double low, double high,
                                               Dimension dimension, double low_si, double high_si);
  /// A list of `count` plain numbers in [low, high], without units.
  std::vector<double> numbers(std::string_view key, std::size_t count, double low, double high);
  Vec3 point(std::string_view key);
  /// A list of points.
  Points points(std::string_view key);
  /// Three plain numbers.
  Vec3 direction(std::string_view key);
  /// The key length_unit: metres in one unit of a mesh file, which carries none. Required.
  double length_unit();
  /// Pair of corners [[x,y,z],[x,y,z]].
  std::pair<Vec3, Vec3> corners(std::string_view key);
  SceneTable table(std::string_view key, std::string name);
  /// Tables of an array (inline or [[...]]); empty when absent.
  std::vector<SceneTable> tables(std::string_view key, std::string name);
  /// The node itself, for keys of several types; nullptr when absent.
  const toml::node* node(std::string_view key);

  /// True if the key is there; unlike has(), this does not make it a known one.
  bool holds(std::string_view key) const { return table_->get(key) != nullptr; }
  void finish() const;
  std::string where(std::string_view key) const;
  std::string where_table() const;
  const std::string& name() const { return name_; }

 private:
  void note(std::string_view key, std::string value, std::string fallback);
  double quantity_of(const toml::node& value, std::string_view key, Dimension dimension, double low,
                     double high) const;
  Vec3 point_of(const toml::node& value, std::string_view key) const;
  double number_of(const toml::node& value, std::string_view key, const std::string& verb,
                   double low, double high, const std::string& remedy) const;
  /// The items of a list, so many unless count is 0; else an Error says what it is not.
  const toml::array& items_of(const toml::node* value, std::string_view key, std::size_t count,
                              const std::string& what, const std::string& remedy) const;
  [[noreturn]] void fail(const toml::node& value, std::string_view key, const std::string& what,
                         const std::string& remedy) const;

  const toml::table* table_;
  std::string name_, file_;
  KeyLog* log_;
  std::set<std::string, std::less<>> asked_;
};

}  // namespace palpate::tools
