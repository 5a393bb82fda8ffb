/* Makes the surface of a face from its points and the frame around it: where each node of a grid
 * lies on the mean face, how it is turned, how visible it is, how much it looks like skin, and the
 * broad light on it. Host side, with all constants and the layout of each buffer: face.py. Numpy
 * twins, which explain each step: pipeline/render/surfaces/face_twin.py, face_fit_twin.py and
 * pipeline/render/skin_likeness_twin.py.
 *
 * One work-group makes all of it, step by step; a work-item computes eight nodes at once.
 *
 * - given: the face and the frame, GIVEN in face.py.
 * - tables: what all faces share, TABLES.
 * - planes: Y', Cb and Cr, one after another.
 * - table: linear light of R'G'B'.
 * - scratch: SCRATCH.
 * - out: to be filled, OUT. */

#include "face_skin.h"

#define BLURRED (SIDE + 2 * PAD)

/* Gaussian of SIGMA_PX from the middle outwards; tests/kernels/test_face.py checks it. */
__constant float face_taps[4] = {
    0.613464348f, 0.187858721f, 0.00539457781f, 1.45267221e-05f};

/* The same for EDGE_PX and HOLE_PX, cut off at MARGIN and at half of MARGIN. */
__constant float face_edge_taps[5] = {
    0.306998819f, 0.228374287f, 0.0940110162f, 0.0214156508f, 0.00269963359f};
__constant float face_hole_taps[3] = {0.6638183f, 0.165524572f, 0.00256626867f};

/* The terms of the cubic: x^i y^j with i + j up to DEGREE. */
static inline void face_terms(float8 x, float8 y, float8 *terms) {
    float8 along = (float8)1.0f;
    int at = 0;
#pragma unroll
    for (int i = 0; i <= DEGREE; ++i) {
        float8 power = along;
#pragma unroll
        for (int j = 0; j <= DEGREE - i; ++j) {
            terms[at++] = power;
            power *= y;
        }
        along *= x;
    }
}

/* Computes the normals, the variance of the noise and the cubic's terms of eight points. */
EIGHT_STEP void face_points(
    int i, __global const float *given, __global const float *tables, __global float *scratch) {
    __global const float *points = given + POINTS_AT;
    float8 tangents[6];
#pragma unroll
    for (int k = 0; k < 6; ++k) tangents[k] = (float8)0.0f;
    for (int p = 0; p < POINTS; ++p) {
        float8 first = EIGHT(tables + TANGENTS_AT + p * PADDED + i);
        float8 second = EIGHT(tables + TANGENTS_AT + (POINTS + p) * PADDED + i);
#pragma unroll
        for (int k = 0; k < 3; ++k) {
            tangents[k] += first * points[k * PADDED + p];
            tangents[3 + k] += second * points[k * PADDED + p];
        }
    }
    float8 nx = tangents[2] * tangents[4] - tangents[1] * tangents[5];
    float8 ny = tangents[0] * tangents[5] - tangents[2] * tangents[3];
    float8 nz = tangents[0] * tangents[4] - tangents[1] * tangents[3];
    float8 shrink = 1.0f / (sqrt(nx * nx + ny * ny + nz * nz) + 1e-9f);
    PUT(scratch + NORMAL_AT + i, nx * shrink);
    PUT(scratch + NORMAL_AT + PADDED + i, ny * shrink);
    PUT(scratch + NORMAL_AT + 2 * PADDED + i, nz * shrink);
    float8 x = EIGHT(points + i), y = EIGHT(points + PADDED + i),
           away = EIGHT(points + 2 * PADDED + i);
    float8 hidden = (float8)0.0f;
    for (int f = 0; f < FRONT_POINTS; ++f) {
        int p = (int)tables[FRONT_AT + f];
        float8 nearer = face_line(away - points[2 * PADDED + p], NEARER_FROM, NEARER_TO);
        float8 across = x - points[p], down = y - points[PADDED + p];
        float8 hides = eight_clamp8(nearer, 0.0f, 1.0f) *
                       face_bell(across * across + down * down, PER_CLOSE) *
                       EIGHT(tables + MAY_HIDE_AT + f * PADDED + i);
        hidden = eight_max8(hidden, hides);
    }
    float8 seen = face_at_least(1.0f - HIDES * hidden, 0.0f);
    float8 weight =
        face_smooth(face_line(nz * shrink, POINT_FACING_FROM, POINT_FACING_TO)) * seen * seen;
    PUT(scratch + NOISE_AT + i, NOISE / face_at_least(weight, LEAST));
    float8 terms[TERMS];
    face_terms(x, y, terms);
    for (int t = 0; t < TERMS; ++t) PUT(scratch + TERMS_AT + t * PADDED + i, terms[t]);
}

