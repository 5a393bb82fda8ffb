/* Lay a product over a region of the frame, in linear light. Numpy twin: paint.py.
 *
 * luma: the plane, from the region's first pixel on, changed in place.
 * chroma: (2, high, wide) f32, Cb and Cr of every luma pixel.  change: the same, how much they changed.
 * surface: (4, high, wide) f32: weight of the product, 0 to 1; luminance of the bare skin without
 * its fine texture; x and y of the unit normal (z is towards the viewer).
 * environment: (3, 16, 16) f32, linear light.
 * runs: of each work-group its first pixel, y * wide + x; those without any weight are left out. */

#include "colour.h"
#include "material.h"

#ifndef SAMPLE
#define SAMPLE uchar
#endif

/* Made by `paint` in paint.py. */
typedef struct {
    int wide, high, luma_stride;
    float mean;        /* luminance of the bare region */
    float to_patch[6]; /* px of the region -> coordinates that stick to the skin */
} paint_region;

__kernel void paint(
    __global SAMPLE *restrict luma, __global const float *restrict chroma,
    __global float *restrict change, __global const float *restrict surface,
    __global const float *restrict environment, __global const int *restrict runs,
    const colour_coding coding, const paint_region region, const material product) {
    int first = runs[get_group_id(0)], y = first / region.wide;
    int x = first - y * region.wide + (int)get_local_id(0);
    if (x >= region.wide) return;
    int pixels = region.wide * region.high, at = y * region.wide + x;
    int here = y * region.luma_stride + x;
    float weight = surface[at];
    float old_luma = luma[here], old_cb = chroma[at], old_cr = chroma[at + pixels];
    material_surface skin = material_at(
        surface[at + pixels], region.mean, surface[at + 2 * pixels], surface[at + 3 * pixels],
        environment, &product);
    float u = region.to_patch[0] * (float)x + region.to_patch[1] * (float)y + region.to_patch[2];
    float v = region.to_patch[3] * (float)x + region.to_patch[4] * (float)y + region.to_patch[5];
    colour_rgb bare = colour_decode(old_luma, old_cb, old_cr, &coding);
    colour_rgb made_up = material_paint(bare, weight, u, v, &skin, &product);
    colour_codes codes = colour_encode(made_up, &coding);
    int is_painted = weight > 0.0f;
    luma[here] = (SAMPLE)colour_round(is_painted ? codes.luma : old_luma, &coding);
    change[at] = is_painted ? codes.cb - old_cb : 0.0f;
    change[at + pixels] = is_painted ? codes.cr - old_cr : 0.0f;
}
