#include "tools/report/page.hpp"

#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"

namespace palpate::tools {
namespace {

namespace fs = std::filesystem;

// Where tools/page/page.html wants the data: the content of a <script type="application/json">.
constexpr std::string_view kPlace = "{\"schema\":\"none\"}";

}  // namespace

std::optional<fs::path> find_page() {
  std::error_code ignored;
  const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
  for (const char* place : {"../share/palpate/page.html", "page/page.html"})
    if (fs::is_regular_file(folder / place, ignored)) return (folder / place).lexically_normal();
  return std::nullopt;
}

void write_page(const fs::path& output, const std::string& contents) {
  const auto path = find_page();
  if (!path)
    throw Error("report", "the page that it fills is not there (share/palpate/page.html)",
                "Install Node.js 18 or newer with npm, then `cmake --build build/PRESET --target "
                "palpate_page`, or copy the page from another installation.");
  const std::string page = read_whole_file(*path);
  const std::size_t at = page.find(kPlace);
  if (at == std::string::npos)
    throw Error(path->string(), "is no page of Palpate's",
                "Build it again: `cmake --build build/PRESET --target palpate_page`.");
  AtomicFile file(output);
  file.write(std::string_view(page).substr(0, at));
  // A text within may not end the element it stands in.
  std::string_view rest = contents;
  for (std::size_t less; (less = rest.find('<')) != std::string_view::npos;) {
    file.write(rest.substr(0, less));
    file.write("\\u003c");
    rest.remove_prefix(less + 1);
  }
  file.write(rest);
  file.write(std::string_view(page).substr(at + kPlace.size()));
  file.commit();
}

}  // namespace palpate::tools
