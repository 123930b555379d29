#include <fmt/format.h>

#include "libfit/assets/asset_file.hpp"
#include "libfit/io/files/describe.hpp"
#include "tools/command.hpp"
#include "tools/commands/inspect_asset.hpp"

namespace palpate::tools {
namespace {

constexpr std::size_t kLongestAttribute = 100;  // a scene or a statement is shown by its first line

void print(const FileDescription& file) {
  fmt::print("{} version {}\n", file.schema, file.version);
  for (const auto& [name, value] : file.attributes) {
    std::string line = value.substr(0, value.find('\n'));
    if (line.size() > kLongestAttribute) line.resize(kLongestAttribute);
    fmt::print("  {} = {}{}\n", name, line, line.size() < value.size() ? " ..." : "");
  }
  for (const DataSetDescription& set : file.data_sets)
    fmt::print("  {:<28} {:<8} {:<14} {}\n", set.name, set.type, h5::to_string(set.shape),
               set.unit == h5::kNoUnit ? "" : set.unit);
}

class Inspect final : public Command {
 public:
  explicit Inspect(Arguments& arguments) {
    arguments.positional("file", file_,
                         "File to read: body.h5, samples.h5, curves.h5, model.h5 or asset.palp");
  }

  int run() override {
    if (is_asset_file(file_))
      print_asset(file_);
    else
      print(describe(file_));
    return kDone;
  }

 private:
  std::string file_;
};

}  // namespace

std::unique_ptr<Command> declare_inspect(Arguments& arguments) {
  return std::make_unique<Inspect>(arguments);
}

}  // namespace palpate::tools
