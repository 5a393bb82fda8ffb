/* Makeup on a surface, in linear light: recolouring, gloss, reflection, shimmer.
 * Numpy twin: material_twin.py. Host side: material.py, which defines the struct `material`, with
 * the meaning of every number, and the constants MATERIAL_*. */

#ifndef MATERIAL_H
#define MATERIAL_H

#define MATERIAL_INLINE static inline __attribute__((always_inline))
#define MATERIAL_ROW MATERIAL_ENVIRONMENT_PX
#define MATERIAL_LAYER (MATERIAL_ENVIRONMENT_PX * MATERIAL_ENVIRONMENT_PX)

/* The surface of the skin at a pixel, whatever the weight of the makeup there. */
typedef struct {
    float coarse;    /* luminance of the bare skin without its fine texture */
    float shade;     /* the same relative to the mean of the region */
    float nx, ny;    /* unit normal; z is towards the viewer */
    float lobe;      /* synthetic highlight, 1 at its peak */
    float mirror;    /* share of the reflection, times the step of room */
    colour_rgb room; /* what the reflection shows, in steps */
} material_surface;

/* The lowest MATERIAL_ROOM_BITS of a word. */
MATERIAL_INLINE float material_part(uint word) {
    return (float)(int)(word & ((1u << MATERIAL_ROOM_BITS) - 1u));
}

/* Computes a pixel's surface. exposed: the share of the synthetic highlight and the reflection that
 * is seen. The environment, (MATERIAL_ENVIRONMENT_PX, MATERIAL_ENVIRONMENT_PX), begins at index
 * `environment` of maps: words of three channels, in steps of room_step. */
MATERIAL_INLINE material_surface material_at(
    float coarse, float mean, float nx, float ny, float exposed, __global const float *maps,
    int environment, float room_step, const material *m) {
    float sum = nx * nx + ny * ny;
    float shrink =
        MATERIAL_STEEPEST / (MATERIAL_STEEPEST + colour_positive(sum - MATERIAL_STEEPEST));
    shrink = colour_sqrt(shrink);
    nx *= shrink;
    ny *= shrink;
    float nz = colour_sqrt(1.0f - (nx * nx + ny * ny));
    material_surface s;
    s.coarse = coarse;
    float shade = (coarse + m->dark) * (1.0f / (mean + m->dark));
    s.shade = colour_min(shade, MATERIAL_BRIGHTEST_SHADE);
    s.nx = nx;
    s.ny = ny;
    float facing = nx * m->half_way[0] + ny * m->half_way[1] + nz * m->half_way[2];
    facing = colour_positive(facing);
    /* Trowbridge and Reitz's lobe (GGX), 1 at its peak, without its tail */
    float lobe = m->lobe / (1.0f - facing * facing * (1.0f - m->lobe));
    lobe = colour_positive(lobe * lobe - MATERIAL_LOBE_TAIL);
    s.lobe = exposed * lobe * (1.0f / (1.0f - MATERIAL_LOBE_TAIL));
    float rim = 1.0f - nz;
    float fresnel = m->fresnel_front + m->fresnel_rim * rim * rim * rim;
    s.mirror = exposed * room_step * m->reflection * fresnel;
    /* the reflected ray's x and y, from the middle of the environment's texels */
    float rx = 2.0f * nz * nx, ry = 2.0f * nz * ny;
    float ex = MATERIAL_MIDDLE + m->room[0] * rx + m->room[1] * ry;
    float ey = MATERIAL_MIDDLE + m->room[2] * rx + m->room[3] * ry;
    ex = colour_clamp(ex, MATERIAL_LAST);
    ey = MATERIAL_LAST - colour_clamp(MATERIAL_LAST - ey, MATERIAL_LAST);
    int ix = (int)ex, iy = (int)ey;
    float fx = ex - (float)ix, fy = ey - (float)iy;
    /* PoCL reads eight scattered places one by one, so one word holds all three channels */
    int k = environment + MATERIAL_ROW * iy + ix;
    float a = (1.0f - fx) * (1.0f - fy), b = fx * (1.0f - fy), c = (1.0f - fx) * fy, d = fx * fy;
    uint at = as_uint(maps[k]), beside = as_uint(maps[k + 1]);
    uint under = as_uint(maps[k + MATERIAL_ROW]), opposite = as_uint(maps[k + MATERIAL_ROW + 1]);
#define MIXED(shift)                                                               \
    (a * material_part(at >> (shift)) + b * material_part(beside >> (shift)) +     \
     c * material_part(under >> (shift)) + d * material_part(opposite >> (shift)))
    s.room.red = MIXED(0);
    s.room.green = MIXED(MATERIAL_ROOM_BITS);
    s.room.blue = MIXED(2 * MATERIAL_ROOM_BITS);
#undef MIXED
    return s;
}

