/* Makes the surfaces of a face's lips and lids from its points, its lip mask and the frame around
 * them. Host side, with all constants and the layout of each buffer: surface.py. Numpy twins, which
 * explain each step: pipeline/render/surfaces/lips_twin.py, eyes_twin.py and
 * pipeline/render/luminance_twin.py.
 *
 * One work-group makes a region (the lips or a lid), step by step. A work-item computes eight
 * pixels at once, since PoCL does not vectorise code that reads neighbours.
 *
 * - given: the face and the frame, GIVEN in surface.py.
 * - rings: (18, RING), the points of half-rings of the upper and the lower lip, from border to
 *   opening, and of the lash line, crease, fold, brow and lower lash line of both eyes.
 * - planes: Y', Cb and Cr, one after another.
 * - table: linear light of R'G'B'.
 * - all_scratch: (3, SCRATCH_SIZE).
 * - out: to be filled, OUT in surface.py. */

#include "surface.h"

/* Replaces `count` points by 4 (count - 1) + 1 on a curve through them (Catmull and Rom, 1974). */
EIGHT_STEP void surface_smooth(float *points, int count) {
    float smooth[SMOOTH];
    int more = 4 * (count - 1) + 1;
    for (int i = 0; i < more; ++i) {
        int at = i / 4 < count - 1 ? i / 4 : count - 2;
        float t = 0.25f * (float)(i - 4 * at), t2 = t * t, t3 = t2 * t;
        float before = points[at > 0 ? at - 1 : 0],
              after = points[at + 2 < count ? at + 2 : count - 1];
        smooth[i] =
            0.5f * ((2.0f * t2 - t - t3) * before + (2.0f - 5.0f * t2 + 3.0f * t3) * points[at] +
                    (t + 4.0f * t2 - 3.0f * t3) * points[at + 1] + (t3 - t2) * after);
    }
    for (int i = 0; i < more; ++i) points[i] = smooth[i];
}

/* Continues a lash line beyond the corners of the eye, in its direction there, until it settles. */
EIGHT_STEP void surface_settle(__global float *heights) {
    int inner_at = (int)LID_INNER_CORNER + 1, outer_at = (int)LID_OUTER_CORNER;
    float inner = eight_clamp(0.5f * (heights[inner_at] - heights[inner_at + 2]), -1.0f, 1.0f);
    float outer = eight_clamp(0.5f * (heights[outer_at] - heights[outer_at - 2]), -1.0f, 1.0f);
    for (int x = 0; x < inner_at; ++x) {
        float beyond = LID_INNER_CORNER - (float)x;
        heights[x] += inner * beyond / (1.0f + beyond / LID_SETTLE);
    }
    for (int x = outer_at + 1; x < LID_WIDE; ++x) {
        float beyond = (float)x - LID_OUTER_CORNER;
        heights[x] += outer * beyond / (1.0f + beyond / LID_SETTLE);
    }
}

/* Stores the straight parts of half of the lips' border. */
EIGHT_STEP void surface_border(const float *x, const float *y, __global float *parts) {
    for (int i = 0; i < RING - 1; ++i, parts += BORDER_PART) {
        float right = x[i + 1] - x[i], down = y[i + 1] - y[i];
        parts[0] = x[i];
        parts[1] = y[i];
        parts[2] = right;
        parts[3] = down;
        parts[4] = 1.0f / eight_max(right * right + down * down, LEAST_SQUARE);
        parts[5] = down == 0.0f ? 0.0f : right / down;
    }
}

/* How far within the lips' border eight px of a row lie, negative outside: the distance to the
 * nearest of its straight parts, with a sign by its winding number. */
EIGHT_STEP float8 surface_within8(float8 x, float y, __global const float *part) {
    float8 nearest = (float8)1e9f;
    int8 winding = (int8)0;
    for (int i = 0; i < 2 * (RING - 1); ++i, part += BORDER_PART) {
        float right = part[2], down = part[3], below = y - part[1];
        float8 beside = x - part[0];
        float8 along = (right * beside + down * below) * part[4];
        along = eight_clamp8(along, 0.0f, 1.0f);
        float8 dx = beside - right * along, dy = below - down * along;
        nearest = eight_min8(nearest, dx * dx + dy * dy);
        /* both lips' borders run from left to right */
        int crosses = (below >= 0.0f) - (below >= down);
        if (crosses) {
            int8 is_right = beside < (float8)(below * part[5]);
            winding += i < RING - 1 ? crosses * is_right : -crosses * is_right;
        }
    }
    float8 distance = nearest * surface_inverse_root8(eight_max8(nearest, (float8)LEAST_SQUARE));
    return winding != 0 ? distance : -distance;
}

