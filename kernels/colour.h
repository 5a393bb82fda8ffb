/* Y'CbCr codes of a frame <-> linear light: the colour maths that every kernel shares.
 * Numpy twin: colour.py, which also defines COLOUR_PQ_*, COLOUR_HLG_*, COLOUR_SRGB_* and the struct
 * colour_coding, with their sources. Linear light is display light in the frame's own primaries; 1
 * is diffuse white. Values outside 0..1 are kept, not clipped, so that colours beyond the gamut
 * return to their codes.
 *
 * COLOUR_TRANSFER picks the transfer function when the program is built, as ITU-T H.273 numbers it:
 * 16 PQ, 18 HLG; everything else is 13, sRGB.
 *
 * Here and in paint.cl: one pixel per work-item, and plain arithmetic and ?: instead of library
 * functions (min, clamp, fabs, vload, pow ...). PoCL does not inline those functions, and one call
 * that is not inlined keeps PoCL from vectorising the kernel: a single fmin made it ten times
 * slower. */

#ifndef COLOUR_H
#define COLOUR_H

#ifndef COLOUR_TRANSFER
#define COLOUR_TRANSFER 13
#endif

#define colour_sqrt sqrt
#ifdef __has_builtin
#if __has_builtin(__builtin_sqrtf)
#undef colour_sqrt
#define colour_sqrt __builtin_sqrtf /* vectorised, unlike sqrt */
#endif
#endif

typedef struct {
    float red, green, blue;
} colour_rgb;

typedef struct {
    float luma, cb, cr;
} colour_codes;

static inline float colour_abs(float x) { return as_float(as_int(x) & 0x7fffffff); }

/* max(x, 0), min(x, y), and x clamped to 0..top. */
static inline float colour_positive(float x) { return x > 0.0f ? x : 0.0f; }

static inline float colour_min(float x, float y) { return x < y ? x : y; }

static inline float colour_clamp(float x, float top) { return colour_min(colour_positive(x), top); }

/* |x| with the sign of `sign`. */
static inline float colour_signed(float x, float sign) {
    return as_float((as_int(x) & 0x7fffffff) | (as_int(sign) & (int)0x80000000));
}

/* log2 of a normal positive number, to 5e-8 before rounding: the exponent, and a polynomial of
 * the mantissa in sqrt(1/2)..sqrt(2). Zero gives -127. */
static inline float colour_log2(float x) {
    int exponent = (as_int(x) - 0x3f3504f3) >> 23;
    float z = as_float(as_int(x) - (exponent << 23)) - 1.0f;
    float sum = -0.145743056f;
    sum = sum * z + 0.236889936f;
    sum = sum * z - 0.250069334f;
    sum = sum * z + 0.286707528f;
    sum = sum * z - 0.360087196f;
    sum = sum * z + 0.480939442f;
    sum = sum * z - 0.721357149f;
    sum = sum * z + 1.44269477f;
    return (float)exponent + z * sum;
}

/* 2^x for x < 127, to a relative error of 1e-7; below -126 the result stays at 2^-126. */
static inline float colour_exp2(float x) {
    x = x < -126.0f ? -126.0f : x;
    float shifted = x + 12582912.0f; /* 1.5 * 2^23: the low bits are now x, rounded */
    float f = x - (shifted - 12582912.0f);
    float sum = 0.00132764671f;
    sum = sum * f + 0.00967554155f;
    sum = sum * f + 0.0555071329f;
    sum = sum * f + 0.240221197f;
    sum = sum * f + 0.693146967f;
    sum = sum * f + 1.00000007f;
    return as_float(as_int(sum) + ((as_int(shifted) - 0x4b400000) << 23));
}

/* R', G' or B' -> linear, and back. Odd functions: -x gives -f(x). */
#if COLOUR_TRANSFER == 16 /* SMPTE ST 2084 */
static inline float colour_to_linear(float encoded) {
    float a = colour_abs(encoded);
    a = a < COLOUR_PQ_LARGEST ? a : COLOUR_PQ_LARGEST; /* the curve has a pole at 1.99 */
    /* 1e-6 is a thousandth of a code and keeps the difference below from reaching 0. With a max
     * there, PoCL packs the max of three channels into vectors of two and no longer vectorises
     * over pixels (12 times slower). */
    float p = colour_exp2(colour_log2(a + 1e-6f) * (1.0f / COLOUR_PQ_M2));
    float y = (p - COLOUR_PQ_C1) / (COLOUR_PQ_C2 - COLOUR_PQ_C3 * p);
    return colour_signed(
        COLOUR_PQ_WHITES * colour_exp2(colour_log2(y) * (1.0f / COLOUR_PQ_M1)), encoded);
}

