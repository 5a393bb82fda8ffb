/* Learns a face's skin from samples, and tells how much each node of the grid looks like that skin.
 * Part of face.cl. face.py defines the constants and where each part of a buffer begins
 * (..._AT). Numpy twin, which explains each step: pipeline/render/skin_likeness_twin.py. */

#ifndef FACE_SKIN_H
#define FACE_SKIN_H

#include "samples.h"

#define NODES (SIDE * SIDE)
#define ROW (PADDED + 8) /* length of a row of the system of equations */

/* Rows at LIGHT_AT and SAMPLE_AT. */
enum { LUMINANCE, RED, GREEN, BLUE, ACROSS, DOWN };

/* Numbers at SKIN_AT: three planes of three, then the lower triangle of the matrix to
 * deviations. */
enum { IS_KNOWN, DARKEST, PLANES, DEVIATIONS = PLANES + 9 };

static inline float8 face_at_least(float8 x, float least) {
    return eight_max8(x, (float8)least);
}

/* 0 at `from`, 1 at `to`, and on in a straight line. */
static inline float8 face_line(float8 x, float from, float to) {
    return (x - from) * (1.0f / (to - from));
}

static inline float8 face_smooth(float8 share) {
    share = eight_clamp8(share, 0.0f, 1.0f);
    return share * share * (3.0f - 2.0f * share);
}

/* e^x for x from FARTHEST to 80, like colour_exp2 but for eight numbers. */
static inline float8 face_exp(float8 x) {
    x *= 1.44269504f;
    float8 shifted = x + 12582912.0f;
    float8 f = x - (shifted - 12582912.0f);
    float8 sum = 0.00132764671f * f + 0.00967554155f;
    sum = sum * f + 0.0555071329f;
    sum = sum * f + 0.240221197f;
    sum = sum * f + 0.693146967f;
    sum = sum * f + 1.00000007f;
    return as_float8(as_int8(sum) + ((as_int8(shifted) - 0x4b400000) << 23));
}

/* The natural logarithm of normal positive numbers, like colour_log2 but for eight numbers. */
static inline float8 face_log(float8 x) {
    int8 exponent = (as_int8(x) - 0x3f3504f3) >> 23;
    float8 z = as_float8(as_int8(x) - (exponent << 23)) - 1.0f;
    float8 sum = -0.145743056f * z + 0.236889936f;
    sum = sum * z - 0.250069334f;
    sum = sum * z + 0.286707528f;
    sum = sum * z - 0.360087196f;
    sum = sum * z + 0.480939442f;
    sum = sum * z - 0.721357149f;
    sum = sum * z + 1.44269477f;
    return 0.693147181f * (eight_float8(exponent) + z * sum);
}

/* A Gaussian of a squared distance; per_square: -1 / (2 sigma^2). */
static inline float8 face_bell(float8 square, float per_square) {
    return face_exp(face_at_least(square * per_square, FARTHEST));
}

/* Collects the samples of the skin: every second node of every second row that is seen in the
 * picture. Returns their number, and fills up the last eight with copies of the first sample. */
EIGHT_STEP int face_collect(
    __global const float *given, __global const float *out, __global float *scratch) {
    __global const float *to = given + TO_FRAME_AT;
    __global float *samples = scratch + SAMPLE_AT;
    int count = 0;
    for (int y = 0; y < SIDE; y += 2)
        for (int x = 0; x < SIDE; x += 2) {
            int at = y * SIDE + x;
            float right = to[0] * (float)x + to[1] * (float)y + to[2] + 0.5f;
            float below = to[3] * (float)x + to[4] * (float)y + to[5] + 0.5f;
            int is_sample = (out[VISIBLE_AT + at] > SAMPLED) &
                            (out[DOWN_AT + at] < given[SAMPLED_DOWN_AT]) & (right > 0.0f) &
                            (right < given[FRAME_WH_AT]) & (below > 0.0f) &
                            (below < given[FRAME_WH_AT + 1]);
            if (!is_sample) continue;
            for (int k = LUMINANCE; k <= BLUE; ++k)
                samples[k * SAMPLES + count] = scratch[LIGHT_AT + k * NODES + at];
            samples[ACROSS * SAMPLES + count] = out[ACROSS_AT + at];
            samples[DOWN * SAMPLES + count] = out[DOWN_AT + at] - MIDDLE;
            ++count;
        }
    for (int k = LUMINANCE; k <= DOWN; ++k)
        for (int i = count; i < count + 8; ++i) samples[k * SAMPLES + i] = samples[k * SAMPLES];
    return count;
}

