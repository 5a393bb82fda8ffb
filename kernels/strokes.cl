/* Draws lines between two borders on the pixels of the canvas. Host side: strokes.py, which defines
 * the struct strokes_job. Numpy twin: pipeline/render/strokes_twin.py.
 *
 * A work-item makes eight rows of a job, eight pixels of a row at once.
 * - jobs: the lines, and where each lies.
 * - maps: for each place of a job's grid, and for each of two strokes, how far the place lies above
 *   the lower border and below the upper one; one grid after another.
 * - out: the canvas, `stride` pixels wide. Pixels of a job's rectangle are set, others of the same
 *   eight become 0. */

#include "eight.h"

/* The four numbers of a grid at eight places, bilinear. */
static inline void strokes_between(
    __global const float4 *map, int wide, float8 x, float8 y, float8 *numbers) {
    int8 left = eight_whole8(x), top = eight_whole8(y);
    float8 across = x - eight_float8(left), down = y - eight_float8(top);
    int8 places = top * wide + left;
    const int *at = (const int *)&places;
    const float *right = (const float *)&across, *below = (const float *)&down;
    float4 found[8];
#pragma unroll
    for (int i = 0; i < 8; ++i) {
        __global const float4 *first = map + at[i], *second = first + wide;
        float4 high = first[0] + right[i] * (first[1] - first[0]);
        float4 low = second[0] + right[i] * (second[1] - second[0]);
        found[i] = high + below[i] * (low - high);
    }
    eight_columns8(found, numbers);
}

/* How much of a window around each pixel a line covers: see strokes_twin.py. */
static inline float8 strokes_covered(float8 above, float8 below, float blur, float soft) {
    float half_px = 0.5f * blur;
    float8 covered = eight_min8(above, (float8)half_px) + eight_min8(below, (float8)half_px);
    covered = eight_clamp8(covered * (1.0f / blur), 0.0f, 1.0f);
    /* The lower border's own fade counts from blur = soft on, and fully from twice that on, so that
     * nothing jumps where a picture gets softer. */
    float share = clamp(blur / soft - 1.0f, 0.0f, 1.0f);
    if (share == 0.0f)
        return covered;
    float8 lower = eight_clamp8(above * (1.0f / soft) + 0.5f, 0.0f, 1.0f);
    return covered * (1.0f + share * (lower - 1.0f));
}

__kernel void strokes(
    __global const strokes_job *restrict jobs, __global const float4 *restrict maps,
    __global float *restrict out, const int stride) {
    const strokes_job job = jobs[get_global_id(1)];
    int first = get_global_id(0) * 8, end = first + 8 < job.high ? first + 8 : job.high;
    float last_x = (float)(job.grid_wide - 1), last_y = (float)(job.grid_high - 1);
    int size = job.grid_wide * job.grid_high;
    for (int row = first; row < end; ++row)
        for (int column = job.left & ~7; column < job.left + job.wide; column += 8) {
            float8 px = (float)(column - job.left) + ROW8;
            float8 x = job.to_grid[0] * px + (job.to_grid[1] * (float)row + job.to_grid[2]);
            float8 y = job.to_grid[3] * px + (job.to_grid[4] * (float)row + job.to_grid[5]);
            int8 is_inside = (px >= 0.0f) & (px < (float)job.wide) & (x >= 0.0f) & (x <= last_x) &
                             (y >= 0.0f) & (y <= last_y);
            x = eight_clamp8(x, 0.0f, last_x - STROKES_INSIDE);
            y = eight_clamp8(y, 0.0f, last_y - STROKES_INSIDE);
            float8 weight = (float8)0.0f, numbers[4];
            for (int i = 0; i < job.count; ++i) {
                strokes_between(maps + job.maps + i * size, job.grid_wide, x, y, numbers);
                for (int at = 0; at < 4; at += 2)
                    weight = eight_max8(weight, strokes_covered(numbers[at], numbers[at + 1],
                                                                job.blur_px, job.soft_px));
            }
            PUT(out + job.first + row * stride + column, is_inside ? weight : (float8)0.0f);
        }
}