/* Computes a curve's heights and depths by column. Curves of the lips: eight half-rings by the
 * grid's columns, then borders and openings (rings 0, 3, 4, 7) by the patch's. Of a lid: LID_CURVES. */
EIGHT_STEP void surface_curve(
    int region, int curve, __global const float *given, __global const int *rings,
    __global float *scratch) {
    int is_lid = region > 0, is_fine = !is_lid && curve >= 8;
    int ring = is_lid    ? 8 + LID_CURVES * (region - 1) + curve
               : is_fine ? ((curve - 8) >> 1) * 4 + (curve & 1) * 3
                         : curve;
    int count = !is_lid ? RING : curve == BROW_LINE ? BROWS : LASHES;
    __global const float *place = given + region * PLACE_SIZE;
    __global const float *to_own = place + TO_OWN_AT, *origin = place + ORIGIN_AT;
    float x[SMOOTH], y[SMOOTH], z[SMOOTH];
    for (int i = 0; i < count; ++i) {
        __global const float *point = given + POINTS_AT + 3 * rings[ring * RING + i];
        float right = point[0] - place[NEAR_AT], down = point[1] - place[NEAR_AT + 1];
        x[i] = to_own[0] * right + to_own[1] * down + origin[0];
        y[i] = to_own[2] * right + to_own[3] * down + origin[1];
        z[i] = point[2] * place[OWN_PX_AT];
    }
    if (curve == 0) {
        scratch[CORNERS_AT] = x[0];
        scratch[CORNERS_AT + 1] = x[count - 1];
    }
    if (!is_lid && (curve == 0 || curve == 4))
        surface_border(x, y, scratch + BORDER_AT + (curve ? BORDER_PARTS : 0));
    /* heights of the opening in the middle of the mouth */
    if (is_fine && (curve & 1)) scratch[CORNERS_AT + 2 + ((curve - 8) >> 1)] = y[count / 2];
    if (is_lid) {
        surface_smooth(x, count);
        surface_smooth(y, count);
        surface_smooth(z, count);
        count = 4 * (count - 1) + 1;
    }
    for (int i = 1; i < count; ++i)
        x[i] = eight_max(x[i], x[i - 1]); /* on a face seen from the side, rings fold over */
    int columns = is_lid ? LID_WIDE : is_fine ? PATCH_WIDE : LIPS_WIDE;
    float step = is_lid || is_fine ? 1.0f : 2.0f, first = is_lid || is_fine ? 0.0f : 0.5f;
    __global float *heights = scratch + CURVES_AT + 2 * curve * PATCH_WIDE;
    for (int column = 0, i = 0; column < columns; ++column) {
        float at = first + step * (float)column;
        while (i + 1 < count && x[i + 1] <= at) ++i;
        int next = i + 1 < count ? i + 1 : i;
        float wide = x[next] - x[i], t = wide > 0.0f && at > x[i] ? (at - x[i]) / wide : 0.0f;
        heights[column] = y[i] + t * (y[next] - y[i]);
        heights[column + PATCH_WIDE] = z[i] + t * (z[next] - z[i]);
    }
    if (is_lid && (curve == LASH_LINE || curve == LOWER_LINE)) surface_settle(heights);
}

/* Computes both lips' slopes between rings, and along the middle, at a column of the grid. */
EIGHT_STEP void surface_bend(int x, __global float *scratch) {
    for (int lip = 0; lip < 2; ++lip) {
        __global const float *ring = scratch + CURVES_AT + lip * 8 * PATCH_WIDE;
        __global float *bends = scratch + BENDS_AT + lip * 5 * PATCH_WIDE + x;
        for (int i = 0; i < 3; ++i) {
            __global const float *here = ring + 2 * i * PATCH_WIDE + x,
                                 *next = here + 2 * PATCH_WIDE;
            float slope =
                (next[PATCH_WIDE] - here[PATCH_WIDE]) / surface_at_least_half(next[0] - here[0]);
            bends[i * PATCH_WIDE] = eight_clamp(slope, -STEEPEST, STEEPEST);
        }
        for (int i = 0; i < 2; ++i) { /* of height and of depth */
            __global const float *outer = ring + (2 + i) * PATCH_WIDE,
                                 *inner = outer + 2 * PATCH_WIDE;
            bends[(3 + i) * PATCH_WIDE] = 0.5f * (surface_slope(outer, x, LIPS_WIDE, 0.5f) +
                                                  surface_slope(inner, x, LIPS_WIDE, 0.5f));
        }
    }
}

