/* Helpers of kernels that compute eight numbers at a time. */

#ifndef EIGHT_H
#define EIGHT_H

#include "colour.h"

/* Not inlined: the program compiles in half the time and runs as fast. */
#define EIGHT_STEP static __attribute__((noinline))

/* Shares items out to the work-items of a group. */
#define EACH(item, count) (int item = get_local_id(0); item < (count); item += get_local_size(0))

static inline float eight_min(float a, float b) { return a < b ? a : b; }
static inline float eight_max(float a, float b) { return a > b ? a : b; }
static inline float eight_clamp(float x, float low, float high) {
    return eight_min(eight_max(x, low), high);
}

/* An index, mirrored at both ends of `count` numbers without repeating the last one. */
static inline int eight_mirror(int i, int count) {
    i = i < 0 ? -i : i;
    return i < count ? i : 2 * (count - 1) - i;
}

/* Eight numbers at any address. */
typedef struct __attribute__((packed)) {
    float8 v;
} eight_floats;
#define EIGHT(at) (((__global const eight_floats *)(at))->v)
#define PUT(at, eight) (((__global eight_floats *)(at))->v = (eight))
#define ROW8 (float8)(0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f)

/* PoCL inlines this builtin, but not convert_int8. */
#define eight_whole8(x) convert_int8(x)
#define eight_float8(x) convert_float8(x)
#ifdef __has_builtin
#if __has_builtin(__builtin_convertvector)
#undef eight_whole8
#undef eight_float8
#define eight_whole8(x) __builtin_convertvector(x, int8)
#define eight_float8(x) __builtin_convertvector(x, float8)
#endif
#endif

static inline float8 eight_min8(float8 a, float8 b) { return a < b ? a : b; }
static inline float8 eight_max8(float8 a, float8 b) { return a > b ? a : b; }
static inline float8 eight_clamp8(float8 x, float low, float high) {
    return eight_min8(eight_max8(x, (float8)low), (float8)high);
}

static inline float eight_sum8(float8 x) {
    float4 four = x.lo + x.hi;
    return four.x + four.y + four.z + four.w;
}

/* Turns the four numbers of each of eight places into four rows of eight. */
static inline void eight_columns8(const float4 *places, float8 *numbers) {
#define EIGHT_COLUMN(name)                                                             \
    (float8)(                                                                          \
        places[0].name, places[1].name, places[2].name, places[3].name, places[4].name, \
        places[5].name, places[6].name, places[7].name)
    numbers[0] = EIGHT_COLUMN(s0);
    numbers[1] = EIGHT_COLUMN(s1);
    numbers[2] = EIGHT_COLUMN(s2);
    numbers[3] = EIGHT_COLUMN(s3);
#undef EIGHT_COLUMN
}

#endif
