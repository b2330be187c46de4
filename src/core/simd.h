// How one binary uses AVX2 where the machine has it and never an illegal instruction where it has not:
// a hot kernel marked SCSLAM_KERNEL is compiled twice (baseline x86-64 and AVX2); the loader picks one by CPUID.
// The build never sets -march, contracts no floating-point expression (-ffp-contract=off) and reorders none, so both
// versions give the same bits. Sanitizer builds compile the baseline only (they start before the loader's choice).
#pragma once

#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(SCSLAM_NO_MULTIVERSION) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SCSLAM_KERNEL __attribute__((target_clones("default", "avx2")))
#else
#define SCSLAM_KERNEL
#endif
