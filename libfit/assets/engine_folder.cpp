#include "libfit/assets/engine_folder.hpp"

#include "libfit/core/error.hpp"
#include "libfit/io/atomic_file.hpp"

namespace palpate {

void write_engine_folder(const std::filesystem::path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure)
    throw Error(folder.string(), "the engine's folder cannot be made: " + failure.message(),
                "Choose a folder that can be written.");
  const bool is_engine = std::filesystem::exists(folder / "palpate.h");
  for (const EngineFile& file : engine_files())
    if (!is_engine && std::filesystem::exists(folder / std::filesystem::path(file.name)))
      throw Error((folder / std::filesystem::path(file.name)).string(),
                  "is there already, in a folder that holds no engine",
                  "Move it away, or give the engine a folder of its own.");
  for (const EngineFile& file : engine_files()) {
    const auto path = folder / std::filesystem::path(file.name);
    std::filesystem::create_directories(path.parent_path(), failure);
    write_file_atomically(path, file.text);
  }
}

}  // namespace palpate
