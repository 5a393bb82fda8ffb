/* What surface.cl works with: where its numbers lie, and eight of them at a time. */

#ifndef SURFACE_H
#define SURFACE_H

#include "colour.h"

#define PATCH_WIDE 112
#define PATCH_HIGH 80
#define LIPS_WIDE 56 /* their grid: the patch by two */
#define LIPS_HIGH 40
#define LID_WIDE 40
#define LID_HIGH 28
#define LIPS_SIZE (LIPS_WIDE * LIPS_HIGH)
#define LID_SIZE (LID_WIDE * LID_HIGH)

#define RING 11  /* points of half a ring of the lips, corner to corner */
#define LASHES 9 /* points of a curve of a lid */
#define SMOOTH 33

/* Where each part begins in `given`: three places, two planes, how codes mean light, all points, the lips' logits. */
#define PLACE 22
#define LUMA_AT (3 * PLACE)
#define CHROMA_AT (LUMA_AT + 3)
#define TO_STEPS_AT (CHROMA_AT + 3)   /* (3, 4): codes -> R'G'B' in steps of the table of light, and a half */
#define WEIGHTS_AT (TO_STEPS_AT + 12) /* (3,) of luminance */
#define LAST_STEP_AT (WEIGHTS_AT + 3) /* of the table */
#define POINTS_AT (LAST_STEP_AT + 1)
#define LOGITS_AT (POINTS_AT + 3 * 478)

/* Of a place. A point of the frame lies at TO_OWN (point - FROM) + ORIGIN in the region's own px, of which one is
 * STEP_PX px of the frame; TO_LUMA and TO_CHROMA map px of the grid to those of a plane. */
enum { TO_OWN = 0, FROM = 4, ORIGIN = 6, OWN_PX = 8, STEP_PX, TO_LUMA, TO_CHROMA = TO_LUMA + 6 };

/* Of a plane: samples from row to row; and a little less than its last column and row, so that the next sample is
 * always there. */
enum { ROW_STEP, LAST_X, LAST_Y };

/* In `out`: odds and rim on the patch; of the lips shading, x and y of the normal, upper; of each lid up, lash_px,
 * and the first three; the mean light of all three. */
#define RIM_AT (PATCH_WIDE * PATCH_HIGH)
#define LIPS_AT (2 * RIM_AT)
#define LIDS_AT (LIPS_AT + 4 * LIPS_SIZE)
#define MEANS_AT (LIDS_AT + 10 * LID_SIZE)

/* In `scratch`, of each region. Rows by column are as long as the patch is wide; those that are blurred have PAD more
 * on each side, where they are mirrored without repeating the last. */
#define PAD 16
#define PADDED (LIPS_WIDE + 2 * PAD)
#define LAYER LIPS_SIZE
#define BLURRED (LIPS_HIGH * PADDED)
#define CURVES_AT 0 /* height and depth of each curve; the x of both corners of the mouth */
#define CORNERS_AT (24 * PATCH_WIDE)
#define BENDS_AT (CORNERS_AT + 16)
#define COLUMNS_AT (BENDS_AT + 10 * PATCH_WIDE)
#define LIGHT_AT (COLUMNS_AT + 26 * PATCH_WIDE)
#define LAYERS_AT (LIGHT_AT + LAYER)
#define BLURRED_AT (LAYERS_AT + 6 * LAYER)
#define SCRATCH (BLURRED_AT + 6 * BLURRED)

/* Rows at COLUMNS_AT. Of the lips: */
enum {
    TOP, AT_TOP, BOTTOM, AT_BOTTOM, UPPER, AT_UPPER, LOWER, AT_LOWER, GAP, PER_UPPER, PER_LOWER, /* by the patch's */
    SEAM, LIP, /* by the grid's columns; then of each lip: */
    FIRST = 0, PER_HEIGHT, BEND, TILT = BEND + 3, ALONG, OF_LIP,
    /* of lids: */
    LASH = 0, CREASE, PER_LASH, PER_CREASE, BELOW, ABOVE, ACROSS, LASH_PX
};

/* Layers at LAYERS_AT and BLURRED_AT. Lids have LIGHT and AREA alone. */
enum { LIGHT, AREA, LIGHT_BELOW, AREA_BELOW, SLOPE_X, SLOPE_Y };

/* Of Gaussians, from the middle on: sigma 2.5, 1.8 and 0.8, cut off at four sigmas. */
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

/* As np.gradient has it, of row[at] of `count` numbers, of which there are per_step to a unit. */
static inline float surface_slope(__global const float *row, int at, int count, float per_step) {
    int before = at > 0 ? at - 1 : 0, after = at < count - 1 ? at + 1 : at;
    return (row[after] - row[before]) * (after - before == 2 ? 0.5f * per_step : per_step);
}

static inline float surface_at_least_half(float x) {
    return x < 0.0f ? surface_min(x, -0.5f) : surface_max(x, 0.5f);
}

/* Eight numbers that begin anywhere. */
typedef struct __attribute__((packed)) {
    float8 v;
} surface_eight;
#define EIGHT(at) (((__global const surface_eight *)(at))->v)
#define PUT(at, eight) (((__global surface_eight *)(at))->v = (eight))
#define ROW8 (float8)(0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f)

/* PoCL inlines this and not convert_int8. */
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

/* 1 / sqrt(1 + x x + y y): Newton's method, from a good guess. */
static inline float8 surface_shrink8(float8 x, float8 y) {
    float8 square = 1.0f + x * x + y * y;
    float8 root = as_float8(0x5f3759df - (as_int8(square) >> 1));
    root *= 1.5f - 0.5f * square * root * root;
    root *= 1.5f - 0.5f * square * root * root;
    return root * (1.5f - 0.5f * square * root * root);
}

/* Two samples that lie beside each other, as one number. */
#define SURFACE_PAIR_uchar ushort
#define SURFACE_PAIR_ushort uint
#define SURFACE_JOIN(a, b) a##b
#define SURFACE_PAIR_OF(sample) SURFACE_JOIN(SURFACE_PAIR_, sample)
typedef struct __attribute__((packed)) {
    SURFACE_PAIR_OF(SAMPLE) v;
} surface_pair;
#define PAIR(at) ((int)((__global const surface_pair *)(at))->v)
#define PAIRS(plane, at) \
    (int8)(PAIR((plane) + at.s0), PAIR((plane) + at.s1), PAIR((plane) + at.s2), PAIR((plane) + at.s3), \
           PAIR((plane) + at.s4), PAIR((plane) + at.s5), PAIR((plane) + at.s6), PAIR((plane) + at.s7))
#define SAMPLE_BITS (8 * (int)sizeof(SAMPLE))

#endif
