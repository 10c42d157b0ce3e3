# Installs the libraries and a CMake package: find_package(relief) gives relief::scan, relief::io, relief::simulation,
# relief::evaluation, relief::registration, relief::hybrid, relief::fusion and
# relief::reconstruction. Headers: see relief_library().
include(CMakePackageConfigHelpers)

set(relief_libraries relief_scan relief_io relief_simulation relief_evaluation relief_registration relief_hybrid
                     relief_fusion relief_reconstruction)
install(TARGETS ${relief_libraries} EXPORT relief_targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT relief_targets NAMESPACE relief:: FILE reliefTargets.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/relief)
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/reliefConfig.cmake.in
  ${PROJECT_BINARY_DIR}/reliefConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/relief)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/reliefConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/reliefConfig.cmake ${PROJECT_BINARY_DIR}/reliefConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/relief)
