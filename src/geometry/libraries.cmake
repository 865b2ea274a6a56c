# CGAL's kernel is header-only; its exact numbers come from GMP. Interval arithmetic needs -frounding-math.
set_source_files_properties(${PROJECT_SOURCE_DIR}/src/geometry/predicates.cpp PROPERTIES COMPILE_OPTIONS -frounding-math)
target_link_libraries(${target} ${scope} gmp)
