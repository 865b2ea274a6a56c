#pragma once
/// @file What a plugin for sizes exports: plain C (C99) and C++, version 1.
///
/// A plugin is a shared library that says how fine a mesh should be, loaded with `--sizing
/// plugin.so[:options]`. It defines lumesh_sizing_abi_version() and at least one of lumesh_size_at() and
/// lumesh_should_be_adapted(); the rest is optional. docs/sizing.md and examples/sizing_plugin show how.
///
/// Points are in physical mm in the frame of the image (LPS: x to the left, y to the back, z to the head).
/// Contract of all functions:
///   - They do not throw, and do not end the program. (Exceptions are caught and reported, but not from C.)
///   - lumesh_size_at() and lumesh_should_be_adapted() are called from any thread, from many at once, and
///     very often (some ten times per tetrahedron): make what they read in lumesh_sizing_create(), and do not
///     change it.
///   - They answer the same for the same question. Otherwise a mesh is not reproducible.
///   - They leave the rounding mode and the treatment of subnormal numbers alone.
/// The library stays loaded until the program ends.

#include <stddef.h>  // C reads this too.

/// Version of what stands here. A plugin compiled for another one is refused.
#define LUMESH_SIZING_ABI_VERSION 1

/// Stands before the definition of each function, so that it can be found in the library.
#ifdef __cplusplus
#define LUMESH_SIZING_EXPORT extern "C" __attribute__((visibility("default")))
#else
#define LUMESH_SIZING_EXPORT __attribute__((visibility("default")))
#endif

/// Required: returns LUMESH_SIZING_ABI_VERSION.
LUMESH_SIZING_EXPORT int lumesh_sizing_abi_version(void);

/// Optional: called once before all others, on one thread. A plugin without it takes no options.
///
/// @param options       What follows the colon in `--sizing plugin.so:options`; "" if there is none.
/// @param state         May be set; handed to the functions below. It is null at first.
/// @param message       For one line (ended by 0) that says what is wrong and what to do, in case of failure.
/// @param message_size  Room there, with the 0; at least 256.
/// @return              0; anything else is a failure, which ends the program with the message.
LUMESH_SIZING_EXPORT int lumesh_sizing_create(const char* options, void** state, char* message,
                                              size_t message_size);

/// Optional: called once after all others, on one thread, if lumesh_sizing_create() succeeded.
LUMESH_SIZING_EXPORT void lumesh_sizing_destroy(void* state);

/// Wanted edge length at a point in mm, > 0, or infinity where any size will do. Any other answer (NaN, 0,
/// less than 0) counts as infinity, and is reported.
LUMESH_SIZING_EXPORT double lumesh_size_at(void* state, double x, double y, double z);

/// Whether an element is too large: not 0 if it should be refined. Called for elements that are small enough
/// by all sizes; it has to be 0 once elements are small, or refinement does not end.
///
/// @param points  x, y, z of each point, 3 n numbers.
/// @param n       Number of points: 4, a tetrahedron.
LUMESH_SIZING_EXPORT int lumesh_should_be_adapted(void* state, const double* points, int n);
