/* Prints what one core of this machine does at best, in a second of processor time: bytes read from memory, and additions and multiplications. */

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#define BYTES (512 * 1024 * 1024) /* many times the caches */
#define ROUNDS 5
#define CHAINS 12 /* independent sums: as many as hide the latency of an addition */
#define STEPS 4000000

#if defined(__AVX512F__)
#define WIDTH 8
#elif defined(__AVX__)
#define WIDTH 4
#else
#define WIDTH 2
#endif
typedef double wide __attribute__((vector_size(8 * WIDTH)));

static double processor_time(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double sink; /* keeps the compiler from leaving the work out */

static double read_seconds(const wide *data, size_t count) {
    wide part[8] = {{0}};
    double begin = processor_time();
    for (size_t i = 0; i + 8 <= count; i += 8)
        for (int k = 0; k < 8; k++) part[k] += data[i + k];
    double end = processor_time();
    for (int k = 0; k < 8; k++)
        for (int l = 0; l < WIDTH; l++) sink += part[k][l];
    return end - begin;
}

static double arithmetic_seconds(void) {
    wide part[CHAINS], factor, term;
    for (int l = 0; l < WIDTH; l++) factor[l] = 0.999999, term[l] = 1e-6;
    for (int k = 0; k < CHAINS; k++) part[k] = term * (double)k;
    double begin = processor_time();
    for (int64_t i = 0; i < STEPS; i++)
        for (int k = 0; k < CHAINS; k++) part[k] = part[k] * factor + term;
    double end = processor_time();
    for (int k = 0; k < CHAINS; k++)
        for (int l = 0; l < WIDTH; l++) sink += part[k][l];
    return end - begin;
}

int main(void) {
    size_t count = BYTES / sizeof(wide);
    wide *data = aligned_alloc(64, BYTES);
    if (!data) return 1;
    for (size_t i = 0; i < count; i++)
        for (int l = 0; l < WIDTH; l++) data[i][l] = (double)(i % 7);
    double least_read = 1e9, least_arithmetic = 1e9;
    for (int round = 0; round < ROUNDS; round++) {
        double read = read_seconds(data, count), arithmetic = arithmetic_seconds();
        least_read = read < least_read ? read : least_read;
        least_arithmetic = arithmetic < least_arithmetic ? arithmetic : least_arithmetic;
    }
    printf("%.6g %.6g\n", BYTES / least_read, 2.0 * CHAINS * WIDTH * STEPS / least_arithmetic);
    return sink == 0.0;
}