/* Computes what all pixels in a column of the lips' grid share. */
EIGHT_STEP void surface_lips_column(int x, __global float *scratch) {
    __global const float *curves = scratch + CURVES_AT + x;
    __global float *columns = scratch + COLUMNS_AT + x;
    for (int lip = 0; lip < 2; ++lip) {
        __global const float *bends = scratch + BENDS_AT + lip * 5 * PATCH_WIDE;
        __global float *out = columns + (LIP + lip * OF_LIP) * PATCH_WIDE;
        float sums[5] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
        for (int tap = -3; tap <= 3; ++tap) {
            int at = eight_mirror(x + tap, LIPS_WIDE);
            for (int i = 0; i < 5; ++i) sums[i] += bends[i * PATCH_WIDE + at];
        }
        for (int i = 0; i < 5; ++i) out[(BEND + i) * PATCH_WIDE] = sums[i] * (1.0f / 7.0f);
        float first = curves[lip * 8 * PATCH_WIDE], last = curves[(lip * 8 + 6) * PATCH_WIDE];
        out[FIRST * PATCH_WIDE] = first;
        out[PER_HEIGHT * PATCH_WIDE] = 1.0f / surface_at_least_half(last - first);
    }
    columns[SEAM * PATCH_WIDE] = 0.5f * (curves[6 * PATCH_WIDE] + curves[14 * PATCH_WIDE]);
}

/* Computes what all pixels in a column of the patch share. */
EIGHT_STEP void surface_patch_column(int x, __global float *scratch) {
    __global const float *y = scratch + CURVES_AT + 16 * PATCH_WIDE,
                         *corners = scratch + CORNERS_AT;
    __global float *out = scratch + COLUMNS_AT + x;
    const int rows[4] = {TOP, UPPER, BOTTOM, LOWER};
    for (int i = 0; i < 4; ++i) out[rows[i] * PATCH_WIDE] = y[2 * i * PATCH_WIDE + x];
    for (int i = 1; i < 4; i += 2) {
        /* Distances are taken across a contour. Down a column, they would make steps where the
         * contour is steep. */
        float slope = surface_slope(y + 2 * i * PATCH_WIDE, x, PATCH_WIDE, 1.0f);
        out[(rows[i] + 1) * PATCH_WIDE] = 1.0f / colour_sqrt(1.0f + slope * slope);
    }
    float top = out[TOP * PATCH_WIDE], upper = out[UPPER * PATCH_WIDE];
    float bottom = out[BOTTOM * PATCH_WIDE], lower = out[LOWER * PATCH_WIDE];
    float width = eight_max(corners[1] - corners[0], 1.0f), reach = REACH * width;
    float open = eight_clamp((corners[3] - corners[2]) / (OPENED * width), 0.0f, 1.0f);
    float across = 2.0f * (float)x - corners[0] - corners[1];
    float out_of_middle = eight_max(across, -across) / width;
    float at_corner =
        eight_clamp((out_of_middle - CORNER_FROM) / (CORNER_TO - CORNER_FROM), 0.0f, 1.0f);
    float more = CORNER_MORE * at_corner * open;
    out[UPPER_MORE * PATCH_WIDE] = more;
    out[LOWER_MORE * PATCH_WIDE] = more - LOWER_LESS * (1.0f - at_corner) * (1.0f - open);
    out[GAP * PATCH_WIDE] = 2.0f * eight_clamp((lower - upper) / reach, 0.0f, 1.0f) - 1.0f;
    out[PER_UPPER * PATCH_WIDE] = 1.0f / eight_max(upper - top, 1.0f);
    out[PER_LOWER * PATCH_WIDE] = 1.0f / eight_max(bottom - lower, 1.0f);
}

/* How many rows a curve of the mesh lies above row `from`, in a column of a lid's grid. `from` is
 * where the curve below was put. The result is at least LID_LEAST, and beyond the corners not much
 * less than the two curves lie apart just inside them. */
static inline float surface_lid_gap(
    float from, __global const float *lower, __global const float *higher, int x) {
    float gap = from - higher[x];
    if (x < LID_INNER_SEED) {
        float seed = lower[LID_INNER_SEED] - higher[LID_INNER_SEED];
        gap = eight_max(gap, seed - LID_INNER_FALL * (float)(LID_INNER_SEED - x));
    }
    if (x > LID_OUTER_SEED) {
        float seed = lower[LID_OUTER_SEED] - higher[LID_OUTER_SEED];
        gap = eight_max(gap, seed - LID_OUTER_FALL * (float)(x - LID_OUTER_SEED));
    }
    return eight_max(gap, LID_LEAST);
}

