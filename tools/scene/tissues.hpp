#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "libfit/certify/certificate.hpp"

namespace palpate::tools {

/// A row of data/materials.toml, which travels inside the program.
struct Tissue {
  std::string name, law;
  double young_Pa = 0, deviation_Pa = 0, poisson = 0;  ///< deviation 0: the source states none
  std::string measured, source, doi;                   ///< doi may be empty
  std::string relaxation;  ///< time constants with their source; may be empty
  std::string rests_on;    ///< neighbours in place of a rigid ground; empty: none that yield
};

/// A row of its [[hollow]]: an organ with a lumen.
struct HollowOrgan {
  std::string name;
  double wall_m = 0;
  std::string source, doi;  ///< doi may be empty
};

const std::vector<Tissue>& tissues();

/// The first hollow organ of which a file's name has the word; null where there is none.
const HollowOrgan* hollow_organ_of_name(std::string_view name);

/// The row that is taken where nothing says which.
inline constexpr std::string_view kUnnamedTissue = "liver";

/// The row of that name. Throws Error at `where`, naming the nearest one.
const Tissue& find_tissue(std::string_view name, const std::string& where);

/// The row that a file's name means by its words, as left_kidney_01 does kidney-cortex: of rows
/// whose first word it holds, the one that shares most letters with it in whole words, the first
/// one among equals. A word may be in the plural; other characters than letters, and a capital
/// behind a small letter, end one. Null where no row is meant.
const Tissue* tissue_of_name(std::string_view name);

/// The rows of data/devices.toml, which travels inside the program, and those of a file of the same
/// form where one is named. Throws Error at a bad key or value.
std::vector<certify::Device> read_devices(const std::filesystem::path& more = {});

}  // namespace palpate::tools
