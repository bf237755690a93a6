/* A step of RK4 for the quadrotor's yaw system with VECTORS tangent vectors, by hand, on GCC's vector types.
 *
 * The arithmetic is that of the printed kernel: terms shared within a stage, coefficients per cell, scaled by dt / 2 so
 * that a stage only adds. A vector of BYTES bytes holds eight cells or four; state and tangent vectors stay in
 * registers as far as the compiler can keep them there.
 * Compiled at run time: gcc -O3 -march=native -ffast-math -shared -fPIC -DBYTES=64 -DVECTORS=3.
 */
#include <stddef.h>

typedef double vec __attribute__((vector_size(BYTES)));

enum { D = 3, K = VECTORS, ROWS = D * (1 + K), COEFFICIENTS = 9, STRIDE = ROWS + COEFFICIENTS };

/* dy = dt/2 f(y), and for every tangent vector dt/2 J(y) q; c: a1 a2 a3 b1 b2 b3 c1 c2 c3, all times dt/2. */
static inline __attribute__((always_inline)) void derivative(const vec *y, const vec *c, vec *dy)
{
    const vec s0 = c[0] * y[2] + c[1], s1 = c[3] * y[2] + c[4];
    const vec j02 = c[0] * y[1], j12 = c[3] * y[0], j20 = c[6] * y[1], j21 = c[6] * y[0];
    dy[0] = s0 * y[1] + c[2] * y[0];
    dy[1] = s1 * y[0] + c[5] * y[1];
    dy[2] = j20 * y[0] + c[7] * y[2] + c[8];
    for (int k = 1; k <= K; k++) {
        const vec *q = y + k * D;
        vec *dq = dy + k * D;
        dq[0] = c[2] * q[0] + s0 * q[1] + j02 * q[2];
        dq[1] = s1 * q[0] + c[5] * q[1] + j12 * q[2];
        dq[2] = j20 * q[0] + j21 * q[1] + c[7] * q[2];
    }
}

/* Advance `groups` groups of cells by `steps` steps; a group is STRIDE rows of one vector. */
void advance(double *lanes, size_t groups, size_t steps)
{
    for (size_t group = 0; group < groups; group++) {
        vec *w = (vec *)lanes + group * STRIDE;
        const vec *c = w + ROWS;
        vec u[ROWS];
        for (int m = 0; m < ROWS; m++)
            u[m] = w[m];
        for (size_t step = 0; step < steps; step++) {
            vec y[ROWS], k[ROWS], x[ROWS], z[ROWS];
            derivative(u, c, k);
            for (int m = 0; m < ROWS; m++) {
                x[m] = k[m];
                y[m] = u[m] + k[m];
            }
            derivative(y, c, k);
            for (int m = 0; m < ROWS; m++) {
                z[m] = k[m];
                y[m] = u[m] + k[m];
            }
            derivative(y, c, k);
            for (int m = 0; m < ROWS; m++) {
                x[m] += 2.0 * (z[m] + k[m]);
                y[m] = u[m] + 2.0 * k[m];
            }
            derivative(y, c, k);
            for (int m = 0; m < ROWS; m++)
                u[m] += (x[m] + k[m]) * (1.0 / 3.0);
        }
        for (int m = 0; m < ROWS; m++)
            w[m] = u[m];
    }
}
