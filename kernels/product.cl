/* Turns products, and the light on a region of a face, into what paint.cl paints there: how the
 * region lies, the material, its layers, and what it mirrors. Host side: product.py, which defines
 * the structs product_*. Numpy twins, which explain each number: pipeline/render/product_twin.py.
 *
 * A work-item makes one region.
 * - regions: where they lie, their light and their products.
 * - rooms: the environment of each region's light, (16, 16, 3).
 * - coding: what all regions share.
 * - records: to be filled.
 * - words: to be filled with the environments, as material.h takes them. */

#include "colour.h"
#include "eight.h"
#include "material.h"

#define PRODUCT_ROOM (3 * MATERIAL_LAYER)

/* How the region lies: from px of its rectangle to px of its grid, and to the skin's coordinates.
 * turn: (2, 2), the directions of the grid's axes in the frame. */
EIGHT_STEP void product_place(
    __global const product_region *region, __global paint_product *record, float *turn) {
    __global const float *to_px = region->to_px;
    float a = to_px[0], b = to_px[1], x = to_px[2], c = to_px[3], d = to_px[4], y = to_px[5];
    float along = colour_sqrt(a * a + c * c), across = colour_sqrt(b * b + d * d);
    float back[6] = {d, -b, b * y - d * x, -c, a, c * x - a * y};
    float area = a * d - b * c, share = area != 0.0f ? 1.0f / area : 0.0f;
    for (int i = 0; i < 6; ++i) {
        float to_grid = back[i] * share;
        record->to_grid[i] = to_grid;
        record->to_patch[i] = to_grid * ((i < 3 ? along : across) / region->skin_px);
    }
    turn[0] = a / along;
    turn[1] = b / across;
    turn[2] = c / along;
    turn[3] = d / across;
}

/* The largest of three channels. */
static inline float product_largest(const float *rgb) {
    return eight_max(rgb[0], eight_max(rgb[1], rgb[2]));
}

/* A channel of a product under a light of that gain: see _lit in product_twin.py. */
static inline float product_lit(float product, float gain, float ceiling) {
    float below = product * colour_min(gain, 1.0f), above = product * colour_positive(gain - 1.0f);
    return material_add(below, above, ceiling);
}

/* Size, radius and visibility of sparkles: see _cells in product_twin.py. */
static inline void product_cells(
    __global const product_coat *coat, float skin_px, material *m, float *seen) {
    float cell = coat->cell, spot = PRODUCT_SPOT;
    int doublings = 0;
    *seen = 0.0f;
    if (m->shimmer > 0.0f) {
        for (; doublings < coat->most_doublings && cell * skin_px < PRODUCT_LEAST_CELL_PX;
             ++doublings)
            cell *= 2.0f;
        float beyond = cell * skin_px / PRODUCT_LEAST_CELL_PX - 1.0f;
        *seen = eight_clamp(beyond / PRODUCT_DISSOLVE, 0.0f, 1.0f);
        if (doublings) *seen *= eight_clamp((1.0f - beyond) / PRODUCT_DISSOLVE, 0.0f, 1.0f);
        spot = eight_clamp(
            PRODUCT_LEAST_SPOT_PX / (cell * skin_px), PRODUCT_SPOT, PRODUCT_LARGEST_SPOT);
    }
    m->cells = 1.0f / cell;
    m->spot = spot * spot;
}

/* The unit vector between light and viewer, in the axes of the region. */
static inline void product_half_way(
    __global const float *direction, const float *turn, float *half_way) {
    float area = turn[0] * turn[3] - turn[1] * turn[2];
    float x = (turn[3] * direction[0] - turn[1] * direction[1]) / area;
    float y = (turn[0] * direction[1] - turn[2] * direction[0]) / area;
    float z = 1.0f - direction[2], shrink = 1.0f / colour_sqrt(x * x + y * y + z * z);
    half_way[0] = x * shrink;
    half_way[1] = y * shrink;
    half_way[2] = z * shrink;
}

/* A coat under the light of its region. */
EIGHT_STEP void product_material(
    __global const product_coat *coat, __global const product_region *region,
    __global const product_coding *coding, const float *turn, material *m) {
    float amount = coat->strength * region->amount, seen;
    m->shimmer = coat->shimmer;
    product_cells(coat, region->skin_px, m, &seen);
    float fine = 1.0f - 0.5f * seen; /* sparkles that are not seen one by one make a sheen */
    for (int i = 0; i < 3; ++i) {
        __global const float *row = coding->to_film + 3 * i, *colour = region->colour;
        float part = row[0] * colour[0] + row[1] * colour[1] + row[2] * colour[2];
        float gain =
            1.0f + coat->adaptation * (colour_positive(part) * region->strength - 1.0f);
        m->product[i] = product_lit(coat->product[i], gain, coding->ceiling);
        m->glint[i] = gain * amount * (coat->glint[i] + coat->sheen[i] * fine);
        m->sparkle[i] = gain * amount * coat->sparkle[i] * seen;
        m->luminance[i] = coding->luminance[i];
    }
    m->opacity = coat->opacity * amount;
    m->texture = coat->texture;
    m->undertone = coat->undertone;
    m->keep_highlights = coat->keep_highlights;
    m->own_highlights = coat->own_highlights * amount;
    m->lobe = coat->lobe;
    product_half_way(region->direction, turn, m->half_way);
    m->reflection = coat->reflection * amount;
    m->fresnel_front = coat->fresnel_front;
    m->fresnel_rim = coat->fresnel_rim;
    for (int i = 0; i < 4; ++i) m->room[i] = coat->room * turn[i];
    m->dark = PRODUCT_DARK * (region->strength > 0.1f ? region->strength : 0.1f);
    m->dark_gain = coat->dark_gain;
    m->dark_offset = coat->dark_offset;
    for (int i = 0; i < 9; ++i) {
        m->to_film[i] = coding->to_film[i];
        m->from_film[i] = coding->from_film[i];
    }
    m->ceiling = coding->ceiling;
}

