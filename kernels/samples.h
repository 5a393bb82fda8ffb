/* Helpers of surface.cl and face.cl: samples of planes, eight at a time. light.py has the layout of
 * ROW_STEP_AT, LAST_X_AT and LAST_Y_AT; program.py defines SAMPLE. */

#ifndef SAMPLES_H
#define SAMPLES_H

#include "eight.h"

/* Two adjacent samples, as one number. */
#define SAMPLES_PAIR_uchar ushort
#define SAMPLES_PAIR_ushort uint
#define SAMPLES_JOIN(a, b) a##b
#define SAMPLES_PAIR_OF(sample) SAMPLES_JOIN(SAMPLES_PAIR_, sample)
typedef struct __attribute__((packed)) {
    SAMPLES_PAIR_OF(SAMPLE) v;
} samples_pair;
#define PAIR(at) ((int)((__global const samples_pair *)(at))->v)
#define PAIRS(plane, at)                                                     \
    (int8)(                                                                  \
        PAIR((plane) + at.s0), PAIR((plane) + at.s1), PAIR((plane) + at.s2), \
        PAIR((plane) + at.s3), PAIR((plane) + at.s4), PAIR((plane) + at.s5), \
        PAIR((plane) + at.s6), PAIR((plane) + at.s7))
#define SAMPLE_BITS (8 * (int)sizeof(SAMPLE))

/* Samples a plane at eight places, bilinear; its border is repeated. */
static inline float8 samples_bilinear(
    __global const SAMPLE *plane, __global const float *of, __global const float *to, float8 x,
    float y) {
    float8 u = eight_clamp8(to[0] * x + (to[1] * y + to[2]), 0.0f, of[LAST_X_AT]);
    float8 v = eight_clamp8(to[3] * x + (to[4] * y + to[5]), 0.0f, of[LAST_Y_AT]);
    int8 left = eight_whole8(u), top = eight_whole8(v);
    float8 across = u - eight_float8(left), down = v - eight_float8(top);
    int8 at = top * (int)of[ROW_STEP_AT] + left;
    int8 above = PAIRS(plane, at), below = PAIRS(plane + (int)of[ROW_STEP_AT], at);
    int mask = (1 << SAMPLE_BITS) - 1;
    float8 high = eight_float8(above & mask), low = eight_float8(below & mask);
    high += across * (eight_float8((above >> SAMPLE_BITS) & mask) - high);
    low += across * (eight_float8((below >> SAMPLE_BITS) & mask) - low);
    return high + down * (low - high);
}

#endif
