#pragma once

#include <string_view>

namespace palpate::tools {

/// Identity of a build, for fingerprints: the version in a release
/// (PALPATE_RELEASE), else a hash of the sources and the compiler's settings, made anew by every
/// build (build_identity.cmake), in one file of its own so that nothing else is compiled for it.
std::string_view build_identity();

}  // namespace palpate::tools