/* Sets a number of `common` to its mean over the coats, by share. */
#define PRODUCT_MEAN(name, shares)                                       \
    do {                                                                 \
        float sum = 0.0f;                                                \
        for (int i = 0; i < count; ++i) sum += (shares)[i] * made[i].name; \
        common->name = sum;                                              \
    } while (0)

/* Divides numbers by their sum; makes equal shares if the sum is next to nothing. */
static inline void product_normalise(float *shares, int count) {
    float sum = 0.0f;
    for (int i = 0; i < count; ++i) sum += shares[i];
    for (int i = 0; i < count; ++i)
        shares[i] = sum > PRODUCT_NONE ? shares[i] / sum : 1.0f / (float)count;
}

/* Fills the rows of the layers and their mean root; returns how much each shines in `shines`. */
EIGHT_STEP void product_layers(
    const material *made, int count, __global const float *seen, __global paint_product *record,
    float *shines) {
    float most[3] = {0.0f, 0.0f, 0.0f}, ways[PAINT_LAYERS][3], roots[3] = {0.0f, 0.0f, 0.0f};
    float opacity = 0.0f;
    for (int i = 0; i < count; ++i) {
        const material *m = made + i;
        ways[i][0] = m->own_highlights;
        ways[i][1] = m->reflection;
        ways[i][2] = m->shimmer * product_largest(m->sparkle);
        for (int k = 0; k < 3; ++k) most[k] = eight_max(most[k], ways[i][k]);
    }
    for (int i = 0; i < PAINT_LAYERS; ++i) {
        __global float *row = record->layers + PAINT_ROW * i;
        if (i >= count) {
            for (int k = 0; k < PAINT_ROW; ++k) row[k] = 0.0f;
            continue;
        }
        const material *m = made + i;
        shines[i] = 0.0f;
        for (int k = 0; k < 3; ++k) {
            row[k] = m->opacity * colour_sqrt(colour_positive(m->product[k]));
            roots[k] += row[k] * seen[i];
            row[4 + k] = m->glint[k];
            if (most[k] > 0.0f) shines[i] = eight_max(shines[i], ways[i][k] / most[k]);
        }
        opacity += m->opacity * seen[i];
        row[3] = m->opacity;
        row[7] = shines[i];
    }
    for (int k = 0; k < 3; ++k)
        record->mean_root[k] = PAINT_FAINT * roots[k] / eight_max(opacity, PRODUCT_NONE);
    record->layer_count = count;
}

/* The material of several coats: the numbers that are the same all over a surface, see _common in
 * product_twin.py.
 * seen: how much each coat shows.  shines: how much it shines. */
EIGHT_STEP void product_common(
    const material *made, int count, __global const float *seen, const float *shines,
    material *common) {
    float opaque[PAINT_LAYERS], glints[PAINT_LAYERS], mirrors[PAINT_LAYERS];
    float shining = 0.0f, mirrored = 0.0f, sparkled = 0.0f, own = 0.0f, most = -1.0f;
    int brightest = 0;
    for (int i = 0; i < count; ++i) {
        const material *m = made + i;
        float part = seen[i];
        float sparkling = part * m->shimmer * product_largest(m->sparkle);
        opaque[i] = part * m->opacity;
        glints[i] = part * product_largest(m->glint);
        mirrors[i] = part * m->reflection;
        mirrored += mirrors[i];
        sparkled += sparkling;
        own += part * m->own_highlights;
        shining += part * shines[i];
        if (sparkling > most) {
            most = sparkling;
            brightest = i;
        }
    }
    /* the map of shine multiplies these strengths, so they are divided by its sum */
    shining = eight_max(shining, PRODUCT_NONE);
    *common = made[brightest];
    float full = common->shimmer * product_largest(common->sparkle);
    float dimmed = full > 0.0f ? eight_min(sparkled / shining / full, 1.0f) : 1.0f;
    for (int k = 0; k < 3; ++k) common->sparkle[k] *= dimmed;
    common->own_highlights = own / shining;
    common->reflection = eight_min(mirrored / shining, 1.0f);
    product_normalise(opaque, count);
    product_normalise(mirrors, count);
    product_normalise(glints, count);
    PRODUCT_MEAN(texture, opaque);
    PRODUCT_MEAN(undertone, opaque);
    PRODUCT_MEAN(keep_highlights, opaque);
    PRODUCT_MEAN(dark_gain, opaque);
    PRODUCT_MEAN(dark_offset, opaque);
    PRODUCT_MEAN(fresnel_front, mirrors);
    PRODUCT_MEAN(fresnel_rim, mirrors);
    PRODUCT_MEAN(room[0], mirrors);
    PRODUCT_MEAN(room[1], mirrors);
    PRODUCT_MEAN(room[2], mirrors);
    PRODUCT_MEAN(room[3], mirrors);
    PRODUCT_MEAN(lobe, glints);
}

