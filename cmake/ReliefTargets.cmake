# What every target of the project shares: warnings, sanitizers, instruction set, and the project folder, from which
# private headers are included.

# relief_build_flags: for all that the project builds. relief_plain_flags: the same without sanitizers. relief_test_flags: for
# tests. They are compiled without the address sanitizer: it watches the libraries and the program. So the presets dev and asan
# compile them alike, and ccache has the one's for the other.
add_library(relief_plain_flags INTERFACE)
add_library(relief_build_flags INTERFACE)
target_link_libraries(relief_build_flags INTERFACE relief_plain_flags)
target_compile_features(relief_plain_flags INTERFACE cxx_std_20)
target_include_directories(relief_plain_flags INTERFACE ${PROJECT_SOURCE_DIR})
# The distribution builds PCL, Ceres and VTK for plain SSE; wider vectors here would change Eigen's
# alignment and corrupt memory shared with them. x86-64-v2 keeps the alignment.
if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
  target_compile_options(relief_plain_flags INTERFACE -march=x86-64-v2)
endif()
target_compile_options(relief_plain_flags INTERFACE -Wall -Wextra -Wpedantic -Wnon-virtual-dtor
                                                    -Wno-missing-field-initializers
                                                    $<$<CXX_COMPILER_ID:GNU>:-Wshadow=local>
                                                    $<$<CXX_COMPILER_ID:Clang>:-fsized-deallocation>)
if(RELIEF_WERROR)
  # Eigen inside PCL's headers trips g++ 12's array-bounds analysis.
  target_compile_options(relief_plain_flags INTERFACE -Werror -Wno-error=array-bounds
                                                      -Wno-error=maybe-uninitialized)
endif()
if(RELIEF_SANITIZE)
  # Checks of null and of misaligned pointers take half of the compiler's time, and those of sizes of objects a seventh of the
  # rest. The address sanitizer reports null pointers and what lies beyond an object, and Eigen asserts alignment.
  target_compile_options(relief_build_flags INTERFACE -fsanitize=${RELIEF_SANITIZE} -fno-sanitize=null,alignment,object-size
                                                      -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
  target_link_options(relief_build_flags INTERFACE -fsanitize=${RELIEF_SANITIZE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND RELIEF_SANITIZE MATCHES "address")
    target_compile_definitions(relief_build_flags INTERFACE EIGEN_MALLOC_ALREADY_ALIGNED=1)
    # Undefined behaviour stops the program, and the address sanitizer shows where (ASAN_OPTIONS=handle_sigill=1, as in
    # scripts/test). To compile the messages of all checks as well, and those of virtual tables, takes 40 % more time.
    target_compile_options(relief_build_flags INTERFACE -fsanitize-undefined-trap-on-error)
  endif()
endif()
add_library(relief_test_flags INTERFACE)
if(RELIEF_SANITIZE MATCHES "address")
  target_compile_options(relief_build_flags INTERFACE -O1)
  if(NOT RELIEF_SANITIZE_SCOPES)  # A fifth of the compiler's time.
    target_compile_options(relief_build_flags INTERFACE -fno-sanitize-address-use-after-scope)
  endif()
  target_link_libraries(relief_test_flags INTERFACE relief_plain_flags)
else()
  target_link_libraries(relief_test_flags INTERFACE relief_build_flags)
endif()

# relief_library(NAME): a static library relief_NAME, alias relief::NAME. Its public headers are below include/relief/NAME
# of its folder; all other headers are private and found from the project folder. Sources follow with target_sources,
# heavy dependencies with target_link_libraries(... PRIVATE).
function(relief_library name)
  add_library(relief_${name} STATIC)
  add_library(relief::${name} ALIAS relief_${name})
  set_target_properties(relief_${name} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(relief_${name}
    PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/include/relief/${name} OPTIONAL
          DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/relief)
  target_link_libraries(relief_${name} PUBLIC Eigen3::Eigen PRIVATE $<BUILD_INTERFACE:relief_build_flags>)
  target_compile_features(relief_${name} PUBLIC cxx_std_20)
endfunction()