/* The row of a curve, held on the grid and above the curve below it. */
static inline float surface_lid_held(float row, float below, float share) {
    return eight_clamp(row, share * below, below - LID_LEAST);
}

/* Computes what all pixels in a column of a lid's grid share. */
EIGHT_STEP void surface_lid_column(int x, float step_px, __global float *scratch) {
    __global const float *y = scratch + CURVES_AT, *z = y + PATCH_WIDE;
    __global const float *creases = y + 2 * CREASE_LINE * PATCH_WIDE;
    __global const float *folds = y + 2 * FOLD_LINE * PATCH_WIDE;
    __global const float *lower = y + 2 * LOWER_LINE * PATCH_WIDE;
    __global float *out = scratch + COLUMNS_AT + x;
    float at_lash = y[x], at_brow = y[x + 2 * BROW_LINE * PATCH_WIDE] + LID_BROW_BELOW;
    float crease = at_lash - surface_lid_gap(at_lash, y, creases, x);
    crease = surface_lid_held(crease, at_lash, LID_HELD);
    float fold = crease - eight_max(
                              surface_lid_gap(crease, creases, folds, x),
                              LID_FOLD_LEAST * (crease - at_brow));
    fold = surface_lid_held(fold, crease, LID_HELD);
    float brow = surface_lid_held(at_brow, fold, LID_BROW_HELD);
    float slope = surface_slope(y, x, LID_WIDE, 1.0f);
    float lower_slope = surface_slope(lower, x, LID_WIDE, 1.0f);
    /* beyond the corners, where the curves end, the surface stays turned as just inside them */
    int turn = x < LID_TURN_FROM ? LID_TURN_FROM : x > LID_TURN_TO ? LID_TURN_TO : x;
    float fall = (z[turn + 2 * CREASE_LINE * PATCH_WIDE] - z[turn]) /
                 eight_min(creases[turn] - y[turn], -1.0f);
    out[LASH * PATCH_WIDE] = at_lash;
    out[CREASE * PATCH_WIDE] = crease;
    out[FOLD * PATCH_WIDE] = fold;
    out[LOWER_LASH * PATCH_WIDE] = lower[x];
    out[PER_LASH * PATCH_WIDE] = 1.0f / (at_lash - crease);
    out[PER_CREASE * PATCH_WIDE] = 1.0f / (crease - fold);
    out[PER_FOLD * PATCH_WIDE] = (2.0f - LID_FOLD_UP) / (fold - brow);
    out[FALL * PATCH_WIDE] = eight_clamp(fall, -LID_STEEPEST, LID_STEEPEST);
    out[ACROSS * PATCH_WIDE] = eight_clamp(
        surface_slope(z + 2 * CREASE_LINE * PATCH_WIDE, turn, LID_WIDE, 1.0f), -LID_STEEPEST,
        LID_STEEPEST);
    out[LASH_PX * PATCH_WIDE] = step_px / colour_sqrt(1.0f + slope * slope);
    out[LOWER_PX * PATCH_WIDE] = step_px / colour_sqrt(1.0f + lower_slope * lower_slope);
}

/* Computes where lipstick goes: odds and rim, for eight px of the patch. */
EIGHT_STEP void surface_odds(
    int x, int y, __global const float *given, __global const float *scratch, __global float *out) {
    __global const float *column = scratch + COLUMNS_AT + x, *corners = scratch + CORNERS_AT;
    float left = corners[0], right = corners[1], row = (float)y;
    float width = eight_max(right - left, 1.0f);
    int at = y * PATCH_WIDE + x;
    float8 across = (float)x + ROW8;
    float8 from_top = row - EIGHT(column + TOP * PATCH_WIDE),
           to_bottom = EIGHT(column + BOTTOM * PATCH_WIDE) - row;
    float8 from_upper = row - EIGHT(column + UPPER * PATCH_WIDE),
           to_lower = EIGHT(column + LOWER * PATCH_WIDE) - row;
    /* beside a round mouth the border is upright, and no column shows how far away it is */
    float8 border = surface_within8(across, row, scratch + BORDER_AT);
    float8 opening = eight_min8(
        from_upper * EIGHT(column + AT_UPPER * PATCH_WIDE),
        to_lower * EIGHT(column + AT_LOWER * PATCH_WIDE));
    float8 near = from_upper < to_lower ? from_top * EIGHT(column + PER_UPPER * PATCH_WIDE)
                                        : to_bottom * EIGHT(column + PER_LOWER * PATCH_WIDE);
    float8 more = from_upper < to_lower ? EIGHT(column + UPPER_MORE * PATCH_WIDE)
                                        : EIGHT(column + LOWER_MORE * PATCH_WIDE);
    more *= eight_clamp8(1.0f - opening, 0.0f, 1.0f); /* not in the opening itself */
    float8 inside = eight_min8(border, -opening);
    float8 limit = eight_min8(border + REACH * width, OPENING_REACH * width - opening);
    float8 rim =
        EIGHT(column + GAP * PATCH_WIDE) * eight_clamp8(2.0f * near - RIM_START, 0.0f, 1.0f);
    float8 sum = (1.0f - CONTOUR_SHARE) * EIGHT(given + LOGITS_AT + at) +
                 CONTOUR_SHARE * eight_clamp8(inside, -CONTOUR_MOST, CONTOUR_MOST) +
                 more + (rim > 0.0f ? (float8)0.0f : (float8)WIDER);
    PUT(out + at, eight_min8(sum, LIMIT_STEEPNESS * limit));
    PUT(out + RIM_AT + at, rim > 0.0f ? ONTO_LIP * rim : OVER_SEAM * rim);
}

