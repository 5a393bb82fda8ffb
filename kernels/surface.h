/* Helpers of surface.cl: rows and layers of its scratch memory, and eight numbers at a time.
 * surface.py defines the constants and where each part of a buffer begins (..._AT). */

#ifndef SURFACE_H
#define SURFACE_H

#include "colour.h"

#define LIPS_SIZE (LIPS_WIDE * LIPS_HIGH)
#define LID_SIZE (LID_WIDE * LID_HIGH)
#define SMOOTH (4 * (LASHES - 1) + 1) /* most points of a smooth curve of a lid */
#define PADDED (LIPS_WIDE + 2 * PAD)
#define LAYER LIPS_SIZE
#define BLURRED (LIPS_HIGH * PADDED)

/* Rows at COLUMNS_AT: */
enum {
    /* of the lips, by the columns of the patch */
    TOP, AT_TOP, BOTTOM, AT_BOTTOM, UPPER, AT_UPPER, LOWER, AT_LOWER, GAP, PER_UPPER, PER_LOWER,
    /* of the lips, by the columns of the grid; LIP begins the rows of each lip, which follow */
    SEAM, LIP,
    FIRST = 0, PER_HEIGHT, BEND, TILT = BEND + 3, ALONG, OF_LIP,
    /* of lids */
    LASH = 0, CREASE, FOLD, LOWER_LASH, PER_LASH, PER_CREASE, PER_FOLD, BELOW, ABOVE, ACROSS,
    LASH_PX, LOWER_PX
};

/* Curves of lids, in the order of `rings`. */
enum { LASH_LINE, CREASE_LINE, FOLD_LINE, BROW_LINE, LOWER_LINE };

/* Layers at LAYERS_AT and BLURRED_AT. Lids have LIGHT and AREA alone. */
enum { LIGHT, AREA, LIGHT_BELOW, AREA_BELOW, SLOPE_X, SLOPE_Y };

/* Gaussians from the middle outwards, of LIPS_SIGMA_PX, LID_SIGMA_PX and SEAM_SIGMA_PX in
 * surface.py, cut off at four sigmas; tests/kernels/test_surface.py compares them. */
__constant float surface_lip_taps[11] = {
    0.15958068f, 0.14731153f, 0.11587936f, 0.077676256f, 0.044369381f, 0.021596896f,
    0.0089580236f, 0.0031662554f, 0.00095365779f, 0.00024476655f, 5.3533354e-05f};
__constant float surface_lid_taps[8] = {
    0.22164003f, 0.18994482f, 0.1195543f, 0.055266432f, 0.018763599f, 0.004678745f,
    0.00085684267f, 0.00011524744f};
__constant float surface_seam_taps[4] = {0.49867645f, 0.22831072f, 0.021910314f, 0.00044074337f};

static inline float surface_min(float a, float b) { return a < b ? a : b; }
static inline float surface_max(float a, float b) { return a > b ? a : b; }
static inline float surface_clamp(float x, float low, float high) {
    return surface_min(surface_max(x, low), high);
}

static inline int surface_mirror(int i, int count) {
    i = i < 0 ? -i : i;
    return i < count ? i : 2 * (count - 1) - i;
}

/* The slope at row[at], as np.gradient computes it, of `count` numbers; per_step: 1 / their
 * distance. */
static inline float surface_slope(__global const float *row, int at, int count, float per_step) {
    int before = at > 0 ? at - 1 : 0, after = at < count - 1 ? at + 1 : at;
    return (row[after] - row[before]) * (after - before == 2 ? 0.5f * per_step : per_step);
}

static inline float surface_at_least_half(float x) {
    return x < 0.0f ? surface_min(x, -0.5f) : surface_max(x, 0.5f);
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

/* 1 / sqrt(1 + x x + y y), by Newton's method from a good guess. */
static inline float8 surface_shrink8(float8 x, float8 y) {
    float8 square = 1.0f + x * x + y * y;
    float8 root = as_float8(0x5f3759df - (as_int8(square) >> 1));
    root *= 1.5f - 0.5f * square * root * root;
    root *= 1.5f - 0.5f * square * root * root;
    return root * (1.5f - 0.5f * square * root * root);
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

#endif
