/* Lips and lids of a face as surfaces, from its points, its lip mask and the frame around them.
 * Host side: surface.py. Numpy twins: pipeline/lips.py, eyes.py and shading.py, which say what each step is for.
 *
 * One face is seven kernels in a row, one after the other:
 * surface_curves   the rings of lips and lids as heights and depths, column by column
 * surface_columns  what all pixels of a column share
 * surface_odds     where lipstick goes, on the lips' patch
 * surface_light    luminance of the frame on the three grids
 * surface_grids    slopes, heights, and the light by areas, on the grids
 * surface_down     these blurred along the columns
 * surface_across   and along the rows: normals and the broad light
 *
 * The grids of the lips and of both lids lie below each other: ROWS rows of WIDE numbers. Borders are mirrored,
 * without repeating the last. Unlike in other kernels a work-item makes eight pixels at once, which PoCL could
 * not find out by itself where neighbours are read. */

#include "colour.h"

#ifndef SAMPLE
#define SAMPLE uchar
#endif

#define PATCH_WIDE 112
#define PATCH_HIGH 80
#define LIPS_WIDE 56 /* as surface.py's: the patch by two */
#define LIPS_HIGH 40
#define LID_WIDE 40
#define LID_HIGH 28
#define WIDE LIPS_WIDE
#define ROWS (LIPS_HIGH + 2 * LID_HIGH)
#define LAYER (ROWS * WIDE)
#define PAD 16 /* of mirrored pixels, on each side of a row that is blurred */
#define PADDED (WIDE + 2 * PAD)

#define RING 11  /* points of half a ring of the lips, corner to corner */
#define LASHES 9 /* points of a curve of a lid */
#define SMOOTH 33
#define LIP_CURVES 8
#define FINE_CURVES 4
#define LID_CURVES 3
#define CORNERS_AT (2 * (LIP_CURVES + FINE_CURVES + 2 * LID_CURVES) * PATCH_WIDE) /* in curves */

/* Where each part begins in `given`: three places, two planes, how codes mean light, all points, the lips' logits. */
#define PLACE 22
#define LUMA_AT (3 * PLACE)
#define CHROMA_AT (LUMA_AT + 6)
#define TO_STEPS_AT (CHROMA_AT + 6)  /* (3, 4): codes -> R'G'B' in steps of the table of light, and a half */
#define WEIGHTS_AT (TO_STEPS_AT + 12) /* (3,) of luminance */
#define LAST_STEP_AT (WEIGHTS_AT + 3) /* of the table */
#define POINTS_AT (LAST_STEP_AT + 1)
#define LOGITS_AT (POINTS_AT + 3 * 478)

/* And in `out`: odds and rim on the patch; of the lips shading, x and y of the normal, upper; of each lid up,
 * lash_px, and the first three; means. */
#define RIM_AT (PATCH_WIDE * PATCH_HIGH)
#define LIPS_AT (2 * RIM_AT)
#define LIPS_SIZE (LIPS_WIDE * LIPS_HIGH)
#define LIDS_AT (LIPS_AT + 4 * LIPS_SIZE)
#define LID_SIZE (LID_WIDE * LID_HIGH)
#define MEANS_AT (LIDS_AT + 10 * LID_SIZE)

/* Of a place. A point of the frame lies at TO_OWN (point - FROM) + ORIGIN in the region's own px, of which one is
 * STEP_PX px of the frame; TO_LUMA and TO_CHROMA map px of the grid to those of a plane. */
enum { TO_OWN = 0, FROM = 4, ORIGIN = 6, OWN_PX = 8, STEP_PX, TO_LUMA, TO_CHROMA = TO_LUMA + 6 };

/* Of a plane: samples from row to row and from column to column; the same to the sample below and to the right, 0
 * where there is but one; and a little less than the last column and row: so the next is always there. */
enum { ROW_STEP, COLUMN_STEP, RIGHT, DOWN, LAST_X, LAST_Y };

/* As in lips.py, eyes.py and shading.py. */
#define STEEPEST 2.5f
#define FIRST_BETWEEN 0.19f
#define MIDDLE_BETWEEN 0.57f
#define LAST_BETWEEN 0.88f
#define REACH 0.06f
#define LIMIT_STEEPNESS 3.0f
#define CONTOUR_SHARE 0.25f
#define CONTOUR_MOST 4.0f
#define WIDER 0.25f
#define OVER_SEAM 0.3f
#define LID_LEFT -0.85f
#define LID_STEP (1.9f / 39.0f)
#define FAINT 0.02f

