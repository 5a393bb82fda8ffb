/* Helpers of surface.cl and face.cl: eight numbers at a time, and samples of planes. light.py has
 * the layout of ROW_STEP_AT, LAST_X_AT and LAST_Y_AT. */

#ifndef EIGHT_H
#define EIGHT_H

#include "colour.h"

#ifndef SAMPLE
#define SAMPLE uchar
#endif

/* Not inlined: the program compiles in half the time and runs as fast. */
#define SURFACE_STEP static __attribute__((noinline))

/* Shares items out to the work-items of a group. */
#define EACH(item, count) (int item = get_local_id(0); item < (count); item += get_local_size(0))

static inline float surface_min(float a, float b) { return a < b ? a : b; }
static inline float surface_max(float a, float b) { return a > b ? a : b; }
static inline float surface_clamp(float x, float low, float high) {
    return surface_min(surface_max(x, low), high);
}

static inline int surface_mirror(int i, int count) {
    i = i < 0 ? -i : i;
    return i < count ? i : 2 * (count - 1) - i;
}

/* Eight numbers at any address. */
typedef struct __attribute__((packed)) {
    float8 v;
} surface_eight;
#define EIGHT(at) (((__global const surface_eight *)(at))->v)
#define PUT(at, eight) (((__global surface_eight *)(at))->v = (eight))
#define ROW8 (float8)(0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f)

/* PoCL inlines this builtin, but not convert_int8. */
#define surface_whole8(x) convert_int8(x)
#define surface_float8(x) convert_float8(x)
#ifdef __has_builtin
#if __has_builtin(__builtin_convertvector)
#undef surface_whole8
#undef surface_float8
#define surface_whole8(x) __builtin_convertvector(x, int8)
#define surface_float8(x) __builtin_convertvector(x, float8)
#endif
#endif

static inline float8 surface_min8(float8 a, float8 b) { return a < b ? a : b; }
static inline float8 surface_max8(float8 a, float8 b) { return a > b ? a : b; }
static inline float8 surface_clamp8(float8 x, float low, float high) {
    return surface_min8(surface_max8(x, (float8)low), (float8)high);
}

static inline float surface_sum8(float8 x) {
    float4 four = x.lo + x.hi;
    return four.x + four.y + four.z + four.w;
}

/* Two adjacent samples, as one number. */
#define SURFACE_PAIR_uchar ushort
#define SURFACE_PAIR_ushort uint
#define SURFACE_JOIN(a, b) a##b
#define SURFACE_PAIR_OF(sample) SURFACE_JOIN(SURFACE_PAIR_, sample)
typedef struct __attribute__((packed)) {
    SURFACE_PAIR_OF(SAMPLE) v;
} surface_pair;
#define PAIR(at) ((int)((__global const surface_pair *)(at))->v)
#define PAIRS(plane, at)                                                     \
    (int8)(                                                                  \
        PAIR((plane) + at.s0), PAIR((plane) + at.s1), PAIR((plane) + at.s2), \
        PAIR((plane) + at.s3), PAIR((plane) + at.s4), PAIR((plane) + at.s5), \
        PAIR((plane) + at.s6), PAIR((plane) + at.s7))
#define SAMPLE_BITS (8 * (int)sizeof(SAMPLE))

/* Samples a plane at eight places, bilinear; its border is repeated. */
static inline float8 surface_sample(
    __global const SAMPLE *plane, __global const float *of, __global const float *to, float8 x,
    float y) {
    float8 u = surface_clamp8(to[0] * x + (to[1] * y + to[2]), 0.0f, of[LAST_X_AT]);
    float8 v = surface_clamp8(to[3] * x + (to[4] * y + to[5]), 0.0f, of[LAST_Y_AT]);
    int8 left = surface_whole8(u), top = surface_whole8(v);
    float8 across = u - surface_float8(left), down = v - surface_float8(top);
    int8 at = top * (int)of[ROW_STEP_AT] + left;
    int8 above = PAIRS(plane, at), below = PAIRS(plane + (int)of[ROW_STEP_AT], at);
    int mask = (1 << SAMPLE_BITS) - 1;
    float8 high = surface_float8(above & mask), low = surface_float8(below & mask);
    high += across * (surface_float8((above >> SAMPLE_BITS) & mask) - high);
    low += across * (surface_float8((below >> SAMPLE_BITS) & mask) - low);
    return high + down * (low - high);
}

#endif
