/* Paints products on regions of a frame, in linear light. Numpy twin: paint_twin.py. Host side:
 * paint.py, which defines the struct paint_region, PAINT_* and RUN; program.py defines SAMPLE and
 * BLOCK_*.
 *
 * The rectangles of all regions lie below each other in one picture, the canvas, `stride` pixels
 * wide; each begins at a whole block. A block is BLOCK_ACROSS x BLOCK_DOWN luma pixels and their
 * chroma. Three kernels run one after another. `paint` runs up to twice for each coat: on the
 * regions without layers, and on those with layers. Their arguments:
 * - luma: the canvas, changed in place where there is weight.
 * - chroma: its Cb, then its Cr, likewise.
 * - codes: f32, Cb and Cr of each luma pixel, likewise.
 * - weights: of the product, 0 to 1, for each pixel; those of a coat begin at `first`.
 * - maps: one region after another: luminance of the bare skin without its fine texture, x and y of
 *   the unit normal (z is towards the viewer), how exposed it is, each (grid_high, grid_wide); and
 *   the environment, as material.h takes it. With PAINT_LAYERED then the shares of the layers,
 *   (count, grid_high, grid_wide).
 * - rows: the region of each row of blocks.
 * - runs: the run that each work-group paints, RUN x BLOCK_DOWN pixels, counted row by row; runs
 *   without weight are left out.
 *
 * Chroma has kernels of its own. If `paint` read chroma at half the index of luma, or behind a
 * barrier, PoCL would vectorise its work on pixels by four, or not at all. */

#include "colour.h"
#include "material.h"

/* The first pixel of a run. */
MATERIAL_INLINE int paint_start(int run, int stride) {
    int in_row = stride / RUN;
    return run / in_row * (BLOCK_DOWN * stride) + run % in_row * RUN;
}

/* The first chroma sample of a run. */
MATERIAL_INLINE int paint_start_chroma(int run, int stride) {
    int in_row = stride / RUN;
    return run / in_row * (stride / BLOCK_ACROSS) + run % in_row * (RUN / BLOCK_ACROSS);
}

/* Copies chroma to each luma pixel. Each chroma sample has a work-item.
 * - size, chroma_size: of luma and of Cb, in samples. */
__kernel void paint_spread(
    __global const SAMPLE *restrict chroma, __global float *restrict codes,
    __global const int *restrict runs, const int stride, const int size, const int chroma_size) {
    int run = runs[get_group_id(0)], lane = get_local_id(0);
    int from = paint_start_chroma(run, stride) + lane;
    int to = paint_start(run, stride) + lane * BLOCK_ACROSS;
    float cb = chroma[from], cr = chroma[from + chroma_size];
    for (int j = 0; j < BLOCK_DOWN; ++j)
        for (int i = 0; i < BLOCK_ACROSS; ++i) {
            codes[to + j * stride + i] = cb;
            codes[to + j * stride + i + size] = cr;
        }
}

/* Interpolates between four neighbours of a grid. */
MATERIAL_INLINE float paint_between(
    __global const float *maps, int k, int wide, float fx, float fy) {
    float a = (1.0f - fx) * (1.0f - fy), b = fx * (1.0f - fy), c = (1.0f - fx) * fy, d = fx * fy;
    return a * maps[k] + b * maps[k + 1] + c * maps[k + wide] + d * maps[k + wide + 1];
}

#ifdef PAINT_LAYERED
/* The sum of one number over all layers, by how much each layer shows. */
#define PAINT_SUM(at)                                         \
    (share[0] * rows[at] + share[1] * rows[PAINT_ROW + (at)] + \
     share[2] * rows[2 * PAINT_ROW + (at)] + share[3] * rows[3 * PAINT_ROW + (at)])

/* Replaces the material's product by the one that the layers make together at a pixel.
 * k: index of the first layer's share, at the top left neighbour.  layer: numbers of a map. */
MATERIAL_INLINE void paint_compose(
    material *m, __global const paint_region *region, __global const float *maps, int k, int wide,
    int layer, float fx, float fy) {
    __global const float *rows = region->product.layers;
    int last = region->product.layer_count - 1;
    float share[PAINT_LAYERS];
#pragma unroll
    for (int i = 0; i < PAINT_LAYERS; ++i)
        share[i] = paint_between(maps, k + (i < last ? i : last) * layer, wide, fx, fy);
    float opacity = PAINT_SUM(3), per_opacity = 1.0f / (opacity + PAINT_FAINT);
    float red = (PAINT_SUM(0) + region->product.mean_root[0]) * per_opacity;
    float green = (PAINT_SUM(1) + region->product.mean_root[1]) * per_opacity;
    float blue = (PAINT_SUM(2) + region->product.mean_root[2]) * per_opacity;
    m->product[0] = red * red;
    m->product[1] = green * green;
    m->product[2] = blue * blue;
    m->opacity = opacity;
    m->glint[0] = PAINT_SUM(4);
    m->glint[1] = PAINT_SUM(5);
    m->glint[2] = PAINT_SUM(6);
    float shine = PAINT_SUM(7);
    m->sparkle[0] *= shine;
    m->sparkle[1] *= shine;
    m->sparkle[2] *= shine;
    m->own_highlights *= shine;
    m->reflection *= shine;
}
#endif