static inline float surface_min(float a, float b) { return a < b ? a : b; }
static inline float surface_max(float a, float b) { return a > b ? a : b; }
static inline float surface_clamp(float x, float low, float high) {
    return surface_min(surface_max(x, low), high);
}
/* Of Gaussians, from the middle on: sigma 2.5, 1.8 and 0.8, cut off at four sigmas. */
__constant float surface_lip_taps[11] = {
    0.15958068f, 0.14731153f, 0.11587936f, 0.077676256f, 0.044369381f, 0.021596896f, 0.0089580236f, 0.0031662554f, 0.00095365779f, 0.00024476655f, 5.3533354e-05f};
__constant float surface_lid_taps[8] = {
    0.22164003f, 0.18994482f, 0.1195543f, 0.055266432f, 0.018763599f, 0.004678745f, 0.00085684267f, 0.00011524744f};
__constant float surface_seam_taps[4] = {
    0.49867645f, 0.22831072f, 0.021910314f, 0.00044074337f};

/* Eight numbers that begin anywhere. */
typedef struct __attribute__((packed)) {
    float8 v;
} surface_eight;
#define ROW8 (float8)(0.0f, 1.0f, 2.0f, 3.0f, 4.0f, 5.0f, 6.0f, 7.0f)
#define EIGHT(at) (((__global const surface_eight *)(at))->v)
#define PUT(at, eight) (((__global surface_eight *)(at))->v = (eight))

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

static inline int surface_mirror(int i, int count) {
    i = i < 0 ? -i : i;
    return i < count ? i : 2 * (count - 1) - i;
}
/* As np.gradient has it, of row `at` of `count` numbers `step` apart. */
static inline float surface_slope(__global const float *row, int at, int count, float per_step) {
    int before = at > 0 ? at - 1 : 0, after = at < count - 1 ? at + 1 : at;
    return (row[after] - row[before]) * (after - before == 2 ? 0.5f * per_step : per_step);
}

/* LASHES points -> SMOOTH of them on a smooth curve (Catmull and Rom, 1974), in place. */
static void surface_smooth(float *points) {
    float smooth[SMOOTH];
    for (int i = 0; i < SMOOTH; ++i) {
        int at = i / 4 < LASHES - 1 ? i / 4 : LASHES - 2;
        float t = 0.25f * (float)(i - 4 * at), t2 = t * t, t3 = t2 * t;
        float before = points[at > 0 ? at - 1 : 0], after = points[at + 2 < LASHES ? at + 2 : LASHES - 1];
        smooth[i] = 0.5f * ((2.0f * t2 - t - t3) * before + (2.0f - 5.0f * t2 + 3.0f * t3) * points[at] +
                            (t + 4.0f * t2 - 3.0f * t3) * points[at + 1] + (t3 - t2) * after);
    }
    for (int i = 0; i < SMOOTH; ++i) points[i] = smooth[i];
}

/* curves: for each of LIP_CURVES on the coarse columns, FINE_CURVES on the patch's, and LID_CURVES of each eye:
 * heights, then depths. After them the x of both corners of the mouth. */
