# Compiler settings that every lumesh target shares.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/bin)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

find_program(LUMESH_CCACHE ccache)
if(LUMESH_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${LUMESH_CCACHE})
endif()

add_library(lumesh_flags INTERFACE)
# Contraction into fused multiply-add would make results depend on the optimiser: predicates and
# "the same bits for every thread count" rest on this flag.
target_compile_options(lumesh_flags INTERFACE -ffp-contract=off)
target_compile_options(lumesh_flags INTERFACE $<BUILD_INTERFACE:-Wall;-Wextra;-Wpedantic>)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # g++ 12 sees overlapping copies in std::string's own operator+ (gcc.gnu.org/PR105651), and writing past the end in
  # fmt 9's parser of formats, depending on what it inlines.
  target_compile_options(lumesh_flags INTERFACE $<BUILD_INTERFACE:-Wno-restrict;-Wno-stringop-overflow>)
endif()
if(CMAKE_CXX_COMPILER_ID MATCHES "Clang")
  target_compile_options(lumesh_flags INTERFACE $<BUILD_INTERFACE:-Wno-unknown-warning-option>)  # Pragmas for g++.
endif()
if(LUMESH_WERROR)
  target_compile_options(lumesh_flags INTERFACE $<BUILD_INTERFACE:-Werror>)
endif()
if(LUMESH_PARANOID)
  target_compile_definitions(lumesh_flags INTERFACE $<BUILD_INTERFACE:LUMESH_PARANOID>)
endif()
if(LUMESH_SANITIZE)
  # GCC documents that sanitizers make it warn of values that are set; builds without them have that warning.
  target_compile_options(lumesh_flags INTERFACE
    $<BUILD_INTERFACE:-fsanitize=${LUMESH_SANITIZE};-fno-sanitize-recover=all;-fno-omit-frame-pointer;-Wno-maybe-uninitialized>)
  target_link_options(lumesh_flags INTERFACE $<BUILD_INTERFACE:-fsanitize=${LUMESH_SANITIZE}>)
  find_program(LUMESH_LLD ld.lld)
  if(LUMESH_LLD)  # Links a program of 280 MB in 1.5 s of CPU, ld in 3.6.
    target_link_options(lumesh_flags INTERFACE $<BUILD_INTERFACE:-fuse-ld=lld>)
  endif()
endif()
if(LUMESH_SANITIZE MATCHES "undefined")
  # UBSan's checks of every access make builds slow. AddressSanitizer itself stops one through a null pointer or past an
  # end; only what reads the bytes of files can come to one that is not aligned, or to an offset that wraps around.
  target_compile_options(lumesh_flags INTERFACE
    $<BUILD_INTERFACE:-fno-sanitize=null>
    "$<BUILD_INTERFACE:$<$<NOT:$<IN_LIST:$<TARGET_PROPERTY:NAME>,lumesh_io$<SEMICOLON>lumesh_image>>:-fno-sanitize=alignment,pointer-overflow>>")
endif()
if(LUMESH_SANITIZE MATCHES "thread")
  # Debian's oneTBB is not built for ThreadSanitizer; the header there says what stands in for it.
  target_include_directories(lumesh_flags BEFORE INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/tests/tsan>)
endif()
