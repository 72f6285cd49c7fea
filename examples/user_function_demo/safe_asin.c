#include <math.h>

/* Arcsine of x brought into -1 .. 1. */
double safe_asin(double x)
{
    return asin(fmin(fmax(x, -1.0), 1.0));
}