__kernel void surface_curves(
    __global const float *restrict given, __global const int *restrict rings, __global float *restrict curves) {
    if (get_global_id(0) > 0) return; /* one after the other along a curve */
    int curve = get_global_id(1), lid = curve - LIP_CURVES - FINE_CURVES, fine = curve - LIP_CURVES;
    int is_lid = lid >= 0, is_fine = fine >= 0 && !is_lid;
    /* the fine ones are border and opening of the upper and of the lower lip: the rings 0, 3, 4 and 7 */
    int ring = is_lid ? LIP_CURVES + lid : is_fine ? (fine >> 1) * 4 + (fine & 1) * 3 : curve;
    __global const float *place = given + (is_lid ? 1 + lid / LID_CURVES : 0) * PLACE;
    __global const float *to_own = place + TO_OWN, *origin = place + ORIGIN;
    int count = is_lid ? LASHES : RING;
    float x[SMOOTH], y[SMOOTH], z[SMOOTH];
    for (int i = 0; i < count; ++i) {
        __global const float *point = given + POINTS_AT + 3 * rings[ring * RING + i];
        float dx = point[0] - place[FROM], dy = point[1] - place[FROM + 1];
        x[i] = to_own[0] * dx + to_own[1] * dy + origin[0];
        y[i] = to_own[2] * dx + to_own[3] * dy + origin[1];
        z[i] = point[2] * place[OWN_PX];
    }
    if (curve == 0) {
        curves[CORNERS_AT] = x[0];
        curves[CORNERS_AT + 1] = x[RING - 1];
    }
    if (is_lid) {
        surface_smooth(x);
        surface_smooth(y);
        surface_smooth(z);
        count = SMOOTH;
    }
    for (int i = 1; i < count; ++i) x[i] = surface_max(x[i], x[i - 1]); /* rings seen from the side fold */
    int columns = is_lid ? LID_WIDE : is_fine ? PATCH_WIDE : LIPS_WIDE;
    float step = is_lid || is_fine ? 1.0f : 2.0f, first = is_lid || is_fine ? 0.0f : 0.5f;
    __global float *heights = curves + 2 * curve * PATCH_WIDE;
    for (int column = 0, i = 0; column < columns; ++column) {
        float at = first + step * (float)column;
        while (i + 1 < count && x[i + 1] <= at) ++i;
        int next = i + 1 < count ? i + 1 : i;
        float wide = x[next] - x[i], t = wide > 0.0f && at > x[i] ? (at - x[i]) / wide : 0.0f;
        heights[column] = y[i] + t * (y[next] - y[i]);
        heights[column + PATCH_WIDE] = z[i] + t * (z[next] - z[i]);
    }
}

/* Rows of `columns`. */
enum {
    TOP, AT_TOP, BOTTOM, AT_BOTTOM, UPPER, AT_UPPER, LOWER, AT_LOWER, GAP, PER_UPPER, PER_LOWER,
    SEAM, LIP, /* of each lip: */
    FIRST = 0, PER_HEIGHT, BEND, TILT = BEND + 3, ALONG, OF_LIP,
    LID = LIP + 2 * OF_LIP, /* of each lid: */
    LASH = 0, CREASE, PER_LASH, PER_CREASE, BELOW, ABOVE, ACROSS, LASH_PX, OF_LID
};

static inline float surface_at_least_half(float x) {
    return x < 0.0f ? surface_min(x, -0.5f) : surface_max(x, 0.5f);
}

/* How steep the surface is between two rings of a lip, at a coarse column. */
static inline float surface_bend(__global const float *ring, int column) {
    __global const float *next = ring + 2 * PATCH_WIDE;
    float down = surface_at_least_half(next[column] - ring[column]);
    float slope = (next[column + PATCH_WIDE] - ring[column + PATCH_WIDE]) / down;
    return surface_clamp(slope, -STEEPEST, STEEPEST);
}

static void surface_lip_column(
    int x, __global const float *curves, __global float *columns) {
    for (int lip = 0; lip < 2; ++lip) {
        __global const float *y = curves + lip * 8 * PATCH_WIDE;
        __global float *out = columns + (LIP + lip * OF_LIP) * PATCH_WIDE + x;
        float bend[5] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
        for (int tap = -3; tap <= 3; ++tap) {
            int at = surface_mirror(x + tap, LIPS_WIDE);
            for (int ring = 0; ring < 3; ++ring)
                bend[ring] += surface_bend(y + 2 * ring * PATCH_WIDE, at);
            for (int part = 0; part < 2; ++part) { /* of height and depth half-way */
                __global const float *middle = y + (2 + part) * PATCH_WIDE;
                bend[3 + part] += 0.5f * (surface_slope(middle, at, LIPS_WIDE, 0.5f) +
                                          surface_slope(middle + 2 * PATCH_WIDE, at, LIPS_WIDE, 0.5f));
            }
        }
        for (int i = 0; i < 5; ++i) out[(BEND + i) * PATCH_WIDE] = bend[i] * (1.0f / 7.0f);
        float first = y[x], last = y[x + 6 * PATCH_WIDE];
        out[FIRST * PATCH_WIDE] = first;
        out[PER_HEIGHT * PATCH_WIDE] = 1.0f / surface_at_least_half(last - first);
    }
    columns[SEAM * PATCH_WIDE + x] = 0.5f * (curves[6 * PATCH_WIDE + x] + curves[14 * PATCH_WIDE + x]);
}

