#pragma once
/// @file Loops that use the widest vector instructions of the machine they run on.

/// Put before a function: it is compiled three times, for every x86-64 processor, for those with AVX2 (2013
/// and later) and for those with AVX-512, and the program picks when it starts. Results are bitwise
/// identical, as no multiplication is fused with an addition. An attribute that not every compiler knows
/// needs a macro; sanitizers' programs do without it, because the choice is made before their runtime is set
/// up. So do unoptimised ones: functions that are not inlined return vectors elsewhere than the wide caller
/// looks for them.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && defined(__OPTIMIZE__) && \
    !defined(__SANITIZE_THREAD__) && !defined(__SANITIZE_ADDRESS__)
#define LUMESH_WIDE_LOOPS __attribute__((target_clones("arch=x86-64-v4", "avx2", "default")))
#else
#define LUMESH_WIDE_LOOPS
#endif
