# What a simulator needs of the engine: headers, the C library, find_package(palpate) and pkg-config.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

file(STRINGS ${CMAKE_CURRENT_SOURCE_DIR}/palpate.h abi_line REGEX "^#define PALPATE_ABI ")
string(REGEX REPLACE ".* ([0-9]+)$" "\\1" PALPATE_ABI "${abi_line}")
set_target_properties(palpate_engine_shared PROPERTIES VERSION ${PALPATE_ABI}.${PROJECT_VERSION}
  SOVERSION ${PALPATE_ABI} EXPORT_NAME engine)
set_target_properties(palpate_engine_static PROPERTIES EXPORT_NAME engine_static)
set_target_properties(palpate_runtime PROPERTIES EXPORT_NAME engine_headers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/palpate)
install(TARGETS palpate_runtime palpate_engine_shared palpate_engine_static EXPORT palpate
  LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT engine
  NAMELINK_COMPONENT engine-dev
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT engine-dev)
install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/palpate
  COMPONENT engine-dev FILES_MATCHING PATTERN "*.hpp" PATTERN "*.h")
install(EXPORT palpate NAMESPACE palpate:: FILE palpate-config.cmake DESTINATION ${package_dir}
  COMPONENT engine-dev)
write_basic_package_version_file(palpate-config-version.cmake COMPATIBILITY SameMinorVersion)
file(CONFIGURE OUTPUT palpate-engine.pc @ONLY CONTENT
"prefix=@CMAKE_INSTALL_PREFIX@
Name: palpate-engine
Description: Force-deflection curves of soft bodies in a haptic loop
Version: @PROJECT_VERSION@
Cflags: -I\${prefix}/@CMAKE_INSTALL_INCLUDEDIR@/palpate
Libs: -L\${prefix}/@CMAKE_INSTALL_LIBDIR@ -lpalpate_engine
")
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/palpate-config-version.cmake DESTINATION ${package_dir}
  COMPONENT engine-dev)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/palpate-engine.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT engine-dev)