static void surface_patch_column(
    int x, __global const float *curves, __global float *columns) {
    __global const float *y = curves + 2 * LIP_CURVES * PATCH_WIDE;
    __global const float *corners = curves + CORNERS_AT;
    float at[4];
    for (int i = 0; i < 4; ++i) {
        /* across a contour, not down its column: where it is steep that would make it a stair */
        float slope = surface_slope(y + 2 * i * PATCH_WIDE, x, PATCH_WIDE, 1.0f);
        at[i] = 1.0f / colour_sqrt(1.0f + slope * slope);
    }
    float top = y[x], upper = y[x + 2 * PATCH_WIDE], bottom = y[x + 4 * PATCH_WIDE], lower = y[x + 6 * PATCH_WIDE];
    float reach = REACH * surface_max(corners[1] - corners[0], 1.0f);
    __global float *out = columns + x;
    out[TOP * PATCH_WIDE] = top;
    out[AT_TOP * PATCH_WIDE] = at[0];
    out[UPPER * PATCH_WIDE] = upper;
    out[AT_UPPER * PATCH_WIDE] = at[1];
    out[BOTTOM * PATCH_WIDE] = bottom;
    out[AT_BOTTOM * PATCH_WIDE] = at[2];
    out[LOWER * PATCH_WIDE] = lower;
    out[AT_LOWER * PATCH_WIDE] = at[3];
    out[GAP * PATCH_WIDE] = 2.0f * surface_clamp((lower - upper) / reach, 0.0f, 1.0f) - 1.0f;
    out[PER_UPPER * PATCH_WIDE] = 1.0f / surface_max(upper - top, 1.0f);
    out[PER_LOWER * PATCH_WIDE] = 1.0f / surface_max(bottom - lower, 1.0f);
}

static void surface_lid_column(
    int x, __global const float *curves, __global float *columns, float step_px) {
    __global const float *y = curves, *z = curves + PATCH_WIDE;
    float lash = y[x], crease = surface_min(y[x + 2 * PATCH_WIDE], lash - 1.0f);
    float brow = surface_min(y[x + 4 * PATCH_WIDE], crease - 1.0f);
    float slope = surface_slope(y, x, LID_WIDE, 1.0f);
    float lower = surface_min(y[x + 2 * PATCH_WIDE] - lash, -1.0f);
    float higher = surface_min(y[x + 4 * PATCH_WIDE] - y[x + 2 * PATCH_WIDE], -1.0f);
    __global float *out = columns + x;
    out[LASH * PATCH_WIDE] = lash;
    out[CREASE * PATCH_WIDE] = crease;
    out[PER_LASH * PATCH_WIDE] = 1.0f / (lash - crease);
    out[PER_CREASE * PATCH_WIDE] = 1.0f / (crease - brow);
    out[BELOW * PATCH_WIDE] = surface_clamp((z[x + 2 * PATCH_WIDE] - z[x]) / lower, -2.0f, 2.0f);
    out[ABOVE * PATCH_WIDE] =
        surface_clamp((z[x + 4 * PATCH_WIDE] - z[x + 2 * PATCH_WIDE]) / higher, -2.0f, 2.0f);
    out[ACROSS * PATCH_WIDE] =
        surface_clamp(surface_slope(z + 2 * PATCH_WIDE, x, LID_WIDE, 1.0f), -2.0f, 2.0f);
    out[LASH_PX * PATCH_WIDE] = step_px / colour_sqrt(1.0f + slope * slope);
}

/* Four rows of work-items: the patch, the lips' grid, and both lids'. */
__kernel void surface_columns(
    __global const float *restrict given, __global const float *restrict curves, __global float *restrict columns) {
    int x = get_global_id(0), part = get_global_id(1), lid = part - 2;
    if (x >= (part == 0 ? PATCH_WIDE : part == 1 ? LIPS_WIDE : LID_WIDE)) return;
    if (part == 0) {
        surface_patch_column(x, curves, columns);
    } else if (part == 1) {
        surface_lip_column(x, curves, columns);
    } else {
        surface_lid_column(
            x, curves + 2 * (LIP_CURVES + FINE_CURVES + lid * LID_CURVES) * PATCH_WIDE,
            columns + (LID + lid * OF_LID) * PATCH_WIDE, given[(1 + lid) * PLACE + STEP_PX]);
    }
}