/* Reads the linear luminance of eight pixels of a grid in two rows. Chroma has no detail finer than
 * two by two pixels, so each sample of chroma serves four. */
EIGHT_STEP void surface_light(
    int x, int y, __global const float *given, __global const float *place,
    __global const SAMPLE *luma, __global const float *table, __global float *light, int wide) {
    __global const SAMPLE *cb = luma + (int)given[CHROMA_BEGINS_AT];
    __global const SAMPLE *cr = cb + (int)given[CHROMA_BEGINS_AT + 1];
    __global const float *to_steps = given + TO_STEPS_AT, *weights = given + WEIGHTS_AT;
    float8 twos = (float)x + (float8)(0.5f, 2.5f, 4.5f, 6.5f, 0.5f, 2.5f, 4.5f, 6.5f);
    float row = (float)y;
    float8 blue =
        samples_bilinear(cb, given + CHROMA_AT, place + TO_CHROMA_AT, twos, row + 0.5f).s00112233;
    float8 red =
        samples_bilinear(cr, given + CHROMA_AT, place + TO_CHROMA_AT, twos, row + 0.5f).s00112233;
    for (int i = 0; i < 2; ++i) {
        float8 codes = samples_bilinear(
            luma, given + LUMA_AT, place + TO_LUMA_AT, (float)x + ROW8, row + (float)i);
        float8 sum = (float8)0.0f;
        for (int j = 0; j < 3; ++j) {
            __global const float *to = to_steps + 4 * j;
            float8 steps = to[0] * codes + to[1] * blue + to[2] * red + to[3];
            int8 at = eight_whole8(eight_clamp8(steps, 0.0f, given[LAST_STEP_AT]));
            sum += weights[j] * (float8)(table[at.s0], table[at.s1], table[at.s2], table[at.s3],
                                         table[at.s4], table[at.s5], table[at.s6], table[at.s7]);
        }
#if COLOUR_TRANSFER == 18
        sum = pow(
            sum, (float8)COLOUR_HLG_GAMMA); /* HLG: the gain of the display comes after the sum */
#endif
        PUT(light + (y + i) * wide + x, sum);
    }
}

/* Computes slopes, and the light of each lip, for eight pixels of the lips' grid. */
EIGHT_STEP void surface_lips_pixels(int x, int y, __global float *scratch, __global float *out) {
    __global const float *columns = scratch + COLUMNS_AT + x;
    __global const float *upper = columns + LIP * PATCH_WIDE, *lower = upper + OF_LIP * PATCH_WIDE;
    int at = y * LIPS_WIDE + x;
    float row = 2.0f * (float)y + 0.5f;
    /* with fractions of a px: otherwise the line where the lips meet would have steps */
    float8 share =
        eight_clamp8(0.5f * (EIGHT(columns + SEAM * PATCH_WIDE) - row) + 0.5f, 0.0f, 1.0f);
    int8 is_upper = share > 0.5f;
#define OF_EITHER(name) \
    (is_upper ? EIGHT(upper + (name) * PATCH_WIDE) : EIGHT(lower + (name) * PATCH_WIDE))
    float8 across = eight_clamp8((row - OF_EITHER(FIRST)) * OF_EITHER(PER_HEIGHT), 0.0f, 1.0f);
    float8 outer = OF_EITHER(BEND), middle = OF_EITHER(BEND + 1), inner = OF_EITHER(BEND + 2);
    float8 bend = across < MIDDLE_BETWEEN
                      ? (middle - outer) * (1.0f / (MIDDLE_BETWEEN - FIRST_BETWEEN))
                      : (inner - middle) * (1.0f / (LAST_BETWEEN - MIDDLE_BETWEEN));
    float8 down = middle + bend * (across - MIDDLE_BETWEEN);
    down += is_upper ? FULLER_UPPER_CHANGE * across + FULLER_UPPER
                     : FULLER_LOWER_CHANGE * across + FULLER_LOWER;
    down = eight_clamp8(down, -STEEPEST, STEEPEST);
    float8 along = OF_EITHER(ALONG) - 0.5f * down * OF_EITHER(TILT);
    __global const float *four = out + 2 * y * PATCH_WIDE + 2 * x; /* odds */
    float8 left = EIGHT(four) + EIGHT(four + PATCH_WIDE),
           right = EIGHT(four + 8) + EIGHT(four + PATCH_WIDE + 8);
    float8 lips =
        (float8)(left.even + left.odd, right.even + right.odd) > 0.0f ? (float8)1.0f : (float8)0.0f;
    float8 light = EIGHT(scratch + LIGHT_AT + at);
    __global float *layers = scratch + LAYERS_AT + at;
    PUT(layers + SLOPE_X * LAYER, eight_clamp8(along, -STEEPEST, STEEPEST));
    PUT(layers + SLOPE_Y * LAYER, down);
    PUT(layers + LIGHT * LAYER, light * lips * share);
    PUT(layers + AREA * LAYER, lips * share);
    PUT(layers + LIGHT_BELOW * LAYER, light * (lips - lips * share));
    PUT(layers + AREA_BELOW * LAYER, lips - lips * share);
    PUT(out + LIPS_AT + 4 * LIPS_SIZE + at, share);
}

