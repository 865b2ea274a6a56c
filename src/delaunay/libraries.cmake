# Sizing plugins are loaded with dlopen().
target_link_libraries(${target} PRIVATE fmt::fmt ${CMAKE_DL_LIBS})
