# Installs the libraries and a CMake package: find_package(relief) gives relief::scan, relief::io, relief::simulation,
# relief::evaluation, relief::rendering, relief::registration, relief::hybrid, relief::fusion and relief::reconstruction; its
# components pcl and vtk give relief::pcl and relief::vtk. Headers: see relief_library().
include(CMakePackageConfigHelpers)

set(relief_libraries relief_scan relief_io relief_simulation relief_evaluation relief_rendering relief_registration
                     relief_hybrid relief_fusion relief_reconstruction)
install(TARGETS ${relief_libraries} EXPORT relief_targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT relief_targets NAMESPACE relief:: FILE reliefTargets.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/relief)
foreach(component pcl vtk)
  if(TARGET relief_${component})
    install(TARGETS relief_${component} EXPORT relief_${component}_targets
            ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT ${component})
    install(EXPORT relief_${component}_targets NAMESPACE relief:: FILE relief-${component}-targets.cmake
            DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/relief COMPONENT ${component})
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/interop/include/relief/interop
            DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/relief COMPONENT ${component}
            FILES_MATCHING PATTERN "${component}_*.h")
  endif()
endforeach()
configure_package_config_file(${PROJECT_SOURCE_DIR}/cmake/reliefConfig.cmake.in
  ${PROJECT_BINARY_DIR}/reliefConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/relief)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/reliefConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/reliefConfig.cmake ${PROJECT_BINARY_DIR}/reliefConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/relief)