/* Computes heights, normals and the light of the area, for eight pixels of a lid's grid. */
EIGHT_STEP void surface_lid_pixels(int x, int y, __global float *scratch, __global float *out) {
    __global const float *column = scratch + COLUMNS_AT + x;
    int at = y * LID_WIDE + x;
    float8 above_lash = EIGHT(column + LASH * PATCH_WIDE) - (float)y;
    float8 above_crease = EIGHT(column + CREASE * PATCH_WIDE) - (float)y;
    float8 above_fold = EIGHT(column + FOLD * PATCH_WIDE) - (float)y;
    float8 below_lower = (float)y - EIGHT(column + LOWER_LASH * PATCH_WIDE);
    /* by the rings of the mesh: crease 1, fold 2 */
    float8 ring = above_lash * EIGHT(column + PER_LASH * PATCH_WIDE);
    ring = ring < 1.0f ? ring : 1.0f + above_crease * EIGHT(column + PER_CREASE * PATCH_WIDE);
    float8 up = ring < 1.0f ? ring : 1.0f + (LID_FOLD_UP - 1.0f) * (ring - 1.0f);
    up = ring < 2.0f ? up : LID_FOLD_UP + above_fold * EIGHT(column + PER_FOLD * PATCH_WIDE);
    float8 gx = EIGHT(column + ACROSS * PATCH_WIDE);
    /* a lid lies on a ball: see LID_LEAN in surface.py */
    float8 turned =
        LID_ROUNDNESS * eight_clamp8(0.5f - ring, 0.5f - LID_ROUND_TO, 0.5f) - LID_LEAN;
    float8 gy = EIGHT(column + FALL * PATCH_WIDE) + turned +
                (LID_BELOW - turned) * eight_clamp8(below_lower, 0.0f, 1.0f);
    float8 shrink = surface_shrink8(gx, gy);
    float8 beside = LID_LEFT + LID_STEP * ((float)x + ROW8);
    int8 is_lid = (up > LID_LIGHT_FROM) & (up < LID_LIGHT_TO) & (beside > -LID_LIGHT_BESIDE) &
                  (beside < LID_LIGHT_BESIDE);
    __global float *layers = scratch + LAYERS_AT + at;
    PUT(layers + LIGHT * LAYER, is_lid ? EIGHT(scratch + LIGHT_AT + at) : (float8)0.0f);
    PUT(layers + AREA * LAYER, is_lid ? (float8)1.0f : (float8)0.0f);
    PUT(out + at, up);
    PUT(out + LID_SIZE + at, above_lash * EIGHT(column + LASH_PX * PATCH_WIDE));
    PUT(out + 3 * LID_SIZE + at, gx * shrink);
    PUT(out + 4 * LID_SIZE + at, gy * shrink);
    PUT(out + 5 * LID_SIZE + at, below_lower * EIGHT(column + LOWER_PX * PATCH_WIDE));
}