/* Maps floats to integers of the same order; the same step maps such integers back. */
static inline int8 face_order8(float8 x) {
    int8 bits = as_int8(x);
    return bits ^ ((bits >> 31) & 0x7fffffff);
}

/* The median, found bit by bit: half of `count` numbers, rounded down, come before it. */
EIGHT_STEP float face_median(__global const float *numbers, int count) {
    int low = (int)0x80000000, high = 0x7fffffff, end = count & ~7;
    while (low < high) {
        int middle = (low >> 1) + (high >> 1) + (low & high & 1), before = 0;
        int8 sums = (int8)0;
        for (int i = 0; i < end; i += 8) sums += face_order8(EIGHT(numbers + i)) <= middle;
        for (int i = end; i < count; ++i) {
            int bits = as_int(numbers[i]);
            before += (bits ^ ((bits >> 31) & 0x7fffffff)) <= middle;
        }
        int4 four = sums.lo + sums.hi;
        before -= four.x + four.y + four.z + four.w; /* a true comparison is -1 */
        if (before > count / 2)
            high = middle;
        else
            low = middle + 1;
    }
    return as_float(low ^ ((low >> 31) & 0x7fffffff));
}

/* Computes log luminance, log red to green and log blue to green of eight places. */
static inline void face_numbers(
    __global const float *light, int step, float darkest, float8 *numbers) {
    float8 logs[4];
#pragma unroll
    for (int k = LUMINANCE; k <= BLUE; ++k)
        logs[k] = face_log(face_at_least(EIGHT(light + k * step) + darkest, 1e-9f));
    numbers[0] = logs[LUMINANCE];
    numbers[1] = logs[RED] - logs[GREEN];
    numbers[2] = logs[BLUE] - logs[GREEN];
}

/* Finds the part of the face that is most like skin, and stores its medians in `start`. Returns 0
 * if no part is seen. */
EIGHT_STEP int face_start(int count, float usual, __global float *scratch, float *start) {
    const float from[3] = {FIRST_PART_FROM, SECOND_PART_FROM, THIRD_PART_FROM};
    const float to[3] = {FIRST_PART_TO, SECOND_PART_TO, THIRD_PART_TO};
    __global const float *across = scratch + SAMPLE_AT + ACROSS * SAMPLES;
    __global const float *down = scratch + SAMPLE_AT + DOWN * SAMPLES;
    float best = -INFINITY;
    for (int part = 0; part < 3; ++part) {
        int here = 0;
        for (int i = 0; i < count; ++i) {
            if (!((colour_abs(across[i]) < BESIDE) & (down[i] > from[part]) & (down[i] < to[part])))
                continue;
            for (int k = 0; k < 3; ++k)
                scratch[PART_AT + k * SAMPLES + here] = scratch[NUMBERS_AT + k * SAMPLES + i];
            ++here;
        }
        if (here < FEWEST) continue;
        float medians[3];
        for (int k = 0; k < 3; ++k) medians[k] = face_median(scratch + PART_AT + k * SAMPLES, here);
        float likely = LIGHTER * eight_min(medians[0] - usual, MOST_LIGHTER) +
                       REDDER * eight_min(medians[1], MOST_RED);
        if (likely > best) {
            best = likely;
            for (int k = 0; k < 3; ++k) start[k] = medians[k];
        }
    }
    return best > -INFINITY;
}

