/* Helpers of surface.cl: rows and layers of its scratch memory. surface.py defines the constants
 * and where each part of a buffer begins (..._AT). */

#ifndef SURFACE_H
#define SURFACE_H

#include "samples.h"

#define LIPS_SIZE (LIPS_WIDE * LIPS_HIGH)
#define LID_SIZE (LID_WIDE * LID_HIGH)
#define SMOOTH (4 * (LASHES - 1) + 1) /* most points of a smooth curve of a lid */
#define PADDED (LIPS_WIDE + 2 * PAD)
#define LAYER LIPS_SIZE
#define BLURRED (LIPS_HIGH * PADDED)

/* Rows at COLUMNS_AT: */
enum {
    /* of the lips, by the columns of the patch */
    TOP, BOTTOM, UPPER, AT_UPPER, LOWER, AT_LOWER, GAP, PER_UPPER, PER_LOWER, UPPER_MORE, LOWER_MORE,
    /* of the lips, by the columns of the grid; LIP begins the rows of each lip, which follow */
    SEAM, LIP,
    FIRST = 0, PER_HEIGHT, BEND, TILT = BEND + 3, ALONG, OF_LIP,
    /* of lids */
    LASH = 0, CREASE, FOLD, LOWER_LASH, PER_LASH, PER_CREASE, PER_FOLD, FALL, ACROSS, LASH_PX,
    LOWER_PX
};

/* Curves of lids, in the order of `rings`. */
enum { LASH_LINE, CREASE_LINE, FOLD_LINE, BROW_LINE, LOWER_LINE };

/* Layers at LAYERS_AT and BLURRED_AT. Lids have LIGHT and AREA alone. */
enum { LIGHT, AREA, LIGHT_BELOW, AREA_BELOW, SLOPE_X, SLOPE_Y };

/* Gaussians from the middle outwards, of LIPS_SIGMA_PX, LID_SIGMA_PX and SEAM_SIGMA_PX in
 * surface.py, cut off at four sigmas; tests/kernels/test_surface.py checks them. */
__constant float surface_lip_taps[13] = {
    0.13298453f, 0.12579799f, 0.10648569f, 0.080659203f, 0.054671578f, 0.03315999f,
    0.0179975f, 0.0087408777f, 0.00379877f, 0.0014773248f, 0.00051410758f, 0.00016009477f,
    4.4611344e-05f};
__constant float surface_lid_taps[8] = {
    0.22164003f, 0.18994482f, 0.1195543f, 0.055266432f, 0.018763599f, 0.004678745f,
    0.00085684267f, 0.00011524744f};
__constant float surface_seam_taps[4] = {0.49867645f, 0.22831072f, 0.021910314f, 0.00044074337f};

/* The slope of a row of `count` numbers at index `at`, as np.gradient computes it.  per_step: 1 /
 * the distance between numbers. */
static inline float surface_slope(__global const float *row, int at, int count, float per_step) {
    int before = at > 0 ? at - 1 : 0, after = at < count - 1 ? at + 1 : at;
    return (row[after] - row[before]) * (after - before == 2 ? 0.5f * per_step : per_step);
}

/* A length with its sign, at least 0.5 away from 0. */
static inline float surface_at_least_half(float x) {
    return x < 0.0f ? eight_min(x, -0.5f) : eight_max(x, 0.5f);
}

/* 1 / sqrt(square), by Newton's method from a good guess. */
static inline float8 surface_inverse_root8(float8 square) {
    float8 root = as_float8(0x5f3759df - (as_int8(square) >> 1));
    root *= 1.5f - 0.5f * square * root * root;
    root *= 1.5f - 0.5f * square * root * root;
    return root * (1.5f - 0.5f * square * root * root);
}

static inline float8 surface_shrink8(float8 x, float8 y) {
    return surface_inverse_root8(1.0f + x * x + y * y);
}

#endif
