# lumesh_module(NAME [DEPENDS module...] [ALONE file...])
#
# One static library per folder of src/. Headers of the API are include/lumesh/NAME, headers that only other modules use
# internal/lumesh/NAME (not installed); sources and private headers are src/NAME. Extra private libraries of a module stand in src/NAME/libraries.cmake where it exists.
# The sanitizer builds, and the first release build of scripts/test, compile the files of a module together;
# ALONE names files that stay out of it: ITK's headers leak macros, and take clang-tidy a minute; g++ 12 warns of toml++ there.
function(lumesh_module name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "DEPENDS;ALONE")
  file(GLOB sources CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/src/${name}/*.cpp)
  set(target lumesh_${name})
  if(sources)
    add_library(${target} STATIC ${sources})
    set(scope PUBLIC)
  else()
    add_library(${target} INTERFACE)
    set(scope INTERFACE)
  endif()
  foreach(file IN LISTS arg_ALONE)
    set_source_files_properties(${PROJECT_SOURCE_DIR}/src/${name}/${file} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endforeach()
  add_library(lumesh::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${target} ${scope}
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/internal>
    $<INSTALL_INTERFACE:include>)
  target_link_libraries(${target} ${scope} lumesh_flags Eigen3::Eigen)
  foreach(dependency IN LISTS arg_DEPENDS)
    target_link_libraries(${target} ${scope} lumesh_${dependency})
  endforeach()
  if(EXISTS ${PROJECT_SOURCE_DIR}/src/${name}/libraries.cmake)
    include(${PROJECT_SOURCE_DIR}/src/${name}/libraries.cmake)
  endif()
  set_property(GLOBAL APPEND PROPERTY LUMESH_MODULES ${target})
endfunction()
