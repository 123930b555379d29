cmake_minimum_required(VERSION 3.25)

# Writes OUTPUT, the definition of build_identity(): the VERSION in a release, else a hash of the
# sources under SOURCE_DIR and of the compiler's SETTINGS. Left alone where it would not change.
# cmake -DOUTPUT=... -DSOURCE_DIR=... -DVERSION=... -DRELEASE=... -DSETTINGS=... -P build_identity.cmake
set(identity "${VERSION}")
if(NOT RELEASE)
  file(GLOB_RECURSE sources LIST_DIRECTORIES false RELATIVE ${SOURCE_DIR}
       ${SOURCE_DIR}/libfit/*.[hc]* ${SOURCE_DIR}/libfem/*.[hc]* ${SOURCE_DIR}/tools/*.[hc]*)
  list(FILTER sources EXCLUDE REGEX "^tools/page/")  # shows results, makes none
  list(SORT sources)
  set(all "${SETTINGS}")
  foreach(source IN LISTS sources)
    file(MD5 ${SOURCE_DIR}/${source} hash)
    string(APPEND all " ${source} ${hash}")
  endforeach()
  string(SHA1 hash "${all}")
  string(APPEND identity " ${hash}")
endif()
file(CONFIGURE OUTPUT ${OUTPUT} CONTENT
"// Made by build_identity.cmake.
#include \"tools/build_identity.hpp\"

namespace palpate::tools {
std::string_view build_identity() { return \"@identity@\"; }
}  // namespace palpate::tools
" @ONLY)
