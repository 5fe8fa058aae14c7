/* SPDX-License-Identifier: GPL-3.0-or-later
 * dot_product.c - one column of samples times several.
 *
 * A sum of products waits for each of its additions. Four sums side by side wait together, and each
 * of them is taken in the order of the samples, so that it has the bits of one taken alone.
 */
#include "run.h"

double lab__dot(const double *a, const double *b, size_t n)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++) {
        sum += a[i] * b[i];
    }
    return sum;
}

void lab__dot_rows(const double *a, const double *b, size_t n, int rows, double *sum)
{
    int r = 0;
    for (; r + 4 <= rows; r += 4, b += 4 * n) {
        const double *b1 = b + n, *b2 = b1 + n, *b3 = b2 + n;
        double s0 = 0.0, s1 = 0.0, s2 = 0.0, s3 = 0.0;
        for (size_t i = 0; i < n; i++) {
            s0 += a[i] * b[i];
            s1 += a[i] * b1[i];
            s2 += a[i] * b2[i];
            s3 += a[i] * b3[i];
        }
        sum[r] = s0;
        sum[r + 1] = s1;
        sum[r + 2] = s2;
        sum[r + 3] = s3;
    }
    for (; r < rows; r++, b += n) {
        sum[r] = lab__dot(a, b, n);
    }
}