/* Fills a row of the fit's equations; the last eight numbers of a row are its right-hand sides. */
EIGHT_STEP void face_equation(
    int row, __global const float *given, __global const float *tables, __global float *scratch) {
    __global const float *points = given + POINTS_AT, *terms = scratch + TERMS_AT;
    __global float *out = scratch + SYSTEM_AT + row * ROW;
    for (int i = 0; i < PADDED; i += 8) {
        float8 across = EIGHT(points + i) - points[row],
               down = EIGHT(points + PADDED + i) - points[PADDED + row];
        float8 alike = (float8)0.0f;
        for (int t = 0; t < TERMS; ++t)
            alike += EIGHT(terms + t * PADDED + i) * terms[t * PADDED + row];
        PUT(out + i, CUBIC * alike + face_bell(across * across + down * down, PER_SIGMA));
    }
    out[row] += scratch[NOISE_AT + row];
    __global const float *normal = scratch + NORMAL_AT + row, *mean = tables + MEAN_XY_AT + row;
    PUT(out + PADDED,
        (float8)(
            mean[0], mean[PADDED], normal[0], normal[PADDED], normal[2 * PADDED], 0.0f, 0.0f,
            0.0f));
}

/* Solves the equations, by elimination: the matrix is symmetric, and no pivot is less than NOISE
 * apart from rounding. The last eight of each row become the heights of its point's Gaussians. */
EIGHT_STEP void face_solve(__global float *scratch) {
    __global float *system = scratch + SYSTEM_AT;
    for (int k = 0; k < POINTS; ++k) {
        __global float *from = system + k * ROW;
        float share = 1.0f / eight_max(from[k], 0.5f * NOISE);
        for (int row = k + 1; row < POINTS; ++row) {
            __global float *to = system + row * ROW;
            float times = from[row] * share;
            for (int i = row & ~7; i < ROW; i += 8)
                PUT(to + i, EIGHT(to + i) - times * EIGHT(from + i));
        }
    }
    for (int k = POINTS - 1; k >= 0; --k) {
        __global float *row = system + k * ROW;
        float8 sum = EIGHT(row + PADDED);
        for (int i = k + 1; i < POINTS; ++i) sum -= row[i] * EIGHT(system + i * ROW + PADDED);
        PUT(row + PADDED, sum * (1.0f / eight_max(row[k], 0.5f * NOISE)));
    }
    for (int t = 0; t < TERMS; ++t) {
        float8 sum = (float8)0.0f;
        for (int p = 0; p < POINTS; ++p)
            sum += scratch[TERMS_AT + t * PADDED + p] * EIGHT(system + p * ROW + PADDED);
        PUT(scratch + CUBIC_AT + 8 * t, CUBIC * sum);
    }
}

/* Computes the Gaussians of a point at eight columns, or rows, of the grid. */
EIGHT_STEP void face_near(
    int point, int i, int axis, __global const float *given, __global float *scratch) {
    float8 off = STEP * ((float)i - 0.5f * (SIDE - 1) + ROW8) -
                 given[POINTS_AT + axis * PADDED + point];
    __global float *near = scratch + (axis ? NEAR_Y_AT : NEAR_X_AT) + point * SIDE + i;
    PUT(near, face_bell(off * off, PER_SIGMA));
}