/* The mean of a region's light in its areas; if those hold less than a pixel, of all of it. */
EIGHT_STEP float surface_mean(__global const float *scratch, int is_lips, int wide, int high) {
    float8 seen = (float8)0.0f, area = (float8)0.0f, all = (float8)0.0f;
    int first = is_lips ? 0 : LID_LIT_FROM, end = is_lips ? wide / 8 : LID_LIT_TO;
    for (int at_eight = 0; at_eight < (end - first) * high; ++at_eight) {
        int i = at_eight / (end - first) * wide + (first + at_eight % (end - first)) * 8;
        __global const float *at = scratch + LAYERS_AT + i;
        seen +=
            EIGHT(at + LIGHT * LAYER) + (is_lips ? EIGHT(at + LIGHT_BELOW * LAYER) : (float8)0.0f);
        area +=
            EIGHT(at + AREA * LAYER) + (is_lips ? EIGHT(at + AREA_BELOW * LAYER) : (float8)0.0f);
        all += EIGHT(scratch + LIGHT_AT + i);
    }
    float total = eight_sum8(area);
    return total >= 1.0f ? eight_sum8(seen) / total : eight_sum8(all) / (float)(8 * (end - first) * high);
}

/* Blurs eight pixels of `count` layers over the rows above and below. Stores them for
 * surface_blur_across, mirrored at both ends. */
static inline void surface_blur_down(
    __global const float *layers, __global float *blurred, int x, int y, int wide, int high,
    __constant const float *taps, int sides, int count) {
    for (int k = 0; k < count; ++k) {
        __global const float *layer = layers + k * LAYER + x;
        float8 sum = taps[0] * EIGHT(layer + y * wide);
        for (int i = 1; i <= sides; ++i)
            sum += taps[i] * (EIGHT(layer + eight_mirror(y - i, high) * wide) +
                              EIGHT(layer + eight_mirror(y + i, high) * wide));
        __global float *row = blurred + k * BLURRED + y * PADDED + PAD;
        PUT(row + x, sum);
        if (x < PAD) PUT(row - x - 7, sum.s76543210);
        if (x >= wide - PAD) PUT(row + 2 * (wide - 1) - x - 7, sum.s76543210);
    }
}

/* Stores zeros likewise, for the columns of a lid's grid that light is not read for. */
static inline void surface_no_light(__global float *blurred, int x, int y) {
    for (int k = LIGHT; k <= AREA; ++k) {
        __global float *row = blurred + k * BLURRED + y * PADDED + PAD;
        PUT(row + x, (float8)0.0f);
        if (x < PAD) PUT(row - x - 7, (float8)0.0f);
        if (x >= LID_WIDE - PAD) PUT(row + 2 * (LID_WIDE - 1) - x - 7, (float8)0.0f);
    }
}

static inline float8 surface_blur_across(
    __global const float *at, __constant const float *taps, int sides) {
    float8 sum = taps[0] * EIGHT(at);
    for (int i = 1; i <= sides; ++i) sum += taps[i] * (EIGHT(at + i) + EIGHT(at - i));
    return sum;
}

/* Finishes shading and normals, and how exposed they are, for eight pixels of the lips' grid. */
EIGHT_STEP void surface_finish_lips(
    int x, int y, __global const float *scratch, __global float *out) {
    __global const float *from = scratch + BLURRED_AT + y * PADDED + PAD + x;
    __global float *to = out + LIPS_AT + y * LIPS_WIDE + x;
    float faint = FAINT * out[MEANS_AT];
    float8 gx = surface_blur_across(from + SLOPE_X * BLURRED, surface_seam_taps, 3);
    float8 gy = surface_blur_across(from + SLOPE_Y * BLURRED, surface_seam_taps, 3);
    float8 shrink = surface_shrink8(gx, gy);
    float8 light[4];
    for (int i = 0; i < 4; ++i)
        light[i] = surface_blur_across(from + i * BLURRED, surface_lip_taps, 12);
    float8 above = (light[LIGHT] + faint) / (light[AREA] + FAINT);
    float8 below = (light[LIGHT_BELOW] + faint) / (light[AREA_BELOW] + FAINT);
    float8 apart = EIGHT(scratch + COLUMNS_AT + SEAM * PATCH_WIDE + x) - (2.0f * (float)y + 0.5f);
    apart = eight_max8(apart, -apart);
    PUT(to, below + EIGHT(to + 4 * LIPS_SIZE) * (above - below));
    PUT(to + LIPS_SIZE, gx * shrink);
    PUT(to + 2 * LIPS_SIZE, gy * shrink);
    PUT(to + 3 * LIPS_SIZE, eight_clamp8(FURROW_PER_PX * apart - FURROW, 0.0f, 1.0f));
}

