# Headers that most source files read, compiled once for several targets. Reading them and what they instantiate is a fifth
# of a compiler run, even where several files share one. Source files still include what they use: single files are
# compiled without these headers by default.
option(RELIEF_PRECOMPILE_HEADERS "Compile common headers once for several targets" ${CMAKE_UNITY_BUILD})

set(RELIEF_COMMON_HEADERS
  <algorithm> <array> <cmath> <cstddef> <cstdint> <filesystem> <functional> <limits> <map> <memory> <numbers> <optional>
  <set> <sstream> <string> <string_view> <unordered_map> <utility> <variant> <vector> <Eigen/Dense> <Eigen/Geometry>)

# relief_precompile(TARGET HEADERS...): the common headers and these, for this target and those that share them.
function(relief_precompile target)
  if(RELIEF_PRECOMPILE_HEADERS)
    target_precompile_headers(${target} PRIVATE ${RELIEF_COMMON_HEADERS} ${ARGN})
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      target_compile_options(${target} PRIVATE -fpch-preprocess)  # For ccache.
    endif()
  endif()
endfunction()

# relief_share_precompiled(TARGET FROM): takes the headers of FROM. The compiler uses them only where its options are the same,
# -fPIC among them.
function(relief_share_precompiled target from)
  if(RELIEF_PRECOMPILE_HEADERS AND NOT target STREQUAL from)
    target_precompile_headers(${target} REUSE_FROM ${from})
    if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
      target_compile_options(${target} PRIVATE -fpch-preprocess)
    endif()
  endif()
endfunction()
