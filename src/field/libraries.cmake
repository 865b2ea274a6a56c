# Eight floats by value between functions of this module alone: how others would pass them does not matter.
target_compile_options(${target} PRIVATE -Wno-psabi)