/* Blurs eight px of both drawn masks along their row. */
EIGHT_STEP void face_borders(
    int x, int row, __global const float *given, __global float *scratch) {
    __global const float *inside = given + INSIDE_AT + row * DRAWN + x + MARGIN;
    __global const float *holes = given + HOLES_AT + row * DRAWN + x + MARGIN;
    float8 edge = face_edge_taps[0] * EIGHT(inside), hole = face_hole_taps[0] * EIGHT(holes);
    for (int i = 1; i <= MARGIN; ++i)
        edge += face_edge_taps[i] * (EIGHT(inside - i) + EIGHT(inside + i));
    for (int i = 1; i <= MARGIN / 2; ++i)
        hole += face_hole_taps[i] * (EIGHT(holes - i) + EIGHT(holes + i));
    PUT(scratch + BORDERS_AT + row * SIDE + x, edge);
    PUT(scratch + BORDERS_AT + (DRAWN + row) * SIDE + x, hole);
}

/* How much of eight nodes is skin by the drawn masks, within the outline of the face and outside
 * eyes, brows, lips and nostrils: 0 to 1 and beyond. */
static inline float8 face_shown(int x, int y, __global const float *scratch) {
    __global const float *edges = scratch + BORDERS_AT + (y + MARGIN) * SIDE + x;
    __global const float *holes = edges + DRAWN * SIDE;
    float8 edge = face_edge_taps[0] * EIGHT(edges), hole = face_hole_taps[0] * EIGHT(holes);
    for (int i = 1; i <= MARGIN; ++i)
        edge += face_edge_taps[i] * (EIGHT(edges - i * SIDE) + EIGHT(edges + i * SIDE));
    for (int i = 1; i <= MARGIN / 2; ++i)
        hole += face_hole_taps[i] * (EIGHT(holes - i * SIDE) + EIGHT(holes + i * SIDE));
    return eight_min8(face_line(edge, ON_EDGE, 255.0f), face_line(hole, IN_HOLE, 0.0f));
}

/* Computes the place, the normal and the visibility of eight nodes. */
EIGHT_STEP void face_nodes(
    int x, int y, __global const float *given, __global const float *scratch, __global float *out) {
    float8 fields[5], terms[TERMS];
    float8 right = STEP * ((float)x - 0.5f * (SIDE - 1) + ROW8);
    face_terms(right, (float8)(STEP * ((float)y - 0.5f * (SIDE - 1))), terms);
#pragma unroll
    for (int k = 0; k < 5; ++k) fields[k] = (float8)0.0f;
#pragma unroll
    for (int t = 0; t < TERMS; ++t)
#pragma unroll
        for (int k = 0; k < 5; ++k) fields[k] += scratch[CUBIC_AT + 8 * t + k] * terms[t];
    for (int p = 0; p < POINTS; ++p) {
        __global const float *bumps = scratch + SYSTEM_AT + p * ROW + PADDED;
        float8 near =
            scratch[NEAR_Y_AT + p * SIDE + y] * EIGHT(scratch + NEAR_X_AT + p * SIDE + x);
#pragma unroll
        for (int k = 0; k < 5; ++k) fields[k] += bumps[k] * near;
    }
    float8 facing = eight_clamp8(fields[4], 0.0f, 1.0f), down = fields[1];
    int at = y * SIDE + x;
    float8 visible = face_shown(x, y, scratch);
    visible = eight_min8(visible, face_line(facing, FACING_FROM, FACING_TO));
    visible = eight_min8(visible, face_line(down, HIGHEST_FROM, HIGHEST_TO));
    visible = eight_min8(visible, face_line(down, LOWEST_FROM, LOWEST_TO));
    PUT(out + ACROSS_AT + at, fields[0]);
    PUT(out + DOWN_AT + at, down);
    PUT(out + NORMALS_AT + at, fields[2]);
    PUT(out + NORMALS_AT + NODES + at, fields[3]);
    PUT(out + FACING_AT + at, facing);
    PUT(out + VISIBLE_AT + at, face_smooth(visible));
}

