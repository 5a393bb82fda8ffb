/* Makeup on a surface, in linear light: recolouring, gloss, reflection, shimmer.
 * Numpy twin, with the meaning of every number: material.py. */

#ifndef MATERIAL_H
#define MATERIAL_H

#define MATERIAL_INLINE static inline __attribute__((always_inline))

/* Made by Material.argument in material.py. */
typedef struct {
    float product[3];   /* the product's colour, lit */
    float glint[3];     /* colour and strength of the synthetic highlight */
    float sparkle[3];   /* the same of shimmer */
    float luminance[3]; /* weights of red, green and blue */
    float opacity;
    float texture;
    float undertone;
    float own_highlights; /* gain of the highlights that were there */
    float lobe;           /* squared width of the highlight */
    float half_way[3];    /* between light and viewer, z towards the viewer */
    float reflection;
    float fresnel_front, fresnel_rim;
    float room[4];     /* turns a normal's x, y into the environment's */
    float shimmer;     /* density */
    float cells;       /* sparkles' cells for each unit of what sticks to the skin */
    float spot;        /* squared radius of a sparkle, in cells */
    float dark;        /* light below which nothing is told apart */
    float dark_gain, dark_offset; /* of fine light: what is spared because it is dark */
    float to_film[9], from_film[9]; /* between the frame's primaries and sRGB's */
    float ceiling;     /* the brightest light that is painted */
} material;

/* What a pixel's surface is, whatever its weight. */
typedef struct {
    float coarse;    /* luminance of what is there, without its fine texture */
    float shade;     /* the same, 1 on the region's average */
    float nx, ny;    /* unit normal; z is towards the viewer */
    float lobe;      /* synthetic highlight, 1 at its peak */
    float mirror;    /* share of the reflection */
    colour_rgb room; /* what it shows */
} material_surface;

/* The environment, (3, 16, 16), begins at that place in maps. */
MATERIAL_INLINE material_surface material_at(
    float coarse, float mean, float nx, float ny, __global const float *maps, int environment,
    const material *m) {
    float sum = nx * nx + ny * ny;
    float shrink = 0.96f / (0.96f + colour_positive(sum - 0.96f));
    shrink = colour_sqrt(shrink);
    nx *= shrink;
    ny *= shrink;
    float nz = colour_sqrt(1.0f - (nx * nx + ny * ny));
    material_surface s;
    s.coarse = coarse;
    float shade = (coarse + m->dark) * (1.0f / (mean + m->dark));
    s.shade = colour_min(shade, 4.0f);
    s.nx = nx;
    s.ny = ny;
    float facing = nx * m->half_way[0] + ny * m->half_way[1] + nz * m->half_way[2];
    facing = colour_positive(facing);
    /* Trowbridge and Reitz's lobe (GGX), 1 at its peak */
    float lobe = m->lobe / (1.0f - facing * facing * (1.0f - m->lobe));
    s.lobe = lobe * lobe;
    float rim = 1.0f - nz;
    s.mirror = m->reflection * (m->fresnel_front + m->fresnel_rim * rim * rim * rim);
    /* the reflected ray's x and y, from the middle of 16 x 16 texels */
    float rx = 2.0f * nz * nx, ry = 2.0f * nz * ny;
    float ex = 7.5f + m->room[0] * rx + m->room[1] * ry;
    float ey = 7.5f + m->room[2] * rx + m->room[3] * ry;
    ex = colour_clamp(ex, 14.999f);
    ey = 14.999f - colour_clamp(14.999f - ey, 14.999f);
    int ix = (int)ex, iy = (int)ey;
    float fx = ex - (float)ix, fy = ey - (float)iy;
    /* one place to gather from, and 32 bits of index: PoCL gathers eight floats at once only so */
    int k = environment + 16 * iy + ix;
    float a = (1.0f - fx) * (1.0f - fy), b = fx * (1.0f - fy), c = (1.0f - fx) * fy, d = fx * fy;
    s.room.red = a * maps[k] + b * maps[k + 1] + c * maps[k + 16] + d * maps[k + 17];
    s.room.green = a * maps[k + 256] + b * maps[k + 257] + c * maps[k + 272] + d * maps[k + 273];
    s.room.blue = a * maps[k + 512] + b * maps[k + 513] + c * maps[k + 528] + d * maps[k + 529];
    return s;
}

/* Light upon light: nearly `base + more` while there is room, and never above the ceiling. */
MATERIAL_INLINE float material_more(float base, float more, float ceiling) {
    float room = colour_positive(ceiling - base) + 1e-4f;
    return room * more / (room + more);
}

MATERIAL_INLINE float material_add(float base, float more, float ceiling) {
    return base + material_more(base, more, ceiling);
}