/* Fills odds and rim. */
__kernel void surface_odds(
    __global const float *restrict given, __global const float *restrict curves,
    __global const float *restrict columns, __global float *restrict out) {
    int item = get_global_id(0), y = item / (PATCH_WIDE / 8), x = (item - y * (PATCH_WIDE / 8)) * 8;
    int at = y * PATCH_WIDE + x;
    if (y >= PATCH_HIGH) return;
    __global const float *corners = curves + CORNERS_AT, *column = columns + x;
    float left = corners[0], right = corners[1], row = (float)y;
    float reach = REACH * surface_max(right - left, 1.0f);
    float8 across = (float)x + ROW8;
    float8 from_top = row - EIGHT(column + TOP * PATCH_WIDE), to_bottom = EIGHT(column + BOTTOM * PATCH_WIDE) - row;
    float8 from_upper = row - EIGHT(column + UPPER * PATCH_WIDE), to_lower = EIGHT(column + LOWER * PATCH_WIDE) - row;
    float8 inside = surface_min8(
        from_top * EIGHT(column + AT_TOP * PATCH_WIDE), to_bottom * EIGHT(column + AT_BOTTOM * PATCH_WIDE));
    float8 opening = surface_min8(
        from_upper * EIGHT(column + AT_UPPER * PATCH_WIDE), to_lower * EIGHT(column + AT_LOWER * PATCH_WIDE));
    float8 near = from_upper < to_lower ? from_top * EIGHT(column + PER_UPPER * PATCH_WIDE)
                                        : to_bottom * EIGHT(column + PER_LOWER * PATCH_WIDE);
    inside = surface_min8(surface_min8(inside, surface_min8(across - left, right - across)), -opening);
    float8 rim = EIGHT(column + GAP * PATCH_WIDE) * surface_clamp8(2.0f * near - 0.8f, 0.0f, 1.0f);
    float8 sum = (1.0f - CONTOUR_SHARE) * EIGHT(given + LOGITS_AT + at) +
                 CONTOUR_SHARE * surface_clamp8(inside, -CONTOUR_MOST, CONTOUR_MOST) +
                 (rim > 0.0f ? (float8)0.0f : (float8)WIDER);
    PUT(out + at, surface_min8(sum, LIMIT_STEEPNESS * (inside + reach)));
    PUT(out + RIM_AT + at, rim > 0.0f ? rim : OVER_SEAM * rim);
}

/* Rows of which a work-item makes eight pixels: those of the lips' grid, then those of both lids'. */
typedef struct {
    int row, x, lid, y; /* lid: -1 of the lips.  y: of its own grid */
} surface_spot;

static inline surface_spot surface_spot_of(int item) {
    surface_spot spot;
    spot.row = item / (WIDE / 8);
    spot.x = (item - spot.row * (WIDE / 8)) * 8;
    spot.lid = spot.row < LIPS_HIGH ? -1 : spot.row < LIPS_HIGH + LID_HIGH ? 0 : 1;
    spot.y = spot.lid < 0 ? spot.row : spot.row - LIPS_HIGH - spot.lid * LID_HIGH;
    return spot;
}

/* Eight samples, bilinear; the border is repeated. */
static inline float8 surface_sample(
    __global const SAMPLE *plane, __global const float *of, __global const float *to, float8 x, float y) {
    float8 u = surface_clamp8(to[0] * x + (to[1] * y + to[2]), 0.0f, of[LAST_X]);
    float8 v = surface_clamp8(to[3] * x + (to[4] * y + to[5]), 0.0f, of[LAST_Y]);
    int8 left = __builtin_convertvector(u, int8), top = __builtin_convertvector(v, int8);
    float8 across = u - __builtin_convertvector(left, float8), down = v - __builtin_convertvector(top, float8);
    int8 at = top * (int)of[ROW_STEP] + left * (int)of[COLUMN_STEP];
    int right = (int)of[RIGHT], below = (int)of[DOWN];
    float corners[4][8];
    for (int i = 0; i < 8; ++i) {
        __global const SAMPLE *first = plane + at[i], *second = first + below;
        corners[0][i] = (float)first[0];
        corners[1][i] = (float)first[right];
        corners[2][i] = (float)second[0];
        corners[3][i] = (float)second[right];
    }
#define OF_CORNER(i) (((const surface_eight *)corners[i])->v)
    float8 high = OF_CORNER(0) + across * (OF_CORNER(1) - OF_CORNER(0));
    float8 low = OF_CORNER(2) + across * (OF_CORNER(3) - OF_CORNER(2));
    return high + down * (low - high);
}

/* light: (ROWS, WIDE), linear. A work-item makes eight pixels of two rows: chroma has no more detail than two by
 * two, so that of four more is not looked at. */
