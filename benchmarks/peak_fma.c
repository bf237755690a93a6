/* Peak rate of fused multiply-adds: twelve independent chains of vectors of BYTES bytes, all in registers.
 *
 * Twelve, because two units with a latency of four or five cycles want eight to ten; with AVX2 they leave four of the
 * sixteen registers for the factors. The empty assembly keeps the compiler from folding rounds into each other.
 */
#include <stddef.h>

typedef double vec __attribute__((vector_size(BYTES)));

#define TURN(x) x = x * factor + term

double peak(size_t rounds)
{
    const vec zero = {0}, factor = zero + 0.999999, term = zero + 1e-6;
    vec a = zero, b = a, c = a, d = a, e = a, f = a, g = a, h = a, i = a, j = a, k = a, l = a;
    for (size_t round = 0; round < rounds; round++) {
        TURN(a), TURN(b), TURN(c), TURN(d), TURN(e), TURN(f), TURN(g), TURN(h), TURN(i), TURN(j), TURN(k), TURN(l);
        __asm__ volatile("" : "+v"(a), "+v"(b), "+v"(c), "+v"(d), "+v"(e), "+v"(f),
                              "+v"(g), "+v"(h), "+v"(i), "+v"(j), "+v"(k), "+v"(l));
    }
    const vec sum = a + b + c + d + e + f + g + h + i + j + k + l;
    return sum[0];
}
