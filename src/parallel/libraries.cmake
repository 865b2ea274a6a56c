find_path(LUMESH_HWLOC_INCLUDE_DIR hwloc.h REQUIRED)
find_library(LUMESH_HWLOC_LIBRARY hwloc REQUIRED)
target_include_directories(${target} SYSTEM PRIVATE ${LUMESH_HWLOC_INCLUDE_DIR})
target_link_libraries(${target} ${scope} TBB::tbb Threads::Threads PRIVATE hwloc)