__kernel void surface_light(
    __global const float *restrict given, __global const SAMPLE *restrict luma,
    __global const SAMPLE *restrict cb, __global const SAMPLE *restrict cr,
    __global const float *restrict table, __global float *restrict light) {
    int item = get_global_id(0), pair = item / (WIDE / 8);
    surface_spot spot = surface_spot_of(item + pair * (WIDE / 8));
    if (spot.row >= ROWS || (spot.lid >= 0 && spot.x >= LID_WIDE)) return;
    __global const float *place = given + (spot.lid + 1) * PLACE;
    float8 x = (float)spot.x + ROW8;
    float8 twos = (float)spot.x + (float8)(0.5f, 2.5f, 4.5f, 6.5f, 0.5f, 2.5f, 4.5f, 6.5f);
    float y = (float)spot.y;
    float8 blue = surface_sample(cb, given + CHROMA_AT, place + TO_CHROMA, twos, y + 0.5f).s00112233;
    float8 red = surface_sample(cr, given + CHROMA_AT, place + TO_CHROMA, twos, y + 0.5f).s00112233;
    for (int row = 0; row < 2; ++row) {
        float8 codes = surface_sample(luma, given + LUMA_AT, place + TO_LUMA, x, y + (float)row);
        float sum[8] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
        for (int i = 0; i < 3; ++i) {
            __global const float *to = given + TO_STEPS_AT + 4 * i;
            float8 steps = surface_clamp8(to[0] * codes + to[1] * blue + to[2] * red + to[3], 0.0f, given[LAST_STEP_AT]);
            int8 at = __builtin_convertvector(steps, int8);
            for (int j = 0; j < 8; ++j) sum[j] += given[WEIGHTS_AT + i] * table[at[j]];
        }
#if COLOUR_TRANSFER == 18
        for (int j = 0; j < 8; ++j) sum[j] = pow(sum[j], 1.2f); /* HLG's display: its gain comes after the sum */
#endif
        PUT(light + (spot.row + row) * WIDE + spot.x, ((const surface_eight *)sum)->v);
    }
}

/* Of layers and blurred. Lids have LIGHT and AREA alone. */
enum { SLOPE_X, SLOPE_Y, LIGHT, AREA, LIGHT_BELOW, AREA_BELOW, LAYERS };

static inline void surface_lips_pixels(
    surface_spot spot, __global const float *columns, float8 light, __global float *layers,
    __global float *out) {
    float row = 2.0f * (float)spot.y + 0.5f;
    /* share that lies above the line where the lips meet: by parts, or the line would be a stair */
    float8 share = surface_clamp8(0.5f * (EIGHT(columns + SEAM * PATCH_WIDE + spot.x) - row) + 0.5f, 0.0f, 1.0f);
    __global const float *upper = columns + LIP * PATCH_WIDE + spot.x, *lower = upper + OF_LIP * PATCH_WIDE;
    int8 is_upper = share > 0.5f;
#define OF_EITHER(name) (is_upper ? EIGHT(upper + (name) * PATCH_WIDE) : EIGHT(lower + (name) * PATCH_WIDE))
    float8 across = surface_clamp8((row - OF_EITHER(FIRST)) * OF_EITHER(PER_HEIGHT), 0.0f, 1.0f);
    float8 outer = OF_EITHER(BEND), middle = OF_EITHER(BEND + 1), inner = OF_EITHER(BEND + 2);
    float8 from_middle = across - MIDDLE_BETWEEN;
    float8 down = middle + (across < MIDDLE_BETWEEN ? (middle - outer) * (1.0f / (MIDDLE_BETWEEN - FIRST_BETWEEN))
                                                    : (inner - middle) * (1.0f / (LAST_BETWEEN - MIDDLE_BETWEEN))) *
                               from_middle;
    down += is_upper ? 0.75f * across - 0.30f : 0.45f - across; /* lips are fuller than the mesh */
    down = surface_clamp8(down, -STEEPEST, STEEPEST);
    float8 along = OF_EITHER(ALONG) - 0.5f * down * OF_EITHER(TILT);
    __global const float *first = out + 2 * spot.y * PATCH_WIDE + 2 * spot.x;
    float8 left = EIGHT(first) + EIGHT(first + PATCH_WIDE), right = EIGHT(first + 8) + EIGHT(first + PATCH_WIDE + 8);
    float8 lips = (float8)(left.even + left.odd, right.even + right.odd) > 0.0f ? (float8)1.0f : (float8)0.0f;
    PUT(out + LIPS_AT + 3 * LIPS_SIZE + spot.y * LIPS_WIDE + spot.x, share);
    PUT(layers + SLOPE_X * LAYER, surface_clamp8(along, -STEEPEST, STEEPEST));
    PUT(layers + SLOPE_Y * LAYER, down);
    PUT(layers + LIGHT * LAYER, light * lips * share);
    PUT(layers + AREA * LAYER, lips * share);
    PUT(layers + LIGHT_BELOW * LAYER, light * (lips - lips * share));
    PUT(layers + AREA_BELOW * LAYER, lips - lips * share);
}