/* Paints one coat on runs, all of regions without layers or all with them. Each pixel has a
 * work-item.  size: of luma, in samples. */
__kernel void paint(
    __global SAMPLE *restrict luma, __global float *restrict codes,
    __global const float *restrict weights,
    __global const float *restrict maps, __global const paint_region *restrict regions,
    __global const int *restrict rows, __global const int *restrict runs, const int first,
    const int stride, const int size, const colour_coding coding) {
    int run = runs[get_group_id(0)], in_row = stride / RUN, block_row = run / in_row;
    int column = (run - block_row * in_row) * RUN + (int)get_local_id(0);
    int row = block_row * BLOCK_DOWN + (int)get_local_id(1), at = row * stride + column;
    __global const paint_region *region = regions + rows[block_row];
#ifdef PAINT_LAYERED
    material product = region->product.material;
#else
    const material product = region->product.material;
#endif
    float x = (float)column, y = (float)(row - region->first_row);
    float weight = weights[first + at];
    float old_luma = luma[at], old_cb = codes[at], old_cr = codes[at + size];
    float gx = region->product.to_grid[0] * x + region->product.to_grid[1] * y + region->product.to_grid[2];
    float gy = region->product.to_grid[3] * x + region->product.to_grid[4] * y + region->product.to_grid[5];
    float last_x = (float)region->grid_wide - PAINT_INSIDE,
          last_y = (float)region->grid_high - PAINT_INSIDE;
    gx = colour_clamp(gx, last_x);
    gy = last_y - colour_clamp(last_y - gy, last_y);
    int ix = (int)gx, iy = (int)gy;
    float fx = gx - (float)ix, fy = gy - (float)iy;
    int wide = region->grid_wide, layer = wide * region->grid_high;
    int k = region->grid + wide * iy + ix;
    float coarse = paint_between(maps, k, wide, fx, fy);
    float nx = paint_between(maps, k + layer, wide, fx, fy);
    float ny = paint_between(maps, k + 2 * layer, wide, fx, fy);
    float exposed = paint_between(maps, k + 3 * layer, wide, fx, fy);
#ifdef PAINT_LAYERED
    paint_compose(
        &product, region, maps, k + 4 * layer + MATERIAL_LAYER, wide, layer, fx, fy);
#endif
    material_surface skin = material_at(
        coarse, region->mean, nx, ny, exposed, maps, region->grid + 4 * layer,
        region->product.room_step, &product);
    float u = region->product.to_patch[0] * x + region->product.to_patch[1] * y + region->product.to_patch[2];
    float v = region->product.to_patch[3] * x + region->product.to_patch[4] * y + region->product.to_patch[5];
    colour_rgb bare = colour_decode(old_luma, old_cb, old_cr, &coding);
    colour_rgb made_up = material_paint(bare, weight, u, v, &skin, &product);
    colour_codes new = colour_encode(made_up, &coding);
    int is_painted = weight > 0.0f;
    luma[at] = (SAMPLE)colour_round(is_painted ? new.luma : old_luma, &coding);
    codes[at] = is_painted ? new.cb : old_cb;
    codes[at + size] = is_painted ? new.cr : old_cr;
}

/* Stores the mean of each block as its chroma; where nothing was painted, that is the old code.
 * Each chroma sample has a work-item. */
__kernel void paint_fold(
    __global SAMPLE *restrict chroma, __global const float *restrict codes,
    __global const paint_region *restrict regions, __global const int *restrict rows,
    __global const int *restrict runs, const int stride, const int size, const int chroma_size,
    const colour_coding coding) {
    int run = runs[get_group_id(0)], lane = get_local_id(0), block_row = run / (stride / RUN);
    int at = paint_start_chroma(run, stride) + lane;
    int from = paint_start(run, stride) + lane * BLOCK_ACROSS;
    __global const paint_region *region = regions + rows[block_row];
    /* the last block of an odd size has fewer pixels */
    int wide = region->wide - from % stride;
    int high = region->high + region->first_row - block_row * BLOCK_DOWN;
    wide = wide < BLOCK_ACROSS ? wide : BLOCK_ACROSS;
    high = high < BLOCK_DOWN ? high : BLOCK_DOWN;
    float cb = 0.0f, cr = 0.0f;
    for (int j = 0; j < BLOCK_DOWN; ++j)
        for (int i = 0; i < BLOCK_ACROSS; ++i) {
            int is_inside = (i < wide) & (j < high);
            cb += is_inside ? codes[from + j * stride + i] : 0.0f;
            cr += is_inside ? codes[from + j * stride + i + size] : 0.0f;
        }
    float share = 1.0f / (float)(wide > 0 ? wide * high : 1);
    chroma[at] = (SAMPLE)colour_round(cb * share, &coding);
    chroma[at + chroma_size] = (SAMPLE)colour_round(cr * share, &coding);
}
