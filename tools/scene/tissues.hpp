#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace palpate::tools {

/// A row of data/materials.toml, which travels inside the program.
struct Tissue {
  std::string name, law;
  double young_Pa = 0, deviation_Pa = 0, poisson = 0;  ///< deviation 0: the source states none
  std::string measured, source, doi;
};

const std::vector<Tissue>& tissues();

/// The row of that name. Throws Error at `where`, naming the nearest one.
const Tissue& find_tissue(std::string_view name, const std::string& where);

}  // namespace palpate::tools