static inline void surface_lid_pixels(
    surface_spot spot, __global const float *columns, float8 light, __global float *layers, __global float *out) {
    __global const float *column = columns + spot.x;
    float8 above_lash = EIGHT(column + LASH * PATCH_WIDE) - (float)spot.y;
    float8 above_crease = EIGHT(column + CREASE * PATCH_WIDE) - (float)spot.y;
    float8 up = above_lash * EIGHT(column + PER_LASH * PATCH_WIDE);
    up = up < 1.0f ? up : 1.0f + above_crease * EIGHT(column + PER_CREASE * PATCH_WIDE);
    float8 below = EIGHT(column + BELOW * PATCH_WIDE), gx = EIGHT(column + ACROSS * PATCH_WIDE);
    float8 gy = below + (EIGHT(column + ABOVE * PATCH_WIDE) - below) * surface_clamp8(up - 0.5f, 0.0f, 1.0f);
    gy += 0.8f * surface_clamp8(0.5f - up, -0.5f, 0.5f); /* a lid lies on a ball */
    float8 shrink = surface_shrink8(gx, gy);
    float8 beside = LID_LEFT + LID_STEP * ((float)spot.x + ROW8);
    int8 is_lid = (up > 0.15f) & (up < 1.5f) & (beside > -0.55f) & (beside < 0.55f);
    PUT(layers + LIGHT * LAYER, is_lid ? light : (float8)0.0f);
    PUT(layers + AREA * LAYER, is_lid ? (float8)1.0f : (float8)0.0f);
    PUT(out, up);
    PUT(out + LID_SIZE, above_lash * EIGHT(column + LASH_PX * PATCH_WIDE));
    PUT(out + 3 * LID_SIZE, gx * shrink);
    PUT(out + 4 * LID_SIZE, gy * shrink);
}

/* Fills upper; and up, lash_px and the normals of lids. */
__kernel void surface_grids(
    __global const float *restrict columns, __global const float *restrict light,
    __global float *restrict layers, __global float *restrict out) {
    surface_spot spot = surface_spot_of(get_global_id(0));
    if (spot.row >= ROWS || (spot.lid >= 0 && spot.x >= LID_WIDE)) return;
    int at = spot.row * WIDE + spot.x;
    if (spot.lid < 0)
        surface_lips_pixels(spot, columns, EIGHT(light + at), layers + at, out);
    else
        surface_lid_pixels(
            spot, columns + (LID + spot.lid * OF_LID) * PATCH_WIDE, EIGHT(light + at), layers + at,
            out + LIDS_AT + 5 * spot.lid * LID_SIZE + spot.y * LID_WIDE + spot.x);
}

/* Mean of the light over a region's areas; over all of its grid where there is hardly any area. */
static float surface_mean(int region, __global const float *layers, __global const float *light) {
    int first = region ? LIPS_HIGH + (region - 1) * LID_HIGH : 0, high = region ? LID_HIGH : LIPS_HIGH;
    int wide = region ? LID_WIDE : LIPS_WIDE;
    float8 seen = (float8)0.0f, area = (float8)0.0f, all = (float8)0.0f;
    for (int row = first; row < first + high; ++row)
        for (int x = 0; x < wide; x += 8) {
            __global const float *at = layers + row * WIDE + x;
            seen += EIGHT(at + LIGHT * LAYER);
            area += EIGHT(at + AREA * LAYER);
            if (region == 0) {
                seen += EIGHT(at + LIGHT_BELOW * LAYER);
                area += EIGHT(at + AREA_BELOW * LAYER);
            }
            all += EIGHT(light + row * WIDE + x);
        }
    float total = surface_sum8(area);
    return total >= 1.0f ? surface_sum8(seen) / total : surface_sum8(all) / (float)(high * wide);
}

