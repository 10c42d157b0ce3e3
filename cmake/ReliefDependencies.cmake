# VTK comes before PCL: PCL's own search for VTK switches PNG off.
find_package(VTK 9.1 REQUIRED COMPONENTS
  CommonCore CommonDataModel CommonExecutionModel FiltersCore FiltersGeneral IOCore IOGeometry
  IOPLY IOXML)
set(RELIEF_VTK_LIBRARIES ${VTK_LIBRARIES})
find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(nlohmann_json 3.9 REQUIRED)
find_package(PNG REQUIRED)
find_package(TIFF REQUIRED)
find_package(OpenEXR REQUIRED CONFIG)
find_package(Ceres 2.1 REQUIRED)
# CHOLMOD has no CMake package of its own in SuiteSparse 5.
find_library(RELIEF_CHOLMOD_LIBRARY cholmod REQUIRED)
find_path(RELIEF_CHOLMOD_INCLUDE_DIR cholmod.h PATH_SUFFIXES suitesparse REQUIRED)
find_package(PCL 1.13 REQUIRED COMPONENTS common io)
find_package(CLI11 REQUIRED)
find_package(spdlog REQUIRED)
if(RELIEF_BUILD_TESTS)
  find_package(GTest REQUIRED)
endif()
if(RELIEF_BUILD_BENCH)
  find_package(benchmark REQUIRED)
endif()
