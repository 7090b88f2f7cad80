/* The larger of two; not a number, if one of them is none. */
static float larger(float a, float b)
{
    return ((a > b) || (a != a)) ? a : b;
}

/* The smaller of two; not a number, if one of them is none. */
static float smaller(float a, float b)
{
    return ((a < b) || (a != a)) ? a : b;
}

/* -1, 0 or 1. */
static float sign_of(float x)
{
    return (x > 0.0f) ? 1.0f : ((x < 0.0f) ? -1.0f : x);
}

/* A whole number, cut off towards zero; the nearest there is beyond the range, 0 for no number. */
static int32_t as_int32(float x)
{
    int32_t whole = 0;
    if (x >= 2147483648.0f) {
        whole = INT32_MAX;
    } else if (x <= -2147483648.0f) {
        whole = INT32_MIN;
    } else if (x == x) {
        whole = (int32_t)x;
    } else {
        whole = 0;
    }
    return whole;
}

/* The sum, modulo 2^32. */
static int32_t sum_of(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a + (uint32_t)b);
}

/* The difference, modulo 2^32. */
static int32_t difference_of(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b);
}

/* The product, modulo 2^32. */
static int32_t product_of(int32_t a, int32_t b)
{
    return (int32_t)((uint32_t)a * (uint32_t)b);
}

/* By so many bits further left, of less than 32. */
static int32_t shifted_left(int32_t a, int32_t by)
{
    return (int32_t)((uint32_t)a << (uint32_t)by);
}

/* The bits of a float. */
static int32_t bits_of(float x)
{
    const union { float x; int32_t bits; } both = {.x = x};
    return both.bits;
}

/* The float of these bits. */
static float float_of(int32_t bits)
{
    const union { int32_t bits; float x; } both = {.bits = bits};
    return both.x;
}

/* Whether it is a number, and not an infinite one. */
static bool is_finite(float x)
{
    return (x <= FLT_MAX) && (x >= -FLT_MAX);
}