/* What is added to `base`: nearly `more` while there is room, next to nothing at the ceiling. */
MATERIAL_INLINE float material_more(float base, float more, float ceiling) {
    float room = colour_positive(ceiling - base) + MATERIAL_LEAST_ROOM;
    return room * more / (room + more);
}

MATERIAL_INLINE float material_add(float base, float more, float ceiling) {
    return base + material_more(base, more, ceiling);
}

/* Sparkles that stick to the skin: each cell of the patch has one or none, with a tilt of its own.
 */
MATERIAL_INLINE float material_sparkle(
    float px, float py, const material_surface *s, const material *m) {
    float u = px * m->cells, v = py * m->cells;
    int iu = (int)(u + (float)MATERIAL_CELLS_BEFORE_ZERO),
        iv = (int)(v + (float)MATERIAL_CELLS_BEFORE_ZERO);
    /* within the cell, from u and v before the shift, in which float32 loses digits */
    float in_u = u - (float)(iu - MATERIAL_CELLS_BEFORE_ZERO),
          in_v = v - (float)(iv - MATERIAL_CELLS_BEFORE_ZERO);
    uint hash = (uint)iu * 374761393u + (uint)iv * 668265263u;
    hash = (hash ^ (hash >> 13)) * 1274126177u;
    hash ^= hash >> 16;
    float unit = 1.0f / 256.0f;
    float present = (float)(int)(hash & 255u) * unit;
    float du = in_u - MATERIAL_SPARKLE_MARGIN -
               MATERIAL_SPARKLE_SPREAD * unit * (float)(int)((hash >> 8) & 255u);
    float dv = MATERIAL_SPARKLE_MARGIN +
               MATERIAL_SPARKLE_SPREAD * unit * (float)(int)((hash >> 16) & 255u) - in_v;
    float tx = s->nx - m->half_way[0] +
               MATERIAL_SPARKLE_TILT * (unit * (float)(int)((hash >> 4) & 255u) - 0.5f);
    float ty = MATERIAL_SPARKLE_TILT * (0.5f - unit * (float)(int)((hash >> 12) & 255u)) -
               (s->ny - m->half_way[1]);
    float spot = 1.0f - (du * du + dv * dv) * (1.0f / m->spot);
    spot = colour_positive(spot);
    float glint = 1.0f - MATERIAL_SPARKLE_NARROWNESS * (tx * tx + ty * ty);
    glint = glint > 0.0f ? glint : 0.0f;
    return present < m->shimmer ? spot * spot * glint : 0.0f;
}

/* One channel of the product, shaded and opaque: only undertone shows through. */
MATERIAL_INLINE float material_lay(
    float bare, float product, float skin, float below, float above, float own, const material *m) {
    float base = product * (1.0f - m->undertone) + colour_positive(bare) * skin;
    return material_add(base * below, base * above + own, m->ceiling);
}

/* How a film changes one channel of the light under it. The film deepens before it covers: see
 * made_up in material_twin.py. */
MATERIAL_INLINE float material_film(float bare, float laid, float opaque) {
    float seen = colour_positive(bare);
    float root = colour_sqrt(seen);
    root += opaque * (colour_sqrt(colour_abs(laid)) - root);
    return root * root - seen - opaque * (bare - seen);
}

