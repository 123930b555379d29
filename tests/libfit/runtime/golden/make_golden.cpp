// Writes the golden asset of a version: make_golden 1 tests/libfit/runtime/golden/version_1.palp
// or that of the ring law: make_golden rings tests/libfit/runtime/golden/rings.palp
// Run it once per version, when the format is released; an old version's file never changes again.
#include <cstdlib>
#include <string>

#include "libfit/io/atomic_file.hpp"
#include "tests/libfit/runtime/golden/golden_asset.hpp"

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const palpate::AssetBytes bytes = std::string(argv[1]) == "rings"
                                        ? palpate::test::golden_rings()
                                        : palpate::test::golden_asset(std::atoi(argv[1]));
  palpate::write_file_atomically(argv[2],
                                 {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return 0;
}
