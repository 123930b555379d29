// Writes the golden asset of the current version: make_golden
// tests/libfit/runtime/golden/version_2.palp Run it once per version, when the format is released;
// an old version's file never changes again.
#include "libfit/io/atomic_file.hpp"
#include "tests/libfit/runtime/golden/golden_asset.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  const palpate::AssetBytes bytes = palpate::test::golden_asset();
  palpate::write_file_atomically(argv[1],
                                 {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  return 0;
}
