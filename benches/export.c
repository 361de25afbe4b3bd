/*
 * Times updates of an exported header at 1 kHz, in microseconds: mean and worst. Of each update the shortest of five passes
 * counts, since other programs interrupt.
 */
#define _POSIX_C_SOURCE 199309L
#include HEADER
#include <stdio.h>
#include <time.h>

enum { SAMPLES = 120000, PASSES = 5 };

static timed_state state;
static double shortest[SAMPLES];

static double now(void)
{
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return 1e6 * (double)at.tv_sec + 1e-3 * (double)at.tv_nsec;
}

int main(void)
{
    timed_real load[TIMED_AXES], gauges[TIMED_GAUGES];
    double worst = 0, total = 0, sum = 0, clock = 1e9;
    long k;
    int pass, g;
    for (pass = 0; pass < PASSES; pass++) {
        timed_init(&state);
        for (k = 0; k < SAMPLES; k++) {
            double time = 1e-3 * (double)k, before, between, after;
            for (g = 0; g < TIMED_GAUGES; g++)
                gauges[g] = (timed_real)(timed_gauge_mean(g) + timed_gauge_deviation(g) * sin(0.7 * time + g) * cos(0.11 * time));
            before = now();
            between = now();
            timed_update(&TIMED_CALIBRATION, &state, time, gauges, load, NULL);
            after = now();
            clock = between - before < clock ? between - before : clock;
            if (pass == 0 || after - between < shortest[k])
                shortest[k] = after - between;
            sum += (double)load[0];
        }
    }
    for (k = 0; k < SAMPLES; k++) {
        double taken = shortest[k] - clock;
        total += taken;
        worst = taken > worst ? taken : worst;
    }
    printf("mean %.3f us, worst %.1f us (sum of loads %g)\n", total / SAMPLES, worst, sum);
    return 0;
}