/* Blurs a room as a coat mirrors it, subtracts most of its mean light, and packs it into words;
 * returns the step of a channel. */
EIGHT_STEP float product_room(
    __global const float *room, __global const product_coat *coat,
    __global const product_coding *coding, __global int *words) {
    float8 turned[PRODUCT_ROOM / 8], blurred[PRODUCT_ROOM / 8]; /* a plane for each channel */
    float *numbers = (float *)turned;
    float8 brightest = (float8)0.0f;
    for (int k = 0; k < 3; ++k) {
        __global const float *row = coding->to_room + 3 * k;
        for (int i = 0; i < MATERIAL_LAYER; ++i)
            numbers[k * MATERIAL_LAYER + i] =
                row[0] * room[3 * i] + row[1] * room[3 * i + 1] + row[2] * room[3 * i + 2];
    }
    for (int y = 0; y < 3 * MATERIAL_ROW; ++y) { /* along each row */
        float8 left = (float8)0.0f, right = (float8)0.0f;
        for (int x = 0; x < MATERIAL_ROW; ++x) {
            left += numbers[y * MATERIAL_ROW + x] * EIGHT(coat->blur + x * MATERIAL_ROW);
            right += numbers[y * MATERIAL_ROW + x] * EIGHT(coat->blur + x * MATERIAL_ROW + 8);
        }
        blurred[2 * y] = left;
        blurred[2 * y + 1] = right;
    }
    for (int k = 0; k < 3; ++k) { /* and down the columns */
        const float8 *plane = blurred + k * MATERIAL_LAYER / 8;
        float8 *made = turned + k * MATERIAL_LAYER / 8, total = (float8)0.0f;
        for (int i = 0; i < MATERIAL_LAYER / 8; ++i) {
            float8 sum = (float8)0.0f;
            for (int y = 0; y < MATERIAL_ROW; ++y)
                sum += coat->blur[y * MATERIAL_ROW + i / 2] * plane[2 * y + i % 2];
            total += sum;
            made[i] = sum;
        }
        float veil = eight_sum8(total) * (PRODUCT_VEIL / MATERIAL_LAYER);
        for (int i = 0; i < MATERIAL_LAYER / 8; ++i) {
            made[i] = eight_max8(made[i] - veil, (float8)0.0f);
            brightest = eight_max8(brightest, made[i]);
        }
    }
    float most = 0.0f;
    for (int i = 0; i < 8; ++i) most = eight_max(most, ((const float *)&brightest)[i]);
    float step = most / (float)((1 << MATERIAL_ROOM_BITS) - 1);
    int is_dark = step < PRODUCT_FAINTEST_STEP;
    float steps = is_dark ? 0.0f : 1.0f / step;
    for (int i = 0; i < MATERIAL_LAYER; ++i) {
        int word = 0;
        for (int k = 0; k < 3; ++k)
            word |= (int)(numbers[k * MATERIAL_LAYER + i] * steps + 0.5f)
                    << (k * MATERIAL_ROOM_BITS);
        words[i] = word;
    }
    return is_dark ? 0.0f : step;
}

__kernel void product(
    __global const product_region *restrict regions, __global const float *restrict rooms,
    __global const product_coding *restrict coding, __global paint_product *restrict records,
    __global int *restrict words) {
    int i = get_global_id(0), count = regions[i].coat_count, mirror = 0;
    __global const product_region *region = regions + i;
    __global paint_product *record = records + i;
    float turn[4], shines[PAINT_LAYERS];
    material made[PAINT_LAYERS], common;
    product_place(region, record, turn);
    for (int k = 0; k < count; ++k) {
        product_material(region->coats + k, region, coding, turn, made + k);
        if (region->coats[k].reflection > region->coats[mirror].reflection) mirror = k;
    }
    record->layer_count = 0;
    if (count > 1) {
        product_layers(made, count, region->seen, record, shines);
        product_common(made, count, region->seen, shines, &common);
        record->material = common;
    } else
        record->material = made[0];
    record->room_step = 0.0f;
    if (region->coats[mirror].reflection > 0.0f)
        record->room_step = product_room(
            rooms + i * PRODUCT_ROOM, region->coats + mirror, coding, words + i * MATERIAL_LAYER);
}