/* Inverts the Cholesky root of a symmetric (3, 3) matrix. The matrix and the result are lower
 * triangles by rows: 00; 10, 11; 20, 21, 22. */
static inline void face_root_inverse(const float *of, float *inverse) {
    float a = sqrt(of[0]), b = of[1] / a, c = of[3] / a;
    float d = sqrt(of[2] - b * b), e = (of[4] - b * c) / d, f = sqrt(of[5] - c * c - e * e);
    inverse[0] = 1.0f / a;
    inverse[2] = 1.0f / d;
    inverse[5] = 1.0f / f;
    inverse[1] = -b * inverse[0] * inverse[2];
    inverse[4] = -e * inverse[2] * inverse[5];
    inverse[3] = -(c * inverse[0] + e * inverse[1]) * inverse[5];
}

/* 1 for those of eight samples that exist, 0 for copies that fill up the last eight. */
static inline float8 face_lanes(int i, int count) {
    return (float)i + ROW8 < (float)count ? (float8)1.0f : (float8)0.0f;
}

/* Fits a plane to each number of the samples, and measures how they vary around it. */
EIGHT_STEP void face_fit(int count, const float *start, __global float *scratch) {
    const float spread[3] = {SPREAD_LIGHT, SPREAD_RED, SPREAD_BLUE};
    __global const float *numbers = scratch + NUMBERS_AT;
    __global const float *across = scratch + SAMPLE_AT + ACROSS * SAMPLES;
    __global const float *down = scratch + SAMPLE_AT + DOWN * SAMPLES;
    __global float *shares = scratch + PART_AT, *skin = scratch + SKIN_AT;
    float8 sums[15];
    for (int k = 0; k < 15; ++k) sums[k] = (float8)0.0f;
    for (int i = 0; i < count; i += 8) {
        float8 given[3], far = (float8)0.0f, x = EIGHT(across + i), y = EIGHT(down + i);
#pragma unroll
        for (int k = 0; k < 3; ++k) {
            given[k] = EIGHT(numbers + k * SAMPLES + i);
            float8 off = (given[k] - start[k]) * (1.0f / spread[k]);
            far += off * off;
        }
        float8 share = 1.0f + far * (1.0f / FAR);
        share = face_lanes(i, count) / (share * share);
        PUT(shares + i, share);
        float8 sx = share * x, sy = share * y;
        sums[0] += share;
        sums[1] += sx;
        sums[2] += sx * x;
        sums[3] += sy;
        sums[4] += sy * x;
        sums[5] += sy * y;
#pragma unroll
        for (int k = 0; k < 3; ++k) {
            sums[6 + k] += share * given[k];
            sums[9 + k] += sx * given[k];
            sums[12 + k] += sy * given[k];
        }
    }
    float sum[15];
    for (int k = 0; k < 15; ++k) sum[k] = eight_sum8(sums[k]);
    for (int k = 0; k < 3; ++k) {
        float normal[6], root[6];
        for (int i = 0; i < 6; ++i) normal[i] = sum[i];
        normal[0] += LEVEL_RIDGE;
        normal[2] += k ? COLOUR_ACROSS_RIDGE : LIGHT_ACROSS_RIDGE;
        normal[5] += k ? COLOUR_DOWN_RIDGE : LIGHT_DOWN_RIDGE;
        face_root_inverse(normal, root);
        float a = root[0] * sum[6 + k], b = root[1] * sum[6 + k] + root[2] * sum[9 + k];
        float c = root[3] * sum[6 + k] + root[4] * sum[9 + k] + root[5] * sum[12 + k];
        skin[PLANES + 3 * k] = root[0] * a + root[1] * b + root[3] * c;
        skin[PLANES + 3 * k + 1] = root[2] * b + root[4] * c;
        skin[PLANES + 3 * k + 2] = root[5] * c;
    }
    float8 products[6];
    for (int k = 0; k < 6; ++k) products[k] = (float8)0.0f;
    for (int i = 0; i < count; i += 8) {
        float8 off[3], share = EIGHT(shares + i);
#pragma unroll
        for (int k = 0; k < 3; ++k)
            off[k] = EIGHT(numbers + k * SAMPLES + i) -
                     (skin[PLANES + 3 * k] + skin[PLANES + 3 * k + 1] * EIGHT(across + i) +
                      skin[PLANES + 3 * k + 2] * EIGHT(down + i));
        products[0] += share * off[0] * off[0];
        products[1] += share * off[1] * off[0];
        products[2] += share * off[1] * off[1];
        products[3] += share * off[2] * off[0];
        products[4] += share * off[2] * off[1];
        products[5] += share * off[2] * off[2];
    }
    const int squares[3] = {0, 2, 5};
    float few = EXPECTED * (float)count, varies[6], inverse[6];
    for (int k = 0; k < 6; ++k) varies[k] = eight_sum8(products[k]);
    for (int k = 0; k < 3; ++k) varies[squares[k]] += few * spread[k] * spread[k];
    for (int k = 0; k < 6; ++k) varies[k] /= sum[0] + few;
    face_root_inverse(varies, inverse);
    for (int k = 0; k < 6; ++k) skin[DEVIATIONS + k] = inverse[k];
}

