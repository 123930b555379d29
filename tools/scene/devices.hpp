#pragma once

#include <filesystem>
#include <vector>

#include "libfit/certify/certificate.hpp"

namespace palpate::tools {

/// The rows of data/devices.toml, which travels inside the program, and those of a file of the same
/// form where one is named. Throws Error at a bad key or value.
std::vector<certify::Device> read_devices(const std::filesystem::path& more = {});

}  // namespace palpate::tools
