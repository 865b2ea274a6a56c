# ITK's CMake package drags in all of its optional dependencies; the few input modules are found by name instead.
find_path(LUMESH_ITK_INCLUDE_DIR itkImageIOBase.h PATH_SUFFIXES ITK-5.2 ITK-5.3 ITK-5.4 REQUIRED)
target_include_directories(${target} SYSTEM PRIVATE ${LUMESH_ITK_INCLUDE_DIR})
string(REGEX MATCH "ITK-([0-9.]+)" _ "${LUMESH_ITK_INCLUDE_DIR}")
foreach(module ITKIONRRD ITKIOGIPL ITKIOGDCM ITKIOImageBase ITKCommon itkvnl_algo itkvnl itksys)
  target_link_libraries(${target} PRIVATE ${module}-${CMAKE_MATCH_1})
endforeach()
target_link_libraries(${target} PRIVATE ZLIB::ZLIB fmt::fmt pugixml::pugixml nlohmann_json::nlohmann_json)
