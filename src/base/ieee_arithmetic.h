// To be included where an answer depends on the error bounds of IEEE arithmetic. The compiler refuses other arithmetic.
#pragma once

#include <cfloat>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || \
    defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__)
#error "Tessera needs IEEE arithmetic: with -ffast-math, -Ofast or their parts its answers would be wrong"
#endif
static_assert(FLT_EVAL_METHOD == 0, "Tessera needs IEEE arithmetic: doubles rounded at each operation, as by SSE2");