/* Reads the linear light of eight nodes. Skin is learnt in sRGB's primaries, whatever the frame's:
 * in wider ones colours lie closer together. */
EIGHT_STEP void face_light(
    int x, int y, __global const float *given, __global const SAMPLE *luma,
    __global const float *table, __global float *light) {
    __global const float *to_steps = given + TO_STEPS_AT, *to_srgb = given + TO_SRGB_AT;
    __global const SAMPLE *cb = luma + (int)given[CHROMA_BEGINS_AT];
    __global const SAMPLE *cr = cb + (int)given[CHROMA_BEGINS_AT + 1];
    float8 columns = (float)x + ROW8, sum = (float8)0.0f;
    float row = (float)y;
    float8 codes = samples_bilinear(luma, given + LUMA_AT, given + TO_LUMA_AT, columns, row);
    float8 blue = samples_bilinear(cb, given + CHROMA_AT, given + TO_CHROMA_AT, columns, row);
    float8 red = samples_bilinear(cr, given + CHROMA_AT, given + TO_CHROMA_AT, columns, row);
    float8 linear[3];
#pragma unroll
    for (int j = 0; j < 3; ++j) {
        __global const float *to = to_steps + 4 * j;
        float8 steps = to[0] * codes + to[1] * blue + to[2] * red + to[3];
        int8 at = eight_whole8(eight_clamp8(steps, 0.0f, given[LAST_STEP_AT]));
        linear[j] = (float8)(table[at.s0], table[at.s1], table[at.s2], table[at.s3],
                             table[at.s4], table[at.s5], table[at.s6], table[at.s7]);
        sum += given[WEIGHTS_AT + j] * linear[j];
    }
#pragma unroll
    for (int j = 0; j < 3; ++j)
        PUT(light + (RED + j) * NODES + y * SIDE + x,
            to_srgb[3 * j] * linear[0] + to_srgb[3 * j + 1] * linear[1] +
                to_srgb[3 * j + 2] * linear[2]);
#if COLOUR_TRANSFER == 18
    sum = pow(
        sum, (float8)COLOUR_HLG_GAMMA); /* HLG: the gain of the display comes after the sum */
#endif
    PUT(light + LUMINANCE * NODES + y * SIDE + x, sum);
}

/* Computes how much eight nodes look like skin, and their visible skin and its light. */
EIGHT_STEP void face_area(int at, __global float *scratch, __global float *out) {
    float8 likeness = face_likeness(at, out, scratch);
    float8 area = likeness * EIGHT(out + VISIBLE_AT + at);
    PUT(out + LIKENESS_AT + at, likeness);
    PUT(scratch + LAYERS_AT + at, area * EIGHT(scratch + LIGHT_AT + at));
    PUT(scratch + LAYERS_AT + NODES + at, area);
}

/* Computes the mean light of all visible skin, and of the cheeks. */
EIGHT_STEP void face_means(__global float *scratch, __global float *out) {
    float8 sums[5];
    for (int k = 0; k < 5; ++k) sums[k] = (float8)0.0f;
    for (int at = 0; at < NODES; at += 8) {
        float8 seen = EIGHT(scratch + LAYERS_AT + at),
               area = EIGHT(scratch + LAYERS_AT + NODES + at);
        float8 across = EIGHT(out + ACROSS_AT + at), down = EIGHT(out + DOWN_AT + at);
        float8 aside = eight_max8(across, -across);
        int8 is_cheek = (aside > CHEEK_INNER) & (aside < CHEEK_OUTER) & (down > CHEEK_TOP) &
                        (down < CHEEK_BOTTOM);
        sums[0] += seen;
        sums[1] += area;
        sums[2] += EIGHT(scratch + LIGHT_AT + at);
        sums[3] += is_cheek ? seen : (float8)0.0f;
        sums[4] += is_cheek ? area : (float8)0.0f;
    }
    float sum[5];
    for (int k = 0; k < 5; ++k) sum[k] = eight_sum8(sums[k]);
    scratch[TOTAL_AT] = sum[1] >= 1.0f ? sum[0] / sum[1] : sum[2] * (1.0f / NODES);
    out[MEAN_AT] = sum[4] >= 1.0f ? sum[3] / sum[4] : scratch[TOTAL_AT];
}