__kernel void surface(
    __global const float *restrict given, __global const int *restrict rings,
    __global const SAMPLE *restrict planes, __global const float *restrict table,
    __global float *restrict all_scratch, __global float *restrict out) {
    int region = get_group_id(0), is_lips = region == 0;
    int wide = is_lips ? LIPS_WIDE : LID_WIDE, high = is_lips ? LIPS_HIGH : LID_HIGH;
    int first_lit = is_lips ? 0 : LID_LIT_FROM, lit = is_lips ? wide / 8 : LID_LIT_TO - first_lit;
    __global float *scratch = all_scratch + region * SCRATCH_SIZE,
                   *lid = out + LIDS_AT + 6 * (region - 1) * LID_SIZE;

    for
        EACH(i, is_lips ? 12 : LID_CURVES) surface_curve(region, i, given, rings, scratch);
    barrier(CLK_GLOBAL_MEM_FENCE);
    for
        EACH(x, is_lips ? LIPS_WIDE : 0) surface_bend(x, scratch);
    barrier(CLK_GLOBAL_MEM_FENCE);
    for
        EACH(x, is_lips ? PATCH_WIDE : 0) surface_patch_column(x, scratch);
    for
        EACH(x, is_lips ? LIPS_WIDE : 0) surface_lips_column(x, scratch);
    for
        EACH(x, is_lips ? 0 : LID_WIDE)
        surface_lid_column(x, given[region * PLACE_SIZE + STEP_PX_AT], scratch);
    for
        EACH(i, lit * high / 2)
    surface_light(
        (first_lit + i % lit) * 8, i / lit * 2, given, given + region * PLACE_SIZE, planes, table,
        scratch + LIGHT_AT, wide);
    barrier(CLK_GLOBAL_MEM_FENCE);
    for
        EACH(i, is_lips ? PATCH_WIDE / 8 * PATCH_HIGH : 0)
    surface_odds(i % (PATCH_WIDE / 8) * 8, i / (PATCH_WIDE / 8), given, scratch, out);
    barrier(CLK_GLOBAL_MEM_FENCE);
    for
        EACH(i, is_lips ? LIPS_SIZE / 8 : 0)
    surface_lips_pixels(i % (LIPS_WIDE / 8) * 8, i / (LIPS_WIDE / 8), scratch, out);
    for
        EACH(i, is_lips ? 0 : LID_SIZE / 8)
    surface_lid_pixels(i % (LID_WIDE / 8) * 8, i / (LID_WIDE / 8), scratch, lid);
    barrier(CLK_GLOBAL_MEM_FENCE);
    __global const float *layers = scratch + LAYERS_AT;
    __global float *blurred = scratch + BLURRED_AT;
    if (get_local_id(0) == 0) out[MEANS_AT + region] = surface_mean(scratch, is_lips, wide, high);
    for
        EACH(i, is_lips ? LIPS_SIZE / 8 : 0) {
            int x = i % (LIPS_WIDE / 8) * 8, y = i / (LIPS_WIDE / 8);
            surface_blur_down(layers, blurred, x, y, LIPS_WIDE, LIPS_HIGH, surface_lip_taps, 12, 4);
            surface_blur_down(
                layers + SLOPE_X * LAYER, blurred + SLOPE_X * BLURRED, x, y, LIPS_WIDE, LIPS_HIGH,
                surface_seam_taps, 3, 2);
        }
    for
        EACH(i, is_lips ? 0 : LID_SIZE / 8) {
            int x = i % (LID_WIDE / 8) * 8, y = i / (LID_WIDE / 8);
            if (x >= 8 * LID_LIT_FROM && x < 8 * LID_LIT_TO)
                surface_blur_down(
                    layers, blurred, x, y, LID_WIDE, LID_HIGH, surface_lid_taps, 7, 2);
            else
                surface_no_light(blurred, x, y);
        }
    barrier(CLK_GLOBAL_MEM_FENCE);
    for
        EACH(i, is_lips ? LIPS_SIZE / 8 : 0)
    surface_finish_lips(i % (LIPS_WIDE / 8) * 8, i / (LIPS_WIDE / 8), scratch, out);
    for
        EACH(i, is_lips ? 0 : LID_SIZE / 8) {
            int x = i % (LID_WIDE / 8) * 8, y = i / (LID_WIDE / 8);
            __global const float *from = blurred + y * PADDED + PAD + x;
            float8 light = surface_blur_across(from + LIGHT * BLURRED, surface_lid_taps, 7) +
                           FAINT * out[MEANS_AT + region];
            float8 area = surface_blur_across(from + AREA * BLURRED, surface_lid_taps, 7) + FAINT;
            PUT(lid + 2 * LID_SIZE + y * LID_WIDE + x, light / area);
        }
}
