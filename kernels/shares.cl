/* Looks coats up on the charts of the skin around both eyes, and computes how much of each is seen.
 * Host side: shares.py. Numpy twin: pipeline/render/lay_coats.py.
 *
 * A work-item makes one eye. It computes eight places of a row at once.
 * - given: what all places of an eye share.
 * - first_upper, second_upper, lower_chart: charts (SHARES_LAST_ROW + 1, LID_WIDE, SHARES_COATS) of
 *   densities in parts of 1 / SHARES_ONE, above each eye and below both. Columns are those of the
 *   grid.
 * - lids: (3, 2, LID_HIGH, LID_WIDE), of both eyes: the height above the lash line, and how many px
 *   a place lies above the upper and below the lower lash line.
 * - out: to be filled. */

#include "eight.h"

#define SHARES_LID (LID_HIGH * LID_WIDE)

/* PoCL inlines this builtin, but not convert_float4. */
#define SHARES_FLOAT4(x) convert_float4(x)
#ifdef __has_builtin
#if __has_builtin(__builtin_convertvector)
#undef SHARES_FLOAT4
#define SHARES_FLOAT4(x) __builtin_convertvector(x, float4)
#endif
#endif

/* The densities of all coats at eight places of a chart.  row: the places' rows on the chart. */
static inline void shares_found(
    __global const ushort *chart, float8 row, int x, float8 *densities) {
    row = eight_clamp8(row, 0.0f, SHARES_LAST_ROW);
    int8 top = eight_whole8(row);
    float8 down = row - eight_float8(top);
    int8 columns = top * LID_WIDE + eight_whole8((float)x + ROW8);
    const int *at = (const int *)&columns;
    const float *share = (const float *)&down;
    float4 found[8];
#pragma unroll
    for (int i = 0; i < 8; ++i) {
        __global const ushort4 *place = (__global const ushort4 *)chart + at[i];
        float4 above = SHARES_FLOAT4(place[0]), under = SHARES_FLOAT4(place[LID_WIDE]);
        found[i] = above + share[i] * (under - above);
    }
    eight_columns8(found, densities);
    for (int i = 0; i < SHARES_COATS; ++i) densities[i] *= 1.0f / SHARES_ONE;
}

/* Joins the densities above an eye and below it. */
EIGHT_STEP void shares_joined(
    const shares_given *eye, __global const ushort *upper_chart,
    __global const ushort *lower_chart, __global const float *lids, int x, int at,
    float8 *densities) {
    float8 lower[SHARES_COATS];
    float8 below = EIGHT(lids + 4 * SHARES_LID + at);
    if (eye->is_upper)
        shares_found(upper_chart, EIGHT(lids + at) * SHARES_ROWS_UP, x, densities);
    if (!eye->is_lower) return;
    shares_found(lower_chart, below * eye->rows_down, x, lower);
    float8 beyond = (EIGHT(lids + 2 * SHARES_LID + at) - below) * eye->fade;
    float8 above_share = eight_clamp8(1.0f + beyond, 0.0f, 1.0f);
    float8 below_share = eight_clamp8(1.0f - beyond, 0.0f, 1.0f);
    for (int i = 0; i < SHARES_COATS; ++i)
        densities[i] = eye->is_upper
                           ? eight_max8(densities[i] * above_share, lower[i] * below_share)
                           : lower[i];
}

__kernel void shares(
    __global const shares_given *restrict given, __global const ushort *restrict first_upper,
    __global const ushort *restrict second_upper, __global const ushort *restrict lower_chart,
    __global const float *restrict lids, __global shares_made *restrict out) {
    int number = get_global_id(0), first = number * SHARES_LID;
    shares_given eye = given[number];
    __global const ushort *upper_chart = number ? second_upper : first_upper;
    int count = eye.count;
    float8 sums[SHARES_COATS];
    for (int i = 0; i < SHARES_COATS; ++i) sums[i] = (float8)0.0f;
    for (int y = 0; y < LID_HIGH; ++y)
        for (int x = 0; x < LID_WIDE; x += 8) {
            int at = first + y * LID_WIDE + x;
            float8 densities[SHARES_COATS];
            shares_joined(&eye, upper_chart, lower_chart, lids, x, at, densities);
            if (count == 1) {
                PUT(out->density + at, densities[0]);
                continue;
            }
            float8 through = (float8)1.0f, most = (float8)0.0f;
#pragma unroll
            for (int i = SHARES_COATS - 1; i >= 0; --i) {
                if (i >= count) continue;
                float8 share = densities[i] * through;
                through -= eye.opacities[i] * share;
                most = eight_max8(most, densities[i]);
                sums[i] += share;
                PUT(out->shares + 2 * i * SHARES_LID + at, share);
            }
            PUT(out->density + at, most > SHARES_FAINTEST ? (float8)1.0f : (float8)0.0f);
        }
    for (int i = 0; i < SHARES_COATS; ++i)
        out->seen[number * SHARES_COATS + i] = eight_sum8(sums[i]);
}