/* Sparkles that stick to the skin: each cell of the patch has one or none, tilted its own way. */
MATERIAL_INLINE float material_sparkle(float px, float py, const material_surface *s, const material *m) {
    float u = px * m->cells, v = py * m->cells;
    /* within the cell, from numbers that are not as large as 4096: those have few digits left */
    int iu = (int)(u + 4096.0f), iv = (int)(v + 4096.0f);
    float in_u = u - (float)(iu - 4096), in_v = v - (float)(iv - 4096);
    uint hash = (uint)iu * 374761393u + (uint)iv * 668265263u;
    hash = (hash ^ (hash >> 13)) * 1274126177u;
    hash ^= hash >> 16;
    float unit = 1.0f / 256.0f;
    float present = (float)(int)(hash & 255u) * unit;
    float du = in_u - 0.3f - 0.4f * unit * (float)(int)((hash >> 8) & 255u);
    float dv = 0.3f + 0.4f * unit * (float)(int)((hash >> 16) & 255u) - in_v;
    float tx = s->nx - m->half_way[0] + 1.3f * (unit * (float)(int)((hash >> 4) & 255u) - 0.5f);
    float ty = 1.3f * (0.5f - unit * (float)(int)((hash >> 12) & 255u)) - (s->ny - m->half_way[1]);
    float spot = 1.0f - (du * du + dv * dv) * (1.0f / m->spot);
    spot = colour_positive(spot);
    float glint = 1.0f - 2.5f * (tx * tx + ty * ty);
    glint = glint > 0.0f ? glint : 0.0f;
    return present < m->shimmer ? spot * spot * glint : 0.0f;
}

/* One channel of the product, shaded, laid on so that nothing shows through but undertone. */
MATERIAL_INLINE float material_lay(
    float bare, float product, float skin, float below, float above, float own, const material *m) {
    float base = product * (1.0f - m->undertone) + colour_positive(bare) * skin;
    return material_add(base * below, base * above + own, m->ceiling);
}

/* How a film changes one channel of what is under it; it deepens it before it covers it: see
 * made_up in material.py. */
MATERIAL_INLINE float material_film(float bare, float laid, float opaque) {
    float seen = colour_positive(bare);
    float root = colour_sqrt(seen);
    root += opaque * (colour_sqrt(colour_abs(laid)) - root);
    return root * root - seen - opaque * (bare - seen);
}

MATERIAL_INLINE colour_rgb material_turn(colour_rgb light, const float *rows) {
    colour_rgb out = {
        rows[0] * light.red + rows[1] * light.green + rows[2] * light.blue,
        rows[3] * light.red + rows[4] * light.green + rows[5] * light.blue,
        rows[6] * light.red + rows[7] * light.green + rows[8] * light.blue,
    };
    return out;
}

/* The light of a pixel with makeup of that weight (0 to 1) on it; px, py in the patch. */
MATERIAL_INLINE colour_rgb material_paint(
    colour_rgb bare, float weight, float px, float py, const material_surface *s, const material *m) {
    colour_rgb under = material_turn(bare, m->to_film);
    float y = m->luminance[0] * under.red + m->luminance[1] * under.green + m->luminance[2] * under.blue;
    float lit = colour_positive(y) + m->dark;
    float broad = s->coarse + m->dark;
    float fine = lit / broad;
    fine = colour_min(fine, 6.0f);
    weight *= colour_clamp(m->dark_offset + m->dark_gain * fine, 1.0f);
    float matte = colour_min(fine, 1.25f);
    float highlight = weight * (fine - matte) * broad; /* at the edge bright skin is no highlight */
    float shade = s->shade * (1.0f + m->texture * (matte - 1.0f));
    float below = colour_min(shade, 1.0f);
    float above = shade - below;
    float product_y = m->luminance[0] * m->product[0] + m->luminance[1] * m->product[1] + m->luminance[2] * m->product[2];
    float skin = m->undertone * product_y / lit;
    float opaque = weight * m->opacity;
    float own = m->texture * highlight;
    float mirror = weight * s->mirror;
    float breakup = 2.5f * fine - 1.5f;
    breakup = colour_clamp(breakup, 2.0f);
    float lobe = weight * s->lobe * breakup;
    float shown = weight * m->own_highlights * highlight;
    float sparkle = weight * material_sparkle(px, py, s, m);
    colour_rgb film = {
        material_film(under.red, material_lay(under.red, m->product[0], skin, below, above, own, m), opaque),
        material_film(under.green, material_lay(under.green, m->product[1], skin, below, above, own, m), opaque),
        material_film(under.blue, material_lay(under.blue, m->product[2], skin, below, above, own, m), opaque),
    };
    colour_rgb change = {
        film.red + material_more(under.red + film.red, lobe * m->glint[0] + shown + sparkle * m->sparkle[0] + mirror * s->room.red, m->ceiling),
        film.green + material_more(under.green + film.green, lobe * m->glint[1] + shown + sparkle * m->sparkle[1] + mirror * s->room.green, m->ceiling),
        film.blue + material_more(under.blue + film.blue, lobe * m->glint[2] + shown + sparkle * m->sparkle[2] + mirror * s->room.blue, m->ceiling),
    };
    change = material_turn(change, m->from_film);
    colour_rgb out = {bare.red + change.red, bare.green + change.green, bare.blue + change.blue};
    return out;
}

#endif