/* Multiplies light by a (3, 3) matrix, given by rows. */
MATERIAL_INLINE colour_rgb material_turn(colour_rgb light, const float *rows) {
    colour_rgb out = {
        rows[0] * light.red + rows[1] * light.green + rows[2] * light.blue,
        rows[3] * light.red + rows[4] * light.green + rows[5] * light.blue,
        rows[6] * light.red + rows[7] * light.green + rows[8] * light.blue,
    };
    return out;
}

/* The light of a pixel with makeup of a weight (0 to 1) on it; px, py: its place in the patch. */
MATERIAL_INLINE colour_rgb material_paint(
    colour_rgb bare, float weight, float px, float py, const material_surface *s,
    const material *m) {
    colour_rgb under = material_turn(bare, m->to_film);
    float y =
        m->luminance[0] * under.red + m->luminance[1] * under.green + m->luminance[2] * under.blue;
    float lit = colour_positive(y) + m->dark;
    float broad = s->coarse + m->dark;
    float fine = lit / broad;
    fine = colour_min(fine, MATERIAL_BRIGHTEST);
    float matte = colour_min(fine, MATERIAL_FINEST);
    float shade = s->shade * (1.0f + m->texture * (matte - 1.0f));
    float below = colour_min(shade, 1.0f);
    float above = shade - below;
    float product_y = m->luminance[0] * m->product[0] + m->luminance[1] * m->product[1] +
                      m->luminance[2] * m->product[2];
    float bright = product_y / lit; /* the product's luminance, as a multiple of the pixel's */
    float skin = m->undertone * bright;
    /* dark places are spared only where the product would lighten them */
    float kept = colour_clamp(m->dark_offset + m->dark_gain * fine, 1.0f);
    float lighter = colour_positive(bright * shade - 1.0f);
    float opaque = weight * m->opacity * (1.0f - colour_min(1.0f - kept, lighter));
    weight *= kept;
    /* as a multiple of the pixel's light; bright skin at the makeup's edge is no highlight */
    float highlight = weight * (fine - matte) * broad / lit;
    float own = m->texture * m->keep_highlights * highlight;
    float mirror = weight * s->mirror;
    float breakup = MATERIAL_BREAKUP_GAIN * fine - MATERIAL_BREAKUP_START;
    breakup = colour_clamp(breakup, MATERIAL_BREAKUP_MOST);
    float lobe = weight * s->lobe * breakup;
    float shown = weight * m->own_highlights * highlight;
    float sparkle = weight * material_sparkle(px, py, s, m);
    float white = (1.0f - MATERIAL_OWN_HUE) * lit;
    colour_rgb shining = {
        white + MATERIAL_OWN_HUE * colour_positive(under.red),
        white + MATERIAL_OWN_HUE * colour_positive(under.green),
        white + MATERIAL_OWN_HUE * colour_positive(under.blue)};
    colour_rgb film = {
        material_film(
            under.red,
            material_lay(under.red, m->product[0], skin, below, above, own * shining.red, m), opaque),
        material_film(
            under.green,
            material_lay(under.green, m->product[1], skin, below, above, own * shining.green, m),
            opaque),
        material_film(
            under.blue,
            material_lay(under.blue, m->product[2], skin, below, above, own * shining.blue, m),
            opaque),
    };
    colour_rgb change = {
        film.red + material_more(
                       under.red + film.red,
                       lobe * m->glint[0] + shown * shining.red + sparkle * m->sparkle[0] +
                           mirror * s->room.red,
                       m->ceiling),
        film.green +
            material_more(
                under.green + film.green,
                lobe * m->glint[1] + shown * shining.green + sparkle * m->sparkle[1] +
                    mirror * s->room.green,
                m->ceiling),
        film.blue +
            material_more(
                under.blue + film.blue,
                lobe * m->glint[2] + shown * shining.blue + sparkle * m->sparkle[2] +
                    mirror * s->room.blue,
                m->ceiling),
    };
    change = material_turn(change, m->from_film);
    colour_rgb out = {bare.red + change.red, bare.green + change.green, bare.blue + change.blue};
    return out;
}

#endif
