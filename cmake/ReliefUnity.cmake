# Several source files a compiler run, where CMAKE_UNITY_BUILD is on: headers are then read and templates
# instantiated once for all of them, which more than halves the time of a sanitized build from nothing.
#
# The unnamed namespaces of files compiled together are one. Files that define the same name at the start of a line go
# into different groups, so that no file needs to know which names the others use.

set(RELIEF_UNITY_FILES 8 CACHE STRING "How many source files at most are compiled together with CMAKE_UNITY_BUILD")

# The names that a source file defines at the start of a line. Some too many do no harm.
function(relief_defined_names file result)
  file(READ ${file} text)
  string(REGEX REPLACE "[][;]" "_" text "\n${text}")
  string(REGEX MATCHALL "\n[A-Za-z_][^\n]*" lines "${text}")
  set(names "")
  foreach(line IN LISTS lines)
    if(line MATCHES "^\n(TEST|INSTANTIATE|namespace|using|template|extern)")
      continue()
    elseif(line MATCHES "^\n(struct|class|union|enum class|enum) ([A-Za-z0-9_]+)")
      list(APPEND names ${CMAKE_MATCH_2})
    elseif(line MATCHES "^\n([^=({]*[ &*])?([A-Za-z_][A-Za-z0-9_]*) *[=({]")
      list(APPEND names ${CMAKE_MATCH_2})
    endif()
  endforeach()
  set(${result} "${names}" PARENT_SCOPE)
endfunction()

# The first group, from 0, that has a place left and defines none of `names`; an empty one at the latest.
function(relief_first_group names result)
  set(group 0)
  while(TRUE)
    set(common ${RELIEF_GROUP_${group}_NAMES})
    list(REMOVE_ITEM common ${names} "")
    list(LENGTH common left)
    list(LENGTH RELIEF_GROUP_${group}_NAMES before)
    list(LENGTH RELIEF_GROUP_${group}_FILES files)
    if(left EQUAL before AND files LESS RELIEF_UNITY_FILES)
      break()
    endif()
    math(EXPR group "${group} + 1")
  endwhile()
  set(${result} ${group} PARENT_SCOPE)
endfunction()

# relief_group_sources(TARGET): call it when the target has all its sources.
function(relief_group_sources target)
  get_target_property(unity ${target} UNITY_BUILD)
  if(NOT unity)
    return()
  endif()
  get_target_property(folder ${target} SOURCE_DIR)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${folder} NORMALIZE OUTPUT_VARIABLE file)
    relief_defined_names(${file} names)
    relief_first_group("${names}" group)
    list(APPEND RELIEF_GROUP_${group}_NAMES ${names})
    list(APPEND RELIEF_GROUP_${group}_FILES ${file})
    set_source_files_properties(${file} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP group_${group})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD_MODE GROUP)
endfunction()