/* Learns this face's skin. */
EIGHT_STEP void face_skin(
    __global const float *given, __global const float *out, __global float *scratch) {
    __global float *skin = scratch + SKIN_AT;
    int count = face_collect(given, out, scratch);
    skin[IS_KNOWN] = 0.0f;
    if (count < FEWEST) return;
    float usual = face_median(scratch + SAMPLE_AT, count);
    skin[DARKEST] = eight_max(DARK * usual, LEAST_LIGHT);
    for (int i = 0; i < count; i += 8) {
        float8 numbers[3];
        face_numbers(scratch + SAMPLE_AT + i, SAMPLES, skin[DARKEST], numbers);
        for (int k = 0; k < 3; ++k) PUT(scratch + NUMBERS_AT + k * SAMPLES + i, numbers[k]);
    }
    float start[3] = {0.0f, 0.0f, 0.0f};
    float log_usual = 0.693147181f * colour_log2(eight_max(usual, LEAST_LIGHT));
    if (!face_start(count, log_usual, scratch, start)) return;
    face_fit(count, start, scratch);
    skin[IS_KNOWN] = 1.0f;
}

/* How much eight nodes look like the face's skin. */
EIGHT_STEP float8 face_likeness(
    int at, __global const float *out, __global const float *scratch) {
    __global const float *skin = scratch + SKIN_AT, *deviations = skin + DEVIATIONS;
    if (skin[IS_KNOWN] == 0.0f) return (float8)1.0f;
    float8 off[3];
    face_numbers(scratch + LIGHT_AT + at, NODES, skin[DARKEST], off);
#pragma unroll
    for (int k = 0; k < 3; ++k)
        off[k] -= skin[PLANES + 3 * k] + skin[PLANES + 3 * k + 1] * EIGHT(out + ACROSS_AT + at) +
                  skin[PLANES + 3 * k + 2] * (EIGHT(out + DOWN_AT + at) - MIDDLE);
    float8 shine = face_at_least(off[0], 0.0f);
    off[0] -= (1.0f - BRIGHTER) * shine;
    off[1] += SHINE_PALES * shine;
    off[2] -= SHINE_PALES * shine;
    float8 paler = face_at_least(off[2] - off[1], 0.0f) * (1.0f / PALER);
    float8 first = deviations[0] * off[0];
    float8 second = deviations[1] * off[0] + deviations[2] * off[1];
    float8 third = deviations[3] * off[0] + deviations[4] * off[1] + deviations[5] * off[2];
    float8 away = sqrt(first * first + second * second + third * third + paler * paler);
    return face_smooth((OTHER - away) * (1.0f / (OTHER - SKIN)));
}

#endif