/* Blurs eight nodes of both layers over the rows above and below, mirrored at both ends. */
EIGHT_STEP void face_blur_down(int x, int y, __global float *scratch) {
    for (int k = 0; k < 2; ++k) {
        __global const float *layer = scratch + LAYERS_AT + k * NODES + x;
        float8 sum = face_taps[0] * EIGHT(layer + y * SIDE);
        for (int i = 1; i < 4; ++i)
            sum += face_taps[i] * (EIGHT(layer + eight_mirror(y - i, SIDE) * SIDE) +
                                   EIGHT(layer + eight_mirror(y + i, SIDE) * SIDE));
        __global float *row = scratch + BLURRED_AT + (k * SIDE + y) * BLURRED + PAD;
        PUT(row + x, sum);
        if (x < PAD) PUT(row - x - 7, sum.s76543210);
        if (x >= SIDE - PAD) PUT(row + 2 * (SIDE - 1) - x - 7, sum.s76543210);
    }
}

/* Finishes the broad light of eight nodes. */
EIGHT_STEP void face_finish(int x, int y, __global const float *scratch, __global float *out) {
    float8 sums[2];
    for (int k = 0; k < 2; ++k) {
        __global const float *at = scratch + BLURRED_AT + (k * SIDE + y) * BLURRED + PAD + x;
        sums[k] = face_taps[0] * EIGHT(at);
        for (int i = 1; i < 4; ++i) sums[k] += face_taps[i] * (EIGHT(at + i) + EIGHT(at - i));
    }
    PUT(out + SHADING_AT + y * SIDE + x,
        (sums[0] + FAINT * scratch[TOTAL_AT]) / (sums[1] + FAINT));
}

__kernel void face(
    __global const float *restrict given, __global const float *restrict tables,
    __global const SAMPLE *restrict planes, __global const float *restrict table,
    __global float *restrict scratch, __global float *restrict out) {
    for
        EACH(i, PADDED / 8) face_points(8 * i, given, tables, scratch);
    barrier(CLK_GLOBAL_MEM_FENCE);
    for
        EACH(row, POINTS) face_equation(row, given, tables, scratch);
    for
        EACH(i, 2 * POINTS * (SIDE / 8))
    face_near(i / (SIDE / 8) % POINTS, i % (SIDE / 8) * 8, i / (SIDE / 8) / POINTS, given, scratch);
    for
        EACH(i, DRAWN * (SIDE / 8))
    face_borders(i % (SIDE / 8) * 8, i / (SIDE / 8), given, scratch);
    barrier(CLK_GLOBAL_MEM_FENCE);
    if (get_local_id(0) == 0) face_solve(scratch);
    barrier(CLK_GLOBAL_MEM_FENCE);
    for
        EACH(i, NODES / 8) {
            int x = i % (SIDE / 8) * 8, y = i / (SIDE / 8);
            face_nodes(x, y, given, scratch, out);
            face_light(x, y, given, planes, table, scratch + LIGHT_AT);
        }
    barrier(CLK_GLOBAL_MEM_FENCE);
    if (get_local_id(0) == 0) face_skin(given, out, scratch);
    barrier(CLK_GLOBAL_MEM_FENCE);
    for
        EACH(i, NODES / 8) face_area(8 * i, scratch, out);
    barrier(CLK_GLOBAL_MEM_FENCE);
    if (get_local_id(0) == 0) face_means(scratch, out);
    for
        EACH(i, NODES / 8) face_blur_down(i % (SIDE / 8) * 8, i / (SIDE / 8), scratch);
    barrier(CLK_GLOBAL_MEM_FENCE);
    for
        EACH(i, NODES / 8) face_finish(i % (SIDE / 8) * 8, i / (SIDE / 8), scratch, out);
}
