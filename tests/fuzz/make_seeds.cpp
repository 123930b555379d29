// Writes the seed corpus into a folder: make_seeds FOLDER, for libFuzzer or the driver; those of
// binary recordings into FOLDER/recordings.
#include "tests/fuzz/recording_seeds.hpp"
#include "tests/fuzz/seeds.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder / "recordings");
  const auto write = [&](const std::string& name, const palpate::fuzz::Bytes& bytes) {
    palpate::write_file_atomically(folder / name,
                                   {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  };
  write("asset_version_1", palpate::fuzz::asset_seed(PALPATE_GOLDEN));
  for (int kind = 0; kind < 4; ++kind)
    write("ticks_" + std::to_string(kind), palpate::fuzz::ticks_seed(kind));
  for (const auto& [name, bytes] : palpate::fuzz::recording_seeds())
    palpate::write_file_atomically(folder / "recordings" / name, bytes);
  return 0;
}