/* Blurs rows above and below `at`, and puts them down for surface_across, mirrored at both ends. */
static inline void surface_blur_down(
    __global const float *layer, __global float *blurred, int y, int high, int x, int wide,
    __constant const float *taps, int sides) {
    float8 sum = taps[0] * EIGHT(layer + y * WIDE + x);
    for (int i = 1; i <= sides; ++i)
        sum += taps[i] * (EIGHT(layer + surface_mirror(y + i, high) * WIDE + x) +
                          EIGHT(layer + surface_mirror(y - i, high) * WIDE + x));
    __global float *row = blurred + y * PADDED + PAD;
    PUT(row + x, sum);
    if (x < PAD) PUT(row - x - 7, sum.s76543210);
    if (x >= wide - PAD) PUT(row + 2 * (wide - 1) - x - 7, sum.s76543210);
}

/* blurred: LAYERS of (ROWS, PADDED). Three items more than there are pixels fill the means. */
__kernel void surface_down(
    __global const float *restrict layers, __global const float *restrict light, __global float *restrict blurred,
    __global float *restrict out) {
    surface_spot spot = surface_spot_of(get_global_id(0));
    int first = spot.row - spot.y, from = first * WIDE, to = first * PADDED;
    if (spot.row >= ROWS) {
        if (spot.row == ROWS && spot.x < 3 * 8) out[MEANS_AT + spot.x / 8] = surface_mean(spot.x / 8, layers, light);
    } else if (spot.lid < 0) {
        for (int layer = SLOPE_X; layer <= SLOPE_Y; ++layer)
            surface_blur_down(
                layers + layer * LAYER, blurred + layer * ROWS * PADDED, spot.y, LIPS_HIGH, spot.x, LIPS_WIDE,
                surface_seam_taps, 3);
        for (int layer = LIGHT; layer <= AREA_BELOW; ++layer)
            surface_blur_down(
                layers + layer * LAYER, blurred + layer * ROWS * PADDED, spot.y, LIPS_HIGH, spot.x, LIPS_WIDE,
                surface_lip_taps, 10);
    } else if (spot.x < LID_WIDE) {
        for (int layer = LIGHT; layer <= AREA; ++layer)
            surface_blur_down(
                layers + layer * LAYER + from, blurred + layer * ROWS * PADDED + to, spot.y, LID_HIGH, spot.x,
                LID_WIDE, surface_lid_taps, 7);
    }
}

static inline float8 surface_blur_across(__global const float *at, __constant const float *taps, int sides) {
    float8 sum = taps[0] * EIGHT(at);
    for (int i = 1; i <= sides; ++i) sum += taps[i] * (EIGHT(at + i) + EIGHT(at - i));
    return sum;
}

/* Fills all shading, and the normals of the lips. */
__kernel void surface_across(
    __global const float *restrict blurred, __global float *restrict out) {
    surface_spot spot = surface_spot_of(get_global_id(0));
    if (spot.row >= ROWS || (spot.lid >= 0 && spot.x >= LID_WIDE)) return;
    __global const float *from = blurred + spot.row * PADDED + PAD + spot.x;
    float faint = FAINT * out[MEANS_AT + 1 + spot.lid];
    float8 shade[2];
    if (spot.lid < 0) {
        float8 gx = surface_blur_across(from + SLOPE_X * ROWS * PADDED, surface_seam_taps, 3);
        float8 gy = surface_blur_across(from + SLOPE_Y * ROWS * PADDED, surface_seam_taps, 3);
        float8 shrink = surface_shrink8(gx, gy);
        for (int lip = 0; lip < 2; ++lip)
            shade[lip] =
                (surface_blur_across(from + (LIGHT + 2 * lip) * ROWS * PADDED, surface_lip_taps, 10) + faint) /
                (surface_blur_across(from + (AREA + 2 * lip) * ROWS * PADDED, surface_lip_taps, 10) + FAINT);
        __global float *to = out + LIPS_AT + spot.y * LIPS_WIDE + spot.x;
        PUT(to, shade[1] + EIGHT(to + 3 * LIPS_SIZE) * (shade[0] - shade[1]));
        PUT(to + LIPS_SIZE, gx * shrink);
        PUT(to + 2 * LIPS_SIZE, gy * shrink);
    } else {
        float8 light = surface_blur_across(from + LIGHT * ROWS * PADDED, surface_lid_taps, 7);
        float8 area = surface_blur_across(from + AREA * ROWS * PADDED, surface_lid_taps, 7);
        PUT(out + LIDS_AT + (5 * spot.lid + 2) * LID_SIZE + spot.y * LID_WIDE + spot.x,
            (light + faint) / (area + FAINT));
    }
}
