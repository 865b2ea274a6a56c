# cmake --install gives the program, the libraries, the headers and the package for find_package(lumesh):
# lumesh::lumesh is everything, lumesh::<module> one module with what it stands on.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

get_property(modules GLOBAL PROPERTY LUMESH_MODULES)
add_library(lumesh_all INTERFACE)
add_library(lumesh::lumesh ALIAS lumesh_all)
set_target_properties(lumesh_all PROPERTIES EXPORT_NAME lumesh)
target_link_libraries(lumesh_all INTERFACE ${modules})
target_compile_features(lumesh_flags INTERFACE cxx_std_20)

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/lumesh)
install(TARGETS lumesh RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
# What shells complete commands and options by comes from the program itself.
install(CODE "foreach(place bash:bash-completion/completions/lumesh zsh:zsh/site-functions/_lumesh
                      fish:fish/vendor_completions.d/lumesh.fish)
  string(REPLACE : \\; place \${place})
  list(GET place 0 shell)
  list(GET place 1 path)
  set(path \$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}/\${path})
  execute_process(COMMAND $<TARGET_FILE:lumesh> completion \${shell} OUTPUT_VARIABLE script COMMAND_ERROR_IS_FATAL ANY)
  file(WRITE \${path} \"\${script}\")
  message(STATUS \"Installing: \${path}\")
endforeach()")
install(TARGETS lumesh_all lumesh_flags ${modules} EXPORT lumeshTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY include/lumesh DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.hpp"
  PATTERN "*.h")
install(EXPORT lumeshTargets NAMESPACE lumesh:: DESTINATION ${package_folder})
configure_package_config_file(cmake/lumeshConfig.cmake.in lumeshConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(lumeshConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/lumeshConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/lumeshConfigVersion.cmake
  DESTINATION ${package_folder})
install(FILES README.md LICENSE NOTICE DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs/ DESTINATION ${CMAKE_INSTALL_DOCDIR}/docs)