static inline float colour_to_encoded(float linear) {
    float a = colour_abs(linear) * (1.0f / COLOUR_PQ_WHITES);
    float y = colour_exp2(colour_log2(a) * COLOUR_PQ_M1);
    float p = (COLOUR_PQ_C1 + COLOUR_PQ_C2 * y) / (1.0f + COLOUR_PQ_C3 * y);
    return colour_signed(colour_exp2(colour_log2(p) * COLOUR_PQ_M2), linear);
}
#elif COLOUR_TRANSFER == 18 /* ITU-R BT.2100, OETF; scene light in units of diffuse white */
static inline float colour_to_linear(float encoded) {
    float a = colour_abs(encoded);
    float high = COLOUR_HLG_LIGHT_END * colour_exp2((a - COLOUR_HLG_C) * COLOUR_HLG_PER_A) +
                 COLOUR_HLG_B_LIGHT;
    return colour_signed(a <= COLOUR_HLG_END ? a * a * COLOUR_HLG_SQUARE : high, encoded);
}

static inline float colour_to_encoded(float linear) {
    float a = colour_abs(linear);
    float offset =
        a * COLOUR_HLG_PER_WHITE - COLOUR_HLG_B; /* may be negative where the root holds */
    float high = COLOUR_HLG_A * colour_log2(offset > 0.25f ? offset : 0.25f) + COLOUR_HLG_C;
    return colour_signed(
        a <= COLOUR_HLG_LIGHT_END ? colour_sqrt(a * COLOUR_HLG_ROOT) : high, linear);
}
#else
/* IEC 61966-2-1. Minimax polynomials: the error is at most 0.02 of a ten-bit code each way, up to
 * an encoded value of 2.2, the largest that codes can stand for. Brighter light still has finite
 * codes. */
static inline float colour_to_linear(float encoded) {
    float a = colour_abs(encoded);
    float sum = -0.00516528084f;
    sum = sum * a + 0.0470767849f;
    sum = sum * a - 0.18066471f;
    sum = sum * a + 0.388477692f;
    sum = sum * a - 0.550804636f;
    sum = sum * a + 0.765373817f;
    sum = sum * a + 0.500522286f;
    sum = sum * a + 0.0342612446f;
    sum = sum * a + 0.000878301484f;
    return colour_signed(
        a <= COLOUR_SRGB_ENCODED_END ? a * (1.0f / COLOUR_SRGB_SLOPE) : sum, encoded);
}

static inline float colour_to_encoded(float linear) {
    float a = colour_abs(linear);
    float root = colour_sqrt(colour_sqrt(a)); /* a power of 5/3 of this is nearly straight */
    float sum = 0.0163168593f;
    sum = sum * root - 0.109808123f;
    sum = sum * root + 0.320911902f;
    sum = sum * root - 0.576811426f;
    sum = sum * root + 1.24505288f;
    sum = sum * root + 0.166146011f;
    sum = sum * root - 0.0618205996f;
    return colour_signed(a <= COLOUR_SRGB_LINEAR_END ? a * COLOUR_SRGB_SLOPE : sum, linear);
}
#endif

/* light * Y^exponent, where Y is the light's luminance, at least `darkest`. */
static inline colour_rgb colour_hlg_gain(colour_rgb light, float exponent, float darkest) {
    float luminance =
        COLOUR_HLG_RED * light.red + COLOUR_HLG_GREEN * light.green + COLOUR_HLG_BLUE * light.blue;
    luminance = luminance > darkest ? luminance : darkest;
    float gain = colour_exp2(exponent * colour_log2(luminance));
    colour_rgb out = {light.red * gain, light.green * gain, light.blue * gain};
    return out;
}

static inline float colour_row(const float *row, float x, float y, float z) {
    return row[0] * x + row[1] * y + row[2] * z + row[3];
}

/* Y'CbCr codes -> linear light. */
static inline colour_rgb colour_decode(
    float luma, float cb, float cr, const colour_coding *coding) {
    colour_rgb linear = {
        colour_to_linear(colour_row(coding->to_rgb, luma, cb, cr)),
        colour_to_linear(colour_row(coding->to_rgb + 4, luma, cb, cr)),
        colour_to_linear(colour_row(coding->to_rgb + 8, luma, cb, cr)),
    };
#if COLOUR_TRANSFER == 18 /* the OOTF of the display */
    linear = colour_hlg_gain(linear, COLOUR_HLG_GAIN, COLOUR_HLG_DARKEST);
#endif
    return linear;
}

/* Linear light -> Y'CbCr codes, neither rounded nor clipped: chroma is averaged first. */
static inline colour_codes colour_encode(colour_rgb linear, const colour_coding *coding) {
#if COLOUR_TRANSFER == 18
    linear = colour_hlg_gain(linear, COLOUR_HLG_GAIN_BACK, COLOUR_HLG_DARKEST_LIGHT);
#endif
    float red = colour_to_encoded(linear.red);
    float green = colour_to_encoded(linear.green);
    float blue = colour_to_encoded(linear.blue);
    colour_codes codes = {
        colour_row(coding->to_codes, red, green, blue),
        colour_row(coding->to_codes + 4, red, green, blue),
        colour_row(coding->to_codes + 8, red, green, blue),
    };
    return codes;
}

/* Rounds and clips a code for storage; halves go up. NaN becomes the largest code. */
static inline int colour_round(float code, const colour_coding *coding) {
    code = code < coding->max_code ? code : coding->max_code;
    code = code > 0.0f ? code : 0.0f;
    return (int)(code + 0.5f);
}

#endif
